#pragma once
/// Free coordinates of joints, as rows: angles about the joint axes, the travel, the length.
#include "engine/joints/swing.hpp"

namespace pantin::detail {

/// The two angles of universal_angles: of z of b about y of a, and of y of a about z of b.
inline AngularRow universal_first(const Joint& joint, const BodyState& a, const BodyState& b,
                                  Real before) {
  const JointAxes on_a = axes_on_a(joint, a);
  const Vec3 z = axes_on_b(joint, b).z();
  return angle_row(dot_row(on_a.x(), z, a, b), dot_row(on_a.z(), z, a, b),
                   relative_angular_velocity(a, b), before);
}
inline AngularRow universal_second(const Joint& joint, const BodyState& a, const BodyState& b,
                                   Real before) {
  const JointAxes on_b = axes_on_b(joint, b);
  const Vec3 y = axes_on_a(joint, a).y();
  return angle_row(dot_row(y, on_b.x(), a, b), dot_row(y, on_b.y(), a, b),
                   relative_angular_velocity(a, b), before);
}

/// The default of write_coordinate(): the twist about x, the second angle of a universal joint, the
/// swing, the travel of b's anchor along x of a.
void write_axis_coordinate(const JointState& at, Coordinate which, RowsOut out);

}  // namespace pantin::detail
