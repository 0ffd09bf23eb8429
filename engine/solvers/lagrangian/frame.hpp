#pragma once
/// Reference frames of the Lagrangian solver: what moves, but is not solved for.
#include <cstdint>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/solvers/drive_lag.hpp"

namespace pantin::detail::lagrangian {

/// Where a frame is at the start of a step, if it is known.
struct FrameStart {
  Pose before;           // at the end of the last step
  Real rate_before = 0;  // m/s, of the winch of a cable, likewise
  bool known = false;
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
  Real rate_before = 0;              // m/s, of a cable, likewise
  bool known = false;

  FrameStart start() const { return {before, rate_before, known}; }
  void begin(const FrameStart& at) {
    before = at.before, rate_before = at.rate_before, known = at.known;
  }
  bool is_body() const { return pin == UINT32_MAX && cable == UINT32_MAX && drive == UINT32_MAX; }

  static void fields(auto& self, auto&& field) {
    field("slot", derived(self.slot));
    field("pin", derived(self.pin));
    field("cable", derived(self.cable));
    field("drive", derived(self.drive));
    field("lag", derived(self.lag));
    field("before", self.before);
    field("rate_before", self.rate_before);
    field("known", self.known);
  }
};

}  // namespace pantin::detail::lagrangian
