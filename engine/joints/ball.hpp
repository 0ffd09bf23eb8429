#pragma once
/// Ball joint: two bodies share a point, C = p_a - p_b.
#include "engine/joints/kind.hpp"

namespace pantin::detail::joint_kinds {

struct ball : SharesPoint, TurnsFreely {
  static constexpr std::string_view name = "ball", alias = "spherical";
  static constexpr int rows = 3, degrees_of_freedom = 3;
  static constexpr bool uses_axes = false;  // unless it has limits or a drive
  static constexpr FreeCoordinate coordinates[] = {{Coordinate::angle, "twist"},
                                                   {Coordinate::swing, "cone"}};
  static constexpr Mark marks[] = {Mark::cone_and_twist};

  static void write(const Joint& joint, const BodyState& a, const BodyState& b, RowsOut out) {
    write_point(span_of(joint, a, b, out), out);
  }
};

}  // namespace pantin::detail::joint_kinds
