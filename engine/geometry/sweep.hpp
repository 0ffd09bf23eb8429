#pragma once
/// Sweep of a convex shape along a straight line, without rotation.
#include <optional>

#include "engine/geometry/kinds.hpp"

namespace pantin::detail {

/// First contact of a sweep.
struct SweepHit {
  Real distance = 0;     // m, along the way; 0: overlap at the start
  Vec3 point{0};         // of the other shape
  Vec3 normal{0, 1, 0};  // unit, out of the other shape
};

/// Where `a`, a convex shape, first touches `b` when it moves along `way`, of unit length, by at
/// most `limit` (m). World axes. Distances are accurate to 1e-9 of the shapes' sizes.
std::optional<SweepHit> sweep(const PlacedShape& a, const PlacedShape& b, Vec3 way, Real limit);

}  // namespace pantin::detail
