// The adjust stage of an island, and how it ends.
#include <algorithm>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// The first body whose state or final position is not finite or out of bounds.
Entity find_lost(const World& world, const Island& a) {
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    if (!(is_finite(b.pose) && is_finite(b.velocity) && is_finite(b.angular_velocity)))
      return a.bodies[c];
    const Vec3 x = a.scratch.work.vec(kAttach, c);
    if (!(glm::dot(x, x) < kTooFar * kTooFar) ||
        !is_finite(a.scratch.work.quat(kAppliedRotation, c)))
      return a.bodies[c];
  }
  return a.bodies.front();
}

/// Writes residuals and tensions back to pins and cables.
void report_holds(World& world, Island& a, Real h) {
  const Real to_force = 1 / (a.force_share * h * h);
  for (PackedPin& constraint : a.pins) {
    const Vec3 at = point_on(world, a.slots[constraint.column], constraint.anchor);
    PANTIN_ASSERT(constraint.column < a.count() && is_index_or_none(constraint.partner, a.count()));
    const Vec3 to = constraint.partner == UINT32_MAX
                        ? constraint.target
                        : point_on(world, a.slots[constraint.partner], constraint.held_anchor);
    constraint.gap_before = to - at;
    constraint.residual = glm::length(constraint.gap_before);
    if (constraint.held_pin == UINT32_MAX) continue;
    Pin& pin = world.pins.values()[constraint.held_pin];
    pin.residual = constraint.residual, pin.reachable = constraint.reachable;
    pin.missed = pin.kind == PinKind::exact && pin.residual > a.settings.tolerance * a.size;
  }
  for (const Tree& t : a.trees) {
    if (t.held_pin == UINT32_MAX) continue;
    Pin& pin = world.pins.values()[t.held_pin];
    const Vec3 at = point_on(world, a.slots[t.first], pin.anchor);
    PANTIN_ASSERT(a.parents[t.first] == kHeld);
    pin.residual = glm::length(t.target - at), pin.reachable = true;
    pin.missed = pin.residual > a.settings.tolerance * a.size;
  }
  for (const PackedCable& cord : a.cables)
    world.cables.values()[cord.cable].tension = to_force * cord.lambda;
}

/// Kinetic and potential energy and momentum of the bodies.
void sum_up(const World& world, const Island& a, EndSums& end) {
  end.kinetic = end.potential = 0;
  Vec3 momentum(0);
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    momentum += b.mass * b.velocity;
    const Vec3 w = glm::conjugate(b.pose.rotation) * b.angular_velocity;
    end.kinetic += 0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(b.inertia, w * w));
    end.potential -= b.mass * b.gravity_scale * glm::dot(world.gravity, b.pose.position);
  }
  for (int n = 0; n < 3; ++n) end.momentum[n] = momentum[n];
}

/// The momentum of free trees. Not in contact: the correction could cause penetration, and contacts
/// change the angular momentum.
void keep_momentum(World& world, Island& a, Real h, EndSums& end) {
  if (!a.scratch.contact_rows.empty())
    for (Tree& t : a.trees) t.knows_angular_momentum = false;
  else if (repair_momentum(world, a, h))
    sum_up(world, a, end);
}

}  // namespace

void remember_step(World& world, Island& a, Real h) {
  const bool calm = !a.limited && !a.disturbed;
  a.calm_steps = calm ? std::min(a.calm_steps + 1, 1000) : 0;
  if (has_rows(a) || a.trees.front().held_pin != UINT32_MAX) report_holds(world, a, h);
  PANTIN_ASSERT(!a.asleep);
  for (std::size_t c = 0; a.changed && c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.restart = b.teleport = false;
  }
  count_turns(world, a);
  a.fresh = false;
  a.last_step = h;
  update_sleep(world, a, h);
}

bool finish_step(World& world, Island& a, Real h, Entity& lost) {
  PANTIN_ASSERT(a.scratch.predicted);
  a.knows_torques = false;
  if (!a.finite) {  // before joints can hide it
    lost = a.unfit ? a.unfit : find_unsound(world, a);
    if (!lost) lost = find_lost(world, a);
    return false;
  }
  EndSums end = close_joints(world, a, h);
  if (!end.sane) {
    lost = find_lost(world, a);
    return false;
  }
  keep_momentum(world, a, h, end);
  if (!a.scratch.contact_rows.empty()) a.supplied_work += finish_contacts(world, a, h);
  if (end.changed_rule) scale_to_momentum(world, a, end, h);
  const Real calm_angle = a.settings.calm_angle;
  a.disturbed = a.disturbed || !(end.largest_rotation2 < calm_angle * calm_angle);
  if (a.settings.solver == Solver::articulated)
    limit_energy(world, a, end, h);
  else
    end_watch(world, a, h);
  remember_step(world, a, h);
  return true;
}

namespace {

/// Substeps of a step that does not converge.
constexpr int kSubsteps = 4;

/// Repeats the step in equal substeps, for rotations too large for one step.
bool adjust_in_substeps(World& world, Island& a, Real h, Entity& lost) {
  for (const ContactRow& t : a.scratch.contact_rows)
    if (t.side > 0) contacts_of(world)[t.contact].lambda = contacts_of(world)[t.contact].before;
  int passes = a.active_set_iterations_used;
  bool sound = true;
  PANTIN_ASSERT(a.substeps_left == 0);
  std::vector<Vec3>& targets = a.scratch.step_targets;
  targets.clear();
  for (const Tree& t : a.trees) targets.push_back(t.target_before), targets.push_back(t.target);
  std::vector<Vec3>& forces = a.scratch.mean_forces;
  forces.assign(a.scratch.contact_rows.size(), Vec3(0));
  for (int part = 1; part <= kSubsteps && sound; ++part) {
    a.substeps_left = kSubsteps - part;
    update(world, a, h / kSubsteps);
    for (std::size_t t = 0; t < a.trees.size(); ++t) {
      const Vec3 whole = targets[2 * t + 1] - targets[2 * t];
      PANTIN_ASSERT(a.scratch.targets.size() == 3 * a.trees.size());
      a.trees[t].target = targets[2 * t] + Real(part) / kSubsteps * whole;
      a.trees[t].target_before = a.trees[t].target - whole / Real(kSubsteps);
      for (std::size_t n = 0; n < 3; ++n)
        a.scratch.targets[3 * t + n] = a.trees[t].target[static_cast<int>(n)];
    }
    begin_step(world, a, h / kSubsteps);
    find_active_set(world, a, h / kSubsteps, StepLength::substep);
    passes += a.active_set_iterations_used;
    sound = finish_step(world, a, h / kSubsteps, lost);
    PANTIN_ASSERT(forces.size() == a.scratch.contact_rows.size());
    for (std::size_t i = 0; i < forces.size(); ++i)
      forces[i] += contacts_of(world)[a.scratch.contact_rows[i].contact].force / Real(kSubsteps);
  }
  for (std::size_t i = 0; i < forces.size(); ++i)
    if (a.scratch.contact_rows[i].side > 0)
      contacts_of(world)[a.scratch.contact_rows[i].contact].force = forces[i];
  a.active_set_iterations_used = passes, a.substeps_left = 0;
  return sound;
}

}  // namespace

bool adjust(World& world, Island& a, Real h, Entity& lost) {
  PANTIN_ASSERT(a.scratch.predicted && (!a.in_group || a.asleep));
  if (a.asleep) {
    keep_sleeping_contacts(world, a, h);
    return true;
  }
  if (conserves(world, a)) return step_conserving(world, a, h, lost);
  if (a.projected_steps > 0) --a.projected_steps;
  begin_step(world, a, h);
  const bool converged = find_active_set(world, a, h, StepLength::whole);
  if (!converged && !a.scratch.contact_rows.empty() && a.settings.active_set_iterations > 2)
    return adjust_in_substeps(world, a, h, lost);
  return finish_step(world, a, h, lost);
}

}  // namespace pantin::detail::articulated
