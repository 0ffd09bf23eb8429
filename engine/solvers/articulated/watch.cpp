// The energy of islands whose solver does not conserve it is watched: it may only come from the
// energy before, from kinematic bodies that move, and from applied forces. Nothing else depends on
// these sums, so bounds suffice.
#include <algorithm>

#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Factor of "severalfold" growth: excess over the energy supplied, relative to the initial energy
/// and to the scale of the island's motion (a fall through its own size, rotation at 1 rad/s).
constexpr Real kSeveral = 3;

struct Energy {
  Real kinetic = 0, potential = 0;  // J
  Real whole() const { return kinetic + potential; }
};

Energy energy_of(const World& world, const Island& a) {
  Energy e;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    const Vec3 w = glm::conjugate(b.pose.rotation) * b.angular_velocity;
    e.kinetic += 0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(b.inertia, w * w));
    e.potential -= b.mass * b.gravity_scale * glm::dot(world.gravity, b.pose.position);
  }
  return e;
}

/// Speed of the fastest anchor of the island, m/s. A gap to be closed counts as displacement.
Real hand_speed(const World& world, const Island& a, Real h) {
  Real most = 0;
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kHeld)
      most = std::max(most, glm::length(t.target - t.target_before) / h);
  for (const PackedPin& constraint : a.pins) {
    if (constraint.compliance > 0) continue;  // springs are not solved here
    const Vec3 way =
        constraint.partner == UINT32_MAX ? constraint.target - constraint.target_before : Vec3(0);
    const Real gap = std::max(glm::length(constraint.gap_before), constraint.residual);
    most = std::max(most, (glm::length(way) + gap) / h);
  }
  for (const PackedCable& c : a.cables) {
    if (c.column_a != UINT32_MAX && c.column_b != UINT32_MAX) continue;
    const Cable& s = world.cables.values()[c.cable];
    const bool a_moves = c.column_a != UINT32_MAX;
    const Body& holder = world.bodies.values()[a_moves ? c.slot_b : c.slot_a];
    const Vec3 arm = holder.pose.rotation * (a_moves ? s.joint.anchor_b : s.joint.anchor_a);
    most = std::max(most, glm::length(holder.velocity + glm::cross(holder.angular_velocity, arm)));
  }
  return most;
}

/// Upper bound on the work done on the island in the step: the forces on its bodies other than
/// weight and applied ones, times the displacement of the fastest anchor; and the applied work.
Real most_work(const World& world, const Island& a, Real h) {
  Real pulls = 0, pushed = 0;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Body& b = world.bodies.values()[a.slots[c]];
    Vec3 change =
        b.mass * (b.velocity - a.scratch.velocities[c] - h * b.gravity_scale * world.gravity);
    const Force* f = a.forced ? world.forces.find(a.bodies[c]) : nullptr;
    if (f) {
      change -= h * f->force;
      pushed += h * std::max(Real(0), glm::dot(f->force, b.velocity) +
                                          glm::dot(f->torque, b.angular_velocity));
    }
    pulls += glm::length(change);
  }
  PANTIN_ASSERT(a.scratch.velocities.size() == a.count());
  const Real speed = hand_speed(world, a, h);
  return pulls * speed + pushed;
}

}  // namespace

void begin_watch(const World& world, Island& a) {
  a.grew = false;
  a.scratch.velocities.resize(a.count());
  for (std::size_t c = 0; c < a.count(); ++c)
    a.scratch.velocities[c] = world.bodies.values()[a.slots[c]].velocity;
  if (a.fresh || a.changed) a.watched = false;
}

void end_watch(const World& world, Island& a, Real h) {
  const Energy now = energy_of(world, a);
  // The first step closes initial gaps; with contacts there is no energy account.
  if (!a.watched || !a.scratch.contact_rows.empty()) {
    a.watched = true, a.budget = now.whole();
    a.usual = now.kinetic + a.mass * a.size * (glm::length(world.gravity) + 0.5 * a.size);
    return;
  }
  a.budget += most_work(world, a, h);
  a.grew = !(now.whole() <= a.budget + kSeveral * a.usual);
  // Energy lost must not return much later: the budget follows the energy downwards.
  a.budget = std::min(a.budget, now.whole() + a.usual);
}

}  // namespace pantin::detail::articulated
