#pragma once
/// Hinge joint: a shared point and a shared axis x; y and z of a stay perpendicular to x of b.
#include "engine/joints/ball.hpp"

namespace pantin::detail::joint_kinds {

struct hinge : SharesPoint, TurnsAboutX {
  static constexpr std::string_view name = "hinge", alias = "revolute";
  static constexpr int rows = 5, degrees_of_freedom = 1;
  static constexpr FreeCoordinate coordinates[] = {
      {Coordinate::angle, "angle", kActuated | kGeared}};
  static constexpr Mark marks[] = {Mark::axis_x, Mark::angle};

  static void write(const Joint& joint, const BodyState& a, const BodyState& b, RowsOut out) {
    ball::write(joint, a, b, out);
    const JointAxes on_a = axes_on_a(joint, a);
    const Vec3 x = axes_on_b(joint, b).x();
    write_row(3, dot_row(on_a.y(), x, a, b), out);
    write_row(4, dot_row(on_a.z(), x, a, b), out);
  }
};

}  // namespace pantin::detail::joint_kinds
