#pragma once
/// A shared line x, along which b slides without turning.
#include "engine/joints/cylindrical.hpp"

namespace pantin {

struct PrismaticRows {
  static constexpr int rows = 5;
  static void write(const Joint& joint, const Placed& a, const Placed& b, RowsOut out) {
    CylindricalRows::write(joint, a, b, out);
    write_square(4, axes_on_a(joint, a).y(), axes_on_b(joint, b).z(), a, b, out);
  }
};

}  // namespace pantin
