#pragma once
/// b's anchor stays in the plane through a's anchor across x; b turns about x only.
#include "engine/joints/primitives.hpp"

namespace pantin {

struct PlanarRows {
  static constexpr int rows = 3;
  static void write(const Joint& joint, const Placed& a, const Placed& b, RowsOut out) {
    const JointAxes on_a = axes_on_a(joint, a);
    const Vec3 x = axes_on_b(joint, b).x();
    write_square(0, on_a.y(), x, a, b, out);
    write_square(1, on_a.z(), x, a, b, out);
    write_along(2, on_a.x(), span_of(joint, a, b, out.gamma != nullptr), a, out);
  }
};

}  // namespace pantin
