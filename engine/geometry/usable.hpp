#pragma once
/// Validity of a shape: users may write any values into its members.
#include "engine/geometry/shape.hpp"

namespace pantin::detail {

/// Whether it has the surface that its kind needs, finite sizes of 0 or more, and a valid pose.
bool is_usable(const Shape& shape);

}  // namespace pantin::detail
