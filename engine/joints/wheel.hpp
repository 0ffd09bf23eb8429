#pragma once
/// Wheel: a thin disc of radius R rolls without slip on a plane of a, which it need not touch.
///
///   c = x_b + anchor_b                     the hub; x of b is the axle
///   e = (n - (n.x) x) / L,  L = |n - (n.x) x|   towards the top of the disc; n is y of a
///   r_b = anchor_b - R e                   to the lowest point
///   t_0 = (x x n) / L,  t_1 = n x t_0      along the track, and across it
///
/// No row keeps the disc at its height; other joints do. A disc that lies flat (L = 0) has no
/// lowest point: its rows are zero.
#include "engine/joints/primitives.hpp"
#include "engine/joints/slip.hpp"

namespace pantin::detail::joint_kinds {

struct wheel : Slips<wheel> {
  static constexpr std::string_view name = "wheel";
  static constexpr int rows = 2, degrees_of_freedom = 4;
  static constexpr Parameter parameters[] = {
      {.key = "radius",
       .needed = "the radius of the wheel, in m",
       .range = ParameterRange::size,
       .value = [](JointParameters& own) -> Real& { return own.length; }},
      kGripParameter,
      kFrictionParameter};

  static SlipPoint slip_point(const Joint& joint, const BodyState& a, const BodyState& b) {
    constexpr Real kFlat = 1e-9;
    const Vec3 x = axes_on_b(joint, b).x(), n = axes_on_a(joint, a).y();
    const Vec3 x_rate = glm::cross(b.angular_velocity, x),
               n_rate = glm::cross(a.angular_velocity, n);
    const Real lean = glm::dot(n, x), lean_rate = glm::dot(n_rate, x) + glm::dot(n, x_rate);
    const Vec3 up = n - lean * x;
    SlipPoint p;
    p.normal = n;
    p.arm_b = b.rotation_matrix * joint.anchor_b;
    p.arm_b_rate = glm::cross(b.angular_velocity, p.arm_b);
    const Real length = glm::length(up), radius = joint.parameters->length;
    if (length > kFlat) {
      const Vec3 e = up / length, t = glm::cross(x, n) / length;
      const auto unit_rate = [&](Vec3 unit, Vec3 rate) {
        return (rate - glm::dot(unit, rate) * unit) / length;
      };
      const Vec3 e_rate = unit_rate(e, n_rate - lean_rate * x - lean * x_rate);
      const Vec3 t_rate = unit_rate(t, glm::cross(x_rate, n) + glm::cross(x, n_rate));
      p.arm_b -= radius * e, p.arm_b_rate -= radius * e_rate;
      p.tangent[0] = t, p.tangent[1] = glm::cross(n, t);
      p.tangent_rate[0] = t_rate;
      p.tangent_rate[1] = glm::cross(n_rate, t) + glm::cross(n, t_rate);
    }
    place_arm_a(p, a, b);
    return p;
  }
};

}  // namespace pantin::detail::joint_kinds
