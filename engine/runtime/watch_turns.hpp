#pragma once
/// Detects motions too fast for the step of their solver: rotating bodies, springs of joints.
#include <span>
#include <vector>

#include "engine/runtime/energy_stores.hpp"
#include "engine/runtime/finding_list.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

class TurnWatch {
 public:
  /// Called after the structure has changed.
  void compile(const World& world);
  /// Called after a substep of `h` seconds; `stores` at its end.
  void end_substep(const World& world, Real h, std::span<const EnergyStore> stores,
                   FindingList& found);

 private:
  /// How the rotation of a body counts. Rotation about a symmetry axis on which all its joints lie
  /// is not limited.
  struct Body {
    bool is_asked = false, is_joined = false;
    bool is_geared = false;  // coupled by gears, belts, surfaces, cables or exact pins
    bool is_sprung = false;  // held by a pin
    Vec3 axis{0};            // symmetry axis, body axes; 0: none
    bool is_ball = false;    // all principal moments equal
    Real turned = 0;         // rad, accumulated over consecutive steps that were too long
    Real rolls = 0;          // rad, in this step in contact, if that is too far; else 0
    Real rolled = 0;         // rad, the same accumulated over consecutive steps
  };

  Real range_of(const World& world, std::uint32_t slot) const;
  void find_axes(const World& world);
  void find_geared(const World& world);
  void link_up(const World& world);
  void note_rolling(const World& world, Real h);
  void check_rolling(const World& world, FindingList& found);
  void check_spring(const World& world, Real h, const EnergyStore& store, FindingList& found);
  void check_spring_pin(const World& world, Real h, const EnergyStore& store, FindingList& found);
  /// The inertia of the subtree beyond a link: moment of inertia about its axis, or mass. 0 if it
  /// is held, or part of a loop.
  Real inertia_beyond(const World& world, const EnergyStore& store, std::uint32_t from,
                      std::uint32_t to);

  Real share_of(const World& world, std::uint32_t slot) const;

  std::vector<Body> bodies_;                 // by slot
  std::vector<std::uint32_t> first_, ends_;  // links of each body, by slot
  std::vector<std::uint32_t> stack_;
  std::vector<std::uint8_t> seen_;
};

}  // namespace pantin::detail
