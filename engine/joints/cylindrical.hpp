#pragma once
/// A shared line x, along which and about which b moves.
#include "engine/joints/primitives.hpp"

namespace pantin {

struct CylindricalRows {
  static constexpr int rows = 4;
  static void write(const Joint& joint, const Placed& a, const Placed& b, RowsOut out) {
    write(joint, span_of(joint, a, b, out.gamma != nullptr), a, b, out);
  }
  static void write(const Joint& joint, const AnchorSpan& span, const Placed& a, const Placed& b,
                    RowsOut out) {
    const JointAxes on_a = axes_on_a(joint, a);
    const Vec3 y = on_a.y(), z = on_a.z(), x = axes_on_b(joint, b).x();
    write_square(0, y, x, a, b, out);
    write_square(1, z, x, a, b, out);
    write_along(2, y, span, a, out);
    write_along(3, z, span, a, out);
  }
};

}  // namespace pantin
