#include "engine/geometry/plane_hull.hpp"

#include <algorithm>
#include <cmath>

namespace pantin::detail {
namespace {

constexpr Real kFlat = 1e-9;   // sine of an angle that counts as straight
constexpr Real kSame = 1e-12;  // of the extent of all: distance of points that count as one

bool turns_left(Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 in = b - a, out = c - b;
  const Real turn = in.x * out.y - in.y * out.x;
  const bool is_back = glm::dot(in, out) < 0;  // a reversal at a tip, however sharp
  return turn > (is_back ? 0 : kFlat * glm::length(in) * glm::length(out));
}

/// Whether all points are within `width` of one line.
bool are_in_line(const std::vector<Vec3>& points, Real width) {
  const auto from_first = [&](Vec3 p) { return glm::distance(p, points.front()); };
  const Vec3 way = *std::ranges::max_element(points, {}, from_first) - points.front();
  return std::ranges::all_of(points, [&](Vec3 p) {
    const Vec3 d = p - points.front();
    return std::abs(way.x * d.y - way.y * d.x) <= width * glm::length(way);
  });
}

}  // namespace

// [Andrew 1979]
std::vector<Vec3> plane_hull(std::vector<Vec3> points) {
  if (points.size() < 3) return {};
  std::ranges::sort(points, [](Vec3 p, Vec3 q) { return p.x != q.x ? p.x < q.x : p.y < q.y; });
  Real extent = 0;
  for (const Vec3& p : points) extent = std::max(extent, glm::distance(p, points.front()));
  if (are_in_line(points, kSame * extent)) return {};
  std::vector<Vec3> hull;
  for (int half = 0; half < 2; ++half) {
    const std::size_t from = hull.size();
    for (const Vec3& p : points) {
      while (hull.size() >= from + 2 && !turns_left(hull[hull.size() - 2], hull.back(), p))
        hull.pop_back();
      if (hull.size() == from || glm::distance(p, hull.back()) > kSame * extent) hull.push_back(p);
    }
    hull.pop_back();  // the first of the other half
    std::ranges::reverse(points);
  }
  return hull;
}

}  // namespace pantin::detail
