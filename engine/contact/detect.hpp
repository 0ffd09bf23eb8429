#pragma once
/// Where bodies touch, or may come to touch within a step.
#include <span>

#include "engine/base/math.hpp"
#include "engine/geometry/shape.hpp"
#include "engine/world/body.hpp"

namespace pantin {

struct World;

namespace contact {

/// Fills contacts_of(world) from the poses as they stand: every point at which two bodies that may
/// touch are nearer than they can come together within a step, so that nothing passes through a
/// thin thing. `reach` (m, by body slot) says how far each body's surface may move.
///
/// At most 8 points for a pair of convex shapes and 16 for a shape on a mesh or a height field.
/// What the contacts of the step before bore (load, sliding, impact) is carried over to those of
/// the same bodies and key. Ordered by slots and key, each once; allocates nothing once warm.
void find_contacts(World& world, std::span<const Real> reach);

/// The contacts of a step of `h` seconds, with the poses at its start and the solvers' reaches in
/// Memory::scratch. Kinematic bodies already stand where the step brings them.
void detect(World& world, Real h);

/// Distance of the farthest point of a body's shapes from its mass centre, m.
Real extent_of(const Shapes& shapes);

/// Of a body that no solver moves: whether it moves all the same.
bool moves(const Body& b);

}  // namespace contact
}  // namespace pantin
