#include "engine/solvers/planar/section.hpp"

#include <algorithm>
#include <limits>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/plane_hull.hpp"
#include "engine/geometry/usable.hpp"
#include "engine/world/flat.hpp"

namespace pantin::detail::planar {
namespace {

constexpr Real kAlong = 1e-9;  // sine of an angle that counts as 0
constexpr std::uint32_t kMostCorners = 8;

Vec3 flat(Vec3 v) { return {v.x, v.y, 0}; }
bool is_along_z(Vec3 axis) { return std::hypot(axis.x, axis.y) < kAlong; }

/// Intersections of a convex piece's edges with the height of its centre.
std::vector<Vec3> cut(const Convex& piece, Real height) {
  std::vector<Vec3> points;
  for (const auto& edge : piece.edges) {
    const Vec3 p = piece.points[edge[0]], q = piece.points[edge[1]];
    const Real below = height - p.z, above = q.z - height;
    if (below * above < 0 || p.z == q.z) continue;
    points.push_back(flat(p + below / (q.z - p.z) * (q - p)));
  }
  return points;
}

void append_polygon(const std::vector<Vec3>& corners, Outline o, Plane& out) {
  o.kind = Outline::polygon;
  for (std::size_t at = 1; at + 1 < corners.size(); at += kMostCorners - 2) {
    o.first = static_cast<std::uint32_t>(out.corners.size());
    out.corners.push_back(corners.front());
    const std::size_t end = std::min(corners.size(), at + kMostCorners - 1);
    out.corners.insert(out.corners.end(), corners.begin() + at, corners.begin() + end);
    o.count = static_cast<std::uint32_t>(out.corners.size()) - o.first;
    out.outlines.push_back(o);
  }
}

void append_disc(Vec3 centre, Real radius, Outline o, Plane& out) {
  o.kind = Outline::disc, o.centre = flat(centre), o.radius = radius;
  out.outlines.push_back(o);
}

/// A straight piece between two ends, with the given half-widths.
void append_bar(const std::array<Vec3, 2>& ends, const std::array<Real, 2>& radii, Outline o,
                Plane& out) {
  const Vec3 along = glm::normalize(ends[1] - ends[0]), left(-along.y, along.x, 0);
  std::vector<Vec3> corners;
  for (int end = 0; end < 2; ++end)
    for (const Real side : {-1.0, 1.0}) corners.push_back(ends[end] + side * radii[end] * left);
  append_polygon(plane_hull(std::move(corners)), o, out);
}

Outline with_heights(const Shape& shape, const Pose& at) {
  Outline o;
  o.material = shape.material;
  o.low = -std::numeric_limits<Real>::infinity(), o.high = -o.low;
  if (is_unbounded(shape.kind)) return o;
  ConvexScratch scratch;
  const Convex piece = convex_piece(shape, at, scratch);
  o.low = piece.extreme({0, 0, -1}).z - piece.radius;
  o.high = piece.extreme({0, 0, 1}).z + piece.radius;
  return o;
}

/// A solid of revolution about y, with radius and half-length of its shape.
void append_turned(const Shape& shape, const Pose& at, const Outline& o, Plane& out) {
  const Vec3 axis = at.rotation * Vec3(0, 1, 0);
  const Real radius = shape.size.x, half = shape.size.y;
  if (is_along_z(axis))
    return append_disc(at.position, shape.kind == ShapeKind::cone ? radius / 2 : radius, o, out);
  const std::array<Vec3, 2> ends{flat(at.position - half * axis), flat(at.position + half * axis)};
  if (half > 0) append_bar(ends, {radius, shape.kind == ShapeKind::cone ? 0 : radius}, o, out);
  if (shape.kind != ShapeKind::capsule) return;
  for (const Vec3& end : ends) append_disc(end, radius, o, out);
}

}  // namespace

void append_section(const Shape& shape, const Pose& body, Plane& out) {
  if (!has_section(shape, body.rotation) || !is_usable(shape)) return;
  const Pose at = compose({{0, 0, body.position.z}, body.rotation}, shape.local);
  Outline o = with_heights(shape, at);
  switch (shape.kind) {
    case ShapeKind::sphere:
      return append_disc(at.position, shape.size.x, o, out);
    case ShapeKind::plane:
      o.kind = Outline::half_plane, o.centre = flat(at.position);
      o.normal = glm::normalize(flat(at.rotation * Vec3(0, 1, 0)));
      return out.outlines.push_back(o);
    case ShapeKind::box:
    case ShapeKind::hull: {
      ConvexScratch scratch;
      const std::vector<Vec3> points = cut(convex_piece(shape, at, scratch), at.position.z);
      append_polygon(plane_hull(points), o, out);
      return;
    }
    default:  // capsules, cylinders, cones: see has_section()
      return append_turned(shape, at, o, out);
  }
}

}  // namespace pantin::detail::planar
