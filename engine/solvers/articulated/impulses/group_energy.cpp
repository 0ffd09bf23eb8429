// Truncated iterations of contacts add no energy to groups without other energy sources.
#include <algorithm>

#include "engine/solvers/articulated/impulses/contact_groups.hpp"

namespace pantin::detail::articulated {
namespace {

/// Tolerated gain, as a fraction of the energy of a substep.
constexpr Real kEnergyRounding = 1e-9;

/// Sine of the least angle of a wedge that is told from parallel walls, between which bodies jam.
constexpr Real kWedge = 0.015;

bool presses(const Group& g, const GroupContact& c, Vec3 GroupContact::*by) {
  return g.is_fixed(c) && (c.*by).x > 0;
}
bool is_led(const Group& g, const GroupContact& c) {
  const GroupBody& b = g.b(c);
  return b.velocity != Vec3(0) || b.spin != Vec3(0);
}

/// How much faster than a led body the others are when it drives them as a wedge.
Real gain_of_wedges(const Group& g, Vec3 GroupContact::*by) {
  Real least = 1;
  for (const GroupContact& c : g.contacts) {
    if (!presses(g, c, by) || !is_led(g, c)) continue;
    for (const GroupContact& d : g.contacts) {
      if (!presses(g, d, by) || !(glm::dot(c.axes[0], d.axes[0]) < 0)) continue;
      const Real sine = glm::length(glm::cross(c.axes[0], d.axes[0]));
      if (sine > kWedge) least = std::min(least, sine);
    }
  }
  return 1 / least;
}

/// What led bodies meet in a substep.
struct Blow {
  Real speed = 0;    // m/s, of the fastest led point
  Real comes = 0;    // m/s, at which a body came towards one
  Real mass = 0;     // kg, of the group
  Real against = 0;  // kg, the largest at a point: a body on a hinge is heavy near it

  /// J, given to bodies of this mass in an elastic impact at this speed.
  Real work(Real of, Real at) const { return 2 * at * of * (at + comes); }
};

/// J: a bound on the work of led bodies. Levers and wedges drive bodies faster than a blow to all
/// of them would, but not beyond what they then have.
Real most_work(const Group& g, const Blow& b, Real before, Vec3 GroupContact::*by) {
  const Real mass = b.mass + b.against, fastest = b.speed * gain_of_wedges(g, by);
  const Real sum = 2 * fastest + b.comes, all = 0.5 * mass * sum * sum;
  return std::max(b.work(b.mass, b.speed), std::min(b.work(mass, fastest), all - before));
}

}  // namespace

bool is_left_alone(const Group& g) {
  const auto stays = [](const GroupTree& t) { return t.from == t.to && t.held_spin == Vec3(0); };
  const auto rests = [&](std::uint32_t body) {
    const GroupBody& b = g.bodies[body];
    return b.per_mass > 0 || (b.velocity == Vec3(0) && b.spin == Vec3(0));
  };
  return std::all_of(g.trees.begin(), g.trees.end(), stays) &&
         std::none_of(g.nodes.begin(), g.nodes.end(),
                      [](auto& n) { return n.has_spring || n.is_driven; }) &&
         std::all_of(g.ties.begin(), g.ties.end(),
                     [&](const GroupTie& t) { return !t.is_reeled && rests(t.a) && rests(t.b); });
}

Real work_of_surfaces(const Group& g, Real before, Vec3 GroupContact::*by, int blows) {
  Real sum = 0, led = 0;
  Blow blow;
  for (const GroupContact& c : g.contacts) {
    const Vec3 passed = c.*by;
    sum -= passed.y * c.surface_first + passed.z * c.surface_second;
    if (!g.is_fixed(c) || !is_led(g, c)) continue;
    const Vec3 speed = speed_at(g.b(c), c.arm_b);
    led += glm::dot(to_world(c, passed), speed);
    if (!(passed.x > 0)) continue;
    blow.speed = std::max(blow.speed, blows * glm::length(speed));
    blow.comes = std::max(blow.comes, c.comes);
    if (c.along > 0) blow.against = std::max(blow.against, 1 / c.along);
  }
  if (led > 0) {
    for (const GroupBody& b : g.bodies)
      if (b.per_mass > 0) blow.mass += 1 / b.per_mass;
    if (blows > 1) blow.comes = std::sqrt(2 * std::max(Real(0), before) / blow.mass);
    led = std::min(led, most_work(g, blow, before, by));
  }
  return std::max(Real(0), sum + led);
}

void note_approach(const Group& g) {
  for (GroupContact& c : g.contacts) {
    const GroupBody& a = g.a(c);
    const Vec3 speed = a.free_velocity + glm::cross(a.free_spin, c.arm_a);
    c.comes = std::max(Real(0), -glm::dot(c.axes[0], speed));
  }
}

Real elastic_energy(const Group& g) {
  Real sum = 0;
  for (const GroupTie& t : g.ties) {
    if (!(t.stiffness > 0)) continue;
    const Real span = glm::length(to_world(g.bodies[t.b].pose, t.anchor_b) -
                                  to_world(g.bodies[t.a].pose, t.anchor_a));
    const bool is_cable = t.kind == GroupTie::Kind::cable;
    const Real stretch = is_cable ? std::max(Real(0), span - t.length) : span;
    sum += 0.5 * t.stiffness * stretch * stretch;
  }
  return sum;
}

Real energy_of_bodies(const Group& g) {
  Real sum = 0;
  for (const GroupBody& b : g.bodies) {
    if (b.per_mass == 0) continue;
    sum += 0.5 * glm::dot(b.velocity, b.velocity) / b.per_mass;
    const Vec3 inside = glm::conjugate(b.pose.rotation) * b.angular_momentum;
    sum += 0.5 * glm::dot(inside, inside * b.per_inertia);
  }
  return sum;
}

Real work_of_external_forces(const Group& g) {
  Real sum = 0;
  for (const GroupBody& b : g.bodies)
    if (b.per_mass > 0) sum += glm::dot(b.acceleration, b.pose.position - b.from) / b.per_mass;
  return sum;
}

void remember_free(const Group& g) {
  for (GroupBody& b : g.bodies)
    b.free_velocity = b.velocity, b.free_spin = b.spin, b.free_momentum = b.angular_momentum;
  for (GroupNode& n : g.nodes)
    n.free_torque = n.torque, n.free_pending = n.pending, n.free_load = n.load;
  note_approach(g);
}

void restore_free_motions(const Group& g) {
  for (GroupBody& b : g.bodies)
    b.velocity = b.free_velocity, b.spin = b.free_spin, b.angular_momentum = b.free_momentum;
  for (GroupNode& n : g.nodes)
    n.torque = n.free_torque, n.pending = n.free_pending, n.load = n.free_load;
  for (GroupTree& t : g.trees) t.at = t.first;
}

void forget_impulses(const Group& g) {
  restore_free_motions(g);
  for (GroupNode& n : g.nodes) {
    n.actuator.impulse = 0;
    for (GroupLimit& limit : n.limits) limit.impulse = 0;
  }
  for (GroupContact& c : g.contacts) c.impulse = Vec3(0);
  for (GroupRolling& r : g.rollings) r.impulse = Vec3(0);
  for (GroupTie& t : g.ties) t.impulse = Vec3(0);
}

Real kinetic_energy(const Group& g) {
  Real sum = 0;
  for (const GroupBody& b : g.bodies)
    if (b.per_mass > 0 && b.node == kNoNode)
      sum += 0.5 *
             (glm::dot(b.velocity, b.velocity) / b.per_mass + glm::dot(b.spin, b.angular_momentum));
  for (const GroupNode& n : g.nodes) {
    const GroupBody& b = g.bodies[n.body];
    const Vec3 velocity = speed_at(b, n.arm);
    sum +=
        0.5 * (n.mass * glm::dot(velocity, velocity) + glm::dot(b.spin, n.world_inertia * b.spin));
  }
  return sum;
}

void bound_energy(const Group& g, Real before) { slow_bodies(g, kinetic_energy(g), before); }

void slow_bodies(const Group& g, Real now, Real before) {
  before = std::max(Real(0), before);
  if (!(now > (1 + kEnergyRounding) * before)) return;
  const Real part = std::sqrt(before / now);
  for (GroupBody& b : g.bodies)
    if (b.per_mass > 0) b.velocity *= part, b.spin *= part, b.angular_momentum *= part;
  if (!g.trees.empty())
    g.trees.front().energy_removed += now - before;
  else if (!g.ties.empty())
    g.ties.front().energy_removed += now - before;
}

}  // namespace pantin::detail::articulated
