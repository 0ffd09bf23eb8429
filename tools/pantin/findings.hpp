#pragma once
// Findings and last readings of a run, as text.
#include <span>

#include "tools/pantin/program.hpp"

namespace pantin::program {

/// "energy_gained: rod 3, 12.3 J more than can be at 0.35 s": one line, printable.
std::string words_of(const World& world, const Finding& finding);
Json findings_json(const World& world, std::span<const Finding> findings);
/// The values of a scene's sensors at the end, by name: a number, or three; null where there is
/// none, as of accelerations, which need two readings.
Json sensors_json(const Scene& scene, const World& world);
/// Prints the worst finding of each kind, a line each.
void print_findings(const Simulation& sim);
/// The number of dynamic bodies whose energy the run cannot balance.
std::size_t unchecked_bodies(const Simulation& sim);

}  // namespace pantin::program
