#pragma once
/// A shared line x, along which b slides by `pitch` for each rad that it turns:
///
///   C_4 = x_a.d - pitch angle           angle: the one nearest to `angle_before`
#include "engine/joints/cylindrical.hpp"

namespace pantin {

struct ScrewRows {
  static constexpr int rows = 5;
  static void write(const Joint& joint, const Placed& a, const Placed& b, Real angle_before,
                    RowsOut out) {
    const AnchorSpan span = span_of(joint, a, b, out.gamma != nullptr);
    CylindricalRows::write(joint, span, a, b, out);
    const JointAxes on_a = axes_on_a(joint, a);
    write_along(4, on_a.x(), span, a, out);
    const TurnRow turn = twist_row(on_a, axes_on_b(joint, b), a, b, angle_before);
    const Real pitch = joint.extras->pitch;
    if (out.c) out.c[4] -= pitch * turn.c;
    if (out.gamma) out.gamma[4] -= pitch * turn.gamma;
    if (out.j) out.j[17] -= pitch * turn.k, out.j[19] += pitch * turn.k;
  }
};

}  // namespace pantin
