#pragma once
/// A body in the elimination of islands with joints that constrain rotations, by the
/// energy-momentum method: before its turn is eliminated, and after it. See conserving_joints.cpp.
#include <cstdint>

#include "engine/base/math.hpp"

namespace pantin::detail::articulated {

struct ConservingSum {
  Mat3 tt{0}, ty{0}, yt{0}, yy{0};
  Vec3 by_torque{0}, by_force{0};  // right-hand sides
  Vec3 torque{0}, impulse{0};      // at the iterate
};
/// A limit of a joint in a part of a step: free to be reached; left alone until it is, where the
/// part ends; held, as a row of the joint; or hit at the end of the part.
enum class LimitState : std::uint8_t { open, followed, held, hit };
struct ConservingLimit {
  LimitState state = LimitState::open, at_start = LimitState::open;
  bool watched = false, both_ways = false;
  bool acts = false;                         // on the velocities at the end
  Vec3 along_before{0}, along{0};            // see JointLimit; at the start, at the iterate
  Real clearance_before = 0, clearance = 0;  // rad, likewise
  Real rate = 0;                             // rad/s, towards the limit, at the start
  Vec3 column{0};  // its multiplier by the torque of the joint; none where it is no row
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
  // Before a blow: the impulse at the joint, and `passed`; kEndJoint, whose rows the blow takes.
  Vec3 impulse_before{0}, passed_before{0}, end_joint{0};
  Vec3 tie_passed{0};  // torque by the response to the impulses of ties
  ConservingLimit limits[4];
};

}  // namespace pantin::detail::articulated
