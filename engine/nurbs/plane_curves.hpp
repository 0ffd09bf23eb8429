#pragma once
/// Outlines of the plane z = 0: made of points and of pieces, and what is wrong with them.
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

/// Curves one after the other as one, periodic if the last ends where the first begins; those that
/// run the other way are turned round. Speeds meet where tangents do. An error names a curve that
/// does not begin where the one before ends, within 1e-6 of the sizes.
Result<Curve> joined(std::span<const Curve> curves);

/// The same points the other way.
Curve reversed(const Curve& curve);

/// Closed, and known to be: a curve whose ends are one place, and smooth there, is periodic.
Curve closed_up(const Curve& curve);

/// Of what a closed curve of the plane runs around, anticlockwise above 0, m^2; within about 1e-3.
Real area_around(const Curve& curve);

/// Parameters of two places at which a curve of the plane crosses itself; of chords that are
/// short against its size.
std::optional<std::array<Real, 2>> crossing_of(const Curve& curve);

/// Points along a curve, so dense that chords are within about `chord` (m) of it, at most 64 to a
/// polynomial piece; of a periodic one the first is not given again.
struct CurvePoints {
  std::vector<Real> at;
  std::vector<Vec3> points;
};
CurvePoints points_along(const Curve& curve, Real chord);

}  // namespace pantin::detail::nurbs
