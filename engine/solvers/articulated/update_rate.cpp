// A step of islands without contacts that ends within its budget. First impacts and losses of
// energy stop dividing steps, as soon as there is time for one substep of each island only. Where
// that is not enough, islands are left out. One without colliders can wait: the energy-momentum
// method is stable at any step, so it later takes one step for all the time. Games know this as
// update rate optimisation.
#include <algorithm>
#include <utility>

#include "engine/base/check.hpp"
#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

/// Most steps in a row that an island is left out of.
constexpr int kMostLeftOut = 3;
/// Part of a cost that is still expected a step later: steps in which strings become taut take
/// several times as long as those between them.
constexpr Real kRemembered = 0.95;

Clock::duration duration_of(Real seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<Real>(seconds));
}
Real seconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<Real>(to - from).count();
}

/// Whether the caller changed a body, or a force acts on it.
bool is_disturbed(const World& world, const Island& a, std::size_t c) {
  const Body& b = world.bodies.values()[a.slots[c]];
  if (b.restart || b.teleport) return true;
  const Force* f = world.forces.empty() ? nullptr : world.forces.find(a.bodies[c]);
  return f && (f->force != Vec3(0) || f->torque != Vec3(0));
}

/// Whether an island may be left out: nothing collides with it, and what moves it are anchors whose
/// points at its last step are known. Cables become taut in long steps so often that these take
/// more time than the short ones that they replace.
bool can_wait(const World& world, const Island& a, Real h) {
  if (a.settings.solver != Solver::articulated || a.fresh || a.unfit || !a.rests.empty() ||
      !a.cables.empty() || a.owed > (kMostLeftOut - 0.5) * h)
    return false;
  for (std::size_t c = 0; c < a.count(); ++c)
    if (is_disturbed(world, a, c)) return false;
  const auto body = [&](std::uint32_t slot) { return &world.bodies.values()[slot]; };
  for (const Tree& t : a.trees) {
    if (t.held_body == kNoSlot) continue;
    const Body& held = *body(t.held_body);
    if (held.teleport || (held.motion == Motion::kinematic && !a.joints.empty())) return false;
  }
  for (const PackedPin& p : a.pins)
    if (p.held_body != kNoSlot && body(p.held_body)->teleport) return false;
  return true;
}

}  // namespace

// Joints that constrain rotations cost severalfold (see README.md).
Real weight_of(const Island& a) {
  return static_cast<Real>((a.joints.empty() ? 1 : 4) * a.count() + 2 * tie_count(a));
}

void fit_into(Real time, Real least, UpdateRates& r) {
  std::sort(r.candidates.begin(), r.candidates.end(),
            [](const UpdateRates::Candidate& a, const UpdateRates::Candidate& b) {
              return a.urgency != b.urgency ? a.urgency > b.urgency : a.island < b.island;
            });
  for (UpdateRates::Candidate& c : r.candidates) {
    time -= r.cost * c.weight, least -= c.weight;
    c.waits = time < 0 && least < 0;
    if (c.waits) r.weight -= c.weight;
  }
}

void choose_steps(World& world, const StepTask& task) {
  Islands& all = world.memory.of<Islands>();
  UpdateRates& r = all.rates;
  const std::vector<std::uint32_t>& awake = rest_lists(world).awake;
  for (const std::uint32_t i : awake) all.list[i].step = task.h + all.list[i].owed;
  if (!task.budget) return;
  const auto& importance = task.budget->importance;
  r.began = Clock::now();
  r.candidates.clear(), r.candidates.reserve(all.list.size());
  r.weight = 0;
  Real must = 0;
  for (const std::uint32_t i : awake) {
    const Island& a = all.list[i];
    if (a.in_group) continue;  // most likely again
    const Real weight = weight_of(a);
    r.weight += weight;
    if (!can_wait(world, a, task.h)) {
      must += weight;
      continue;
    }
    const Real matters =
        importance && *importance ? std::max(Real(0), (*importance)(a.bodies.front())) : 1;
    r.candidates.push_back({matters * a.step, weight, i, false});
  }
  const Real whole = r.cost * r.weight, time = seconds(r.began, task.budget->until);
  const bool fits = whole + r.others <= time;
  // Else their part of the time is that of their cost.
  const Real own = fits ? time - r.others : time * (whole > 0 ? whole / (whole + r.others) : 1);
  r.until = r.began + duration_of(own);
  if (fits) return;
  // At least as many step as lets them take turns, else all that waited would be due in the same
  // step.
  fit_into(own - r.cost * must, r.weight / (kMostLeftOut + 1) - must, r);
  for (const UpdateRates::Candidate& c : r.candidates)
    if (c.waits) all.list[c.island].step = 0;
}

void leave_out(World& world, Island& a, Real h) {
  PANTIN_ASSERT(a.step == 0 && a.rests.empty());
  a.owed += h;
  a.scratch.predicted = true, a.conserves = a.forced = false;
  forget_result(a);
  predict_still(world, a);
}

bool is_late(const UpdateRates& r, Real weight) {
  return seconds(Clock::now(), r.until) < r.cost * weight;
}

void share_time(World& world, const StepTask& task) {
  Islands& all = world.memory.of<Islands>();
  if (!task.budget && !std::exchange(all.rates.is_shared, false)) return;
  all.rates.is_shared = task.budget != nullptr;
  const std::vector<std::uint32_t>& awake = rest_lists(world).awake;
  Real left = 0;  // s, of this one and those after it
  for (auto i = awake.rbegin(); i != awake.rend(); ++i) {
    Island& a = all.list[*i];
    a.scratch.hurries_from = Clock::time_point::max();
    if (!task.budget || a.in_crowd || a.in_group || a.step == 0) continue;
    left += all.rates.cost * weight_of(a);
    a.scratch.hurries_from = all.rates.until - duration_of(left);
  }
}

void note_stepping(World& world, const StepTask& task) {
  if (task.budget) world.memory.of<Islands>().rates.stepping = Clock::now();
}

void note_stepped(World& world, const StepTask& task) {
  if (!task.budget) return;
  Islands& all = world.memory.of<Islands>();
  UpdateRates& r = all.rates;
  r.stepped = Clock::now();
  Real tried = 0;
  for (const std::uint32_t i : rest_lists(world).awake) {
    Island& a = all.list[i];
    if (!a.in_group && a.step > 0) tried += weight_of(a) * std::exchange(a.scratch.attempts, 1);
  }
  if (tried > 0) r.cost = std::max(kRemembered * r.cost, seconds(r.stepping, r.stepped) / tried);
}

void note_end(World& world, const StepTask& task) {
  if (!task.budget) return;
  Islands& all = world.memory.of<Islands>();
  UpdateRates& r = all.rates;
  Real taken = 0, planned = 0;
  for (const GroupCost& c : all.groups.costs) taken += c.substeps, planned += c.planned;
  const Real groups = seconds(r.stepped, Clock::now()) * (taken > 0 ? planned / taken : 1);
  r.others = seconds(r.began, r.stepping) + groups;
}

}  // namespace pantin::detail::articulated
