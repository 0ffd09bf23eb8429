#pragma once
/// Islands: bodies connected by joints, cables, pins and gears. One solver owns each island.
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/hash.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/faults.hpp"
#include "engine/world/memory.hpp"
#include "engine/world/scope.hpp"
#include "engine/world/settings.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/turns.hpp"

namespace pantin {
struct World;
}

namespace pantin::detail {

/// The owner of a body: solver, island and column.
struct Owner {
  static constexpr std::uint32_t kNone = UINT32_MAX;
  std::uint8_t solver = 0;       // row of kSolvers
  bool feels_contacts = false;   // its solver resolves contacts of this body
  std::uint32_t island = kNone;  // of that solver; none: no solver owns the body
  std::uint32_t column = kNone;  // in the island; known only if some body collides
  explicit operator bool() const { return island != kNone; }
};

/// An island as passed to its solver for compilation.
struct IslandPlan {
  std::uint8_t solver = 0;
  SolverSettings settings;           // those of its first body with settings
  std::vector<std::uint32_t> slots;  // in World::bodies, ascending
  Entity unfit;                      // a body that no step can be computed with, or none
  Entity beyond;                     // the entity that "auto" does not support, passed to
                                     // `settings.solver`
};

/// Owners of all bodies. Derived from the components; rebuilt when World::structure() changes.
struct Partition {
  static constexpr std::string_view name = "partition";  // in saved Worlds
  struct Place {
    std::uint8_t solver = 0;
    bool feels_contacts = false;
    std::uint32_t island = 0;  // of that solver
    bool unfit = false;        // contains a body that no step can be computed with
    Entity beyond;             // see IslandPlan
  };
  std::vector<Place> islands;            // of all solvers
  std::vector<std::uint32_t> island;     // by slot in World::bodies: index into `islands`, or
                                         // Owner::kNone
  std::vector<std::uint32_t> column;     // by slot; empty if no body collides
  std::vector<std::uint32_t> kinematic;  // slots of bodies that no solver owns
  /// Slots of the moving bodies that are awake, ascending. Bodies that wake within a step are added
  /// to it; bodies that fall asleep are removed before the next step.
  std::vector<std::uint32_t> awake;
  std::uint64_t rest_version = 1;  // changes when an island falls asleep or wakes
  std::uint64_t awake_for = 0;     // the rest_version for which `awake` was listed
  std::vector<StructureFault> faults;
  bool has_open_motors = false;  // a motor waits for its gain: see solvers/motor_gains.hpp
  std::uint64_t built_for = 0;   // World::structure() at the last build; 0: never
  std::uint64_t edit_count = 0;  // World::edit_count at that build
  TurnCounts turns;              // for the next build, of a step that was aborted

  void set_column(std::uint32_t slot, std::uint32_t to) {
    if (!column.empty()) column[slot] = to;
  }

  static void fields(auto& self, auto&& field) {
    field("islands", derived(self.islands));
    field("island", derived(self.island));
    field("column", derived(self.column));
    field("kinematic", derived(self.kinematic));
    field("awake", derived(self.awake));
    field("rest_version", derived(self.rest_version));
    field("awake_for", derived(self.awake_for));
    field("faults", derived(self.faults));
    field("has_open_motors", derived(self.has_open_motors));
    field("built_for", derived(self.built_for));
    field("edit_count", derived(self.edit_count));
    field("turns", derived(self.turns));
  }
};

/// Finds all islands: bodies that joints, surfaces, gears, belts, cables and pins connect. The
/// solver of an island is that of its first body with settings; "auto" passes islands that it does
/// not support to "lagrangian". Islands are ordered by their lowest slot.
std::vector<IslandPlan> find_islands(const World& world);
/// Those of a scope.
std::vector<IslandPlan> find_islands(const World& world, const Scope& scope);

/// The partition of the last step.
const Partition& partition_of(const World& world);
/// The owner of the body in `slot`; none if the body is newer than the last compilation.
inline Owner owner_of(const Partition& partition, std::uint32_t slot) {
  Owner owner;
  if (slot >= partition.island.size() || partition.island[slot] == Owner::kNone) return owner;
  const Partition::Place& place = partition.islands[partition.island[slot]];
  owner.solver = place.solver, owner.feels_contacts = place.feels_contacts;
  owner.island = place.island;
  if (slot < partition.column.size()) owner.column = partition.column[slot];
  return owner;
}

}  // namespace pantin::detail

// Copying, hashing and saving are compiled once, in partition.cpp.
namespace pantin::detail {
extern template Partition& Memories::create();
extern template const Partition& Memories::none();
}  // namespace pantin::detail
