// The energy limiter: what numerical errors add is taken away again.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::articulated {
namespace {

/// Work done on the articulation through the places that hold it, J.
Real work_of_holders(const World& world, const Island& a, const EndSums& end, Real h) {
  const Real to_force = 1 / (a.force_share * h * h);
  Vec3 other_impulses(0);  // N s, of all but a single held root
  Real work = 0;
  for (const Hold& hold : a.holds) {
    if (hold.partner != UINT32_MAX) continue;
    work += to_force * glm::dot(hold.load, hold.target - hold.target_before);
    other_impulses += to_force * h * hold.load;
  }
  for (const Cord& cord : a.cords) {
    if (cord.column_a != UINT32_MAX && cord.column_b != UINT32_MAX) continue;
    if (cord.load == 0) continue;
    const String& s = world.strings.values()[cord.string];
    const bool a_moves = cord.column_a != UINT32_MAX;  // a is the packed end
    const std::uint32_t slot = a_moves ? cord.slot_b : cord.slot_a;
    const Vec3 held = point_on(world, slot, a_moves ? s.joint.anchor_b : s.joint.anchor_a);
    const Vec3 free =
        a_moves ? point_at(a, cord.column_a, s.joint.anchor_a, kFinalPosition, kFinalRotation)
                : point_at(a, cord.column_b, s.joint.anchor_b, kFinalPosition, kFinalRotation);
    const Real span = glm::length(held - free);
    if (!(span > 0)) continue;
    const Vec3 force = to_force * cord.load / span * (held - free);
    const Body& holder = world.bodies.values()[slot];
    const Vec3 velocity = holder.velocity + glm::cross(holder.spin, held - holder.pose.position);
    work += h * glm::dot(force, velocity);
    other_impulses += h * force;
  }
  int held_trees = 0;
  for (const Tree& t : a.trees) held_trees += a.parents[t.first] == kHeld;
  for (const Tree& t : a.trees) {
    const Vec3 moved = t.target - t.target_before;
    if (a.parents[t.first] != kHeld || moved == Vec3(0)) continue;
    if (held_trees >
        1) {  // the balance of one cannot be told from the others': take the multipliers
      work += to_force * glm::dot(a.memory.vec(kLoad, t.first), moved);
      continue;
    }
    Vec3 impulse = Vec3(end.momentum[0], end.momentum[1], end.momentum[2]) - a.momentum_before;
    for (std::size_t c = 0; c < a.count(); ++c) {
      const Real mass = a.constants.at(kMass, c);
      impulse -= h * mass * a.constants.at(kGravityScale, c) * world.gravity;
      if (a.forced) impulse -= h * mass * a.room.forces.vec(0, c);
      // What the drag took from the momentum, the holder gave.
      impulse += a.constants.at(kDrag, c) * mass * a.memory.vec(kLastSlide, c);
    }
    work += glm::dot(impulse - other_impulses, moved) / h;
  }
  return work;
}

/// Does any place that holds the articulation move in this step?
bool is_driven(const World& world, const Island& a) {
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kHeld && t.target != t.target_before) return true;
  for (const Hold& h : a.holds)
    if (h.partner == UINT32_MAX && h.target != h.target_before) return true;
  if (!a.room.touches.empty()) return true;  // a collider may lift it
  for (const PackedJoint& j : a.joints)
    if (j.drive != UINT32_MAX) return true;
  for (const Cord& c : a.cords) {
    if (c.column_a != UINT32_MAX && c.column_b != UINT32_MAX) continue;
    const Body& holder = world.bodies.values()[c.column_a != UINT32_MAX ? c.slot_b : c.slot_a];
    if (holder.velocity != Vec3(0) || holder.spin != Vec3(0)) return true;
  }
  return false;
}

/// Nothing ties the articulation to the world.
bool flies_free(const Island& a) {
  if (a.bears || !a.room.touches.empty()) return false;
  for (const Tree& t : a.trees)
    if (a.parents[t.first] != kFree) return false;
  for (const Cord& c : a.cords)
    if (c.column_a == UINT32_MAX || c.column_b == UINT32_MAX) return false;
  return a.holds.empty();
}

/// Takes all velocities so far down that the energy is `allowed`, or to nothing. What flies free
/// keeps the motion of its mass centre. Returns the energy that is left, J.
Real slow_down(Island& a, const Packed& p, const EndSums& end, Real allowed) {
  const bool free = flies_free(a);
  Real mass = 0;
  for (std::size_t c = 0; c < a.count(); ++c) mass += a.constants.at(kMass, c);
  const Vec3 momentum(end.momentum[0], end.momentum[1], end.momentum[2]);
  const Vec3 mean = free ? momentum / mass : Vec3(0);
  const Real whole = free ? 0.5 * mass * glm::dot(mean, mean) : 0;
  const Real within = end.kinetic - whole;
  const Real left = std::max(Real(0), allowed - end.potential - whole);
  const Real factor = within > 0 ? std::sqrt(std::min(Real(1), left / within)) : 1;
  kernels().scale(p, factor, &mean[0]);
  for (Tree& t : a.trees) t.spin_momentum *= factor;
  return end.potential + whole + factor * factor * within;
}

/// Potential of the poses that the last sweep left, J.
Real potential_of_final(const World& world, const Island& a) {
  Real sum = 0;
  for (std::size_t c = 0; c < a.count(); ++c)
    sum -= a.constants.at(kMass, c) * a.constants.at(kGravityScale, c) *
           glm::dot(world.gravity, a.room.work.vec(kFinalPosition, c));
  return sum;
}

/// A step that lifted the bodies higher than all their energy could is taken back to a half or a
/// quarter of its way, or to where it began; there the bodies rest, joints closed. The loads found
/// stay, and stiffen the next attempt.
void take_back(World& world, Island& a, const Packed& p, Real allowed) {
  const Kernels& k = kernels();
  Table& w = a.room.work;
  for (Real back : {0.5, 0.75, 1.0}) {
    for (std::size_t c = 0; c < a.count(); ++c) {
      const Pose& pose = world.bodies.values()[a.slots[c]].pose;
      const Quat turn = turn_by(-back * a.memory.vec(kLastTurn, c));
      w.set(kPosition, c, pose.position - back * a.memory.vec(kLastSlide, c));
      w.set(kRotation, c, glm::normalize(turn * pose.rotation));
    }
    k.levers(p, kPosition, kRotation);
    k.sweep(p, a.room.targets.data(), kPosition, a.settings.turn_stiffness);
    k.commit(p, kRotation);
    if (!a.joints.empty()) sweep_closed(world, a);
    if (!a.holds.empty() || !a.cords.empty()) relax(world, a, true);
    if (potential_of_final(world, a) <= allowed) break;
  }
  for (std::size_t c = 0; c < a.count(); ++c) {
    Body& b = world.bodies.values()[a.slots[c]];
    b.pose = {w.vec(kFinalPosition, c), w.quat(kFinalRotation, c)};
    b.velocity = b.spin = Vec3(0);
  }
}

}  // namespace

void limit_energy(World& world, Island& a, const Packed& p, const EndSums& end, Real h) {
  // Of the work of a hand that has stopped nothing comes back: what is held gains no energy.
  const bool driven = is_driven(world, a);
  if (a.driven && !driven) a.reserve = 0;
  a.driven = driven;

  const Real allowed =
      a.energy_before + a.reserve - a.damped + end.work + a.stop_work +
      work_of_holders(world, a, end, h);
  const Real slack = 1e-3 * a.kinetic_before + 1e-12 * std::abs(end.potential);
  Real energy = end.kinetic + end.potential;
  a.limited = a.settings.limiter && energy > allowed + slack;
  if (a.limited) {
    energy = slow_down(a, p, end, allowed);
    // Contacts may have to lift a little more than is accounted for.
    const Real lift = a.bears ? 0.01 * a.mass * glm::length(world.gravity) * a.size : 0;
    // A step among contacts that found more motion than there was did not find its way.
    const Real may_have = a.kinetic_before + std::max(Real(0), allowed - a.energy_before) +
                          0.1 * a.mass * glm::length(world.gravity) * a.size;
    const bool wild = !a.room.touches.empty() && end.kinetic > 4 * may_have;
    if (wild) take_back(world, a, p, -1e300);
    if (!wild && !flies_free(a) && end.potential > allowed + slack + lift) take_back(world, a, p, allowed);
  }
  const Real lent = std::max(Real(0), allowed - energy);
  a.reserve = a.limited || a.disturbed ? 0 : lent * std::exp(-h / a.settings.reservoir_time);
}

}  // namespace pantin::articulated
