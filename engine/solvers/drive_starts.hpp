#pragma once
/// Exact drives that start, or go on, where their joints stand.
#include "engine/world/world.hpp"

namespace pantin::detail {

/// Sets the offset of their motions from the present poses.
void start_drives(World& world);

}  // namespace pantin::detail
