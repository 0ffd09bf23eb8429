#pragma once
/// Watches the steps of a World from outside the solvers and lists what makes the result doubtful.
#include <span>

#include "engine/runtime/energy_account.hpp"
#include "engine/runtime/finding_list.hpp"
#include "engine/runtime/watch_contacts.hpp"
#include "engine/runtime/watch_gaps.hpp"
#include "engine/runtime/watch_turns.hpp"
#include "engine/world/report.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// Each kind once for each body, joint or cable, in the order of time. Takes memory when the
/// structure changes, and for nothing else.
class Monitor {
 public:
  /// In each substep: see EnergyAccount.
  void begin_substep(const World& world);
  void note_start(const World& world, Real h);
  void end_substep(const World& world, Real h);
  /// At the end of a step of `h` seconds; counts what is new in the report.
  void end_step(const World& world, Real h, StepReport& report);
  /// Another World is in place: its energy is balanced from here on.
  void start_again() {
    if (built_for_ != 0) energy_ = {}, built_for_ = 0;
  }

  std::span<const Finding> findings() const { return found_.all(); }
  /// Bodies whose balance of energy is not asked for; see EnergyAccount.
  const EnergyAccount& energy() const { return energy_; }

 private:
  /// Something that may happen now and then: its part of the last second, and all that there was.
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
  std::size_t found_before_ = 0;  // findings at the end of the step before
  std::uint64_t built_for_ = 0;
};

}  // namespace pantin::detail
