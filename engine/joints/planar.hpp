#pragma once
/// Planar joint: b's anchor stays in the plane through a's anchor perpendicular to x; b rotates
/// about x only.
#include "engine/joints/kind.hpp"

namespace pantin::detail::joint_kinds {

struct planar : Kind, TurnsAboutX {
  static constexpr std::string_view name = "planar";
  static constexpr int rows = 3, degrees_of_freedom = 3;
  static constexpr FreeCoordinate coordinates[] = {{Coordinate::angle, "angle"}};
  static constexpr Mark marks[] = {Mark::axis_x};

  static Real gap(const Joint& joint, const Pose& a, const Pose& b) {
    return std::abs(glm::dot(residual(joint, a, b), axis_x_of_a(joint, a)));
  }
  static void write(const Joint& joint, const BodyState& a, const BodyState& b, RowsOut out) {
    const JointAxes on_a = axes_on_a(joint, a);
    const Vec3 x = axes_on_b(joint, b).x();
    write_row(0, dot_row(on_a.y(), x, a, b), out);
    write_row(1, dot_row(on_a.z(), x, a, b), out);
    write_along(2, on_a.x(), span_of(joint, a, b, out), out);
  }
};

}  // namespace pantin::detail::joint_kinds
