#pragma once
/// Applies the requests of a program to the next step: see engine/world/requests.hpp.
#include "engine/world/requests.hpp"

namespace pantin::detail {

/// Called at the start of a substep of `h` seconds. Impulses become forces for that substep.
/// Ignored pairs whose time has come collide again, and wake; pairs of destroyed bodies are
/// removed.
void apply_requests(World& world, Real h);

/// Wakes a body that sleeps; returns false if it is awake.
bool rouse(World& world, Entity body);

}  // namespace pantin::detail
