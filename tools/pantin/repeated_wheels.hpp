#pragma once
/// Wheels on one axle: both forbid the same motion along it, so one of their rows is redundant.
#include <string>
#include <vector>

#include "engine/world/world.hpp"

namespace pantin::program {

/// A line for each pair, with names and what to do instead; the structure of the World is built.
/// Integrators that solve for the end of a step are not troubled by it: none for their islands.
std::vector<std::string> words_of_repeated_wheels(const World& world);

}  // namespace pantin::program
