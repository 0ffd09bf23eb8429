#pragma once
/// Where bodies touch, or may come to touch within a step.
#include <span>

#include "engine/base/math.hpp"

namespace pantin {

struct World;

/// Fills `world.contacts` from the poses as they stand: every point at which two bodies that may
/// touch are nearer than they can come together within a step, so that nothing passes through a
/// thin thing. `reach` (m, by body slot) says how far each body's surface may move.
///
/// At most 8 points for a pair of convex shapes and 16 for a shape on a mesh or a height field.
/// What the contacts of the step before bore (load, sliding, impact) is carried over to those of
/// the same bodies and key. Ordered by slots and key, each once; allocates nothing once warm.
void find_contacts(World& world, std::span<const Real> reach);

}  // namespace pantin
