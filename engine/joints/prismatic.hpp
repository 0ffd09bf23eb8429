#pragma once
/// Prismatic joint: b translates along a shared axis x without rotation.
#include "engine/joints/cylindrical.hpp"

namespace pantin::detail::joint_kinds {

struct prismatic : SlidesAlongX, TurnsNowhere {
  static constexpr std::string_view name = "prismatic";
  static constexpr int rows = 5, degrees_of_freedom = 1;
  static constexpr FreeCoordinate coordinates[] = {
      {Coordinate::travel, "travel", kActuated | kGeared}};

  static void write(const Joint& joint, const BodyState& a, const BodyState& b, RowsOut out) {
    cylindrical::write(joint, a, b, out);
    write_row(4, dot_row(axes_on_a(joint, a).y(), axes_on_b(joint, b).z(), a, b), out);
  }
};

}  // namespace pantin::detail::joint_kinds
