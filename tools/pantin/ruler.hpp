#pragma once
/// What a run is measured by, kept from its first state to its last.
#include <string>
#include <vector>

#include "engine/runtime/report.hpp"
#include "engine/world/world.hpp"

namespace pantin::program {

/// A pin, string or joint that did not come to its place.
struct Unreached {
  std::string name;
  std::string kind;     // "pin", "string" or "joint"
  Real residual_m = 0;  // how far from it
};

/// Those of the state as it stands, worst first; as in StepReport, springs are not expected to
/// reach anything.
std::vector<Unreached> unreached(const World& world);

/// How the solvers of a World's articulations are called: "auto", or "auto+sweep" if they differ.
std::string solvers_of(const World& world);

/// One line for each link, string or pin that is left out. Builds the articulations if need be.
std::vector<std::string> structure_faults(World& world);

struct Counts {
  std::size_t bodies = 0, dynamic = 0, driven = 0, joints = 0, strings = 0, pins = 0;
  std::size_t articulations = 0;
  Real mass = 0;  // kg, of dynamic bodies
};
Counts counts_of(const World& world);

/// Extremes over a run. Gaps count from the first step on: a scene may start open.
struct Ruler {
  Measures last;
  Real worst_gap = 0, worst_gap_rel = 0;                  // m, part of the articulation's size
  std::string worst_joint;                                // name; empty as long as nothing is open
  Real worst_time = 0;                                    // s
  Real energy_start = 0, energy_end = 0, energy_max = 0;  // J
  Real worst_unreached = 0;                               // m, largest residual of any step

  void start(const World& world);
  void take(const World& world, const StepReport& report);
};

}  // namespace pantin::program
