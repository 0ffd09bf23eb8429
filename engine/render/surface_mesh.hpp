#pragma once
/// Triangles of hulls, meshes, height fields and skins, as the card draws them.
#include "engine/geometry/shape.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/render/meshes.hpp"

namespace pantin::detail {

/// Vertices whose `corner` is a position in the shape's frame, m: drawn with a core of 1 and no
/// skin.
struct SurfaceMesh {
  std::vector<MeshVertex> vertices;
  std::vector<std::uint32_t> indices;  // triangles, counter-clockwise seen from outside
};

/// Hulls and meshes get flat faces, what stands for a `smooth` shape that shape's normals; height
/// fields are shaded smoothly and stand on a rim, so that they look solid from the side.
SurfaceMesh make_surface_mesh(const Surface& surface, const Shape* smooth = nullptr);

/// Triangles that stand for a convex shape that is known by its support function; null if it is
/// flat.
std::shared_ptr<const Surface> tessellate(const Shape& shape);

/// How far the rim of a height field reaches below its lowest point, m.
Real rim_of(const Surface& height_field);

}  // namespace pantin::detail
