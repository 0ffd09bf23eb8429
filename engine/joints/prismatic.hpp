#pragma once
/// A shared line x, along which b slides without turning.
#include "engine/joints/cylindrical.hpp"

namespace pantin::joint_kinds {

struct prismatic : SlidesAlongX, TurnsNowhere {
  static constexpr std::string_view name = "prismatic";
  static constexpr int rows = 5, freedoms = 1;
  static constexpr FreeCoordinate coordinates[] = {
      {Coordinate::slide, "travel", kActuated | kGeared}};

  static void write(const Joint& joint, const Placed& a, const Placed& b, RowsOut out) {
    cylindrical::write(joint, a, b, out);
    write_square(4, axes_on_a(joint, a).y(), axes_on_b(joint, b).z(), a, b, out);
  }
};

}  // namespace pantin::joint_kinds
