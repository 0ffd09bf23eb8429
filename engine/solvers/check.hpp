#pragma once
/// Conditions of a World that no step can be computed with: checked when it is compiled.
#include <vector>

#include "engine/world/body.hpp"
#include "engine/world/faults.hpp"

namespace pantin::detail {

/// Why no step can be computed with a dynamic body, or null.
const char* fault_of(const Body& b);

/// Removes components that a stale handle added for an entity that no longer exists: they may hide
/// those of the entity that reuses its slot. One fault for each.
std::vector<StructureFault> drop_strays(World& world);

/// Normalises rotations that a user wrote, if they are not zero. Returns whether fault_of() finds
/// nothing at any dynamic body then.
bool normalise_rotations(World& world);

}  // namespace pantin::detail
