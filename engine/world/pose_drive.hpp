#pragma once
/// A muscle: a joint drawn towards a target pose.
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

/// One pose on the way, of the joint axes of b in those of a (see Joint).
struct PoseKey {
  Real time = 0;  // s
  Quat turn{1, 0, 0, 0};

  static void fields(auto& self, auto&& field) {
    field("time", self.time);
    field("turn", self.turn);
  }
};

/// A component of links: a spring and damper between the bodies of a joint, capped.
///
///   torque = stiffness * (shortest rotation vector to the target)
///            - damping * (relative spin - the target's own)        at most max_torque
///
/// The spring is implicit in the step: no stiffness makes it unstable. With `keys` the target
/// follows them (slerp between keys, times strictly increasing); otherwise `target` is where it
/// goes, and may be changed by hand at any time.
struct PoseDrive {
  Quat target{1, 0, 0, 0};
  Real stiffness = 0;       // N m/rad
  Real damping = 0;         // N m s/rad
  Real max_torque = 1e300;  // N m
  std::vector<PoseKey> keys;
  bool loop = false;        // the last key is the first one again
  // What the last step left:
  Real torque = 0;  // N m, size of the torque exerted
  bool capped = false;

  static void fields(auto& self, auto&& field) {
    field("target", self.target);
    field("stiffness", self.stiffness);
    field("damping", self.damping);
    field("max_torque", self.max_torque);
    field("keys", self.keys);
    field("loop", self.loop);
    field("torque", passive(self.torque));
    field("capped", passive(self.capped));
  }
};

/// The target at `time` (s).
Quat target_at(const PoseDrive& drive, Real time);

}  // namespace pantin
