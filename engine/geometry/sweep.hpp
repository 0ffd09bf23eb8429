#pragma once
/// A convex shape that slides through others without turning.
#include <optional>

#include "engine/geometry/kinds.hpp"

namespace pantin::detail {

/// First contact of a slide.
struct SweepHit {
  Real distance = 0;     // m, along the way; 0: it started within
  Vec3 point{0};         // of the other shape
  Vec3 normal{0, 1, 0};  // unit, out of the other shape
};

/// Where `a`, a convex shape, first touches `b`, when it slides along `way`, of unit length, for at
/// most `limit` (m). World axes. Distances are good to 1e-9 of the shapes' sizes.
std::optional<SweepHit> sweep(const PlacedShape& a, const PlacedShape& b, Vec3 way, Real limit);

}  // namespace pantin::detail
