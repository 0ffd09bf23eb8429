// The convex hull of points: its size is in its surface.
#include <limits>

#include "engine/geometry/kinds/parts.hpp"
#include "engine/geometry/surface.hpp"

namespace pantin::detail::shape_kinds {
namespace {

Vec3 support(const Shape& shape, Vec3 direction) {
  Vec3 best(0);
  Real most = -std::numeric_limits<Real>::infinity();
  for (Vec3 p : shape.surface->points)
    if (const Real way = glm::dot(p, direction); way > most) most = way, best = p;
  return best;
}

Real inner_radius(const Shape& shape) {
  Real least = std::numeric_limits<Real>::infinity();
  for (const Face& face : shape.surface->faces) least = glm::min(least, face.offset);
  return least;
}

Convex convex_piece(const Shape& shape, const Pose& at, ConvexScratch& scratch) {
  const Surface& hull = *shape.surface;
  const Mat3 rotation = glm::mat3_cast(at.rotation);
  scratch.points.resize(hull.points.size()), scratch.faces.resize(hull.faces.size());
  for (std::size_t i = 0; i < hull.points.size(); ++i)
    scratch.points[i] = at.position + rotation * hull.points[i];
  for (std::size_t f = 0; f < hull.faces.size(); ++f) {
    const Face& face = hull.faces[f];
    const Vec3 normal = rotation * face.normal;
    scratch.faces[f] = {face.first, face.count, normal,
                        face.offset + glm::dot(normal, at.position)};
  }
  return {scratch.points,
          scratch.faces,
          hull.corners,
          hull.edges,
          hull.sides,
          0,
          at.position + rotation * ((hull.low + hull.high) / 2.0),
          glm::length(hull.high - hull.low) / 2};
}

/// Inside is below all faces.
std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  Real enter = -1, leave = limit;
  RayEntry entry;
  for (const Face& face : shape.surface->faces) {
    const Real above = glm::dot(face.normal, from) - face.offset,
               sinks = -glm::dot(face.normal, way);
    if (sinks == 0) {
      if (above > 0) return std::nullopt;
      continue;
    }
    const Real at = above / sinks;
    if (sinks > 0 && at > enter) enter = at, entry = {at, face.normal};
    if (sinks < 0) leave = glm::min(leave, at);
  }
  if (enter < 0 || enter > leave) return std::nullopt;
  return entry;
}

std::optional<SurfacePoint> closest(const Shape& shape, Vec3 p, Real limit) {
  const Face* nearest_face = nullptr;
  Real above = -std::numeric_limits<Real>::infinity();
  for (const Face& face : shape.surface->faces)
    if (const Real at = glm::dot(face.normal, p) - face.offset; at > above)
      above = at, nearest_face = &face;
  if (!nearest_face || above > limit) return std::nullopt;
  const SurfacePoint on_face{p - above * nearest_face->normal, nearest_face->normal, above};
  if (above <= 0) return on_face;
  ConvexScratch scratch;
  const Convex hull_piece = shape_kinds::convex_piece(shape, Pose{}, scratch);
  const Convex point{{&p, 1}, {}, {}, {}, {}, 0, p, 0};
  const Nearest near = nearest(point, hull_piece, limit);
  if (near.state == Nearest::State::beyond) return std::nullopt;
  if (near.state == Nearest::State::overlap) return on_face;
  return SurfacePoint{near.on_b, near.normal, near.distance};
}

}  // namespace

constinit const ShapeTraits hull{
    .about = "The convex hull of points that are not coplanar; at most 256 corners.",
    .source = SurfaceSource::points,
    .support = support,
    .enclosed = enclosed_by_faces,
    .inner_radius = inner_radius,
    .bounds = bounds_of_surface,
    .convex_piece = convex_piece,
    .cast = cast,
    .closest = closest,
};

}  // namespace pantin::detail::shape_kinds
