#include "engine/modes/outline.hpp"

#include <algorithm>
#include <limits>

namespace pantin::detail::modes {
namespace {

std::size_t after(std::size_t i, std::size_t count) { return i + 1 < count ? i + 1 : 0; }

/// The side of the line from a to b on which p is: 1 left, -1 right, 0 on it.
int side(Vec2 a, Vec2 b, Vec2 p) {
  const Real turn = cross(b - a, p - a);
  return (turn > 0) - (turn < 0);
}

bool meet(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  if (side(a, b, c) * side(a, b, d) > 0 || side(c, d, a) * side(c, d, b) > 0) return false;
  const auto apart = [](Real a0, Real a1, Real b0, Real b1) {
    return std::max(a0, a1) < std::min(b0, b1) || std::max(b0, b1) < std::min(a0, a1);
  };
  return !apart(a.x, b.x, c.x, d.x) && !apart(a.y, b.y, c.y, d.y);
}

}  // namespace

Real area(std::span<const Vec2> corners) {
  Real sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    sum += cross(corners[i] - corners[0], corners[after(i, corners.size())] - corners[0]) / 2;
  return sum;
}

Vec2 centroid(std::span<const Vec2> corners) {
  Vec2 sum;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i] - corners[0], b = corners[after(i, corners.size())] - corners[0];
    sum = sum + cross(a, b) / 6 * (a + b);
  }
  return corners[0] + 1 / area(corners) * sum;
}

Real extent(std::span<const Vec2> corners) {
  Vec2 low = corners[0], high = corners[0];
  for (const Vec2 c : corners) {
    low = {std::min(low.x, c.x), std::min(low.y, c.y)};
    high = {std::max(high.x, c.x), std::max(high.y, c.y)};
  }
  return std::max(high.x - low.x, high.y - low.y);
}

std::optional<std::pair<std::size_t, std::size_t>> crossing(std::span<const Vec2> corners) {
  const std::size_t n = corners.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j + 1 == n) continue;
      if (meet(corners[i], corners[after(i, n)], corners[j], corners[after(j, n)]))
        return std::pair(i, j);
    }
  return std::nullopt;
}

bool is_inside(std::span<const Vec2> corners, Vec2 p) {
  bool inside = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i], b = corners[after(i, corners.size())];
    if ((a.y > p.y) == (b.y > p.y)) continue;
    if (p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
  }
  return inside;
}

bool is_convex(std::span<const Vec2> corners) {
  const std::size_t n = corners.size();
  for (std::size_t i = 0; i < n; ++i)
    if (cross(corners[(i + 1) % n] - corners[i], corners[(i + 2) % n] - corners[(i + 1) % n]) < 0)
      return false;
  return true;
}

/// By ear clipping.
std::vector<std::vector<Vec2>> convex_pieces(std::span<const Vec2> outline) {
  std::vector<Vec2> corners(outline.begin(), outline.end());
  if (is_convex(outline)) return {std::move(corners)};
  std::vector<std::vector<Vec2>> all;
  for (std::size_t i = 0; corners.size() > 3 && i < corners.size();) {
    const std::size_t n = corners.size();
    const Vec2 a = corners[(i + n - 1) % n], b = corners[i], c = corners[(i + 1) % n];
    const auto is_in = [&](Vec2 p) {
      return cross(b - a, p - a) > 0 && cross(c - b, p - b) > 0 && cross(a - c, p - c) > 0;
    };
    if (cross(b - a, c - b) <= 0 || std::any_of(corners.begin(), corners.end(), is_in)) {
      ++i;
      continue;
    }
    all.push_back({a, b, c});
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(i));
    i = 0;
  }
  if (corners.size() == 3) all.push_back(std::move(corners));
  return all;
}

Edge edge_of(std::span<const Vec2> corners, std::size_t edge) {
  Edge e;
  e.from = corners[edge];
  const Vec2 way = corners[after(edge, corners.size())] - e.from;
  e.length = length(way);
  e.along = 1 / e.length * way;
  e.normal = tangent_of(e.along);
  return e;
}

Nearest nearest_edge(std::span<const Vec2> corners, Vec2 p, Real tolerance) {
  Nearest best;
  best.distance = std::numeric_limits<Real>::infinity();
  Real second = best.distance;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Edge e = edge_of(corners, i);
    const Real t = std::clamp(dot(p - e.from, e.along), 0.0, e.length);
    const Real away = length(p - e.from - t * e.along);
    if (away < best.distance) {
      second = best.distance;
      best.edge = i, best.distance = away;
    } else {
      second = std::min(second, away);
    }
  }
  best.is_corner = second <= best.distance + tolerance;
  return best;
}

}  // namespace pantin::detail::modes
