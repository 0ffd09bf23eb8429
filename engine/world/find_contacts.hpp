#pragma once
/// Where bodies touch, or may come to touch within a step.
#include "engine/world/world.hpp"

namespace pantin {

/// Room of the search, kept between steps.
struct ContactSearch;

/// Fills `world.contacts` for a step of `h` seconds from the poses as they stand: every point at
/// which two bodies that may touch are nearer than they can come together within the step, so that
/// nothing passes through a thin thing. `reach` (m, by body slot) says how far each body's surface
/// may move. What the contacts of the step before bore (load, sliding, impact) is carried over to
/// those of the same key. Ordered by slots and key; allocates nothing once warm.
void find_contacts(World& world, std::span<const Real> reach, ContactSearch& search);

}  // namespace pantin
