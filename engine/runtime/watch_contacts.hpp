#pragma once
/// What lies too deep in something, and what came through something: a continuous check of what
/// moves by more than its own thickness in a substep, from poses and shapes alone.
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
  /// After the structure has changed.
  void compile(const World& world);
  /// Before bodies are moved, kinematic ones included.
  void begin_substep(const World& world);
  /// Before the solvers start: what sleeps stays as it is noted here.
  void note_start(const World& world);
  /// After the solvers, `h` seconds later; looks for what passed through something.
  void end_substep(const World& world, Real h, FindingList& found);
  /// At the end of a step of `h` seconds: looks for what lies too deep.
  void end_step(const World& world, Real h, FindingList& found);

 private:
  /// A shape of a solid body, and the middle half of it.
  struct Solid {
    std::uint32_t slot = 0, shape = 0;
    Shape core;
    Real half_thickness = 0, reach = 0;  // m
  };

  /// The ball around a shape, in the frame of its body; not finite: it has no bounds.
  struct Ball {
    Vec3 centre{0};
    std::uint32_t slot = 0;
    Real radius = 0;
  };

  /// How deep a body lies in another one, at rest or not.
  struct Overlap {
    Real part = 0, depth = 0;  // of the thickness of the thinner one; m; in this step
    Real for_long = 0;         // s, times that part, on end
  };

  /// A body as a substep began.
  struct Before {
    Pose pose;
    Vec3 velocity{0}, angular_velocity{0};  // m/s, rad/s
    bool leaps = true;                      // was placed anew
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

  std::vector<Solid> solids_;         // by body
  std::vector<Ball> balls_;           // as `solids_`
  std::vector<std::uint32_t> fast_;   // of these, in this substep
  std::vector<std::uint32_t> first_;  // of these, by slot; one more at the end
  // Partition::rest_version at note_start(), and at that when all boxes were placed.
  // The same when sleepers were looked at.
  std::uint64_t rest_version_ = 0, placed_for_ = 0, slept_for_ = 0;
  std::vector<std::uint32_t> unbounded_;               // of them
  std::vector<Before> before_;                         // by slot
  std::vector<Real> thickness_, shallow_, rests_for_;  // by slot: m, of the thinnest shape; m; s
  std::vector<Real> depth_;                            // m, by slot, of this step
  std::vector<Overlap> overlaps_;                      // by slot
  std::vector<Aabb> boxes_;                            // of the ways of all solids
  AabbTree tree_;
  std::vector<std::uint64_t> joined_;  // see engine/world/joined.hpp
};

}  // namespace pantin::detail
