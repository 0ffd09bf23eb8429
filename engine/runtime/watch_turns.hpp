#pragma once
/// What moves by more in a step than its solver can follow: bodies that turn, springs of joints.
#include <span>
#include <vector>

#include "engine/runtime/energy_stores.hpp"
#include "engine/runtime/finding_list.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

class TurnWatch {
 public:
  /// After the structure has changed.
  void compile(const World& world);
  /// After a substep of `h` seconds; `stores` as they are then.
  void end_substep(const World& world, Real h, std::span<const EnergyStore> stores,
                   FindingList& found);

 private:
  /// What of a body's turning counts: about an axis of symmetry that all its joints lie on it may
  /// turn as fast as it likes.
  struct Body {
    bool is_asked = false, is_joined = false;
    bool is_geared = false;  // moves as others do: by gears, belts, surfaces, cables, exact pins
    bool is_sprung = false;  // by a pin
    Vec3 axis{0};            // of that symmetry, body axes; 0: none
    bool is_ball = false;    // all moments alike
    Real turned = 0;         // rad, on end in steps that were too long for it
    Real rolls = 0;          // rad, in this step on what it touches, where that is too far; or 0
    Real rolled = 0;         // rad, likewise on end
  };

  Real range_of(const World& world, std::uint32_t slot) const;
  void find_axes(const World& world);
  void find_geared(const World& world);
  void link_up(const World& world);
  void note_rolling(const World& world, Real h);
  void check_rolling(const World& world, FindingList& found);
  void check_spring(const World& world, Real h, const EnergyStore& store, FindingList& found);
  void check_spring_pin(const World& world, Real h, const EnergyStore& store, FindingList& found);
  /// Of the bodies beyond a link, as seen from it: moment of inertia about an axis, or mass; 0:
  /// held, or part of a loop.
  Real inertia_beyond(const World& world, const EnergyStore& store, std::uint32_t from,
                      std::uint32_t to);

  Real share_of(const World& world, std::uint32_t slot) const;

  std::vector<Body> bodies_;                 // by slot
  std::vector<std::uint32_t> first_, ends_;  // links of each body, by slot
  std::vector<std::uint32_t> stack_;
  std::vector<std::uint8_t> seen_;
};

}  // namespace pantin::detail
