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
    write(joint, span_of(joint, a, b, out.gamma != nullptr), a, b, out);
  }
  static void write(const Joint& joint, const AnchorSpan& span, const BodyState& a,
                    const BodyState& b, RowsOut out) {
    const JointAxes on_a = axes_on_a(joint, a);
    const Vec3 y = on_a.y(), z = on_a.z(), x = axes_on_b(joint, b).x();
    write_square(0, y, x, a, b, out);
    write_square(1, z, x, a, b, out);
    write_along(2, y, span, a, out);
    write_along(3, z, span, a, out);
  }
};

}  // namespace pantin::detail::joint_kinds
