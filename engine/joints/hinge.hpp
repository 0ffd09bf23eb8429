#pragma once
/// A shared point and a shared axis x: y and z of a stay square to x of b.
#include "engine/joints/ball.hpp"

namespace pantin {

struct HingeRows {
  static constexpr int rows = 5;
  static void write(const Joint& joint, const Placed& a, const Placed& b, RowsOut out) {
    BallRows::write(joint, a, b, out);
    const JointAxes on_a = axes_on_a(joint, a);
    const Vec3 x = axes_on_b(joint, b).x();
    write_square(3, on_a.y(), x, a, b, out);
    write_square(4, on_a.z(), x, a, b, out);
  }
};

}  // namespace pantin
