#pragma once
/// Skate, or knife edge: the point of b at its anchor does not move along x of b, relative to a.
///
///   J V = x_b.(velocity of a at the point - velocity of b there) = 0
///
/// Only b's anchor and axes count. The blade is across x: the point is free to move along it.
#include "engine/joints/primitives.hpp"
#include "engine/joints/slip.hpp"

namespace pantin::detail::joint_kinds {

struct skate : Slips<skate> {
  static constexpr std::string_view name = "skate", alias = "knife_edge";
  static constexpr int rows = 1, degrees_of_freedom = 5;
  static constexpr Parameter parameters[] = {kGripParameter, kFrictionParameter};

  static SlipPoint slip_point(const Joint& joint, const BodyState& a, const BodyState& b) {
    const JointAxes on_b = axes_on_b(joint, b);
    SlipPoint p;
    p.arm_b = b.rotation_matrix * joint.anchor_b;
    p.arm_b_rate = glm::cross(b.angular_velocity, p.arm_b);
    p.tangent[0] = on_b.x(), p.normal = on_b.y();
    p.tangent_rate[0] = glm::cross(b.angular_velocity, p.tangent[0]);
    place_arm_a(p, a, b);
    return p;
  }
};

}  // namespace pantin::detail::joint_kinds
