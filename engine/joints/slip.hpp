#pragma once
/// Rows that constrain velocities only: the slip velocity u of a against b at a contact point p.
///
///   J V = t.u = 0,  u = v_a + w_a x r_a - v_b - w_b x r_b
///   gamma = -(t'.u + t.(w_a x r_a' - w_b x r_b'))
///
/// with a tangent t and the arms r from the mass centres to p. p is a point of neither body, so r'
/// is not w x r. The rows have no residual: no pose violates them. [Nelson & Cohen, Eqns 12-13]
#include "engine/joints/kind.hpp"

namespace pantin::detail {

/// Where and along which directions two bodies must not slip; world axes.
struct SlipPoint {
  Vec3 arm_a{0}, arm_b{0};  // r, m
  Vec3 normal{0, 1, 0};     // unit, perpendicular to the tangents
  Vec3 tangent[2] = {};     // unit; as many as the kind has rows
  Vec3 arm_b_rate{0};       // r_b', m/s
  Vec3 tangent_rate[2] = {};
};

/// The arm of a to the point that b carries at arm_b.
inline void place_arm_a(SlipPoint& p, const BodyState& a, const BodyState& b) {
  p.arm_a = b.position + p.arm_b - a.position;
}

/// Rows of the first `rows` tangents.
inline void write_slip_rows(const SlipPoint& p, const JointState& at, int rows, RowsOut out) {
  const BodyState &a = at.a, &b = at.b;
  const Vec3 arm_a_rate = b.velocity + p.arm_b_rate - a.velocity;
  const Vec3 slip = a.velocity + glm::cross(a.angular_velocity, p.arm_a) - b.velocity -
                    glm::cross(b.angular_velocity, p.arm_b);
  const Vec3 bend =
      glm::cross(a.angular_velocity, arm_a_rate) - glm::cross(b.angular_velocity, p.arm_b_rate);
  for (int i = 0; i < rows; ++i) {
    const Vec3 t = p.tangent[i];
    if (out.c) out.c[i] = 0;
    if (out.gamma) out.gamma[i] = -(glm::dot(p.tangent_rate[i], slip) + glm::dot(t, bend));
    if (!out.j) continue;
    Vec3* j = out.j + 4 * i;
    j[0] = t, j[1] = glm::cross(p.arm_a, t), j[2] = -t, j[3] = -glm::cross(p.arm_b, t);
  }
}

namespace joint_kinds {

/// A kind that constrains velocities only. It has slip_point(); beyond the force `grip`, or
/// `friction` times the load that it shares, it slides against that force.
template <class K>
struct Slips : Kind, TurnsFreely {
  static constexpr Mark marks[] = {Mark::slip};

  static const char* fault(const Joint& joint) {
    return joint.parameters->grip > 0 && joint.parameters->friction > 0
               ? "has both a grip and a coefficient of friction"
               : nullptr;
  }
  static Real gap(const Joint&, const Pose&, const Pose&) { return 0; }
  static void write(const Joint& joint, const BodyState& a, const BodyState& b, RowsOut out) {
    write_slip_rows(K::slip_point(joint, a, b), {joint, a, b}, K::rows, out);
  }
};

inline constexpr Parameter kGripParameter = {
    .key = "grip",
    .about = "N: the force beyond which it slides against that force. Default 0: it never slides.",
    .range = ParameterRange::not_negative,
    .value = [](JointParameters& own) -> Real& { return own.grip; }};
inline constexpr Parameter kFrictionParameter = {
    .key = "friction_coefficient",
    .about =
        "Instead of grip: it slides beyond that times its load, the normal force of the one "
        "joint between its bodies, or between a and a body joined to b, that carries them. "
        "Those on one such joint share it equally. Default 0: it never slides.",
    .range = ParameterRange::not_negative,
    .value = [](JointParameters& own) -> Real& { return own.friction; }};

}  // namespace joint_kinds
}  // namespace pantin::detail
