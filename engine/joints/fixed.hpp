#pragma once
/// A shared point and shared axes.
#include "engine/joints/hinge.hpp"

namespace pantin {

struct FixedRows {
  static constexpr int rows = 6;
  static void write(const Joint& joint, const Placed& a, const Placed& b, RowsOut out) {
    HingeRows::write(joint, a, b, out);
    write_square(5, axes_on_a(joint, a).y(), axes_on_b(joint, b).z(), a, b, out);
  }
};

}  // namespace pantin
