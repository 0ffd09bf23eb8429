#pragma once
/// The solver interface and the table of solvers.
///
/// A solver is a folder and a row of kSolvers. Each island of the World belongs to one row; the
/// solver compiles its islands into memory of its own (World::memory) and steps them. Solvers are
/// independent of one another: one of them steps all bodies that are connected or may collide.
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/base/threads.hpp"
#include "engine/contact/memory.hpp"
#include "engine/solvers/budget.hpp"
#include "engine/solvers/rebuild.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/report.hpp"
#include "engine/world/solver_list.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// Parameters of a step.
struct StepTask {
  Real h = 0;  // s
  Threads threads;
  const ContactFilter* filter = nullptr;
  const Budget* budget = nullptr;  // none: all substeps are taken
};

/// One solver. `island` is the index of one of its islands, in the order of compilation. Functions
/// that a row omits do nothing.
struct SolverRow {
  const char* name;
  bool feels_contacts = false;  // resolves contacts of its bodies

  /// Packs the given islands in their order, carrying state over by body; writes Owner::column of
  /// their bodies and faults into the Partition.
  void (*compile)(World&, std::span<const IslandPlan>);
  /// The same for the islands that a change concerns; null: all are packed anew.
  void (*recompile)(World&, const Rebuild&) = nullptr;
  /// Appends the turns that its joints have counted, before a build.
  void (*list_turns)(const World&, TurnCounts&) = [](const World&, TurnCounts&) {};
  /// Allocates scratch memory: after compile, and after the World was copied.
  void (*prepare)(World&) = [](World&) {};

  /// Wakes the sleeping islands that were changed since the last step, before other code reads the
  /// bodies. A solver without it reports no island as asleep.
  void (*wake_changed)(World&, const StepTask&) = nullptr;
  /// The update stage: free motion of all islands.
  void (*predict)(World&, const StepTask&);
  /// After a compilation between the update and the adjust stage of a step: predicts the changed
  /// islands, or lets them skip the substep.
  void (*catch_up)(World&, const StepTask&) = [](World&, const StepTask&) {};
  /// After a saved World was read: a reason why its islands cannot be stepped, or null.
  const char* (*fault)(const World&) = [](const World&) -> const char* { return nullptr; };
  /// Whether all its islands sleep.
  bool (*asleep)(const World&);
  /// Whether that island sleeps; false for a solver without sleeping.
  bool (*sleeps)(const World&, std::size_t island) = [](const World&, std::size_t) {
    return false;
  };
  /// Appends the slots of its bodies that are awake. Null: it has no sleeping islands.
  void (*list_awake)(const World&, std::vector<std::uint32_t>& slots) = nullptr;
  /// Bounds on the displacements of its bodies in the step.
  void (*find_reaches)(const World&, Real h, const contact::Reaches& out) =
      [](const World&, Real, const contact::Reaches&) {};
  /// Appends the solid bodies that `predict` has already moved to the end of the step.
  void (*find_starts)(const World&, std::vector<contact::StartPose>&) =
      [](const World&, std::vector<contact::StartPose>&) {};
  /// After contact detection: each island takes the contacts of its bodies.
  void (*take_contacts)(World&, Real h) = [](World&, Real) {};
  /// The adjust stage: closes joints, resolves contacts, writes bodies.
  void (*adjust)(World&, const StepTask&) = [](World&, const StepTask&) {};
  /// At the end of a substep: appends contacts that the solver has found by itself, in the order of
  /// contact::Memory::contacts. Null: it has none.
  void (*list_contacts)(const World&, std::vector<Contact>&) = nullptr;

  /// After each substep: reports its failure, unless a worse one is in the report, and the energy
  /// that was removed.
  void (*note_failure)(const World&, StepReport&) = [](const World&, StepReport&) {};
  /// Adds the results of the step, those of its last substep, to the report and to the measures.
  void (*report)(const World&, StepReport&);
  void (*measure)(const World&, Measures&) = [](const World&, Measures&) {};
  /// The angle that an exact drive turns its joint by, after the last step, with whole turns
  /// counted, rad; NaN where it drives none.
  Real (*drive_angle)(const World&, Entity joint) = [](const World&, Entity) {
    return std::numeric_limits<Real>::quiet_NaN();
  };
};

namespace quasistatic {
extern const SolverRow kRow;
}
namespace planar {
extern const SolverRow kRow;
}
namespace lagrangian {
extern const SolverRow kRow;
}
namespace articulated {
extern const SolverRow kRow;
}
/// By SolverIndex (engine/world/solver_list.hpp).
inline constexpr std::array<const SolverRow*, kSolverCount> kSolvers{
    &quasistatic::kRow, &planar::kRow, &lagrangian::kRow, &articulated::kRow};

/// Forgets the state of all solvers, but for the turns that joints have counted, where there is
/// memory for them.
void forget_state(World& world) noexcept;
/// If the structure changed, finds the islands and compiles them; allocates scratch memory where
/// needed.
void compile_if_changed(World& world);

/// The part of compile_if_changed that finds unsupported features and invalid numbers in a scope,
/// and marks the islands concerned.
void list_faults(World& world, const Scope& scope, std::span<std::vector<IslandPlan>> plans);

/// Brings Partition::awake up to date.
void list_awake(World& world);

/// Runs `work(i)` for every i below `count` on the threads of a task; the calls are independent.
template <class Work>
void for_each_island(std::size_t count, const StepTask& task, const Work& work) {
  task.threads.run(count, Job(work));
}

}  // namespace pantin::detail
