// Lines and conics, and surfaces derived from them exactly.
#include <algorithm>
#include <cmath>

#include "engine/base/check.hpp"
#include "engine/nurbs/makers.hpp"

namespace pantin::detail::nurbs {
namespace {

/// Quadratic pieces of a circle: positions of their control points, in units of the radius, and
/// their weights.
struct Turn {
  Knots knots;
  struct Stop {
    Real x, y, weight;
  };
  std::vector<Stop> stops;
};

// Cosine and sine, exact for whole quarters.
std::array<Real, 2> direction(Real angle) {
  const Real quarters = angle / (kPi / 2), whole = std::round(quarters);
  if (std::abs(quarters - whole) > 1e-15 * std::max(1.0, std::abs(whole)))
    return {std::cos(angle), std::sin(angle)};
  constexpr Real kExact[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  const auto& d = kExact[((static_cast<int>(whole) % 4) + 4) % 4];
  return {d[0], d[1]};
}

Turn turn(Range angles) {
  const Real width = angles.width();
  PANTIN_ASSERT(width > 0 && width <= 2 * kPi * (1 + 1e-15));
  const int pieces = std::clamp(static_cast<int>(std::ceil(width / (kPi / 2) - 1e-12)), 1, 4);
  const bool is_whole = width >= 2 * kPi * (1 - 1e-15);
  Turn made;
  made.knots = {.degree = 2, .values = {0, 0, 0}, .is_periodic = is_whole};
  const bool is_quarter = is_whole || std::abs(width / pieces - kPi / 2) < 1e-15;
  const Real half = is_quarter ? std::sqrt(0.5) : std::cos(width / pieces / 2);
  for (int i = 0; i <= pieces; ++i) {
    const auto angle_at = [&](int k) { return angles.low + width * k / pieces; };
    const auto [x, y] = direction(is_whole && i == pieces ? angles.low : angle_at(i));
    if (i > 0) {
      // The tangents at both ends of a piece meet here.
      const auto& before = made.stops.back();
      const Real k = is_quarter ? 1 : 1 / (2 * half * half);
      made.stops.push_back({(before.x + x) * k, (before.y + y) * k, half});
      if (i < pieces) made.knots.values.insert(made.knots.values.end(), 2, Real(i) / pieces);
    }
    made.stops.push_back({x, y, 1});
  }
  made.knots.values.insert(made.knots.values.end(), 3, 1);
  return made;
}

}  // namespace

Curve line(Vec3 from, Vec3 to) {
  return {{.degree = 1, .values = {0, 0, 1, 1}}, {Weighted(from, 1), Weighted(to, 1)}};
}

Curve elliptic_arc(const Frame& at, Real a, Real b, Range angles) {
  const Turn around = turn(angles);
  Curve made{around.knots, {}};
  for (const auto& s : around.stops)
    made.points.push_back(Weighted(at.origin + a * s.x * at.x + b * s.y * at.y, s.weight));
  return made;
}

Curve ellipse(const Frame& at, Real a, Real b) { return elliptic_arc(at, a, b, {0, 2 * kPi}); }

Surface revolved(const Curve& profile, const Frame& at, Real angle) {
  const Turn around = turn({0, angle});
  Surface made{around.knots, profile.knots, {}};
  for (const auto& s : around.stops)
    for (const Weighted& w : profile.points) {
      const Vec3 arm = w.point() - at.origin;
      const Real x = glm::dot(arm, at.x), y = glm::dot(arm, at.y), z = glm::dot(arm, at.z);
      const Vec3 turned = (x * s.x - y * s.y) * at.x + (x * s.y + y * s.x) * at.y + z * at.z;
      made.points.push_back(Weighted(at.origin + turned, s.weight * w.w));
    }
  return made;
}

Surface plane(const Frame& at, Real a, Real b) {
  const Vec3 corner = at.origin - (a * at.x + b * at.y) / 2.0;
  return extruded(line(corner, corner + a * at.x), b * at.y);
}

Surface cone(const Frame& at, std::array<Real, 2> radii, Real height) {
  const Vec3 bottom = at.origin + radii[0] * at.x;
  const Vec3 top = at.origin + radii[1] * at.x + height * at.z;
  return revolved(line(bottom, top), at, 2 * kPi);
}

Surface cylinder(const Frame& at, Real radius, Real height) {
  return cone(at, {radius, radius}, height);
}

Surface torus(const Frame& at, Real radius, Real tube) {
  const Frame around{at.origin + radius * at.x, at.x, at.z, -at.y};
  return revolved(circle(around, tube), at, 2 * kPi);
}

Surface sphere(const Frame& at, Real radius) { return ellipsoid(at, Vec3(radius)); }

Surface ellipsoid(const Frame& at, Vec3 half_axes) {
  const Frame own{};
  const Frame meridian{Vec3(0), own.x, own.z, -own.y};
  const Surface unit = revolved(arc(meridian, 1, {-kPi / 2, kPi / 2}), own, 2 * kPi);
  const Mat3 axes(half_axes.x * at.x, half_axes.y * at.y, half_axes.z * at.z);
  return transformed(unit, {axes, at.origin});
}

Surface extruded(const Curve& curve, Vec3 way) {
  Surface made{curve.knots, {.degree = 1, .values = {0, 0, 1, 1}}, {}};
  for (const Weighted& w : curve.points) {
    made.points.push_back(w);
    made.points.push_back(Weighted(w.product().x + w.w * way.x, w.product().y + w.w * way.y,
                                   w.product().z + w.w * way.z, w.w));
  }
  return made;
}

Surface swept(const Curve& section, const Curve& path) {
  Surface made{path.knots, section.knots, {}};
  for (const Weighted& p : path.points)
    for (const Weighted& s : section.points)
      made.points.push_back(Weighted(p.point() + s.point(), p.w * s.w));
  return made;
}

// ---- Ellipsoids without poles ------------------------------------------------------------------

namespace {

// The axes of a chart: u, v and outwards, right-handed.
std::array<Vec3, 3> axes_of(int chart) {
  const int axis = chart / 2;
  const Real sign = chart % 2 == 0 ? 1 : -1;
  Vec3 out(0), u(0), v(0);
  out[axis] = sign, u[(axis + 1) % 3] = sign, v[(axis + 2) % 3] = 1;
  return {u, v, out};
}

}  // namespace

std::array<Surface, 6> charts(Vec3 half_axes) {
  // (2 u, 2 v, 1 - u^2 - v^2) / (1 + u^2 + v^2) over a square, by blossoms of its terms.
  constexpr Real r = kChartReach;
  constexpr Real kLinear[3] = {-r, 0, r}, kSquare[3] = {r * r, -r * r, r * r};
  std::array<Surface, 6> all;
  for (int chart = 0; chart < 6; ++chart) {
    const auto [x, y, z] = axes_of(chart);
    const Knots knots{.degree = 2, .values = {-r, -r, -r, r, r, r}};
    Surface& made = all[static_cast<std::size_t>(chart)];
    made = {knots, knots, {}};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const Real squares = kSquare[i] + kSquare[j];
        const Vec3 a = half_axes * (2 * kLinear[i] * x + 2 * kLinear[j] * y + (1 - squares) * z);
        made.points.push_back({a.x, a.y, a.z, 1 + squares});
      }
  }
  return all;
}

ChartPoint chart_point(Vec3 half_axes, Vec3 p) {
  const Vec3 d = glm::normalize(p / half_axes);
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(d[i]) > std::abs(d[axis])) axis = i;
  const int chart = 2 * axis + (d[axis] < 0 ? 1 : 0);
  const auto [x, y, z] = axes_of(chart);
  const Real below = 1 + glm::dot(d, z);
  return {chart, glm::dot(d, x) / below, glm::dot(d, y) / below};
}

}  // namespace pantin::detail::nurbs
