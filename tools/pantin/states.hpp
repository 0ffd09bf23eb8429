#pragma once
// Colours of bodies by their state: fixed, kinematic, asleep or moving.
#include <vector>

#include "engine/render/renderer.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

/// By slot of World::bodies, linear RGB.
std::vector<Vec3> state_colours(const World& world);
/// The meaning of these colours: those that the bodies of the World can have.
std::vector<LegendEntry> states_legend(const World& world);

}  // namespace pantin::program
