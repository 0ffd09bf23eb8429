#pragma once
/// How far convex shapes are apart, by a search over all directions.
#include <algorithm>
#include <vector>

#include "engine/geometry/kinds.hpp"
#include "tests/base/random.hpp"

namespace pantin::test {

/// How far two convex shapes are apart along a unit direction from b to a, m, by their support
/// functions.
inline Real gap_along(const detail::PlacedShape& a, const detail::PlacedShape& b, Vec3 normal) {
  const auto farthest = [](const detail::PlacedShape& s, Vec3 d) {
    const Vec3 own = glm::conjugate(s.at.rotation) * d;
    return to_world(s.at, detail::traits_of(s.shape.kind).support(s.shape, own));
  };
  return glm::dot(normal, farthest(a, -normal) - farthest(b, normal));
}

/// How thorough the search is.
struct Thoroughness {
  int directions = 3000, starts = 6;
};

/// The most by which any direction parts two convex shapes, m; below 0 the least overlap. By
/// support functions alone: the best of many directions, then of ever nearer ones.
inline Real brute_force_gap(const detail::PlacedShape& a, const detail::PlacedShape& b,
                            Random& dice, const Thoroughness& effort = {}) {
  constexpr int kTries = 16;
  struct Found {
    Vec3 normal;  // from b to a
    Real gap;
  };
  const auto along = [&](Vec3 n) { return Found{n, gap_along(a, b, n)}; };
  std::vector<Found> best;
  for (int i = 0; i < effort.directions; ++i) best.push_back(along(dice.direction()));
  std::partial_sort(best.begin(), best.begin() + effort.starts, best.end(),
                    [](const Found& p, const Found& q) { return p.gap > q.gap; });
  Real most = -1e300;
  for (int k = 0; k < effort.starts; ++k) {
    Found at = best[static_cast<std::size_t>(k)];
    for (Real step = 0.1; step > 1e-9;) {
      bool is_better = false;
      for (int i = 0; i < kTries; ++i) {
        const Found next = along(glm::normalize(at.normal + step * dice.direction()));
        if (next.gap > at.gap) at = next, is_better = true;
      }
      if (!is_better) step *= 0.5;
    }
    most = std::max(most, at.gap);
  }
  return most;
}

}  // namespace pantin::test
