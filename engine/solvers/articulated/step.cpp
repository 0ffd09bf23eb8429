// The adjust stage of an island, and the end of its step.
#include <algorithm>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Clears the multipliers of joints, pins and cables, which are unknown after sweeps.
void forget_loads(Island& a) {
  for (std::size_t c = 0; c < a.count(); ++c) a.memory.set(kLambda, c, Vec3(0));
  for (JointMemory& j : a.joint_memory)
    std::fill(std::begin(j.lambdas), std::end(j.lambdas), 0), j.torque = Vec3(0);
  for (PackedPin& pin : a.pins) pin.lambda = Vec3(0);
  for (PackedCable& cable : a.cables) cable.lambda = 0;
}

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
void report_pins_and_cables(World& world, Island& a, Real h) {
  const Real to_force = 1 / (h * h);
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
  for (PackedCable& cord : a.cables) {
    Cable& cable = world.cables.values()[cord.cable];
    cable.tension = to_force * cord.lambda;
    cord.length_before = cable.joint.length, cord.rate_before = cable.joint.rate;
  }
}

}  // namespace

Missed missed_by(const World& world, const Island& a) {
  const Real bound = a.settings.tolerance * a.size;
  Missed missed;
  const auto note = [&](Real residual, Entity who) {
    missed.count += residual > bound;
    if (residual > missed.worst) missed.worst = residual, missed.at = who;
  };
  for (const PackedPin& h : a.pins) {
    if (h.compliance > 0) continue;
    PANTIN_ASSERT(h.held_pin != kNoSlot || h.held_link != kNoSlot);
    note(h.residual, h.held_pin != kNoSlot ? world.pins.owners()[h.held_pin]
                                           : world.links.owners()[h.held_link]);
  }
  for (const PackedCable& c : a.cables) {
    const Cable& s = world.cables.values()[c.cable];
    if (s.joint.compliance > 0) continue;
    note(stretch(s.joint, world.bodies[s.a].pose, world.bodies[s.b].pose),
         world.cables.owners()[c.cable]);
  }
  return missed;
}

void remember_step(World& world, Island& a, Real h) {
  if (has_rows(a) || a.trees.front().held_pin != UINT32_MAX) report_pins_and_cables(world, a, h);
  a.missed = missed_by(world, a);
  PANTIN_ASSERT(!a.asleep);
  for (std::size_t c = 0; a.changed && c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.restart = b.teleport = false;
  }
  count_turns(world, a);
  a.fresh = false;
  a.last_step = h, a.owed = 0;
}

bool close_by_sweeps(World& world, Island& a, Real h, Entity& lost) {
  a.knows_torques = false;
  a.sweeps_used = a.stops_hit = a.drives_capped = 0;
  if (!a.finite) {  // before closing the joints can hide it
    lost = a.unfit ? a.unfit : find_unsound(world, a);
    if (!lost) lost = find_lost(world, a);
    return false;
  }
  forget_loads(a);
  begin_watch(world, a);
  if (!close_joints(world, a, h)) {
    lost = find_lost(world, a);
    return false;
  }
  // With contacts the correction could cause penetration, and contacts change the angular momentum.
  if (a.scratch.contact_rows.empty())
    repair_momentum(world, a, h);
  else
    for (Tree& t : a.trees) t.knows_angular_momentum = false;
  end_watch(world, a, h);
  remember_step(world, a, h);
  return true;
}

bool adjust(World& world, Island& a, Real h, Entity& lost) {
  PANTIN_ASSERT(a.scratch.predicted && !a.in_group && !a.asleep);
  if (a.conserves && a.finite) return step_conserving(world, a, h, lost);
  if (a.swept_steps > 0) --a.swept_steps;
  return close_by_sweeps(world, a, h, lost);
}

}  // namespace pantin::detail::articulated
