#pragma once
// Random articulated trees, and numbers that do not depend on the standard library.
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "engine/base/rotation.hpp"
#include "engine/runtime/simulation.hpp"

namespace pantin::test {

using namespace detail;

/// Random numbers that are the same everywhere: the standard fixes the engine, not the
/// distributions.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  Real between(Real low, Real high) {
    return low + (high - low) * static_cast<Real>(engine_() >> 11) * 0x1p-53;
  }
  int below(int count) { return static_cast<int>(between(0, count)); }
  Vec3 in_box(Real low, Real high) {
    // One after the other: the order in which arguments are evaluated is the compiler's affair.
    const Real x = between(low, high), y = between(low, high), z = between(low, high);
    return {x, y, z};
  }
  Vec3 in_cube(Real half) { return in_box(-half, half); }
  Vec3 direction() {
    for (;;) {
      const Vec3 v = in_cube(1);
      const Real l2 = glm::dot(v, v);
      if (l2 > 0.01 && l2 < 1) return v / std::sqrt(l2);
    }
  }
  Quat rotation() { return from_rotation_vector(between(0, kPi) * direction()); }

 private:
  std::mt19937_64 engine_;
};

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
inline RandomTree random_tree(const TreeSpec& spec, Dice& dice) {
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
    if (parent >= 0) t.world.add_link(t.bodies[static_cast<std::size_t>(parent)], e, {out, anchor});
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
