#pragma once
/// Cylindrical joint: b rotates about and translates along a shared axis x.
#include "engine/joints/kind.hpp"

namespace pantin::detail::joint_kinds {

struct cylindrical : SlidesAlongX, TurnsAboutX {
  static constexpr std::string_view name = "cylindrical";
  static constexpr int rows = 4, degrees_of_freedom = 2;
  static constexpr FreeCoordinate coordinates[] = {
      {Coordinate::angle, "angle", kActuated | kGeared},
      {Coordinate::travel, "travel", kActuated | kGeared}};

  static void write(const Joint& joint, const BodyState& a, const BodyState& b, RowsOut out) {
    write({joint, a, b}, span_of(joint, a, b, out), out);
  }
  static void write(const JointState& at, const AnchorSpan& span, RowsOut out) {
    const auto& [joint, a, b, before] = at;
    const JointAxes on_a = axes_on_a(joint, a);
    const Vec3 y = on_a.y(), z = on_a.z(), x = axes_on_b(joint, b).x();
    write_row(0, dot_row(y, x, a, b), out);
    write_row(1, dot_row(z, x, a, b), out);
    write_along(2, y, span, out);
    write_along(3, z, span, out);
  }
};

}  // namespace pantin::detail::joint_kinds
