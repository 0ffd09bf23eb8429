#include "engine/solvers/solver.hpp"

#include <algorithm>

#include "engine/base/check.hpp"
#include "engine/contact/resting.hpp"
#include "engine/solvers/check.hpp"
#include "engine/solvers/drive_starts.hpp"
#include "engine/solvers/motor_gains.hpp"
#include "engine/solvers/takeover.hpp"

namespace pantin::detail {

namespace {

/// Assigns the islands to solvers, and so an owner to each body.
std::array<std::vector<IslandPlan>, kSolverCount> partition(World& world, const Scope& scope) {
  Partition& all = world.memory.of<Partition>();
  all.islands.clear(), all.faults.clear(), all.kinematic.clear();
  ++all.rest_version;
  all.island.assign(world.bodies.size(), Owner::kNone);
  all.column.assign(world.collisions.empty() ? 0 : world.bodies.size(), Owner::kNone);
  std::array<std::vector<IslandPlan>, kSolverCount> plans;
  const std::vector<Takeover>& taken = world.memory.of<Takeovers>().list;
  for (IslandPlan& plan : find_islands(world, scope)) {
    PANTIN_ASSERT(plan.solver < kSolverCount &&
                  std::is_sorted(plan.slots.begin(), plan.slots.end()));
    const Entity first = world.bodies.owners()[plan.slots.front()];
    for (const Takeover& t : taken)
      if (t.body == first) plan.settings = t.by, plan.solver = row_of(t.by.solver);
    std::vector<IslandPlan>& own = plans[plan.solver];
    for (const std::uint32_t slot : plan.slots)
      all.island[slot] = static_cast<std::uint32_t>(all.islands.size());
    all.islands.push_back({plan.solver, kSolvers[plan.solver]->feels_contacts,
                           static_cast<std::uint32_t>(own.size()), false, plan.beyond});
    own.push_back(std::move(plan));
  }
  for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot)
    if (!owner_of(all, slot).feels_contacts) all.kinematic.push_back(slot);
  return plans;
}

bool is_solid(const World& world, Entity e) {
  const Collision* collision = world.collisions.find(e);
  return collision && !collision->sensor;
}

/// The slots now of the `count` bodies of the last build, by their slots then; kNoSlot where one is
/// no longer solid.
std::vector<std::uint32_t> solid_slots(const World& world, std::size_t count) {
  std::vector<std::uint32_t> now(count, kNoSlot);
  for (std::uint32_t then = 0; then < now.size(); ++then)
    if (const std::uint32_t slot = world.bodies.slot_now(then);
        slot != kNoSlot && is_solid(world, world.bodies.owners()[slot]))
      now[then] = slot;
  return now;
}

/// Renumbers the slots of contacts, or ends contacts whose body is gone or no longer solid. Then
/// the remaining body wakes, if it is dynamic: fixed ground would wake all bodies that rest on it.
void renumber_contacts(World& world, std::size_t bodies_then) {
  contact::Memory& memory = world.memory.of<contact::Memory>();
  memory.scratch.stale = true;
  if (!world.bodies.has_moved() && !world.collisions.has_moved()) return;
  contact::renumber_filters(world, memory.scratch.filters);
  contact::renumber_resting(world, memory.scratch.search.resting);
  const std::vector<std::uint32_t> now = solid_slots(world, bodies_then);
  const auto slot_of = [&](std::uint32_t then) { return then < now.size() ? now[then] : kNoSlot; };
  const auto is_gone = [&](Contact& c) {
    const std::uint32_t a = slot_of(c.slot_a), b = slot_of(c.slot_b);
    if (a != kNoSlot && b != kNoSlot) {
      c.slot_a = a, c.slot_b = b;
      return false;
    }
    for (const std::uint32_t then : {c.slot_a, c.slot_b})
      if (const std::uint32_t slot = world.bodies.slot_now(then);
          slot != kNoSlot && owner_of(partition_of(world), slot))
        world.bodies.values()[slot].restart = true;
    return true;
  };
  std::erase_if(memory.contacts, is_gone);
  if (std::erase_if(memory.resting, is_gone) > 0) contact::sum_up_resting(memory);
}

/// Lets bodies that became solid since the last build wake the islands in contact with them.
void note_what_comes(World& world, const Partition& now) {
  if (now.built_for == 0) return;
  for (const std::uint32_t slot : now.kinematic) {
    const std::uint32_t collision = world.collisions.slot(world.bodies.owners()[slot]);
    if (collision == kNoSlot || world.collisions.values()[collision].sensor) continue;
    if (world.bodies.is_new(slot) || world.collisions.is_new(collision))
      world.bodies.values()[slot].restart = true;
  }
}

/// From here on the stores map the slots of islands and contacts to the present ones.
void note_build(World& world, Partition& now) {
  for_each_structural_store(world, [](auto& store) { store.track_slots(); });
  now.built_for = world.structure(), now.edit_count = world.edit_count;
}

}  // namespace

namespace {

/// The turns that all solvers have counted, sorted.
TurnCounts counted_turns(const World& world) {
  TurnCounts counts;
  for (const SolverRow* solver : kSolvers) solver->list_turns(world, counts);
  sort(counts);
  return counts;
}

void build_all(World& world, Partition& now) {
  if (now.built_for != 0) now.turns = counted_turns(world);
  const std::vector<StructureFault> strays = drop_strays(world);
  start_drives(world);
  const Scope scope = Scope::all(world);
  auto plans = partition(world, scope);
  now.faults = strays;
  list_faults(world, scope, plans);
  for (std::size_t i = 0; i < kSolverCount; ++i) kSolvers[i]->compile(world, plans[i]);
  now.turns.clear();
}

/// Builds what a change of structure concerns; false if all has to be built.
bool build_changed(World& world) {
  std::optional<Rebuild> rebuild = find_rebuild(world);
  if (!rebuild) return false;
  start_drives(world);
  std::array<std::vector<IslandPlan>, kSolverCount> plans;
  plans[kArticulated] = std::move(rebuild->plans);
  list_faults(world, rebuild->scope, plans);
  rebuild->plans = std::move(plans[kArticulated]);
  kSolvers[kArticulated]->recompile(world, *rebuild);
  world.memory.of<Partition>().awake_for = 0;
  if (!rebuild->same_obstacles) world.memory.of<contact::Memory>().scratch.rest_version = 0;
  return true;
}

}  // namespace

void forget_state(World& world) noexcept {
  TurnCounts turns;
  try {
    turns = counted_turns(world);
  } catch (...) {
  }
  world.memory = {};
  try {
    world.memory.of<Partition>().turns = std::move(turns);
  } catch (...) {
  }
}

void compile_if_changed(World& world) {
  // Created in this fixed order, so that the hash does not depend on the order of use.
  Partition& now = world.memory.of<Partition>();
  world.memory.of<Takeovers>();
  world.memory.of<contact::Memory>();
  if (now.built_for == 0 || now.built_for != world.structure()) {
    const std::size_t bodies_then = now.island.size();
    if (!build_changed(world)) build_all(world, now);
    renumber_contacts(world, bodies_then);
    note_what_comes(world, now);
    note_build(world, now);
    now.has_open_motors = has_open_motors(world);
  }
  PANTIN_ASSERT(now.island.size() == world.bodies.size());
  for (const SolverRow* solver : kSolvers) solver->prepare(world);
}

void list_awake(World& world) {
  Partition& all = world.memory.of<Partition>();
  if (all.awake_for == all.rest_version) return;
  all.awake_for = all.rest_version;
  all.awake.clear();
  for (const SolverRow* solver : kSolvers)
    if (solver->list_awake) solver->list_awake(world, all.awake);
  const auto never_sleeps = [](const Partition::Place& p) {
    return !kSolvers[p.solver]->list_awake;
  };
  if (std::any_of(all.islands.begin(), all.islands.end(), never_sleeps))
    for (std::uint32_t slot = 0; slot < all.island.size(); ++slot)
      if (all.island[slot] != Owner::kNone && never_sleeps(all.islands[all.island[slot]]))
        all.awake.push_back(slot);
  std::sort(all.awake.begin(), all.awake.end());
}

}  // namespace pantin::detail

namespace pantin {

using namespace detail;

bool has_threads() {
#ifdef PANTIN_HAS_TBB
  return true;
#else
  return false;
#endif
}

}  // namespace pantin
