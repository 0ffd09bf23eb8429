#pragma once
/// Two bodies share a point: C = p_a - p_b.
#include "engine/joints/primitives.hpp"

namespace pantin {

struct BallRows {
  static constexpr int rows = 3;
  static void write(const Joint& joint, const Placed& a, const Placed& b, RowsOut out) {
    write_point(span_of(joint, a, b, out.gamma != nullptr), out);
  }
};

}  // namespace pantin
