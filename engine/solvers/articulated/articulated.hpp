#pragma once
/// The articulated solver: free motion first, then the joints closed. [Lee 2000], corrected and made
/// to keep energy and order; the method and its measures are described in the functions.
#include "engine/contact/memory.hpp"
#include "engine/solvers/articulated/island.hpp"

namespace pantin::articulated {

/// Memory for the steps of every island that has none; after compile, and after a copy.
void prepare(World& world);

/// Update stage: predicts the free motion of every body of an island over `h` seconds.
void update(World& world, Island& a, Real h);

/// Wakes an island (Island::resting), within a step.
void stir(World& world, Island& a, Real h);

/// How far the surfaces of all bodies may come in a step, m, by body slot; from their predictions.
void find_reaches(const World& world, Real h, std::span<Real> reach);
/// Whether every island is asleep.
bool all_asleep(const World& world);
/// Hands the contacts found to the islands they concern.
void take_contacts(World& world, Real h);

/// Adjust stage: closes the joints of the predicted poses, finds velocities, writes the bodies.
/// False if a number is not finite or out of all bounds; the bodies are then left as they were, and
/// `lost` names one that is concerned.
bool adjust(World& world, Island& a, Real h, Entity& lost);

/// The same in parts, for islands that touch one another (Island::mutual): all of them begin; then
/// passes, until nothing changes: all begin the pass, the loads between them are found for the whole
/// World at once, all end it. At last each finishes.
void begin_passes(World& world, Island& a, Real h);
void begin_iterating(World& world, Island& a);
void begin_pass(World& world, Island& a, Real h);
void iterate_mutual(World& world, Real h);
bool end_pass(World& world, Island& a, Real h);
bool finish_passes(World& world, Island& a, Real h, Entity& lost);

/// What an adjusted island pulled through its interfaces over the step.
void react(World& world, std::size_t island, Real h, std::vector<contact::Reaction>& out);
/// What all islands press by contacts on bodies of solvers that feel none.
void press(const World& world, std::vector<contact::Pressure>& out);

}  // namespace pantin::articulated
