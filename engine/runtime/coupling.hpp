#pragma once
/// Coupling of islands of different solvers at interfaces: both repeat the same step until action
/// equals reaction.
#include "engine/world/world.hpp"

namespace pantin::detail {

/// Saves the initial state of all islands with interfaces, before the step.
void save_coupled(World& world);

/// After structural changes within a step, once the islands are compiled again: those that did not
/// change keep the initial state that save_coupled stored.
void recouple(World& world);

/// One step of `h` seconds of all leaders and followers, with the contacts of the step. Momentum is
/// exchanged to a relative residual of 1e-6, which is carried into the next step. Does not allocate
/// in the steady state.
void step_coupled(World& world, Real h);

/// Exchanges the reactions of followers that were solved together because they are in contact.
void couple_touching(World& world, Real h);

}  // namespace pantin::detail
