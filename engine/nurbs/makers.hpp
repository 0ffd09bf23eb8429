#pragma once
/// Curves and surfaces by name. Lengths in metres, angles in radians. Conics are exact, and so are
/// their revolutions, translations and scalings.
#include <optional>
#include <span>

#include "engine/base/result.hpp"
#include "engine/nurbs/spline.hpp"

namespace pantin::detail::nurbs {

/// Frame of a conic or a surface: `x`, `y` and `z` are unit and perpendicular, z = x cross y.
struct Frame {
  Vec3 origin{0};
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
};

// ---- Curves, all over [0, 1] -------------------------------------------------------------------

Curve line(Vec3 from, Vec3 to);
/// Part of an ellipse with the half axes `a` (along x) and `b` (along y), between two angles (at
/// most 2 pi apart): quadratic, with a piece for every quarter or less.
Curve elliptic_arc(const Frame& at, Real a, Real b, Range angles);
inline Curve arc(const Frame& at, Real radius, Range angles) {
  return elliptic_arc(at, radius, radius, angles);
}
/// A whole ellipse, periodic.
Curve ellipse(const Frame& at, Real a, Real b);
inline Curve circle(const Frame& at, Real radius) { return ellipse(at, radius, radius); }

// ---- Surfaces, u x v outwards ------------------------------------------------------------------

/// [0, 1] x [0, 1]; outwards is z. `a` along x, `b` along y, the origin in the middle.
Surface plane(const Frame& at, Real a, Real b);
/// About z: u around, v from the bottom at the origin up. Side only.
Surface cylinder(const Frame& at, Real radius, Real height);
/// A cone's side between two circles; a radius of 0 makes a degenerate edge, see flaws_of().
Surface cone(const Frame& at, std::array<Real, 2> radii, Real height);
/// u around z, v from pole to pole, which are singular: see charts() for one without poles.
Surface sphere(const Frame& at, Real radius);
Surface ellipsoid(const Frame& at, Vec3 half_axes);
/// u around z at `radius`, v around the tube.
Surface torus(const Frame& at, Real radius, Real tube);
/// A curve, given in space, revolved about z; u is the angle, periodic if it is 2 pi.
Surface revolved(const Curve& profile, const Frame& at, Real angle);
/// u along the curve, v along `way`.
Surface extruded(const Curve& curve, Vec3 way);
/// u along the path, v along the section, which is not rotated: S = path(u) + section(v). Exact.
Surface swept(const Curve& section, const Curve& path);
/// A section, given in a frame's x and y, that rotates with the path by a rotation-minimising frame
/// [Wang 2008]. Exact at `stations` points equally spaced in the path's parameter, interpolated
/// between them.
Surface swept_turning(const Curve& section, const Curve& path, int stations);

/// Six overlapping charts of an ellipsoid about the origin, one for each side of a cube, each over
/// [-reach, reach]^2 and far from singular. Each is exact: the stereographic map makes a rational
/// biquadratic patch. Order +x, -x, +y, -y, +z, -z.
inline constexpr Real kChartReach = 0.7;
std::array<Surface, 6> charts(Vec3 half_axes);
/// The chart that covers a point of that ellipsoid, or a direction, farthest from its edges;
/// parameters there.
struct ChartPoint {
  int chart = 0;
  Real u = 0, v = 0;
};
ChartPoint chart_point(Vec3 half_axes, Vec3 p);

// ---- Through points ----------------------------------------------------------------------------

/// The curve of a degree through points, at parameters by chord length over [0, 1]; the first point
/// is not given again at the end of a periodic one. At least degree + 1 points, of a periodic curve
/// too, no two neighbours the same. An error names the point.
enum class Ends { open, periodic };
Result<Curve> interpolated(std::span<const Vec3> points, int degree, Ends ends);
/// The surface through a grid of points [i * columns + j], rows along u; clamped, parameters by
/// mean chord lengths.
struct PointGrid {
  std::span<const Vec3> points;
  int columns = 0;
};
Result<Surface> interpolated(const PointGrid& grid, std::array<int, 2> degrees);

}  // namespace pantin::detail::nurbs
