#pragma once
/// The contract between the step and its solvers, and the table of them.
///
/// A solver is a folder and a row of kSolvers. The World's islands are shared out by row; each solver
/// compiles its own into memory of its own (World::memory) and moves them. Solvers do not know one
/// another: what crosses islands goes through the room contact.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/contact/memory.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/report.hpp"
#include "engine/world/world.hpp"

namespace pantin {

/// What a solver is told of the step it takes part in.
struct StepTask {
  Real h = 0;       // s
  int threads = 1;  // that may work on islands; the result does not depend on it
};

/// One solver. `island` numbers its own islands, as they were compiled.
struct SolverRow {
  const char* name;
  bool feels_contacts;  // moves its bodies away from what they touch

  /// Packs all islands it is given, in their order, carrying memory over by body; writes
  /// Owner::column of their bodies and faults into the Partition.
  void (*compile)(World&, std::span<const IslandPlan>);
  /// Memory for the steps: after compile, and after the World was copied.
  void (*prepare)(World&);

  /// The update stage: free motion of all its islands. Islands with interfaces of their own
  /// (leaders) wait for `repeat`.
  void (*predict)(World&, const StepTask&);
  /// Whether nothing that it moves moves.
  bool (*asleep)(const World&);
  /// How far the surfaces of its bodies may move in the step, m, by body slot.
  void (*find_reaches)(const World&, Real h, std::span<Real> reach);
  /// Contacts were found: each island takes those of its bodies.
  void (*take_contacts)(World&, Real h);
  /// The adjust stage: joints closed, contacts borne, bodies written; all islands that neither
  /// follow an interface nor touch one another.
  void (*adjust)(World&, const StepTask&);
  /// ... of those that touch one another.
  void (*adjust_touching)(World&, const StepTask&);

  // Interfaces: see runtime/coupling.hpp.
  std::size_t (*count)(const World&);
  /// The interfaces that the island leads.
  std::span<contact::Interface> (*interfaces)(World&, std::size_t island);
  /// Whether the island is tied to one of another solver that leads it.
  bool (*follows)(const World&, std::size_t island);
  /// Whether it touches another island of its solver.
  bool (*touches)(const World&, std::size_t island);
  /// Remembers where the island's step starts from, bodies included.
  void (*save)(World&, std::size_t island);
  /// Takes the step from there once more. False if it cannot be taken.
  bool (*repeat)(World&, std::size_t island, Real h);
  /// What a follower pulled through its interfaces over the step, added to the list.
  void (*react)(World&, std::size_t island, Real h, std::vector<contact::Reaction>&);
  /// What its islands press on bodies that feel no contacts, added to the list.
  void (*press)(const World&, std::vector<contact::Pressure>&);

  /// What the step left, added to the report and to the measures.
  void (*report)(const World&, StepReport&);
  void (*measure)(const World&, Measures&);
};

/// Rows of kSolvers, in the order in which solvers predict and adjust.
enum SolverIndex : std::uint8_t { kLagrangian, kArticulated, kSolverCount };

namespace lagrangian {
extern const SolverRow kRow;
}
namespace articulated {
extern const SolverRow kRow;
}
inline constexpr std::array<const SolverRow*, kSolverCount> kSolvers{&lagrangian::kRow,
                                                                    &articulated::kRow};

/// The row that runs what a setting asks for.
std::uint8_t row_of(Solver solver);

/// Finds the islands anew if the structure changed and has their solvers compile them; makes memory
/// for the steps where there is none.
void compile_if_changed(World& world);

/// A function of an island's number, borrowed: no memory is taken for it.
struct IslandWork {
  void (*run)(const void* with, std::size_t island);
  const void* with;
};
void run_islands(std::size_t count, int threads, IslandWork work);
/// Runs `work(i)` for every i below `count` on the threads of a task; no two i share anything.
template <class Work>
void for_each_island(std::size_t count, int threads, const Work& work) {
  run_islands(count, threads,
              {[](const void* with, std::size_t i) { (*static_cast<const Work*>(with))(i); }, &work});
}
/// Whether a step can use more than one thread in this build.
bool has_threads();

}  // namespace pantin
