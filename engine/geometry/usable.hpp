#pragma once
/// Whether a shape is one: what users may write into its members is asked before it is solid.
#include "engine/geometry/shape.hpp"

namespace pantin::detail {

/// Whether it has the surface that its kind needs, and sizes and a place that are some.
bool is_usable(const Shape& shape);

}  // namespace pantin::detail
