// The quasi-static solver's row in the table of solvers.
#include <algorithm>
#include <cmath>

#include "engine/solvers/quasistatic/island.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::quasistatic {
namespace {

void predict(World& world, const StepTask& task) {
  std::vector<Island>& all = islands_of(world);
  for_each_island(all.size(), task, [&](std::size_t i) { step(world, all[i], task.h); });
}

/// What is wrong with a saved World that was read, or null.
const char* fault(const World& world) {
  for (const Island& m : islands_of(world)) {
    if (m.unfit) continue;
    const Lamina& lamina = *laminas_of(world)->find(m.body);
    if (m.motion.touches.count > modes::kMostContacts)
      return "contains more contacts than a lamina can have";
    for (const modes::Touch& t : m.motion.touches)
      if (t.finger >= lamina.fingers.size() || t.feature >= lamina.outline.size())
        return "contains a contact of a finger or an edge that does not exist";
    for (const planar::PlaneContact& t : m.touches)
      if (std::max(t.a, t.b) > lamina.fingers.size())
        return "contains a contact of a body that does not exist";
    if (!std::isfinite(m.turned) || !(m.calm >= 0))
      return "contains a number that is not finite or below 0";
  }
  return nullptr;
}

/// A moving lamina shows by its velocity, as other bodies without contact resolution.
bool asleep(const World&) { return true; }

/// Laminas are obstacles, already at the end of the step.
void find_starts(const World& world, std::vector<contact::StartPose>& out) {
  for (const Island& m : islands_of(world)) {
    const Collision* collision = world.collisions.find(m.body);
    if (m.scratch.stepped && collision && !collision->sensor)
      out.push_back({m.slot, m.scratch.start});
  }
}

void note_failure(const World& world, StepReport& report) {
  for (const Island& m : islands_of(world)) {
    if (m.lost && report.status != Status::diverged)
      report.status = Status::diverged, report.body = m.body;
    report.mode_switches += m.scratch.switches;
    if (!m.scratch.changed || report.lamina) continue;
    report.lamina = m.body;
    report.changed = m.phase == Phase::dynamics ? word_for(m.why) : "";
  }
}

void report(const World& world, StepReport& report) {
  for (const Island& m : islands_of(world)) {
    report.handed_over += m.phase == Phase::dynamics;
    report.contacts +=
        static_cast<int>(m.phase == Phase::modes ? m.motion.touches.count : m.touches.size());
  }
}

}  // namespace

const SolverRow kRow{.name = "quasistatic",
                     .compile = compile,
                     .prepare = prepare,
                     .predict = predict,
                     .fault = fault,
                     .asleep = asleep,
                     .find_starts = find_starts,
                     .note_failure = note_failure,
                     .report = report};

}  // namespace pantin::detail::quasistatic

namespace pantin::detail {
template quasistatic::Islands& Memories::create();
template const quasistatic::Islands& Memories::none();
}  // namespace pantin::detail
