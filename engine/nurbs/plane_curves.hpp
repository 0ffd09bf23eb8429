#pragma once
/// Outlines of the plane z = 0: made of points and of pieces, and their faults.
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/nurbs/spline.hpp"

namespace pantin::detail::nurbs {

/// The closed polygon through points, its corners rounded by arcs of a radius (m), which touch both
/// sides: lines and arcs of degree 2, exact, tangents and speed without jumps. An error names a
/// corner whose sides are too short, and two points that are one.
Result<Curve> rounded_polygon(std::span<const Vec3> points, Real radius);

/// Joins consecutive curves to one, periodic if the last ends where the first begins; reverses
/// curves that run the other way. Speeds agree where tangents do. An error names a curve that does
/// not begin where the one before ends, within 1e-6 of the sizes.
Result<Curve> joined(std::span<const Curve> curves);

/// The same points in reverse order.
Curve reversed(const Curve& curve);

/// Marks a curve as periodic if its ends coincide smoothly.
Curve closed_up(const Curve& curve);

/// Signed area of a closed curve of the plane, m^2: above 0 anticlockwise; accurate to about 1e-3.
Real area_around(const Curve& curve);

/// Parameters of two points at which a curve of the plane crosses itself; tested on chords that are
/// short against its size.
std::optional<std::array<Real, 2>> crossing_of(const Curve& curve);

/// Points along a curve, with chords within about `chord` (m) of it, at most 64 to a polynomial
/// piece; a periodic curve does not repeat its first point.
struct CurvePoints {
  std::vector<Real> at;
  std::vector<Vec3> points;
};
CurvePoints points_along(const Curve& curve, Real chord);

}  // namespace pantin::detail::nurbs
