#include "engine/runtime/monitor.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/world/partition.hpp"

namespace pantin::detail {
namespace {

/// Time constant of the average, s, and the fraction of time above which an incident counts as
/// frequent.
constexpr Real kLately = 1, kOften = 0.05;
/// Tolerated loss to the energy limiter in a second, as a fraction of the kinetic energy.
constexpr Real kLittle = 0.25;
/// Tolerances: a fraction of the greatest energy so far, and a fraction of a body's radius of
/// gyration. A lift by that distance, or a motion by it in a second, is negligible.
constexpr Real kTrifle = 1e-3, kLift = 0.03;

FindingKind kind_of(EnergyAccount::Change::Kind kind) {
  switch (kind) {
    case EnergyAccount::Change::Kind::gain:
      return FindingKind::energy_gained;
    case EnergyAccount::Change::Kind::loss:
      return FindingKind::energy_lost;
    case EnergyAccount::Change::Kind::spin:
      return FindingKind::angular_momentum_changed;
    case EnergyAccount::Change::Kind::flight:
      return FindingKind::flung;
  }
  return FindingKind::energy_gained;
}

}  // namespace

void Monitor::compile(const World& world) {
  found_.open();
  gaps_.compile(world), contacts_.compile(world), turns_.compile(world);
  built_for_ = world.structure();
}

void Monitor::begin_substep(const World& world) {
  energy_.begin_substep(world);
  if (built_for_ == world.structure()) contacts_.begin_substep(world);
}

void Monitor::note_start(const World& world, Real h) {
  if (built_for_ != world.structure()) compile(world), contacts_.begin_substep(world);
  energy_.note_start(world, h), contacts_.note_start(world);
}

/// Changes made within the substep are monitored from the next one on.
void Monitor::end_substep(const World& world, Real h) {
  energy_.end_substep(world, h);
  if (built_for_ != world.structure()) return;
  found_.set_time(world.time + h);
  turns_.end_substep(world, h, energy_.stores(), found_);
  contacts_.end_substep(world, h, found_);
}

/// Whether the loss is significant for the island from which the limiter removed most.
bool Monitor::is_much_removed(const World& world, const StepReport& report, Real kept) {
  energies_.removed = kept * energies_.removed + report.energy_removed, energies_.kinetic *= kept;
  if (!(report.energy_removed > 0)) return false;
  const std::vector<std::uint32_t>& islands = partition_of(world).island;
  const std::uint32_t slot = world.bodies.slot(report.limited_at);
  const Real g = glm::length(world.gravity);
  Real kinetic = report.energy_removed, slack = 0;
  for (std::uint32_t i = 0; i < islands.size() && i < world.bodies.size(); ++i)
    if (const Body& b = world.bodies.values()[i];
        slot < islands.size() && islands[i] == islands[slot]) {
      kinetic += kinetic_energy(b);
      const Real lift = kLift * radius_of_gyration(b.inertia, b.mass);
      slack += b.mass * lift * (g + lift);
    }
  energies_.kinetic = std::max(energies_.kinetic, kinetic);
  slack += kTrifle * energy_.greatest_of(slot);
  return energies_.removed > slack + kLittle * energies_.kinetic;
}

/// Updates the exponentially weighted fraction of time of each incident, and notes the frequent
/// ones.
void Monitor::check_habits(const World& world, const StepReport& report, Real h) {
  const Real kept = std::exp(-h / kLately);
  const bool is_much = is_much_removed(world, report, kept);
  const auto check = [&](Habit& habit, FindingKind kind, Entity where, Real amount) {
    habit.part = kept * habit.part + (amount > 0 ? 1 - kept : 0), habit.amount += amount;
    if (habit.part > kOften && amount > 0 && (is_much || kind != FindingKind::energy_limited))
      found_.note(kind, where, habit.amount);
  };
  check(limited_, FindingKind::energy_limited, report.limited_at, report.energy_removed);
  check(rescued_, FindingKind::step_rescued, report.rescued_at, report.rescued > 0 ? h : 0);
  check(unsolved_, FindingKind::contacts_unsolved, report.unsolved_at, report.unsolved > 0 ? h : 0);
  if (report.uncertain > 0)
    found_.note(FindingKind::place_uncertain, report.uncertain_at, uncertain_ += h);
}

void Monitor::end_step(const World& world, Real h, StepReport& report) {
  found_.set_time(world.time);
  if (built_for_ != world.structure()) compile(world);  // no substep has begun yet
  energy_.each_change(world, [&](const EnergyAccount::Change& change) {
    found_.note(kind_of(change.kind), change.body, change.amount);
  });
  gaps_.end_step(world, h, found_);
  contacts_.end_step(world, h, found_);
  check_habits(world, report, h);
  report.findings = static_cast<int>(found_.all().size() - found_before_);
  found_before_ = found_.all().size();
  found_.end_step();
}

}  // namespace pantin::detail
