#pragma once
/// Rational curves and tensor-product surfaces: values and derivatives, and operations that keep
/// their shape: knot insertion, degree elevation, cuts. [Piegl & Tiller 1997]
///
/// Internal (pantin::detail); installed because a World holds surfaces.
#include <array>
#include <vector>

#include "engine/nurbs/knots.hpp"

namespace pantin::detail::nurbs {

/// A curve in space; one of the plane has z = 0.
struct Curve {
  Knots knots;
  std::vector<Weighted> points;

  static void fields(auto& self, auto&& field) {
    field("knots", self.knots);
    field("points", self.points);
  }
};

/// A surface over (u, v). Its outer side is the one that u x v points to.
struct Surface {
  Knots u, v;
  std::vector<Weighted> points;  // [i * v.count() + j], i along u
  // Closed loops in the plane of (u, v), z = 0. The face is what is within an odd number of them,
  // in any direction; without loops it is the whole domain.
  std::vector<Curve> trims = {};

  const Weighted& at(int i, int j) const {
    return points[static_cast<std::size_t>(i * v.count() + j)];
  }

  static void fields(auto& self, auto&& field) {
    field("u", self.u);
    field("v", self.v);
    field("points", self.points);
    field("trims", self.trims);
  }
};

/// [k]: derivative k, [0] the point. In the curve's frame, m per parameter^k.
using CurveDerivatives = std::array<Vec3, kMostOrder + 1>;
/// [k][l]: k times along u, l times along v; 0 where k + l is above the order.
using SurfaceDerivatives = std::array<std::array<Vec3, kMostOrder + 1>, kMostOrder + 1>;

/// Derivatives up to `order` (at most 3). Parameters outside the domain are wrapped or clamped.
CurveDerivatives evaluate(const Curve& curve, Real t, int order);
SurfaceDerivatives evaluate(const Surface& surface, Real u, Real v, int order);
/// The same by the polynomials of one span, which are continued outside it: one-sided at knots.
CurveDerivatives evaluate_on(const Curve& curve, int span, Real t, int order);
struct Cell {
  int u = 0, v = 0;  // spans
};
SurfaceDerivatives evaluate_on(const Surface& surface, Cell cell, std::array<Real, 2> at,
                               int order);

enum class Along { u, v };
inline const Knots& knots_of(const Surface& s, Along way) { return way == Along::u ? s.u : s.v; }

/// Inserts a knot `times` over, inside the domain; of a periodic direction with unclamped ends, its
/// images too.
Curve with_knot(const Curve& curve, Real knot, int times);
Surface with_knot(const Surface& surface, Along way, Real knot, int times);

/// Elevates the degree by one.
Curve elevated(const Curve& curve);
Surface elevated(const Surface& surface, Along way);

/// The part over a range of the domain, clamped, not periodic.
Curve part_of(const Curve& curve, Range range);
Surface part_of(const Surface& surface, Along way, Range range);

/// One piece for each span that is not empty, over its own range; of a surface, u outermost.
std::vector<Curve> bezier_pieces(const Curve& curve);
std::vector<Surface> bezier_pieces(const Surface& surface);

/// x -> linear x + shift.
struct Affine {
  Mat3 linear{1};
  Vec3 shift{0};
};
Affine affine_of(const Pose& pose);
Curve transformed(const Curve& curve, const Affine& by);
Surface transformed(const Surface& surface, const Affine& by);
/// The same points with the outer side inside: u is reversed.
Surface inside_out(const Surface& surface);

struct Ball {
  Vec3 centre{0};
  Real radius = 0;
};
/// Bounding ball of all control points, and so of the spline if weights are above 0.
Ball bounding_ball(std::span<const Weighted> points);

/// The isoline of a surface: u or v fixed.
Curve isoline(const Surface& surface, Along fixed, Real at);

}  // namespace pantin::detail::nurbs
