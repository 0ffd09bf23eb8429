#pragma once
/// Reference frames of the Lagrangian solver: what moves, but is not solved for.
#include <cstdint>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin::detail::lagrangian {

/// How an exact drive with a maximum torque acts in a step.
struct DriveLag {
  // Its coordinate is behind its motion by (value + (rate + decay value) t) exp(-decay t), at the
  // time t since `from`: rad or m, rad/s or m/s, s, 1/s.
  Real value = 0, rate = 0, from = 0, decay = 0;
  bool yields = false;   // it exerts `force` instead
  Real force = 0;        // N m or N
  bool limited = false;  // it yields for want of torque; others do while contacts are resolved
};

/// A reference frame that is not part of the island: the world, a fixed or kinematic body, a pin's
/// target; the winch of a cable, whose x is the cable's length; or an exact drive, whose x is the
/// coordinate of its joint.
struct Frame {
  std::uint32_t slot = UINT32_MAX;   // in World::bodies; none: see pin
  std::uint32_t pin = UINT32_MAX;    // in World::pins; none: the world
  std::uint32_t cable = UINT32_MAX;  // in World::cables
  std::uint32_t drive = UINT32_MAX;  // in World::joint_drives
  DriveLag lag;                      // of a drive
  Pose before;                       // at the end of the last step
  bool known = false;

  bool is_body() const { return pin == UINT32_MAX && cable == UINT32_MAX && drive == UINT32_MAX; }

  static void fields(auto& self, auto&& field) {
    field("slot", derived(self.slot));
    field("pin", derived(self.pin));
    field("cable", derived(self.cable));
    field("drive", derived(self.drive));
    field("lag", derived(self.lag));
    field("before", self.before);
    field("known", self.known);
  }
};

}  // namespace pantin::detail::lagrangian
