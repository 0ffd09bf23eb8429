// Reduction of the points of a manifold.
#include <algorithm>
#include <span>

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

namespace {

struct Keep {
  std::size_t first, most;
  Real same = 0;
};

/// Keeps the deepest point, then repeatedly the one farthest from those kept, by the square
/// `way_between`. A negative square rejects a point.
template <class Way>
void keep_apart(std::vector<ContactPoint>& points, const Keep& keep, const Way& way_between) {
  const std::size_t first = keep.first, most = keep.most;
  const Real same = keep.same;
  const auto begin = points.begin() + static_cast<std::ptrdiff_t>(first);
  Real least = 1e300;
  for (auto p = begin; p != points.end(); ++p) least = glm::min(least, p->gap);
  const auto is_deepest = [&](const ContactPoint& p) { return !(p.gap > least + same); };
  std::iter_swap(begin, std::find_if(begin, points.end(), is_deepest));
  for (std::size_t kept = 1; kept < glm::min(most, points.size() - first); ++kept) {
    // Take the point farthest from the others; by a margin, so that the choice persists.
    std::size_t best = first + kept;
    Real farthest = -1;
    for (std::size_t i = first + kept; i < points.size(); ++i) {
      const Real way = way_between(points[i], std::span(points).subspan(first, kept));
      if (way > (same > 0 ? 1.01 : 1) * farthest) farthest = way, best = i;
    }
    if (farthest < 0) return points.resize(first + kept);
    std::swap(points[first + kept], points[best]);
  }
  points.resize(glm::min(points.size(), first + most));
}

}  // namespace

void reduce_points(std::vector<ContactPoint>& points, std::size_t first, std::size_t most,
                   Real same) {
  if (points.size() - first <= most) return;
  keep_apart(points, {first, most, same},
             [](const ContactPoint& p, std::span<const ContactPoint> kept) {
               Real way = 1e300;
               for (const ContactPoint& q : kept)
                 way = glm::min(way, glm::dot(p.on_a - q.on_a, p.on_a - q.on_a));
               return way;
             });
}

void reduce_directed(std::vector<ContactPoint>& points, std::size_t first, std::size_t most,
                     Real size) {
  constexpr Real kAlike = 0.995;  // cosine
  if (points.size() - first <= most / 2) return;
  keep_apart(points, {first, most, 1e-6 * size},
             [&](const ContactPoint& p, std::span<const ContactPoint> kept) {
               Real way = 1e300;
               std::size_t alike = 0;
               for (const ContactPoint& q : kept) {
                 const Vec3 apart = p.on_a - q.on_a, turn = size * (p.normal - q.normal);
                 way = glm::min(way, glm::dot(apart, apart) + glm::dot(turn, turn));
                 if (glm::dot(p.normal, q.normal) > kAlike) ++alike;
               }
               return alike < most / 2 ? way : -1;
             });
}

}  // namespace pantin::detail
