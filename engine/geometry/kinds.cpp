#include "engine/geometry/kinds.hpp"

#include "engine/geometry/kinds/parts.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/smooth.hpp"
#include "engine/geometry/surface.hpp"

namespace pantin::detail {
namespace {

Aabb bounds_by_support(const Shape& shape, const Pose& at) {
  const auto support = traits_of(shape.kind).support;
  const Mat3 rotation = glm::mat3_cast(at.rotation), back = glm::transpose(rotation);
  Aabb box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = at.position[k] + (rotation * support(shape, -back[k]))[k];
    box.high[k] = at.position[k] + (rotation * support(shape, back[k]))[k];
  }
  return box;
}

}  // namespace

Convex convex_piece(const Shape& shape, const Pose& at, ConvexScratch& scratch) {
  const ShapeTraits& kind = traits_of(shape.kind);
  if (kind.convex_piece) return kind.convex_piece(shape, at, scratch);
  Convex c;
  const Aabb box = bounds_of(shape, Pose{});
  c.smooth = &shape, c.rotation = glm::mat3_cast(at.rotation), c.origin = at.position;
  c.centre = at.position + c.rotation * ((box.low + box.high) / 2.0);
  c.size = glm::length(box.high - box.low) / 2;
  if (kind.flat_faces) {
    scratch.faces.resize(2);
    scratch.faces.resize(kind.flat_faces(shape, std::span<Face, 2>(scratch.faces.data(), 2)));
    for (Face& f : scratch.faces) {
      f.normal = c.rotation * f.normal;
      f.offset += glm::dot(f.normal, at.position);
    }
    c.faces = scratch.faces;
  }
  return c;
}

Vec3 Convex::smooth_extreme(Vec3 direction) const {
  return origin + rotation * traits_of(smooth->kind).support(*smooth, direction * rotation);
}

Aabb bounds_of(const Shape& shape, const Pose& at) {
  const ShapeTraits& kind = traits_of(shape.kind);
  return kind.bounds ? kind.bounds(shape, at) : bounds_by_support(shape, at);
}

Real reach_of(const Shape& shape) {
  const ShapeTraits& kind = traits_of(shape.kind);
  if (kind.rounded)
    if (const auto box = kind.rounded(shape)) return glm::length(box->core) + box->radius;
  if (shape.surface)
    return glm::length(glm::max(glm::abs(shape.surface->low), glm::abs(shape.surface->high)));
  if (!kind.support || !is_complete(shape)) return 0;
  const Aabb box = bounds_by_support(shape, Pose{});
  return glm::length(glm::max(glm::abs(box.low), glm::abs(box.high)));
}

bool is_convex(const Shape& shape) {
  if (traits_of(shape.kind).shape_class != ShapeClass::skin) return is_convex(shape.kind);
  return is_complete(shape) && shape.surface->model->is_convex;
}

Real inner_radius(const Shape& shape) {
  const auto radius = traits_of(shape.kind).inner_radius;
  return radius && is_complete(shape) ? radius(shape) : 0;
}

std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  if (!is_complete(shape)) return std::nullopt;
  const auto exact = traits_of(shape.kind).cast;
  if (exact) return exact(shape, from, way, limit);
  ConvexScratch scratch;
  return cast_at(convex_piece(shape, Pose{}, scratch), from, way, limit);
}

std::optional<SurfacePoint> closest(const Shape& shape, Vec3 p, Real limit) {
  if (!is_complete(shape)) return std::nullopt;
  const ShapeTraits& kind = traits_of(shape.kind);
  if (kind.closest) return kind.closest(shape, p, limit);
  if (kind.rounded)
    if (const auto box = kind.rounded(shape)) {
      const SurfacePoint near = shape_kinds::closest_of_rounded(*box, p);
      return near.distance <= limit ? std::optional(near) : std::nullopt;
    }
  ConvexScratch scratch;
  return closest_of(convex_piece(shape, Pose{}, scratch), p, limit);
}

bool contains(const Shape& shape, Vec3 p) {
  if (shape.surface && !is_unbounded(shape.kind) &&
      !(glm::all(glm::lessThanEqual(shape.surface->low, p)) &&
        glm::all(glm::lessThanEqual(p, shape.surface->high))))
    return false;
  const auto near = closest(shape, p, 0);
  return near && near->distance < 0;
}

}  // namespace pantin::detail
