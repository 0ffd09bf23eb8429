#pragma once
/// Watches the steps of a World from outside the solvers and lists what makes the result doubtful.
#include <span>
#include <vector>

#include "engine/runtime/energy_account.hpp"
#include "engine/world/findings.hpp"
#include "engine/world/report.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {

/// Each kind once for each body, joint or cable, in the order of time. Takes memory when the
/// structure changes, and for nothing else.
class Monitor {
 public:
  /// In each substep: see EnergyAccount.
  void begin_substep(const World& world) { energy_.begin_substep(world); }
  void note_start(const World& world) { energy_.note_start(world); }
  void end_substep(const World& world, Real h) { energy_.end_substep(world, h); }
  /// Another World is in place: its energy is balanced from here on.
  void start_again() { energy_ = {}, built_for_ = 0; }
  /// At the end of the step; counts what is new in the report.
  void end_step(const World& world, StepReport& report);

  std::span<const Finding> findings() const { return findings_; }
  /// Bodies whose balance of energy is not asked for; see EnergyAccount.
  const EnergyAccount& energy() const { return energy_; }

 private:
  static constexpr std::size_t kMost = 256;

  void find_sizes(const World& world);
  void check_joints(const World& world);
  void note(FindingKind kind, Entity where, Real amount);

  EnergyAccount energy_;
  std::vector<Finding> findings_;
  Real time_ = 0;
  std::uint64_t built_for_ = 0;
  std::vector<Real> sizes_;  // m, of the mechanism that each body is part of
};

}  // namespace pantin::detail
