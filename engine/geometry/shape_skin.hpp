#pragma once
/// Shapes as smooth surfaces, exactly.
#include "engine/geometry/shape.hpp"
#include "engine/nurbs/skin.hpp"

namespace pantin::detail {

/// The surface of a shape in the shape's frame: of a sphere, an ellipsoid, a NURBS shape, the side
/// of a cylinder, a plane as a square of 1 km about its origin. Null of all others.
std::shared_ptr<const nurbs::Skin> skin_of(const Shape& shape);

}  // namespace pantin::detail
