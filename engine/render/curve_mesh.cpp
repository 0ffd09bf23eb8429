#include "engine/render/curve_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "engine/nurbs/plane_curves.hpp"

namespace pantin::detail {
namespace {

// Relative to the curve's size.
constexpr Real kChord = 5e-4, kPlate = 0.05, kWall = 0.03, kTube = 0.012;
constexpr std::size_t kSides = 10;  // of a tube

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

Real cross(Vec3 a, Vec3 b) { return a.x * b.y - a.y * b.x; }

/// Triangulates a simple anticlockwise polygon by ear clipping.
Triangles ears(const std::vector<Vec3>& p) {
  Triangles all;
  std::vector<std::uint32_t> left(p.size());
  for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
  std::size_t at = 0, tries = 0;
  while (left.size() > 3 && tries <= 2 * left.size()) {
    const std::size_t n = left.size();
    const std::uint32_t a = left[(at + n - 1) % n], b = left[at % n], c = left[(at + 1) % n];
    const bool is_convex = cross(p[b] - p[a], p[c] - p[b]) > 0;
    const bool is_ear = is_convex && std::none_of(left.begin(), left.end(), [&](std::uint32_t q) {
                          if (q == a || q == b || q == c) return false;
                          return cross(p[b] - p[a], p[q] - p[a]) >= 0 &&
                                 cross(p[c] - p[b], p[q] - p[b]) >= 0 &&
                                 cross(p[a] - p[c], p[q] - p[c]) >= 0;
                        });
    if (is_ear) {
      all.push_back({a, b, c}), left.erase(left.begin() + static_cast<std::ptrdiff_t>(at % n));
      tries = 0, at = at % n;
      continue;
    }
    ++tries, at = (at + 1) % n;
  }
  if (left.size() == 3) all.push_back({left[0], left[1], left[2]});
  return all;
}

/// The closed mesh of a curve.
struct Mesh3 {
  std::vector<Vec3> points;
  Triangles triangles;
  void quad(std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    const auto n = [](std::size_t i) { return static_cast<std::uint32_t>(i); };
    triangles.push_back({n(a), n(b), n(c)}), triangles.push_back({n(a), n(c), n(d)});
  }
};

Mesh3 plate(const std::vector<Vec3>& outline, Real half) {
  Mesh3 made;
  const std::size_t n = outline.size();
  for (const Real z : {half, -half})
    for (const Vec3 p : outline) made.points.push_back({p.x, p.y, z});
  for (const auto& [a, b, c] : ears(outline)) {
    made.triangles.push_back({a, b, c});
    const auto down = static_cast<std::uint32_t>(n);
    made.triangles.push_back({a + down, c + down, b + down});
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t next = (i + 1) % n;
    made.quad(i, i + n, next + n, next);
  }
  return made;
}

/// Connects consecutive sections with equal corner counts, anticlockwise as seen against the
/// direction of the curve.
enum class Loft { ring, strip };
Mesh3 lofted(const std::vector<std::vector<Vec3>>& sections, Loft how) {
  const bool is_closed = how == Loft::ring;
  Mesh3 made;
  const std::size_t n = sections.size(), sides = sections[0].size();
  for (const auto& section : sections)
    made.points.insert(made.points.end(), section.begin(), section.end());
  for (std::size_t i = 0; i + (is_closed ? 0 : 1) < n; ++i) {
    const std::size_t here = i * sides, there = (i + 1) % n * sides;
    for (std::size_t k = 0; k < sides; ++k) {
      const std::size_t next = (k + 1) % sides;
      made.quad(here + k, there + k, there + next, here + next);
    }
  }
  if (is_closed) return made;
  for (std::uint32_t k = 1; k + 1 < sides; ++k) {
    const auto last = static_cast<std::uint32_t>((n - 1) * sides);
    made.triangles.push_back({0, k, k + 1});
    made.triangles.push_back({last, last + k + 1, last + k});
  }
  return made;
}

Mesh3 wall(const nurbs::Curve& curve, const std::vector<Real>& at, std::array<Real, 2> half) {
  std::vector<std::vector<Vec3>> sections;
  for (const Real t : at) {
    const nurbs::CurveDerivatives d = nurbs::evaluate(curve, t, 1);
    const Vec3 back = 2 * half[0] * glm::normalize(Vec3(-d[1].y, d[1].x, 0)), up(0, 0, half[1]);
    sections.push_back({d[0] - up, d[0] + up, d[0] + back + up, d[0] + back - up});
  }
  return lofted(sections, curve.knots.is_periodic ? Loft::ring : Loft::strip);
}

Mesh3 tube(const nurbs::Curve& curve, const std::vector<Real>& at, Real radius) {
  std::vector<std::vector<Vec3>> sections;
  Vec3 side(0);
  for (const Real t : at) {
    const nurbs::CurveDerivatives d = nurbs::evaluate(curve, t, 1);
    const Vec3 way = glm::normalize(d[1]);
    if (side == Vec3(0)) side = std::abs(way.x) < 0.7 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    side = glm::normalize(side - glm::dot(side, way) * way);
    const Vec3 other = glm::cross(way, side);
    std::vector<Vec3>& section = sections.emplace_back();
    for (std::size_t k = 0; k < kSides; ++k) {
      const Real angle = -2 * kPi * static_cast<Real>(k) / kSides;
      section.push_back(d[0] + radius * (std::cos(angle) * side + std::sin(angle) * other));
    }
  }
  return lofted(sections, curve.knots.is_periodic ? Loft::ring : Loft::strip);
}

}  // namespace

std::shared_ptr<const Surface> solid_of(const nurbs::Wire& wire) {
  const nurbs::Curve& curve = wire.curve();
  const Real size = wire.size();
  const nurbs::CurvePoints along = nurbs::points_along(curve, kChord * size);
  if (along.points.size() < 2) return nullptr;
  const bool is_flat = std::all_of(curve.points.begin(), curve.points.end(), [&](const auto& w) {
    return std::abs(w.point().z) <= 1e-9 * size;
  });
  Mesh3 made;
  if (!is_flat)
    made = tube(curve, along.at, kTube * size);
  else if (curve.knots.is_periodic && nurbs::area_around(curve) > 0)
    made = plate(along.points, kPlate * size);
  else
    made = wall(curve, along.at, {kWall * size, kPlate * size});
  auto solid = std::make_shared<Surface>();
  solid->points = std::move(made.points), solid->low = Vec3(1e300), solid->high = Vec3(-1e300);
  for (const Vec3 p : solid->points)
    solid->low = glm::min(solid->low, p), solid->high = glm::max(solid->high, p);
  for (const auto& triangle : made.triangles) {
    Face face{static_cast<std::uint32_t>(solid->corners.size()), 3};
    const Vec3 a = solid->points[triangle[0]];
    const Vec3 across = glm::cross(solid->points[triangle[1]] - a, solid->points[triangle[2]] - a);
    if (!(glm::length(across) > 0)) continue;
    face.normal = glm::normalize(across), face.offset = glm::dot(face.normal, a);
    solid->corners.insert(solid->corners.end(), triangle.begin(), triangle.end());
    solid->faces.push_back(face);
  }
  return solid;
}

}  // namespace pantin::detail
