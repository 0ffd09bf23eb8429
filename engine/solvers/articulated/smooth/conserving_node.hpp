#pragma once
/// A body in the elimination of islands with joints that constrain rotations, by the
/// energy-momentum method: before and after its rotation is eliminated. See conserving_joints.cpp.
#include <cstdint>

#include "engine/base/math.hpp"

namespace pantin::detail::articulated {

struct ConservingSum {
  Mat3 tt{0}, ty{0}, yt{0}, yy{0};
  Vec3 by_torque{0}, by_force{0};  // right-hand sides
  Vec3 torque{0}, impulse{0};      // at the iterate
};
/// A limit of a joint in a substep: open, may become active; followed, the substep ends where it is
/// reached; held, an active row of the joint; or hit at the end of the substep.
enum class LimitState : std::uint8_t { open, followed, held, hit };
struct ConservingLimit {
  LimitState state = LimitState::open, at_start = LimitState::open;
  bool watched = false, both_ways = false;
  bool acts = false;                         // active in the velocities at the end
  Vec3 along_before{0}, along{0};            // see JointLimit; at the start, at the iterate
  Real clearance_before = 0, clearance = 0;  // rad, likewise
  Real rate = 0;                             // rad/s, towards the limit, at the start
  Vec3 column{0};  // its multiplier per torque of the joint; zero if it is no row
};
struct ConservingNode {
  Mat3 compliance{0}, turning{0}, crossing{0};
  Mat3 turn_y{0}, turn_p{0}, force_y{0}, force_p{0}, torque_y{0}, torque_p{0};
  Vec3 turn{0}, force{0}, torque{0};
  bool passes_torque = false;
  Vec3 passed{0};  // torque from the parent by the last iteration, N m s over half the substep
  // Torque of springs, drives and motors, N m; minus its derivative by the relative rotation.
  Vec3 exerted{0};
  Mat3 stiffness{0};
  // Impulse at the end that damps unresolved motion: damped - damping * relative spin.
  Vec3 damped{0};
  Mat3 damping{0};
  // Spring, friction or motor along its coordinate: torque by the last iteration, N m; response,
  // rad per N m; minus its slope. Fraction of the drive's torque within its bound.
  Real expected = 0, yield = 0, slope = 0, drive_share = 1;
  Real driven = 0;  // N m, size of the drive's torque
  Vec3 axis{0};
  // Before an impact: the joint's impulse, `passed`, and kEndJoint, whose rows the impact reuses.
  Vec3 impulse_before{0}, passed_before{0}, end_joint{0};
  Vec3 tie_passed{0};  // torque in response to the impulses of ties
  ConservingLimit limits[4];
};

}  // namespace pantin::detail::articulated
