#include "engine/solvers/solver.hpp"

#include <algorithm>
#include <atomic>
#include <new>

#include "engine/base/check.hpp"
#include "engine/solvers/check.hpp"
#include "engine/solvers/takeover.hpp"

#ifdef PANTIN_HAS_TBB
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace pantin::detail {

namespace {

/// Assigns the islands to solvers, and so an owner to each body.
std::array<std::vector<IslandPlan>, kSolverCount> partition(World& world) {
  Partition& all = world.memory.of<Partition>();
  all.islands.clear(), all.faults.clear(), all.kinematic.clear();
  ++all.rest_version;
  all.island.assign(world.bodies.size(), Owner::kNone);
  all.column.assign(world.collisions.empty() ? 0 : world.bodies.size(), Owner::kNone);
  std::array<std::vector<IslandPlan>, kSolverCount> plans;
  const std::vector<Takeover>& taken = world.memory.of<Takeovers>().list;
  for (IslandPlan& plan : find_islands(world)) {
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

/// Renumbers the slots of contacts, or ends contacts whose body is gone or no longer solid. Then
/// the remaining body wakes, if it is dynamic: fixed ground would wake all bodies that rest on it.
void renumber_contacts(World& world) {
  contact::Memory& memory = world.memory.of<contact::Memory>();
  memory.scratch.stale = true;
  if (!world.bodies.has_moved() && !world.collisions.has_moved()) return;
  const auto is_there = [&](std::uint32_t slot) { return slot < world.bodies.size(); };
  const auto stays = [&](std::uint32_t slot) {
    return is_there(slot) && is_solid(world, world.bodies.owners()[slot]);
  };
  const auto is_gone = [&](Contact& c) {
    const std::uint32_t a = world.bodies.slot_now(c.slot_a), b = world.bodies.slot_now(c.slot_b);
    if (stays(a) && stays(b)) {
      c.slot_a = a, c.slot_b = b;
      return false;
    }
    for (const std::uint32_t slot : {a, b})
      if (is_there(slot) && owner_of(partition_of(world), slot))
        world.bodies.values()[slot].restart = true;
    return true;
  };
  std::erase_if(memory.contacts, is_gone), std::erase_if(memory.resting, is_gone);
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

void compile_if_changed(World& world) {
  // Created in this fixed order, so that the hash does not depend on the order of use.
  Partition& now = world.memory.of<Partition>();
  world.memory.of<Takeovers>();
  world.memory.of<contact::Memory>();
  if (now.built_for == 0 || now.built_for != world.structure()) {
    const std::vector<StructureFault> strays = drop_strays(world);
    auto plans = partition(world);
    now.faults = strays;
    list_faults(world, plans);
    for (std::size_t i = 0; i < kSolverCount; ++i) kSolvers[i]->compile(world, plans[i]);
    renumber_contacts(world);
    note_what_comes(world, now);
    note_build(world, now);
  }
  PANTIN_ASSERT(now.island.size() == world.bodies.size());
  for (const SolverRow* solver : kSolvers) solver->prepare(world);
}

/// Islands of a solver without wake-up detection never count as asleep.
void list_awake(World& world) {
  Partition& all = world.memory.of<Partition>();
  if (all.awake_for == all.rest_version) return;
  all.awake_for = all.rest_version;
  all.awake.clear();
  for (std::uint32_t slot = 0; slot < all.island.size(); ++slot) {
    if (all.island[slot] == Owner::kNone) continue;
    const Partition::Place& place = all.islands[all.island[slot]];
    const SolverRow& solver = *kSolvers[place.solver];
    if (!solver.wake_changed || !solver.sleeps(world, place.island)) all.awake.push_back(slot);
  }
}

namespace {

/// Runs jobs on a user's threads, which exceptions of a job (out of memory) must not reach.
void run_by_user(std::size_t count, const RunJobs& run_jobs, Job job) {
  std::atomic<bool> failed = false;
  const auto guarded = [&](std::size_t i) {
    try {
      job(i);
    } catch (...) {
      failed = true;
    }
  };
  run_jobs(count, Job(guarded));
  if (failed) throw std::bad_alloc();
}

}  // namespace

void run_islands(std::size_t count, const StepTask& task, Job job) {
  if (task.run_jobs && count > 1) return run_by_user(count, *task.run_jobs, job);
#ifdef PANTIN_HAS_TBB
  if (task.threads > 1 && count > 1) {
    // Asking for more threads than there are cores makes TBB print a warning.
    tbb::task_arena arena(std::min(task.threads, tbb::this_task_arena::max_concurrency()));
    arena.execute(
        [&] { tbb::parallel_for(std::size_t(0), count, [&](std::size_t i) { job(i); }); });
    return;
  }
#endif
  for (std::size_t i = 0; i < count; ++i) job(i);
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
