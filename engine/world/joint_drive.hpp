#pragma once
/// A joint drive: a spring and damper towards a target pose.
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

/// One key pose: the joint axes of b in those of a (see Joint).
struct PoseKey {
  Real time = 0;  // s
  Quat rotation{1, 0, 0, 0};

  static void fields(auto& self, auto&& field) {
    field("time", self.time);
    field("rotation", self.rotation);
  }
};

/// A component of links: a spring and damper between the bodies of a joint, capped.
///
///   torque = stiffness * (shortest rotation vector to the target)
///            - damping * (relative angular velocity - the target's own)        at most max_torque
///
/// The spring is integrated implicitly: no stiffness makes it unstable. With `keys` the target
/// follows them (slerp between keys, times strictly increasing). Otherwise the target is `target`,
/// which may be changed at any time.
struct JointDrive {
  Quat target{1, 0, 0, 0};
  Real stiffness = 0;       // N m/rad
  Real damping = 0;         // N m s/rad
  Real max_torque = 1e300;  // N m
  std::vector<PoseKey> keys;
  bool loop = false;  // the last key is the first one again
  // Results of the last step:
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
Quat target_at(const JointDrive& drive, Real time);

}  // namespace pantin
