#pragma once
/// Building blocks of several kinds of shapes.
#include "engine/geometry/kinds.hpp"

namespace pantin::detail::shape_kinds {

/// Half extents along the outer axes of a box with half extents `extent`, rotated by `rotation`.
inline Vec3 spread(const Mat3& rotation, Vec3 extent) {
  return Vec3(glm::dot(glm::abs(Vec3(rotation[0].x, rotation[1].x, rotation[2].x)), extent),
              glm::dot(glm::abs(Vec3(rotation[0].y, rotation[1].y, rotation[2].y)), extent),
              glm::dot(glm::abs(Vec3(rotation[0].z, rotation[1].z, rotation[2].z)), extent));
}

/// Bounds of the box around a surface.
Aabb bounds_of_surface(const Shape& shape, const Pose& at);

/// What faces enclose, at density 1: signed tetrahedra from one point.
MassProperties enclosed_by_faces(const Shape& shape);

/// The first entry of a ray into a ball about `centre`.
std::optional<RayEntry> cast_ball(Vec3 from, Vec3 way, Vec3 centre, Real radius);

/// The nearest point of a rounded box. Ties are decided for the first axis and its positive side.
SurfacePoint closest_of_rounded(const RoundedBox& rounded, Vec3 p);

/// Entry of a ray through a triangle from its outer side, and the distance: nothing beyond `limit`.
/// [Moeller & Trumbore 1997]
std::optional<RayEntry> cast_triangle(const std::array<Vec3, 3>& corners, Vec3 from, Vec3 way,
                                      Real limit);

}  // namespace pantin::detail::shape_kinds
