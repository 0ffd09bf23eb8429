#pragma once
/// The procedural solver: free motion first, then the joints closed. [Lee 2000], corrected and made
/// to keep energy and order; the method and its measures are described in the functions.
#include "engine/world/world.hpp"

namespace pantin::procedural {

/// Makes room for the steps of every articulation; after the structure changed.
void prepare(World& world);

/// Update stage: predicts the free motion of every body of an articulation over `h` seconds.
void update(World& world, Articulation& a, Real h);

/// Adjust stage: closes the joints of the predicted poses, finds velocities, writes the bodies.
/// False if a number is not finite or out of all bounds; the bodies are then left as they were, and
/// `lost` names one that is concerned.
bool adjust(World& world, Articulation& a, Real h, Entity& lost);

}  // namespace pantin::procedural
