// Which points of a manifold are kept.
#include <algorithm>

#include "engine/geometry/manifold.hpp"

namespace pantin::detail {

void drop_duplicates(std::vector<ContactPoint>& points, std::size_t first, Real near) {
  std::size_t kept = first;
  for (std::size_t i = first; i < points.size(); ++i) {
    std::size_t j = first;
    const auto same = [&](const ContactPoint& p) {
      return (glm::distance(p.on_a, points[i].on_a) <= near ||
              glm::distance(p.on_b, points[i].on_b) <= near) &&
             glm::dot(p.normal, points[i].normal) > 1 - 1e-6;
    };
    while (j < kept && !same(points[j])) ++j;
    if (j == kept)
      points[kept++] = points[i];
    else if (points[i].gap < points[j].gap - near)
      points[j] = points[i];
  }
  points.resize(kept);
}

void reduce_points(std::vector<ContactPoint>& points, std::size_t first, std::size_t most,
                   Real same) {
  if (points.size() - first <= most) return;
  const auto begin = points.begin() + static_cast<std::ptrdiff_t>(first);
  Real least = 1e300;
  for (auto p = begin; p != points.end(); ++p) least = glm::min(least, p->gap);
  const auto is_deepest = [&](const ContactPoint& p) { return !(p.gap > least + same); };
  std::iter_swap(begin, std::find_if(begin, points.end(), is_deepest));
  for (std::size_t kept = 1; kept < most; ++kept) {
    // What matters is a place far from the others, and what is deeper than they are.
    std::size_t best = first + kept;
    Real farthest = -1;
    for (std::size_t i = first + kept; i < points.size(); ++i) {
      Real way = 1e300;
      for (std::size_t j = first; j < first + kept; ++j) {
        const Vec3 d = points[i].on_a - points[j].on_a;
        way = glm::min(way, glm::dot(d, d));
      }
      if (way > (same > 0 ? 1.01 : 1) * farthest) farthest = way, best = i;
    }
    std::swap(points[first + kept], points[best]);
  }
  points.resize(first + most);
}

}  // namespace pantin::detail
