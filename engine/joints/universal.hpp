#pragma once
/// Universal joint: a shared point; y of a stays perpendicular to z of b. Rotates about y of a,
/// then about z of b.
#include "engine/joints/ball.hpp"

namespace pantin::detail::joint_kinds {

struct universal : SharesPoint, TurnsAboutTwo {
  static constexpr std::string_view name = "universal";
  static constexpr int rows = 4, degrees_of_freedom = 2;
  static constexpr FreeCoordinate coordinates[] = {{Coordinate::angle, "first", kActuated},
                                                   {Coordinate::second, "second"}};
  static constexpr Mark marks[] = {Mark::axis_y, Mark::axis_z, Mark::two_angles};

  static void write_coordinate(const JointState& at, Coordinate which, RowsOut out) {
    if (which == Coordinate::angle)
      return write_row(0, universal_first(at.joint, at.a, at.b, at.before), out);
    Kind::write_coordinate(at, which, out);
  }
  static void write(const Joint& joint, const BodyState& a, const BodyState& b, RowsOut out) {
    ball::write(joint, a, b, out);
    write_row(3, dot_row(axes_on_a(joint, a).y(), axes_on_b(joint, b).z(), a, b), out);
  }
};

}  // namespace pantin::detail::joint_kinds
