#pragma once
/// Islands of different solvers that pins and cables tie at interfaces: both take the same step again
/// until what one pulls is what the other feels.
#include "engine/world/world.hpp"

namespace pantin {

/// Before the step: remembers where all islands with interfaces start from.
void save_coupled(World& world);

/// After structural changes within a step, once the islands caught up: what save_coupled remembered
/// goes on for those that did not change.
void recouple(World& world);

/// One step of `h` seconds of all islands that lead interfaces and of those that follow them;
/// contacts are those found for the step. Momentum is exchanged to 1e-6 of each pull; what is left
/// of it is carried into the next step. Allocates nothing once it has run.
void step_coupled(World& world, Real h);

/// After followers that also touch one another were solved side by side, once: what they pulled.
void settle_touching(World& world, Real h);

}  // namespace pantin
