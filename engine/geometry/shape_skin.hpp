#pragma once
/// Shapes as exact NURBS surfaces.
#include "engine/geometry/shape.hpp"
#include "engine/nurbs/skin.hpp"

namespace pantin::detail {

/// The surface, in the shape's frame, of a sphere, an ellipsoid, a NURBS shape, the side of a
/// cylinder, or a plane as a square of 1 km about its origin. Null for all other shapes.
std::shared_ptr<const nurbs::Skin> skin_of(const Shape& shape);

}  // namespace pantin::detail
