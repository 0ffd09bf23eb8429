#pragma once
/// Detects bodies that are too deep in others, and bodies that passed through others. The latter is
/// a continuous check of shapes that move far for their thickness in a substep, from poses and
/// shapes alone.
#include <optional>
#include <vector>

#include "engine/contact/search.hpp"
#include "engine/runtime/finding_list.hpp"
#include "engine/world/world.hpp"

namespace pantin {
struct Contact;
}

namespace pantin::detail {

class ContactWatch {
 public:
  /// Called after the structure has changed.
  void compile(const World& world);
  /// Called before bodies move, kinematic ones included.
  void begin_substep(const World& world);
  /// Called before the solvers start; records bodies that sleep.
  void note_start(const World& world);
  /// Called after the solvers, `h` seconds later; looks for bodies that passed through others.
  void end_substep(const World& world, Real h, FindingList& found);
  /// Called at the end of a step of `h` seconds; looks for bodies that are too deep.
  void end_step(const World& world, Real h, FindingList& found);

 private:
  /// A collider shape and its core.
  struct Solid {
    std::uint32_t slot = 0, shape = 0;
    Shape core;
    Real half_thickness = 0, reach = 0;  // m
  };

  /// The bounding sphere of a shape, in its body's frame; the radius is infinite if it is
  /// unbounded.
  struct Ball {
    Vec3 centre{0};
    std::uint32_t slot = 0;
    Real radius = 0;
  };

  /// How deep a body is in another one, at rest or moving.
  struct Overlap {
    Real part = 0, depth = 0;  // of this step: relative to the thinner one's thickness; m
    Real for_long = 0;         // s, weighted by the relative depth, without interruption
  };

  /// A body at the start of a substep.
  struct Before {
    Pose pose;
    Vec3 velocity{0}, angular_velocity{0};  // m/s, rad/s
    bool leaps = true;                      // it was teleported
  };

  void note(const World& world, std::uint32_t slot);
  bool may_meet(const World& world, std::uint32_t a, std::uint32_t b) const;
  bool is_fast(const World& world, const Solid& s) const;
  bool may_pass(const World& world, std::size_t one, std::size_t two) const;
  template <class Meet>
  void each_near(const World& world, std::uint32_t fast, const Meet& meet) const;
  bool is_sunk(const Contact& contact) const;
  void tell_of_sleepers(const World& world, FindingList& found);
  void place_box(const World& world, std::size_t solid);
  void place_boxes(const World& world);
  std::optional<Real> passage(const World& world, const Solid& a, const Solid& b, Real h) const;

  std::vector<Solid> solids_;         // grouped by body
  std::vector<Ball> balls_;           // parallel to `solids_`
  std::vector<std::uint32_t> fast_;   // indices into `solids_`, in this substep
  std::vector<std::uint32_t> first_;  // index of the first solid by slot; one more at the end
  // Partition::rest_version at note_start(), when all boxes were placed, and when sleeping bodies
  // were checked.
  std::uint64_t rest_version_ = 0, placed_for_ = 0, slept_for_ = 0;
  std::vector<std::uint32_t> unbounded_;               // indices into `solids_`
  std::vector<Before> before_;                         // by slot
  std::vector<Real> thickness_, shallow_, rests_for_;  // by slot: m, of the thinnest shape; m; s
  std::vector<Real> depth_;                            // m, by slot, of this step
  std::vector<Overlap> overlaps_;                      // by slot
  std::vector<std::uint8_t> is_skin_;                  // by slot: has a NURBS shape
  std::vector<Aabb> boxes_;                            // of the motion of all solids in the substep
  AabbTree tree_;
  std::vector<std::uint64_t> joined_;  // see engine/world/joined.hpp
};

}  // namespace pantin::detail
