#pragma once
/// The procedural solver: free motion first, then the joints closed. [Lee 2000], corrected and made
/// to keep energy and order; the method and its measures are described in the functions.
#include "engine/world/world.hpp"

namespace pantin::procedural {

/// Makes room for the steps of every articulation; after the structure changed.
void prepare(World& world);

/// Update stage: predicts the free motion of every body of an articulation over `h` seconds.
void update(World& world, Articulation& a, Real h);

/// Wakes an articulation that lies still (Articulation::resting), within a step.
void stir(World& world, Articulation& a, Real h);

/// Between the stages: looks for contacts and hands them to the articulations they concern. Needs
/// every articulation's prediction.
void touch(World& world, Real h);

/// Adjust stage: closes the joints of the predicted poses, finds velocities, writes the bodies.
/// False if a number is not finite or out of all bounds; the bodies are then left as they were, and
/// `lost` names one that is concerned.
bool adjust(World& world, Articulation& a, Real h, Entity& lost);

/// The same in parts, for articulations that touch one another (Articulation::mutual): all of them
/// begin; then passes, until nothing changes: all begin the pass, the loads between them are found
/// for the whole World at once, all end it. At last each finishes.
void begin_passes(World& world, Articulation& a, Real h);
void begin_iterating(World& world, Articulation& a);
void begin_pass(World& world, Articulation& a, Real h);
void iterate_mutual(World& world, Real h);
bool end_pass(World& world, Articulation& a, Real h);
bool finish_passes(World& world, Articulation& a, Real h, Entity& lost);

/// What an adjusted articulation pulled on mechanisms over the step: Hanging::force.
void tell_pulls(World& world, Articulation& a, Real h);
/// What all pressed on them by contacts: Mechanism::owed, for the next step.
void tell_pressures(World& world);

}  // namespace pantin::procedural
