#pragma once
/// A shared point; y of a stays square to z of b. Turns about y of a, then about z of b.
#include "engine/joints/ball.hpp"

namespace pantin {

struct UniversalRows {
  static constexpr int rows = 4;
  static void write(const Joint& joint, const Placed& a, const Placed& b, RowsOut out) {
    BallRows::write(joint, a, b, out);
    write_square(3, axes_on_a(joint, a).y(), axes_on_b(joint, b).z(), a, b, out);
  }
};

/// The two angles of universal_angles: how z of b stands about y of a, and y of a about z of b.
inline TurnRow universal_first(const Joint& joint, const Placed& a, const Placed& b, Real before) {
  const JointAxes on_a = axes_on_a(joint, a);
  const Vec3 z = axes_on_b(joint, b).z();
  return angle_row(dot_row(on_a.x(), z, a, b), dot_row(on_a.z(), z, a, b), a, b, before);
}
inline TurnRow universal_second(const Joint& joint, const Placed& a, const Placed& b,
                                Real before) {
  const JointAxes on_b = axes_on_b(joint, b);
  const Vec3 y = axes_on_a(joint, a).y();
  return angle_row(dot_row(y, on_b.x(), a, b), dot_row(y, on_b.y(), a, b), a, b, before);
}

}  // namespace pantin
