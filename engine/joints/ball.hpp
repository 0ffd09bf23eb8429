#pragma once
/// Two bodies share one point and turn freely about it.
///
///   C = p_b - p_a                       three rows, metres
///   p_i = x_i + R_i anchor_i            anchors fixed in each body
#include "engine/base/math.hpp"

namespace pantin {

struct BallJoint {
  Vec3 anchor_a{0};  // in body a's mass-centre frame
  Vec3 anchor_b{0};  // in body b's mass-centre frame
};

/// What the joint lacks: from the point on body a to the point on body b, world axes, metres.
inline Vec3 residual(const BallJoint& joint, const Pose& a, const Pose& b) {
  return to_world(b, joint.anchor_b) - to_world(a, joint.anchor_a);
}

}  // namespace pantin
