// The energy limiter: removes energy added by numerical errors.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr Real kKineticRounding = 1e-13;  // of the kinetic energy

/// Work done on the island at its anchors, J.
Real work_of_anchors(const World& world, const Island& a, const EndSums& end, Real h) {
  const Real to_force = 1 / (a.force_share * h * h);
  Vec3 other_impulses(0);  // N s, of all anchors except a single root
  Real work = 0;
  for (const PackedPin& pin : a.pins) {
    if (pin.partner != UINT32_MAX) continue;
    const Vec3 moved = pin.target - pin.target_before;
    work += pin.compliance > 0 ? spring_exchange(a, pin, h).work
                               : to_force * glm::dot(pin.lambda, moved);
    other_impulses += to_force * h * pin.lambda;
  }
  for (const PackedCable& cord : a.cables) {
    if (cord.column_a != UINT32_MAX && cord.column_b != UINT32_MAX) continue;
    if (cord.lambda == 0) continue;
    const Cable& s = world.cables.values()[cord.cable];
    const bool a_moves = cord.column_a != UINT32_MAX;  // end a belongs to the island
    const std::uint32_t slot = a_moves ? cord.slot_b : cord.slot_a;
    const Vec3 held = point_on(world, slot, a_moves ? s.joint.anchor_b : s.joint.anchor_a);
    const Vec3 free = a_moves ? point_at(a, cord.column_a, s.joint.anchor_a, kFinalPoses)
                              : point_at(a, cord.column_b, s.joint.anchor_b, kFinalPoses);
    const Real span = glm::length(held - free);
    if (!(span > 0)) continue;
    const Vec3 force = to_force * cord.lambda / span * (held - free);
    const Vec3 held_before =
        point_before(world, slot, a_moves ? s.joint.anchor_b : s.joint.anchor_a, h);
    work += glm::dot(force, held - held_before);
    other_impulses += h * force;
  }
  int held_trees = 0;
  for (const Tree& t : a.trees) held_trees += a.parents[t.first] == kHeld;
  for (const Tree& t : a.trees) {
    const Vec3 moved = t.target - t.target_before;
    if (a.parents[t.first] != kHeld || moved == Vec3(0)) continue;
    if (held_trees > 1) {  // several anchored trees: the momentum balance does not separate them,
                           // so the multipliers are used
      work += to_force * glm::dot(a.memory.vec(kLambda, t.first), moved);
      continue;
    }
    Vec3 impulse = Vec3(end.momentum[0], end.momentum[1], end.momentum[2]) - a.momentum_before;
    for (std::size_t c = 0; c < a.count(); ++c) {
      const Real mass = a.constants.at(kMass, c);
      impulse -= h * mass * a.constants.at(kGravityScale, c) * world.gravity;
      if (a.forced) impulse -= h * mass * a.scratch.forces.vec(0, c);
      // Momentum lost to drag was supplied by the anchor.
      impulse += a.constants.at(kDrag, c) * mass * a.memory.vec(kLastTranslation, c);
    }
    work += glm::dot(impulse - other_impulses, moved) / h;
  }
  return work;
}

/// Whether any anchor of the island moves in this step.
bool is_driven(const World& world, const Island& a) {
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kHeld && t.target != t.target_before) return true;
  for (const PackedPin& h : a.pins)
    if (h.partner == UINT32_MAX && h.target != h.target_before) return true;
  if (!a.scratch.contact_rows.empty()) return true;  // a contact may do work
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    if (is_driven(world, a, c)) return true;
  for (const PackedCable& c : a.cables) {
    if (c.column_a != UINT32_MAX && c.column_b != UINT32_MAX) continue;
    const Body& holder = world.bodies.values()[c.column_a != UINT32_MAX ? c.slot_b : c.slot_a];
    if (holder.velocity != Vec3(0) || holder.angular_velocity != Vec3(0)) return true;
  }
  return false;
}

/// Whether the island is free: no connection to the world.
bool flies_free(const Island& a) {
  if (a.contact_active || !a.scratch.contact_rows.empty()) return false;
  for (const Tree& t : a.trees)
    if (a.parents[t.first] != kFree) return false;
  for (const PackedCable& c : a.cables)
    if (c.column_a == UINT32_MAX || c.column_b == UINT32_MAX) return false;
  return a.pins.empty();
}

/// Scales the velocities so that the energy is at most `allowed`. A free island keeps the motion of
/// its mass centre. Returns the remaining energy, J.
Real slow_down(Island& a, const IslandView& p, const EndSums& end, Real allowed) {
  const bool free = flies_free(a);
  Real mass = 0;
  for (std::size_t c = 0; c < a.count(); ++c) mass += a.constants.at(kMass, c);
  const Vec3 momentum(end.momentum[0], end.momentum[1], end.momentum[2]);
  const Vec3 mean = free ? momentum / mass : Vec3(0);
  const Real whole = free ? 0.5 * mass * glm::dot(mean, mean) : 0;
  const Real rest = end.kinetic - whole, within = rest > kKineticRounding * end.kinetic ? rest : 0;
  const Real left = std::max(Real(0), allowed - end.potential - whole);
  const Real factor = within > 0 ? std::sqrt(std::min(Real(1), left / within)) : 1;
  if (factor == 1) return end.potential + end.kinetic;
  kernels().scale(p, factor, &mean[0]);
  for (Tree& t : a.trees) t.angular_momentum *= factor;
  return end.potential + whole + factor * factor * within;
}

/// Potential energy at the final poses, elastic energy included, J.
Real potential_of_final(const World& world, const Island& a) {
  Real sum = elastic_energy_of_final(world, a);
  for (std::size_t c = 0; c < a.count(); ++c)
    sum -= a.constants.at(kMass, c) * a.constants.at(kGravityScale, c) *
           glm::dot(world.gravity, a.scratch.work.vec(kFinalPosition, c));
  return sum;
}

/// A step whose potential energy exceeds the total energy is undone to a half, to a quarter or
/// completely; there the bodies are at rest with closed joints. The lambdas are kept and stiffen
/// the next step.
void take_back(World& world, Island& a, const IslandView& p, Real allowed) {
  const Kernels& k = kernels();
  LaneTable& w = a.scratch.work;
  PANTIN_ASSERT(a.scratch.targets.size() == 3 * a.trees.size());
  for (Real back : {0.5, 0.75, 1.0}) {
    for (std::size_t c = 0; c < a.count(); ++c) {
      const Pose& pose = world.bodies.values()[a.slots[c]].pose;
      const Quat rotation = from_rotation_vector(-back * a.memory.vec(kLastRotation, c));
      w.set(kPosition, c, pose.position - back * a.memory.vec(kLastTranslation, c));
      w.set(kRotation, c, glm::normalize(rotation * pose.rotation));
    }
    k.levers(p, kPosition, kRotation);
    k.sweep(p, a.scratch.targets.data(), kPosition, a.settings.rotation_stiffness);
    k.apply_poses(p, kRotation);
    if (!a.joints.empty()) sweep_closed(world, a);
    if (!a.pins.empty() || !a.cables.empty()) relax(world, a, Relaxed::pins_and_cables);
    if (potential_of_final(world, a) <= allowed) break;
  }
  for (std::size_t c = 0; c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.pose = {w.vec(kFinalPosition, c), w.quat(kFinalRotation, c)};
    b.velocity = b.angular_velocity = Vec3(0);
  }
}

}  // namespace

void limit_energy(World& world, Island& a, const EndSums& sums, Real h) {
  // When the anchors stop, the reserve is cleared: a stationary anchor does no work.
  const bool driven = is_driven(world, a);
  if (a.driven && !driven) a.reserve = 0;
  a.driven = driven;

  EndSums end = sums;
  end.potential += elastic_energy(world, a);
  Real allowed = a.energy_before + a.reserve - a.damped + end.work + a.supplied_work +
                 work_of_anchors(world, a, end, h);
  for (const PackedPin& pin : a.pins)
    if (pin.compliance > 0) allowed -= spring_exchange(a, pin, h).lost;
  const Real slack = 1e-3 * a.kinetic_before + 1e-12 * std::abs(end.potential);
  Real energy = end.kinetic + end.potential;
  a.limited = a.settings.limiter && energy > allowed + slack;
  if (a.limited) {
    const IslandView p = view_of(world, a);
    const Real before = energy;
    energy = slow_down(a, p, end, allowed);
    // What a free island has only by the motion of its mass centre stays with it.
    a.limited = energy < before;
    // Contacts may lift the island slightly more than accounted for.
    const Real lift = a.contact_active ? 0.01 * a.mass * glm::length(world.gravity) * a.size : 0;
    // A step with contacts that found far more kinetic energy than available has diverged.
    const Real may_have = a.kinetic_before + std::max(Real(0), allowed - a.energy_before) +
                          0.1 * a.mass * glm::length(world.gravity) * a.size;
    const bool wild = !a.scratch.contact_rows.empty() && end.kinetic > 4 * may_have;
    if (wild) take_back(world, a, p, -1e300);
    const bool lifted = !wild && !flies_free(a) && end.potential > allowed + slack + lift;
    if (lifted) take_back(world, a, p, allowed);
    if (wild || lifted) energy = potential_of_final(world, a);
    a.energy_removed += std::max(Real(0), before - energy);
  }
  const Real lent = std::max(Real(0), allowed - energy);
  a.reserve = a.limited || a.disturbed ? 0 : lent * std::exp(-h / a.settings.reservoir_time);
}

}  // namespace pantin::detail::articulated
