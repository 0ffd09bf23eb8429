#pragma once
/// A body in the elimination of islands with joints that constrain rotations, by the
/// energy-momentum method: before its turn is eliminated, and after it. See conserving_joints.cpp.
#include "engine/base/math.hpp"

namespace pantin::detail::articulated {

struct ConservingSum {
  Mat3 tt{0}, ty{0}, yt{0}, yy{0};
  Vec3 by_torque{0}, by_force{0};  // right-hand sides
  Vec3 torque{0}, impulse{0};      // at the iterate
};
struct ConservingNode {
  Mat3 compliance{0}, turning{0}, crossing{0};
  Mat3 turn_y{0}, turn_p{0}, force_y{0}, force_p{0}, torque_y{0}, torque_p{0};
  Vec3 turn{0}, force{0}, torque{0};
  bool passes_torque = false;
  Vec3 passed{0};  // torque from the parent by the last iteration, N m s over half the part
  // Of that by springs, drives and the like, N m; minus its derivative by the relative turn.
  Vec3 exerted{0};
  Mat3 stiffness{0};
  // Impulse at the end that takes what the step does not resolve: damped - damping relative spin.
  Vec3 damped{0};
  Mat3 damping{0};
  // Of a spring, friction or a motor along its coordinate: by the last iteration, N m and rad per
  // N m; and what of the drive its limit allows.
  Real expected = 0, yield = 0, slope = 0, drive_share = 1;
  Real driven = 0;  // N m, size of the drive's torque
  Vec3 axis{0};
};

}  // namespace pantin::detail::articulated
