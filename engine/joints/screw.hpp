#pragma once
/// Screw joint: b translates by `pitch` per radian along a shared axis x:
///
///   C_4 = x_a.d - pitch angle       angle: nearest to JointState::before
#include "engine/joints/cylindrical.hpp"

namespace pantin::detail::joint_kinds {

struct screw : SlidesAlongX, TurnsAboutX {
  static constexpr std::string_view name = "screw";
  static constexpr int rows = 5, degrees_of_freedom = 1;
  static constexpr bool counts_turns = true;
  static constexpr FreeCoordinate coordinates[] = {
      {Coordinate::angle, "angle", kActuated | kGeared}, {Coordinate::travel, "travel", kGeared}};
  static constexpr Parameter parameters[] = {
      {.key = "pitch",
       .needed = "the travel per rad of rotation, in m/rad",
       .never_zero = "a screw without pitch is a hinge",
       .value = [](JointParameters& own) -> Real& { return own.pitch; }}};

  static Real slide_per_turn(const Joint& joint) { return joint.parameters->pitch; }
  static Real gap(const Joint& joint, const Pose& a, const Pose& b) {
    const Vec3 x = axis_x_of_a(joint, a);
    const Real rotation = swing_twist(relative_rotation(joint, a.rotation, b.rotation)).twist;
    return glm::length(residual(joint, a, b) - slide_per_turn(joint) * rotation * x);
  }

  static void write(const JointState& at, RowsOut out) {
    const auto& [joint, a, b, angle_before] = at;
    const AnchorSpan span = span_of(joint, a, b, out);
    cylindrical::write(at, span, out);
    write_along(4, axes_on_a(joint, a).x(), span, out);
    const AngularRow rotation = twist_row(joint, a, b, angle_before);
    const Real pitch = joint.parameters->pitch;
    if (out.c) out.c[4] -= pitch * rotation.c;
    if (out.gamma) out.gamma[4] -= pitch * rotation.gamma;
    if (out.j) out.j[17] -= pitch * rotation.k, out.j[19] += pitch * rotation.k;
  }
};

}  // namespace pantin::detail::joint_kinds
