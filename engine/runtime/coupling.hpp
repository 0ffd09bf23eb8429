#pragma once
/// Articulations that hang on mechanisms: both take the same step again until what one pulls is
/// what the other feels.
#include "engine/world/world.hpp"

namespace pantin {

/// After structural changes within a step, once everything else was built anew: what begin_coupled
/// remembered goes on under today's numbers.
void renumber_coupled(World& world);

/// Before the step: remembers where all that hangs together starts from.
void begin_coupled(World& world);

/// One step of `h` seconds of all mechanisms on which something hangs, and of what hangs there;
/// contacts are those found for the step. Momentum is exchanged to 1e-6 of each pull; what is left
/// of it is carried into the next step. Allocates nothing once it has run.
void step_coupled(World& world, Real h);

/// After articulations that also touch one another were solved side by side, once: what they pulled.
void settle_mutual(World& world, Real h);

/// Whether the articulation's own step is taken by step_coupled.
inline bool steps_coupled(const World& world, std::size_t articulation) {
  return articulation < world.coupling.hanging.size() &&
         world.coupling.hanging[articulation] != 0 && !world.articulations[articulation].mutual;
}

/// Whether anything hangs on the mechanism.
inline bool is_coupled(const Mechanism& m) { return !m.hangings.empty() && !m.sits_out; }

}  // namespace pantin
