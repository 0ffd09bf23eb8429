#pragma once
/// Applies timed events to a World at the start of a substep.
#include "engine/world/timed_event.hpp"

namespace pantin::detail {

/// Applies the events of the next `h` seconds: forces of pushes and wind act in the following
/// substep, changes are made at once. Allocates only if the structure changes.
void apply_events(World& world, Real h);

}  // namespace pantin::detail
