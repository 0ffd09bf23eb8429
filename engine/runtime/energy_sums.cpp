// Sums of energies and momenta over the bodies of each group, for the energy account.
#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/runtime/energy_account.hpp"
#include "engine/world/partition.hpp"

namespace pantin::detail {
namespace {

/// Velocity before, after and in the mean of the substep.
struct Speeds {
  Vec3 before, after, mean;
};
/// The largest and the least of the powers of a force at these velocities, W.
struct Powers {
  Real most, least;
};
Powers powers_of(Vec3 force, const Speeds& v) {
  const auto [least, most] =
      std::minmax({glm::dot(force, v.mean), glm::dot(force, v.before), glm::dot(force, v.after)});
  return {most, least};
}

}  // namespace

Real kinetic_energy(const Body& b) {
  const Vec3 spin = glm::conjugate(b.pose.rotation) * b.angular_velocity;
  return 0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(spin, b.inertia * spin));
}

EnergyAccount::Energies EnergyAccount::energies_of(const World& world, const Body& b) {
  const Vec3 spin =
      b.pose.rotation * (b.inertia * (glm::conjugate(b.pose.rotation) * b.angular_velocity));
  Energies e;
  e.kinetic =
      0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(spin, b.angular_velocity));
  e.all = e.kinetic - b.mass * b.gravity_scale * glm::dot(world.gravity, b.pose.position);
  e.spin = spin;
  return e;
}

/// Sums consecutive bodies first: bodies of one group are mostly stored side by side.
void EnergyAccount::add_bodies(const World& world, Real h) {
  Sums sums;
  std::uint32_t root = kNoSlot;
  for (const std::uint32_t i : partition_of(world).awake) {
    if (world.bodies.values()[i].motion != Motion::dynamic) continue;
    const std::uint32_t own = sets_.root(i);
    if (own != root && root != kNoSlot) add_sums(world, sums, groups_[root], h), sums = {};
    root = own;
    add_body(world, i, h, sums);
  }
  if (root != kNoSlot) add_sums(world, sums, groups_[root], h);
}

void EnergyAccount::add_body(const World& world, std::uint32_t slot, Real h, Sums& sums) const {
  const Body& b = world.bodies.values()[slot];
  const Start& s = bodies_[slot];
  const Energies e = energies_of(world, b);
  const Vec3 first = b.mass * b.pose.position, first_before = b.mass * s.pose.position;
  const Vec3 momentum = b.mass * b.velocity, momentum_before = b.mass * s.velocity;
  sums.kinetic += e.kinetic, sums.kinetic_before += s.kinetic, sums.rise += e.all - s.energy;
  sums.now.mass += b.mass, sums.now.first += first, sums.now.momentum += momentum;
  sums.now.angular += e.spin + glm::cross(b.pose.position, momentum);
  sums.now.spins += glm::length(e.spin);
  sums.before.first += first_before, sums.before.momentum += momentum_before;
  sums.before.angular += s.spin + glm::cross(s.pose.position, momentum_before);
  sums.weight += b.gravity_scale * b.mass;
  sums.weight_first += 0.5 * b.gravity_scale * (first + first_before);
  const bool is_forced = s.force != Vec3(0) || s.torque != Vec3(0);
  if (!is_forced && b.drag == 0) return;
  const Vec3 way = (b.pose.position - s.pose.position) / h;
  const Vec3 middle = 0.5 * (b.pose.position + s.pose.position);
  const Vec3 known = s.force - b.drag * b.mass * way;  // N, without the weight
  sums.now.force += known, sums.now.torque += glm::cross(middle, known) + s.torque;
  sums.slowed_spin += 0.5 * b.drag * (e.spin + s.spin);
  sums.paid += 2 * h * b.drag * std::max(e.kinetic, s.kinetic);
  sums.is_slowed = sums.is_slowed || b.drag > 0;
  if (!is_forced) return;
  const Vec3 turning = angular_velocity_between(s.pose.rotation, b.pose.rotation, h);
  const Powers push = powers_of(s.force, {s.velocity, b.velocity, way}),
               twist = powers_of(s.torque, {s.angular_velocity, b.angular_velocity, turning});
  const Real work = h * (push.most + twist.most);
  sums.work += work, sums.works += std::abs(work);
  sums.paid += h * (push.most - push.least + twist.most - twist.least);  // it may have done less
}

void EnergyAccount::add_sums(const World& world, const Sums& s, Group& g, Real h) {
  g.kinetic += s.kinetic, g.kinetic_before += s.kinetic_before, g.rise += s.rise;
  g.paid += s.paid, g.is_slowed = g.is_slowed || s.is_slowed;
  g.change -= s.work, g.exchanged += s.works, g.worked += s.works;
  const Vec3 force = s.now.force + s.weight * world.gravity,
             torque = s.now.torque + glm::cross(s.weight_first, world.gravity);
  g.now.mass += s.now.mass, g.now.first += s.now.first, g.now.momentum += s.now.momentum;
  g.now.angular += s.now.angular, g.now.spins += s.now.spins;
  g.now.force += force, g.now.torque += torque;
  g.before.mass += s.now.mass, g.before.first += s.before.first;
  g.before.momentum += s.before.momentum, g.before.angular += s.before.angular;
  g.momentum += s.now.momentum - s.before.momentum - h * force;
  g.angular += s.now.angular - s.before.angular - h * torque + h * s.slowed_spin;
}

}  // namespace pantin::detail
