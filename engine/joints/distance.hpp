#pragma once
/// The anchors stay a length L above zero apart: C = (d.d - L L) / (2 L), close to |d| - L.
#include "engine/joints/primitives.hpp"

namespace pantin {

struct DistanceRows {
  static constexpr int rows = 1;
  static void write(const Joint& joint, const Placed& a, const Placed& b, RowsOut out) {
    write_distance(0, joint.extras->length, span_of(joint, a, b, out.gamma != nullptr), out);
  }
};

}  // namespace pantin
