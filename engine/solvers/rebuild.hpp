#pragma once
/// Changes of structure that concern few islands: the others stay compiled as they are.
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/world/partition.hpp"
#include "engine/world/scope.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

/// What a change of structure leaves of the islands, and what is compiled anew. All islands belong
/// to one solver, so that their numbers in the Partition are those of the solver.
struct Rebuild {
  static constexpr std::uint32_t kGone = UINT32_MAX;
  Scope scope;                        // the bodies that are compiled anew, and what ties them
  std::vector<IslandPlan> plans;      // of these, in the order of their lowest slots
  std::vector<std::uint32_t> places;  // of the plans: their numbers among all islands
  std::vector<std::uint32_t> now;     // by island of the last build: its number, or kGone
  std::vector<std::uint32_t> moved;   // islands, now, whose bodies or ties are in other slots
  bool same_obstacles = true;         // bodies of no solver neither came nor went
};

/// Compares the stores with the last build. None if a whole build is needed: after mark_dirty(),
/// with faults, with several solvers or another than "auto", with gears, belts or joints of
/// surfaces, or after more removals than the stores remember. If there is one, the Partition knows
/// the new islands.
std::optional<Rebuild> find_rebuild(World& world);

}  // namespace pantin::detail
