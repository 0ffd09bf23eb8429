#pragma once
/// Shapes that represent curves in contact: plates for closed planar ones, walls and tubes for
/// others.
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/closest.hpp"

namespace pantin::detail {

/// A solid for a curve, in its frame: the inside of a closed planar curve; a wall behind its outer
/// side if it is open or bounds a hole; a tube around a space curve. Null if it has no extent.
std::shared_ptr<const Surface> solid_of(const nurbs::Wire& wire);

}  // namespace pantin::detail
