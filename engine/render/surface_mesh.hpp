#pragma once
/// Triangles of hulls, meshes, height fields and skins, in the format of the GPU.
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

/// Hulls and meshes get flat faces; approximations of a `smooth` shape get its normals. Height
/// fields are shaded smoothly and have a rim, so that they look solid from the side.
SurfaceMesh make_surface_mesh(const Surface& surface, const Shape* smooth = nullptr);

/// Triangles that approximate a convex shape given by its support function; null if it is flat.
std::shared_ptr<const Surface> tessellate(const Shape& shape);

/// The depth of a height field's rim below its lowest point, m.
Real rim_of(const Surface& height_field);

}  // namespace pantin::detail
