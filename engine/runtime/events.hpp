#pragma once
/// What timed events do to a World at the start of a substep.
#include "engine/world/timed_event.hpp"

namespace pantin::detail {

/// Makes the events of the next `h` seconds happen: forces of pushes and winds act in the substep
/// that follows, changes are made. Allocates only where the structure changes.
void apply_events(World& world, Real h);

}  // namespace pantin::detail
