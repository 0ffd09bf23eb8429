#include "engine/solvers/solver.hpp"

#include <algorithm>

#ifdef PANTIN_HAS_TBB
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace pantin {

std::uint8_t row_of(Solver solver) {
  return solver == Solver::lagrangian ? kLagrangian : kArticulated;
}

namespace {

/// Shares the islands out; who moves a body is known from then on.
std::array<std::vector<IslandPlan>, kSolverCount> partition(World& world) {
  Partition& all = world.memory.of<Partition>();
  all.islands.clear(), all.faults.clear(), all.kinematic.clear();
  all.island.assign(world.bodies.size(), Owner::kNone);
  all.column.assign(world.collisions.empty() ? 0 : world.bodies.size(), Owner::kNone);
  std::array<std::vector<IslandPlan>, kSolverCount> plans;
  for (IslandPlan& plan : find_islands(world, row_of)) {
    std::vector<IslandPlan>& own = plans[plan.solver];
    for (const std::uint32_t slot : plan.slots)
      all.island[slot] = static_cast<std::uint32_t>(all.islands.size());
    all.islands.push_back({plan.solver, kSolvers[plan.solver]->feels_contacts,
                           static_cast<std::uint32_t>(own.size())});
    own.push_back(std::move(plan));
  }
  for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot)
    if (!owner_of(all, slot).feels_contacts) all.kinematic.push_back(slot);
  return plans;
}

}  // namespace

void compile_if_changed(World& world) {
  // Made in this order, whoever asks first: what is hashed does not depend on it.
  Partition& now = world.memory.of<Partition>();
  world.memory.of<contact::Memory>();
  if (now.built_for != world.structure()) {
    const auto plans = partition(world);
    for (std::size_t i = 0; i < kSolverCount; ++i) kSolvers[i]->compile(world, plans[i]);
    now.built_for = world.structure();
  }
  for (const SolverRow* solver : kSolvers) solver->prepare(world);
}

void run_islands(std::size_t count, [[maybe_unused]] int threads, IslandWork work) {
#ifdef PANTIN_HAS_TBB
  if (threads > 1 && count > 1) {
    // Asking for more threads than there are cores makes TBB print a warning.
    tbb::task_arena arena(std::min(threads, tbb::this_task_arena::max_concurrency()));
    arena.execute([&] {
      tbb::parallel_for(std::size_t(0), count, [&](std::size_t i) { work.run(work.with, i); });
    });
    return;
  }
#endif
  for (std::size_t i = 0; i < count; ++i) work.run(work.with, i);
}

bool has_threads() {
#ifdef PANTIN_HAS_TBB
  return true;
#else
  return false;
#endif
}

}  // namespace pantin
