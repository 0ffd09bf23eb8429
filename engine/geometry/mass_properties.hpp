#pragma once
/// Rounding errors of mass properties.
#include "engine/geometry/shape.hpp"

namespace pantin::detail {

/// Sets coordinates of the mass centre and products of inertia that are rounding errors to 0, so
/// that coincident frames agree exactly.
void round_off(MassProperties& whole);

}  // namespace pantin::detail
