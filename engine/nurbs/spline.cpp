#include "engine/nurbs/spline.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/check.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr Real kBinomial[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};

}  // namespace

CurveDerivatives evaluate_on(const Curve& curve, int span, Real t, int order) {
  const int p = curve.knots.degree;
  Basis basis;
  write_basis(curve.knots, {span, t}, order, basis);
  std::array<Weighted, kMostOrder + 1> a;
  for (int k = 0; k <= order; ++k)
    for (int j = 0; j <= p; ++j)
      a[k] = a[k] + basis[k][j] * curve.points[static_cast<std::size_t>(span - p + j)];
  CurveDerivatives d{};
  for (int k = 0; k <= order; ++k) {
    Vec3 sum = a[k].product();
    for (int i = 1; i <= k; ++i) sum -= kBinomial[k][i] * a[i].w * d[k - i];
    d[k] = sum / a[0].w;
  }
  return d;
}

CurveDerivatives evaluate(const Curve& curve, Real t, int order) {
  const Real inside = curve.knots.inside(t);
  return evaluate_on(curve, curve.knots.span_at(inside), inside, order);
}

namespace {

// Derivatives of S from those of A = w S and of w: the quotient rule.
SurfaceDerivatives divided(const Weighted (&a)[4][4], int order) {
  SurfaceDerivatives s{};
  for (int k = 0; k <= order; ++k)
    for (int l = 0; k + l <= order; ++l) {
      Vec3 sum = a[k][l].product();
      for (int i = 0; i <= k; ++i)
        for (int j = i == 0 ? 1 : 0; j <= l; ++j)
          sum -= kBinomial[k][i] * kBinomial[l][j] * a[i][j].w * s[k - i][l - j];
      s[k][l] = sum / a[0][0].w;
    }
  return s;
}

}  // namespace

SurfaceDerivatives evaluate_on(const Surface& surface, Cell cell, std::array<Real, 2> at,
                               int order) {
  const int p = surface.u.degree, q = surface.v.degree;
  Basis by_u, by_v;
  write_basis(surface.u, {cell.u, at[0]}, order, by_u);
  write_basis(surface.v, {cell.v, at[1]}, order, by_v);
  Weighted a[4][4];
  for (int i = 0; i <= p; ++i) {
    Weighted row[4];
    for (int j = 0; j <= q; ++j) {
      const Weighted& point = surface.at(cell.u - p + i, cell.v - q + j);
      for (int l = 0; l <= order; ++l) row[l] = row[l] + by_v[l][j] * point;
    }
    for (int k = 0; k <= order; ++k)
      for (int l = 0; k + l <= order; ++l) a[k][l] = a[k][l] + by_u[k][i] * row[l];
  }
  return divided(a, order);
}

SurfaceDerivatives evaluate(const Surface& surface, Real u, Real v, int order) {
  const std::array<Real, 2> at{surface.u.inside(u), surface.v.inside(v)};
  return evaluate_on(surface, {surface.u.span_at(at[0]), surface.v.span_at(at[1])}, at, order);
}

// ---- The same spline on other knots ------------------------------------------------------------

namespace {

Curve moved(const Curve& curve, Knots to) {
  Rows rows = on_knots(curve.knots, {curve.points, 1}, to);
  return {std::move(to), std::move(rows.points)};
}

Surface moved(const Surface& s, Along way, Knots to) {
  Rows rows{s.points, static_cast<std::size_t>(s.v.count())};
  if (way == Along::u) return {to, s.v, on_knots(s.u, rows, to).points};
  return {s.u, to, turned(on_knots(s.v, turned(rows), to)).points};
}

Knots added(Knots knots, Real knot, int times) {
  const Range domain = knots.domain();
  const Real first = knots.values.front(), last = knots.values.back();
  PANTIN_ASSERT(domain.holds(knot) && times >= 0);
  std::vector<Real> more{knot};
  if (knots.is_periodic) {
    for (Real t = knot - domain.width(); t > first; t -= domain.width()) more.push_back(t);
    for (Real t = knot + domain.width(); t < last; t += domain.width()) more.push_back(t);
  }
  for (Real& t : more)
    for (const Real end : {domain.low, domain.high})
      if (std::abs(t - end) < 1e-12 * domain.width()) t = end;
  for (Real t : more) {
    const auto at = std::upper_bound(knots.values.begin(), knots.values.end(), t);
    knots.values.insert(at, static_cast<std::size_t>(times), t);
  }
  // Images push knots out at both ends, so that the domain stays; both ends have the same index
  // among their copies.
  if (knots.is_periodic && first < domain.low && domain.high < last) {
    auto& values = knots.values;
    const auto high = std::upper_bound(values.begin(), values.end(), domain.high) - 1;
    values.erase(high + knots.degree + 1, values.end());
    const auto low = std::upper_bound(values.begin(), values.end(), domain.low) - 1;
    values.erase(values.begin(), low - knots.degree);
  }
  return knots;
}

// Every inner knot once more, the ends clamped: the knots of one degree more.
Knots raised(const Knots& knots) {
  Knots to{.degree = knots.degree + 1, .values = {}, .is_periodic = knots.is_periodic};
  const std::vector<Real> breaks = knots.breaks();
  for (Real t : breaks) {
    const bool is_end = t == breaks.front() || t == breaks.back();
    const int times = is_end ? to.degree + 1 : knots.multiplicity(t) + 1;
    to.values.insert(to.values.end(), static_cast<std::size_t>(times), t);
  }
  return to;
}

/// The knots of one direction that affect a range of its domain, and the number of control points
/// before them.
struct Local {
  Knots knots;
  std::size_t first = 0;
};
Local local(const Knots& knots, Range range) {
  const int p = knots.degree, from = knots.span_at(range.low);
  int to = knots.span_at(range.high);
  while (to > from && !(knots[to] < range.high)) --to;
  const auto at = [&](int i) { return knots.values.begin() + i; };
  return {{.degree = p, .values = {at(from - p), at(to + p + 2)}},
          static_cast<std::size_t>(from - p)};
}

Knots cut(const Knots& knots, Range range) {
  PANTIN_ASSERT(range.low < range.high && knots.domain().holds(range.low) &&
                knots.domain().holds(range.high));
  const auto ends = static_cast<std::size_t>(knots.degree + 1);
  Knots to{.degree = knots.degree, .values = std::vector<Real>(ends, range.low)};
  for (Real t : knots.values)
    if (range.low < t && t < range.high) to.values.push_back(t);
  to.values.insert(to.values.end(), ends, range.high);
  return to;
}

}  // namespace

Curve with_knot(const Curve& curve, Real knot, int times) {
  return moved(curve, added(curve.knots, knot, times));
}
Surface with_knot(const Surface& surface, Along way, Real knot, int times) {
  return moved(surface, way, added(knots_of(surface, way), knot, times));
}

Curve elevated(const Curve& curve) { return moved(curve, raised(curve.knots)); }
Surface elevated(const Surface& surface, Along way) {
  return moved(surface, way, raised(knots_of(surface, way)));
}

Curve part_of(const Curve& curve, Range range) {
  const auto [knots, first] = local(curve.knots, range);
  const auto from = curve.points.begin() + static_cast<std::ptrdiff_t>(first);
  return moved({knots, {from, from + knots.count()}}, cut(knots, range));
}
Surface part_of(const Surface& surface, Along way, Range range) {
  const auto [knots, first] = local(knots_of(surface, way), range);
  const auto across = static_cast<std::size_t>(surface.v.count());
  const bool is_u = way == Along::u;
  const std::size_t rows =
      is_u ? static_cast<std::size_t>(knots.count()) : surface.points.size() / across;
  const std::size_t columns = is_u ? across : static_cast<std::size_t>(knots.count());
  std::vector<Weighted> points;
  points.reserve(rows * columns);
  for (std::size_t i = 0; i < rows; ++i) {
    const auto row = surface.points.begin() +
                     static_cast<std::ptrdiff_t>(is_u ? (first + i) * across : i * across + first);
    points.insert(points.end(), row, row + static_cast<std::ptrdiff_t>(columns));
  }
  const Surface part{is_u ? knots : surface.u, is_u ? surface.v : knots, std::move(points)};
  return moved(part, way, cut(knots, range));
}

std::vector<Curve> bezier_pieces(const Curve& curve) {
  std::vector<Curve> pieces;
  for (int i : curve.knots.spans())
    pieces.push_back(part_of(curve, {curve.knots[i], curve.knots[i + 1]}));
  return pieces;
}

std::vector<Surface> bezier_pieces(const Surface& surface) {
  std::vector<Surface> pieces;
  for (int i : surface.u.spans()) {
    const Surface strip = part_of(surface, Along::u, {surface.u[i], surface.u[i + 1]});
    for (int j : surface.v.spans())
      pieces.push_back(part_of(strip, Along::v, {surface.v[j], surface.v[j + 1]}));
  }
  return pieces;
}

// ---- Maps and bounds ----------------------------------------------------------------------------

Affine affine_of(const Pose& pose) { return {glm::mat3_cast(pose.rotation), pose.position}; }

namespace {

std::vector<Weighted> transformed(std::vector<Weighted> points, const Affine& by) {
  for (Weighted& p : points) {
    const Vec3 moved = by.linear * p.product() + p.w * by.shift;
    p = {moved.x, moved.y, moved.z, p.w};
  }
  return points;
}

}  // namespace

Curve transformed(const Curve& curve, const Affine& by) {
  return {curve.knots, transformed(curve.points, by)};
}
Surface transformed(const Surface& surface, const Affine& by) {
  return {surface.u, surface.v, transformed(surface.points, by), surface.trims};
}

Surface inside_out(const Surface& surface) {
  Surface turned = surface;
  const Real sum = surface.u.low() + surface.u.high();
  const std::size_t across = static_cast<std::size_t>(surface.v.count());
  std::reverse(turned.u.values.begin(), turned.u.values.end());
  for (Real& t : turned.u.values) t = sum - t;
  const std::size_t rows = surface.points.size() / across;
  for (std::size_t i = 0; i < rows; ++i)
    std::copy_n(surface.points.begin() + static_cast<std::ptrdiff_t>(i * across), across,
                turned.points.begin() + static_cast<std::ptrdiff_t>((rows - 1 - i) * across));
  for (Curve& loop : turned.trims)
    loop = transformed(loop, {Mat3(-1, 0, 0, 0, 1, 0, 0, 0, 1), {sum, 0, 0}});
  return turned;
}

Ball bounding_ball(std::span<const Weighted> points) {
  Vec3 low(1e300), high(-1e300);
  for (const Weighted& p : points) low = glm::min(low, p.point()), high = glm::max(high, p.point());
  Ball ball{(low + high) / 2.0, 0};
  for (const Weighted& p : points)
    ball.radius = std::max(ball.radius, glm::distance(p.point(), ball.centre));
  return ball;
}

Curve isoline(const Surface& surface, Along fixed, Real at) {
  const Knots& across = knots_of(surface, fixed);
  const Real t = across.inside(at);
  const int span = across.span_at(t);
  Basis basis;
  write_basis(across, {span, t}, 0, basis);
  Curve curve{fixed == Along::u ? surface.v : surface.u, {}};
  for (int i = 0; i < curve.knots.count(); ++i) {
    Weighted sum;
    for (int j = 0; j <= across.degree; ++j) {
      const int k = span - across.degree + j;
      sum = sum + basis[0][j] * (fixed == Along::u ? surface.at(k, i) : surface.at(i, k));
    }
    curve.points.push_back(sum);
  }
  return curve;
}

}  // namespace pantin::detail::nurbs
