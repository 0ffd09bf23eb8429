#pragma once
/// Simplexes in the Minkowski difference of two convex pieces, for the GJK algorithm.
/// [Gilbert, Johnson & Keerthi 1988]
#include <cstdint>

#include "engine/base/math.hpp"

namespace pantin::detail {

struct Vertex {
  Vec3 w{0};                   // of a minus of b
  std::uint32_t a = 0, b = 0;  // their numbers
  Real weight = 1;
};

struct Simplex {
  Vertex v[4];
  int count = 0;
};

/// Reduces a simplex to its part nearest to the origin, with weights, and that point; false if the
/// origin is inside.
bool shrink(Simplex& s, Vec3& point);

}  // namespace pantin::detail
