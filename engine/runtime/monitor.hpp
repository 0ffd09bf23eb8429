#pragma once
/// Monitors the steps of a World from outside the solvers and lists what makes the result doubtful.
#include <span>

#include "engine/runtime/energy_account.hpp"
#include "engine/runtime/finding_list.hpp"
#include "engine/runtime/watch_contacts.hpp"
#include "engine/runtime/watch_gaps.hpp"
#include "engine/runtime/watch_turns.hpp"
#include "engine/world/report.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// One finding of each kind for each body, joint or cable, in the order of time. Allocates only
/// when the structure changes.
class Monitor {
 public:
  /// In each substep: see EnergyAccount.
  void begin_substep(const World& world);
  void note_start(const World& world, Real h);
  void end_substep(const World& world, Real h);
  /// Called at the end of a step of `h` seconds; counts new findings in the report.
  void end_step(const World& world, Real h, StepReport& report);
  /// The World was replaced: its energy account starts again.
  void start_again() {
    if (built_for_ != 0) energy_ = {}, built_for_ = 0;
  }

  std::span<const Finding> findings() const { return found_.all(); }
  /// The energy account, which knows the bodies whose balance is not checked.
  const EnergyAccount& energy() const { return energy_; }

 private:
  /// An incident that is tolerated if rare: its fraction of the last second, and its sum over the
  /// run.
  struct Habit {
    Real part = 0, amount = 0;
  };
  /// Energy of the last second, J.
  struct Lately {
    Real removed = 0, kinetic = 0;
  };

  void compile(const World& world);
  void check_habits(const World& world, const StepReport& report, Real h);
  bool is_much_removed(const World& world, const StepReport& report, Real kept);

  EnergyAccount energy_;
  GapWatch gaps_;
  ContactWatch contacts_;
  TurnWatch turns_;
  FindingList found_;
  Lately energies_;
  Habit limited_, rescued_, unsolved_;
  Real uncertain_ = 0;            // s, of surfaces whose place of contact was uncertain
  std::size_t found_before_ = 0;  // findings at the end of the previous step
  std::uint64_t built_for_ = 0;
};

}  // namespace pantin::detail
