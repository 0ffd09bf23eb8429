#pragma once
/// One direction of a spline: its knots and basis functions.
///
/// Internal (pantin::detail); installed because a World holds surfaces.
#include <array>
#include <span>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin::detail::nurbs {

/// Bounds memory on the stack; also the limit of OpenCASCADE and STEP files.
inline constexpr int kMostDegree = 25;
/// Highest order of derivatives.
inline constexpr int kMostOrder = 3;

struct Range {
  Real low = 0, high = 1;
  Real width() const { return high - low; }
  Real middle() const { return (low + high) / 2; }
  bool holds(Real t) const { return low <= t && t <= high; }
  Real clamped(Real t) const { return t < low ? low : (t > high ? high : t); }
};

/// Degree and knots of one direction, which has count() control points. The ends may be clamped or
/// not.
///
/// `is_periodic`: both ends of the domain are one point, and parameters are wrapped. The control
/// points close up: clamped (first = last) or wrapped (the first `degree` are repeated at the end).
struct Knots {
  int degree = 1;
  std::vector<Real> values;  // not decreasing
  bool is_periodic = false;

  int count() const { return static_cast<int>(values.size()) - degree - 1; }
  Real low() const { return values[static_cast<std::size_t>(degree)]; }
  Real high() const { return values[static_cast<std::size_t>(count())]; }
  Range domain() const { return {low(), high()}; }
  Real operator[](int i) const { return values[static_cast<std::size_t>(i)]; }

  /// Inside the domain: wrapped if periodic, else clamped.
  Real inside(Real t) const;
  /// i with values[i] <= t < values[i + 1] within the domain; at its end the last that is not
  /// empty.
  int span_at(Real t) const;
  /// Multiplicity of a knot.
  int multiplicity(Real knot) const;
  /// The distinct knots of the domain, both ends included.
  std::vector<Real> breaks() const;
  /// The first index of every span of the domain that is not empty.
  std::vector<int> spans() const;

  static void fields(auto& self, auto&& field) {
    field("degree", self.degree);
    field("values", self.values);
    field("is_periodic", self.is_periodic);
  }
};

/// Knots of a clamped spline with `count` control points and equal spans over [0, 1].
Knots uniform_knots(int degree, int count);

/// A parameter evaluated by the polynomials of a span, which are continued outside it.
struct InSpan {
  int span;
  Real t;
};

/// [k][j]: derivative k of basis function span - degree + j.
using Basis = std::array<std::array<Real, kMostDegree + 1>, kMostOrder + 1>;

/// The basis functions that are not zero on a span, and their derivatives up to `order`. [Boor
/// 1978]
void write_basis(const Knots& knots, InSpan at, int order, Basis& out);

/// A control point times its weight, and the weight.
struct Weighted {
  Real x = 0, y = 0, z = 0, w = 0;

  Weighted() = default;
  Weighted(Real ax, Real ay, Real az, Real aw) : x(ax), y(ay), z(az), w(aw) {}
  Weighted(Vec3 p, Real weight) : x(p.x * weight), y(p.y * weight), z(p.z * weight), w(weight) {}
  Vec3 product() const { return {x, y, z}; }
  Vec3 point() const { return Vec3(x, y, z) / w; }
  friend Weighted operator+(const Weighted& a, const Weighted& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w};
  }
  friend Weighted operator-(const Weighted& a, const Weighted& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w};
  }
  friend Weighted operator*(Real s, const Weighted& a) {
    return {s * a.x, s * a.y, s * a.z, s * a.w};
  }
  friend bool operator==(const Weighted&, const Weighted&) = default;

  static void fields(auto& self, auto&& field) {
    field("x", self.x);
    field("y", self.y);
    field("z", self.z);
    field("w", self.w);
  }
};

/// Control points of one direction of a net: count() rows of `across` points each.
struct Rows {
  std::vector<Weighted> points;  // [row * across + column]
  std::size_t across = 1;
};

/// The same spline on other knots, of the same degree or of one more. Every knot of `from` within
/// the domain of `to` has to occur as often (for one degree more: once more); the domain may be a
/// part. Used for knot insertion, degree elevation, cuts and the extraction of pieces. [Ramshaw
/// 1989: control points are values of the blossom]
Rows on_knots(const Knots& from, const Rows& rows, const Knots& to);

/// Transposes a net of `rows` by `across`.
Rows turned(const Rows& rows);

}  // namespace pantin::detail::nurbs
