#pragma once
/// A shared line x, along which b slides by `pitch` for each rad that it turns:
///
///   C_4 = x_a.d - pitch angle           angle: the one nearest to `angle_before`
#include "engine/joints/cylindrical.hpp"

namespace pantin::joint_kinds {

struct screw : SlidesAlongX, TurnsAboutX {
  static constexpr std::string_view name = "screw";
  static constexpr int rows = 5, freedoms = 1;
  static constexpr bool counts_turns = true;
  static constexpr FreeCoordinate coordinates[] = {
      {Coordinate::turn, "angle", kActuated | kGeared}, {Coordinate::slide, "travel", kGeared}};
  static constexpr Parameter parameters[] = {
      {.key = "pitch",
       .needed = "how far it slides for each rad it turns, in m",
       .never_zero = "a screw without pitch is a hinge",
       .value = [](JointExtras& extras) -> Real& { return extras.pitch; }}};

  static Real slide_per_turn(const Joint& joint) { return joint.extras->pitch; }
  static Real gap(const Joint& joint, const Pose& a, const Pose& b) {
    const Vec3 x = axis_x_of_a(joint, a);
    const Real turn = swing_twist(relative_turn(joint, a.rotation, b.rotation)).twist;
    return glm::length(residual(joint, a, b) - slide_per_turn(joint) * turn * x);
  }

  static void write(const Joint& joint, const Placed& a, const Placed& b, Real angle_before,
                    RowsOut out) {
    const AnchorSpan span = span_of(joint, a, b, out.gamma != nullptr);
    cylindrical::write(joint, span, a, b, out);
    const JointAxes on_a = axes_on_a(joint, a);
    write_along(4, on_a.x(), span, a, out);
    const TurnRow turn = twist_row(on_a, axes_on_b(joint, b), a, b, angle_before);
    const Real pitch = joint.extras->pitch;
    if (out.c) out.c[4] -= pitch * turn.c;
    if (out.gamma) out.gamma[4] -= pitch * turn.gamma;
    if (out.j) out.j[17] -= pitch * turn.k, out.j[19] += pitch * turn.k;
  }
};

}  // namespace pantin::joint_kinds
