#pragma once
// Random articulated trees.
#include <cmath>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"
#include "tests/base/random.hpp"

namespace pantin::test {

using namespace detail;

inline Vec3 box_inertia(Real mass, Vec3 half) {
  const Vec3 s = half * half;
  return mass / 3 * Vec3(s.y + s.z, s.z + s.x, s.x + s.y);
}

struct TreeSpec {
  int bodies = 8;
  Real decades = 0;  // masses lie within 10^-decades .. 10^decades kg
  Real drag = 0;     // 1/s
  bool held = true;  // by a pin on the first body
  bool chain = false;
};

struct RandomTree {
  World world;
  std::vector<Entity> bodies;  // parents first
  std::vector<int> parents;
  Entity pin;        // of the first body, if held
  Real reach = 0;    // m, from the pin to the farthest mass centre, all joints stretched
  Real deepest = 0;  // kg m, sum of mass times the farthest distance of its centre from the pin

  /// A bound from below of the potential, J: every body as far below the pin as its joints allow.
  Real lowest_potential() const {
    Real mass = 0;
    for (const Body& b : world.bodies.values()) mass += b.mass;
    return 9.81 * (mass * world.pins[pin].target.y - deepest);
  }
};

/// Boxes of random sizes and turns, tied at random points in and on them; all joints closed.
inline RandomTree random_tree(const TreeSpec& spec, Random& dice) {
  RandomTree t;
  std::vector<Vec3> halves, own;
  std::vector<Real> ways;
  for (int i = 0; i < spec.bodies; ++i) {
    Body b;
    const Vec3 half = dice.in_box(0.03, 0.2);
    b.mass = std::pow(10.0, dice.between(-spec.decades, spec.decades));
    b.inertia = box_inertia(b.mass, half);
    b.drag = spec.drag;
    b.pose.rotation = dice.rotation();
    const Vec3 anchor = dice.in_cube(1) * half;
    const int parent = i == 0 ? -1 : spec.chain ? i - 1 : dice.below(i);
    Vec3 joint(0), out(0);
    Real way = 0;
    if (parent >= 0) {
      const auto p = static_cast<std::size_t>(parent);
      out = dice.in_cube(1) * halves[p];
      joint = to_world(t.world.bodies[t.bodies[p]].pose, out);
      way = ways[p] + glm::length(out - own[p]);
    }
    b.pose.position = joint - b.pose.rotation * anchor;
    const Entity e = t.world.add_body(b);
    if (parent >= 0)
      add_link(t.world, {t.bodies[static_cast<std::size_t>(parent)], e, {out, anchor}});
    if (i == 0 && spec.held) {
      Pin pin;
      pin.body = e, pin.anchor = anchor;
      t.pin = t.world.add_pin(pin);
    }
    t.bodies.push_back(e), t.parents.push_back(parent);
    halves.push_back(half), own.push_back(anchor), ways.push_back(way);
    t.reach = std::max(t.reach, way + glm::length(anchor));
    t.deepest += b.mass * (way + glm::length(anchor));
  }
  return t;
}

/// What a run kept of its energy.
struct Kept {
  Real most = 0, end = 0;       // change of energy, parts of a scale
  Real gap = 0, violation = 0;  // m, rad
  int limited = 0;              // steps in which the limiter acted
};

/// A run at `rate` steps a second; `scale` is an energy, J.
inline Kept kept_over(const World& world, Real scale, Real rate, Real duration) {
  Simulation sim = Simulation::copy_of(world, {1 / rate, 1, 1, true});
  const Real start = measure(sim.world).energy();
  Kept kept;
  const int steps = static_cast<int>(std::lround(duration * rate));
  for (int i = 0; i < steps; ++i) {
    const StepReport report = sim.step();
    if (report.status != Status::ok) return {1e9, -1e9, 1e9, 1e9, steps};
    kept.end = (report.measures.energy() - start) / scale;
    kept.most = std::max(kept.most, kept.end);
    kept.gap = std::max(kept.gap, report.measures.worst_gap);
    kept.violation = std::max(kept.violation, report.measures.worst_violation);
    kept.limited += report.limited;
  }
  return kept;
}

inline bool is_finite(const World& world) {
  for (const Body& b : world.bodies.values())
    if (!(pantin::is_finite(b.pose) && pantin::is_finite(b.velocity) &&
          pantin::is_finite(b.angular_velocity)))
      return false;
  return true;
}

/// Largest distance of an exact pin from its place, m.
inline Real worst_pin_gap(const World& world) {
  Real worst = 0;
  for (const Pin& p : world.pins.values())
    worst = std::max(worst, glm::length(to_world(world.bodies[p.body].pose, p.anchor) - p.target));
  return worst;
}

}  // namespace pantin::test
