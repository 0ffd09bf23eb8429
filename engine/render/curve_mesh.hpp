#pragma once
/// How curves that touch are drawn: closed ones of the plane as plates, others as walls and tubes.
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/closest.hpp"

namespace pantin::detail {

/// A solid about a curve, in its frame: within a closed one of the plane; behind its outer side if
/// it is open or bounds a hole; around one in space. Null if it has no extent.
std::shared_ptr<const Surface> solid_of(const nurbs::Wire& wire);

}  // namespace pantin::detail
