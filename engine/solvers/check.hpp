#pragma once
/// What a World holds that no step can be computed with: found when it is compiled.
#include <vector>

#include "engine/world/body.hpp"
#include "engine/world/faults.hpp"

namespace pantin::detail {

/// Why no step can be computed with a dynamic body, or null.
const char* fault_of(const Body& b);

/// Removes the components of what does not exist, which a stale handle had added: they may hide
/// those of what has taken its place. One fault for each.
std::vector<StructureFault> drop_strays(World& world);

/// Gives rotations that a user wrote unit length, where they have any.
void normalise_rotations(World& world);

}  // namespace pantin::detail
