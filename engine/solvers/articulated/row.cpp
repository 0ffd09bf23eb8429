// The articulated solver's row in the table of solvers.
#include <algorithm>

#include "engine/base/invariants.hpp"
#include "engine/joints/joint_force.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

void predict(World& world, const StepTask& task) {
  IslandVector& all = islands_of(world);
  const std::vector<std::uint32_t>& awake = rest_lists(world).awake;
  choose_steps(world, task);
  for_each_island(awake.size(), task, [&](std::size_t i) {
    Island& a = all[awake[i]];
    a.step > 0 ? update(world, a, a.step) : leave_out(world, a, task.h);
  });
}

/// Predicts islands that were compiled within the step.
void catch_up(World& world, const StepTask& task) {
  IslandVector& all = islands_of(world);
  for (const std::uint32_t i : rest_lists(world).awake) {
    Island& a = all[i];
    if (!a.scratch.predicted) a.step = task.h + a.owed, update(world, a, a.step);
  }
}

void adjust_all(World& world, const StepTask& task) {
  IslandVector& all = islands_of(world);
  const std::vector<std::uint32_t>& awake = rest_lists(world).awake;
  note_stepping(world, task);
  step_crowds(world, task);
  share_time(world, task);
  for_each_island(awake.size(), task, [&](std::size_t i) {
    Island& a = all[awake[i]];
    if (a.in_crowd) return;
    forget_result(a);
    if (!a.in_group && a.step > 0) adjust(world, a, a.step, a.lost);
  });
  note_stepped(world, task);
  step_contact_groups(world, task);
  note_end(world, task);
}

void list_turns(const World& world, TurnCounts& counts) {
  for (const Island& a : islands_of(world))
    for (std::size_t c = 0; c < a.joints.size(); ++c) {
      if (!counts_turns(a, c)) continue;
      const std::uint32_t link = world.links.slot_now(a.links[c]);
      if (link != kNoSlot)
        counts.push_back({world.links.owners()[link], Coordinate::angle, a.joint_memory[c].angle});
    }
}

bool sleeps(const World& world, std::size_t island) { return islands_of(world)[island].asleep; }

void list_awake(const World& world, std::vector<std::uint32_t>& slots) {
  each_awake(world, [&](const Island& a) {
    if (!a.asleep)
      slots.insert(slots.end(), a.slots.begin(), a.slots.begin() + std::ptrdiff_t(a.count()));
  });
}

const char* fault(const World& world) {
  for (const Island& a : islands_of(world)) {
    if (const char* why = a.unfit ? nullptr : settings_fault(a.settings)) return why;
    PANTIN_ASSERT(a.slots.size() % kLanes == 0 && a.slots.size() >= a.count());
    for (std::size_t c = 0; c < a.slots.size() && !a.unfit; ++c)  // padding too
      if (!is_mass(a.constants.at(kMass, c)) || !is_mass(a.constants.vec(kInertia, c)))
        return "contains a mass that is not positive and finite";
  }
  return nullptr;
}

void add_missed(const Missed& missed, StepReport& report) {
  report.unreached += missed.count;
  if (missed.worst > report.worst_residual)
    report.worst_residual = missed.worst, report.worst_residual_at = missed.at;
}

void measure_joint(const World& world, const Island& a, std::uint32_t slot, Measures& m) {
  PANTIN_ASSERT(slot < world.links.size());
  const Link& link = world.links.values()[slot];
  const Pose &pa = world.bodies[link.a].pose, &pb = world.bodies[link.b].pose;
  const Real gap = glm::length(residual(link.joint, pa, pb));
  if (gap > m.worst_gap) m.worst_gap = gap, m.worst_link = world.links.owners()[slot];
  m.worst_gap_rel = std::max(m.worst_gap_rel, gap / a.size);
  if (!info_of(link.joint.kind).uses_axes && !link.joint.limits.any()) return;
  const Quat rotation = relative_rotation(link.joint, pa.rotation, pb.rotation);
  m.worst_violation = std::max(m.worst_violation, violation(link.joint, rotation));
}

/// J: energy of the springs along the coordinates of joints.
Real energy_of_springs(const World& world, const Island& a) {
  Real sum = 0;
  for (std::size_t c = 0; c < a.joints.size(); ++c) {
    if (!a.joints[c].stiff || !is_actuated(a.joints[c]) || a.parents[c] == kFree) continue;
    sum += energy_of(dof_of(world, a, c).spring, angle_of(world, a, c));
  }
  return sum;
}

void measure(const World& world, Measures& m) {
  for (const Island& a : islands_of(world)) {
    m.elastic += energy_of_springs(world, a);
    for (const std::uint32_t link : a.links)
      if (link != kNoSlot) measure_joint(world, a, link, m);
    for (const PackedPin& p : a.pins)
      if (p.held_link != kNoSlot) measure_joint(world, a, p.held_link, m);
  }
}

/// What islands and groups gave up for the budget.
void report_costs(const World& world, StepReport& report) {
  each_awake(world, [&](const Island& a) {
    if (a.owed > 0 && report.left_out++ == 0) report.left_out_at = a.bodies.front();
    if (a.scratch.hurried && report.hurried++ == 0) report.hurried_at = a.bodies.front();
  });
  for (const GroupCost& c : world.memory.of<Islands>().groups.costs) {
    if (c.substeps >= c.planned) continue;
    ++report.shortened;
    const Real given_up = 1 - Real(c.substeps) / c.planned;
    if (given_up > report.given_up) report.given_up = given_up, report.shortened_at = c.body;
  }
}

void note_failure(const World& world, StepReport& report) {
  int limited = 0, jammed = 0;
  Real most = 0;
  each_awake(world, [&](const Island& a) {
    limited += a.energy_removed > 0, report.energy_removed += a.energy_removed;
    if (a.energy_removed > most) most = a.energy_removed, report.limited_at = a.bodies.front();
    if (a.jammed && jammed++ == 0) report.unsolved_at = a.bodies.front();
    if (a.grew && report.status == Status::ok)
      report.status = Status::energy_grew, report.body = a.bodies.back();
    if (!a.lost || report.status == Status::diverged) return;
    Measures gaps;
    measure(world, gaps);
    report.status = Status::diverged, report.body = a.lost, report.residual = gaps.worst_gap;
  });
  report.limited = std::max(report.limited, limited);
  report.unsolved = std::max(report.unsolved, jammed);
}

void report(const World& world, StepReport& report) {
  const auto add = [&](const Island& a) {
    report.sweeps_used = std::max(report.sweeps_used, a.sweeps_used);
    report.stops_hit += a.stops_hit, report.drives_capped += a.drives_capped;
  };
  each_awake(world, [&](const Island& a) {
    report.asleep += a.asleep, add(a);
    add_missed(a.missed, report);
  });
  const RestLists& rest = world.memory.of<Islands>().rest;
  report.asleep += static_cast<int>(rest.sleepers.size());
  for (const RestLists::Sleeper& s : rest.sleepers)
    if (s.slot == kNoSlot) {
      const Island& a = islands_of(world)[s.island];
      add(a), add_missed(missed_by(world, a), report);
    }
  report_costs(world, report);
}

}  // namespace

const SolverRow kRow{.name = "articulated",
                     .feels_contacts = true,
                     .compile = compile,
                     .recompile = recompile,
                     .list_turns = list_turns,
                     .prepare = prepare,
                     .wake_changed = wake_changed,
                     .predict = predict,
                     .catch_up = catch_up,
                     .fault = fault,
                     .asleep = all_asleep,
                     .sleeps = sleeps,
                     .list_awake = list_awake,
                     .find_reaches = find_reaches,
                     .take_contacts = take_contacts,
                     .adjust = adjust_all,
                     .note_failure = note_failure,
                     .report = report,
                     .measure = measure};

}  // namespace pantin::detail::articulated

namespace pantin {
std::span<const GroupCost> group_costs(const World& world) {
  return world.memory.of<detail::articulated::Islands>().groups.costs;
}
}  // namespace pantin

namespace pantin::detail {
template articulated::Islands& Memories::create();
template const articulated::Islands& Memories::none();
}  // namespace pantin::detail
