#pragma once
/// What a program asked of the step to come: see engine/world/requests.hpp.
#include "engine/world/requests.hpp"

namespace pantin::detail {

/// At the start of a substep of `h` seconds: blows become forces that last it; pairs whose time has
/// come collide again, and wake. Pairs of bodies that are gone are forgotten.
void apply_requests(World& world, Real h);

/// Wakes a body that sleeps; false if it does not. What is awake goes on as it does.
bool rouse(World& world, Entity body);

}  // namespace pantin::detail
