// A closed surface of triangles, for fixed and kinematic bodies: its size is in its surface.
#include "engine/geometry/kinds/parts.hpp"
#include "engine/geometry/surface.hpp"

namespace pantin::detail::shape_kinds {
namespace {

std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  const Surface& s = *shape.surface;
  std::optional<RayEntry> best;
  s.tree.cast(from, way, limit, [&](std::uint32_t index, Real so_far) {
    if (const auto entry = cast_triangle(triangle_of(s, index), from, way, so_far))
      if (!best || entry->distance < best->distance) best = entry;
    return best ? best->distance : so_far;
  });
  return best;
}

std::optional<SurfacePoint> closest(const Shape& shape, Vec3 p, Real limit) {
  const Surface& s = *shape.surface;
  const NearestTile at = nearest_tile(s, p);
  if (at.index == UINT32_MAX) return std::nullopt;
  const Vec3 point = nearest_in(triangle_of(s, at.index), p), way = p - point;
  const Real apart = glm::length(way);
  if (!at.inside && apart > limit) return std::nullopt;
  const Vec3 face = s.faces[at.index].normal;
  const Vec3 normal = apart > 0 ? (at.inside ? -way : way) / apart : face;
  return SurfacePoint{point, normal, at.inside ? -apart : apart};
}

}  // namespace

constinit const ShapeTraits mesh{
    .about =
        "A closed surface of triangles, anticlockwise seen from outside. Only for fixed or "
        "kinematic bodies; a dynamic body takes one or several hulls.",
    .shape_class = ShapeClass::mesh,
    .source = SurfaceSource::triangles,
    .enclosed = enclosed_by_faces,
    .bounds = bounds_of_surface,
    .cast = cast,
    .closest = closest,
};

}  // namespace pantin::detail::shape_kinds
