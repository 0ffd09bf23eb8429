// Free ball joints by the energy-momentum method: bodies of any shape and mass keep their energy
// and momentum, whatever the step.
#include <catch2/catch.hpp>

#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/articulated/kernels.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/chains.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// Rods in a tree, every joint at an end of the outboard rod.
struct Rods {
  int bodies = 8;
  bool chain = false;
  bool held = true;
  Real axial = 1e-2;      // moment of inertia about the axis to that across it
  Real mass_ratio = 1;    // of a rod to its parent
  Real length_ratio = 1;  // likewise
  Real whirl = 0;         // rad/s, of the whole tree about an axis of any direction
  Real spin = 0;          // rad/s, of each rod about its own axis
  std::uint64_t seed = 1;
};

struct RodTree {
  World world;
  std::vector<Entity> bodies;
  Real scale = 0;  // J: kinetic energy at the start, and the fall to the lowest potential
};

RodTree rods(const Rods& spec) {
  Random dice(spec.seed);
  RodTree t;
  std::vector<int> parents;
  std::vector<Real> lengths, depths;
  for (int i = 0; i < spec.bodies; ++i) {
    const int parent = i == 0 ? -1 : spec.chain ? i - 1 : dice.below(i);
    const auto p = static_cast<std::size_t>(std::max(parent, 0));
    Body b;
    b.drag = 0;
    b.mass = parent < 0 ? 1 : spec.mass_ratio * t.world.bodies[t.bodies[p]].mass;
    const Real l = parent < 0 ? 0.4 : spec.length_ratio * lengths[p];
    const Real across = b.mass * l * l / 12;
    b.inertia = Vec3(across, spec.axial * across, across);
    b.pose.rotation = dice.rotation();
    Vec3 joint(0), out(0);
    if (parent >= 0) {
      out = {0, -0.5 * lengths[p] * (spec.chain ? 1 : dice.between(-0.5, 1)), 0};
      joint = to_world(t.world.bodies[t.bodies[p]].pose, out);
    }
    const Vec3 own(0, 0.5 * l, 0);
    b.pose.position = joint - b.pose.rotation * own;
    const Entity e = t.world.add_body(b);
    if (parent >= 0) add_link(t.world, {t.bodies[p], e, {out, own}});
    if (parent < 0 && spec.held) {
      Pin pin;
      pin.body = e, pin.anchor = own;
      t.world.add_pin(pin);
    }
    t.bodies.push_back(e), parents.push_back(parent), lengths.push_back(l);
    depths.push_back(parent < 0 ? l : depths[p] + l);
  }
  const Vec3 whirl = spec.whirl * dice.direction();
  for (std::size_t i = 0; i < t.bodies.size(); ++i) {
    Body& b = t.world.bodies[t.bodies[i]];
    b.velocity = glm::cross(whirl, b.pose.position);
    b.angular_velocity = whirl;
  }
  // A spin about the own axis through its joint is allowed by a joint on the axis of the parent;
  // children elsewhere would move with it, so only rods without children spin.
  for (std::size_t i = 0; i < t.bodies.size(); ++i)
    if (std::find(parents.begin(), parents.end(), static_cast<int>(i)) == parents.end()) {
      Body& b = t.world.bodies[t.bodies[i]];
      b.angular_velocity += spec.spin * (b.pose.rotation * Vec3(0, 1, 0));
    }
  const Measures start = measure(t.world);
  t.scale = start.kinetic;
  for (std::size_t i = 0; i < t.bodies.size() && spec.held; ++i) {
    const Body& b = t.world.bodies[t.bodies[i]];
    t.scale += 9.81 * b.mass * (b.pose.position.y + depths[i] - 0.5 * lengths[i]);
  }
  return t;
}

Kept run(const RodTree& t, Real rate, Real duration) {
  return kept_over(t.world, t.scale, rate, duration);
}

}  // namespace

TEST_CASE("a whirled stick keeps its energy, however thin it is") {
  for (const Real axial : {1.0, 1e-1, 1e-2, 1e-4, 1e-6})
    for (const Real whirl : {2.0, 5.0, 10.0, 30.0}) {
      Rods spec;
      spec.bodies = 1, spec.axial = axial, spec.whirl = whirl;
      for (const Real rate : {60.0, 240.0}) {
        const Kept kept = run(rods(spec), rate, 10);
        INFO("axial ratio " << axial << ", " << whirl << " rad/s, " << rate << " Hz: " << kept.end);
        CHECK(kept.most < 1e-3);
        CHECK(kept.end > (rate > 100 ? -1e-3 : -2e-2));
        CHECK(kept.limited == 0);
      }
    }
}

TEST_CASE("a stick that spins about its own axis keeps its energy") {
  for (const Real axial : {1e-1, 1e-2, 1e-3})
    for (const Real spin : {20.0, 60.0}) {
      Rods spec;
      spec.bodies = 1, spec.axial = axial, spec.spin = spin;
      const Kept kept = run(rods(spec), 480, 60);
      INFO("axial ratio " << axial << ", " << spin << " rad/s: " << kept.end);
      CHECK(kept.most < 1e-3);
      CHECK(kept.end > -1e-2);
      CHECK(kept.limited == 0);
    }
}

TEST_CASE("trees of thin, tapering and heavy-ended rods keep their energy") {
  int cases = 0;
  for (const Real axial : {1e-1, 1e-3, 1e-6})
    for (const Real mass_ratio : {0.5, 1.0, 2.0})
      for (const int bodies : {2, 5, 12})
        for (const bool chain : {true, false}) {
          Rods spec;
          spec.axial = axial, spec.mass_ratio = mass_ratio, spec.bodies = bodies;
          spec.chain = chain, spec.whirl = 4;
          spec.length_ratio = chain ? 0.9 : 0.8;
          spec.seed = static_cast<std::uint64_t>(++cases);
          const Kept coarse = run(rods(spec), 60, 10), fine = run(rods(spec), 240, 10);
          INFO("axial ratio " << axial << ", masses x" << mass_ratio << ", " << bodies
                              << (chain ? " in a chain" : " in a tree") << ": " << coarse.end
                              << " at 60 Hz, " << fine.end << " at 240 Hz, most " << coarse.most
                              << " and " << fine.most);
          CHECK(std::max(coarse.most, fine.most) < 1e-3);
          CHECK(coarse.end > -0.15);
          CHECK(fine.end > -0.02);
          CHECK(coarse.limited + fine.limited == 0);
          CHECK(std::max(coarse.gap, fine.gap) < 1e-13);
        }
}

TEST_CASE("masses a hundred times those of the parents, or a hundredth, keep their energy") {
  // Heavy ends go over the hook and snap the light rods straight.
  int cases = 0;
  for (const Real mass_ratio : {0.01, 0.1, 10.0, 100.0})
    for (const int bodies : {2, 3, 4})
      for (const Real axial : {1e-1, 1e-3, 1e-6}) {
        Rods spec;
        spec.bodies = bodies, spec.chain = true, spec.mass_ratio = mass_ratio;
        spec.axial = axial, spec.whirl = 4, spec.seed = static_cast<std::uint64_t>(++cases);
        const Kept kept = run(rods(spec), 60, 10);
        INFO("masses x" << mass_ratio << ", " << bodies << " rods, axial ratio " << axial << ": "
                        << kept.end << ", most " << kept.most);
        CHECK(kept.most < 1e-3);
        // A million between the ends of a snap is beyond the shortest part of a step.
        if (bodies < 4 || mass_ratio < 100) CHECK(kept.end > -0.01);
        CHECK(kept.gap < 1e-12);
      }
}

TEST_CASE("a free tree of thin rods keeps momentum, angular momentum and energy") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Rods spec;
    spec.held = false, spec.axial = 1e-4, spec.whirl = 5, spec.seed = seed;
    RodTree t = rods(spec);
    t.world.gravity = Vec3(0);
    Simulation sim = Simulation::copy_of(t.world, {1.0 / 60, 1, 1, true});
    const Measures start = measure(sim.world);
    Measures now = start;
    for (int i = 0; i < 600; ++i) now = sim.step().measures;
    const Real l = glm::length(start.angular_momentum);
    const Real p = std::sqrt(2 * start.kinetic * 8);
    INFO("seed " << seed);
    CHECK(glm::length(now.momentum - start.momentum) < 1e-12 * p);
    CHECK(glm::length(now.angular_momentum - start.angular_momentum) < 1e-8 * l);
    CHECK(now.kinetic <= start.kinetic * (1 + 1e-9));
    CHECK(now.kinetic > 0.9 * start.kinetic);
  }
}

TEST_CASE("the error falls with the square of the step for thin rods in space") {
  Rods spec;
  spec.bodies = 3, spec.chain = true, spec.axial = 1e-3, spec.whirl = 3;
  const auto after = [&](Real rate) {
    const RodTree t = rods(spec);
    Simulation sim = Simulation::copy_of(t.world, {1 / rate});
    for (int i = 0; i < static_cast<int>(rate); ++i) sim.step();
    return sim.world.bodies[t.bodies.back()].pose.position;
  };
  const Vec3 reference = after(30720);
  const Real e240 = glm::length(after(240) - reference), e960 = glm::length(after(960) - reference),
             e3840 = glm::length(after(3840) - reference);
  INFO("errors " << e240 << ", " << e960 << ", " << e3840 << " m");
  CHECK(e240 / e960 > 12);
  CHECK(e960 / e3840 > 12);
}

TEST_CASE("drag takes its part to second order, also from a start in motion") {
  // Without gravity a free body slows by exp(-c t), exactly.
  World w;
  Body b;
  b.mass = 2, b.inertia = Vec3(0.1), b.drag = 0.7;
  b.velocity = {1, 2, 3}, b.angular_velocity = {0, 4, 0};
  const Entity e = w.add_body(b);
  w.gravity = Vec3(0);
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 60; ++i) sim.step();
  const Real kept = std::exp(-0.7);
  CHECK(glm::length(sim.world.bodies[e].velocity - kept * Vec3(1, 2, 3)) < 1e-12);
  CHECK(glm::length(sim.world.bodies[e].angular_velocity - kept * Vec3(0, 4, 0)) < 1e-9);
}

TEST_CASE("limits that are far and slack cables cost no accuracy") {
  // A thin whirled stick from a nail, with a cone that it stays in, and with a cable too long.
  const auto after = [](bool limited, bool tied) {
    World w;
    Body nail;
    nail.motion = Motion::fixed;
    const Entity top = w.add_body(nail);
    Body b;
    b.mass = 1, b.drag = 0, b.inertia = 1.0 / 12 * Vec3(1, 1e-4, 1);
    const Vec3 arm(0.6 * 0.5, -0.8 * 0.5, 0);
    b.pose.rotation = from_rotation_vector({0, 0, std::atan2(0.6, 0.8)});
    b.pose.position = arm;
    b.angular_velocity = {0, 4, 0}, b.velocity = glm::cross(b.angular_velocity, arm);
    const Entity stick = w.add_body(b);
    Joint joint{Vec3(0), {0, 0.5, 0}};
    if (limited) joint.limits.edit().swing = {.on = true, .y = 3.1, .z = 3.1};
    add_link(w, {top, stick, joint});
    if (tied) add_cable(w, {top, stick, {Vec3(0), {0, -0.5, 0}, 50, 0}});
    Simulation sim(std::move(w), {1.0 / 60, 1, 1, true});
    for (int i = 0; i < 120; ++i) CHECK(sim.step().limited == 0);
    return sim.world.bodies[stick].pose.position;
  };
  const Vec3 free = after(false, false);
  CHECK(glm::length(after(true, false) - free) < 1e-7);
  CHECK(glm::length(after(false, true) - free) < 1e-7);
}

TEST_CASE("a chain that is led to and fro goes no faster than it can, at any step") {
  // Rods hang straight from a hook that swings by 2 g. Newton's method has roots that turn a rod by
  // half a turn.
  const auto fastest = [](int count, Real hertz, Real rate) {
    World w;
    Body lead;
    lead.motion = Motion::kinematic;
    const Entity hook = w.add_body(lead);
    Entity before = hook;
    for (int i = 0; i < count; ++i) {
      Body b;
      b.drag = 0, b.mass = 0.06, b.inertia = 2e-4 * Vec3(1, 0.015, 1);
      b.pose.position = {0, -0.1 - 0.2 * i, 0};
      const Entity e = w.add_body(b);
      add_link(w, {before, e, {i == 0 ? Vec3(0) : Vec3(0, -0.1, 0), {0, 0.1, 0}}});
      before = e;
    }
    Simulation sim(std::move(w), {1 / rate});
    const Real omega = 6.283185307179586 * hertz, amplitude = 2 * 9.81 / (omega * omega);
    Real speed = 0;
    for (int i = 1; i <= static_cast<int>(5 * rate); ++i) {
      const Real angle = omega * i / rate;
      Body& led = sim.world.bodies[hook];
      led.pose.position = {amplitude * std::sin(angle), 0, 0};
      led.velocity = {amplitude * omega * std::cos(angle), 0, 0};
      sim.step();
      for (const Body& b : sim.world.bodies.values())
        speed = std::max(speed, glm::length(b.velocity));
    }
    return speed;
  };
  for (const int count : {5, 10})
    for (const Real hertz : {0.95, 1.0, 1.05, 2.3}) {
      const Real right = fastest(count, hertz, 3840);
      for (const Real rate : {60.0, 120.0, 240.0, 480.0, 960.0}) {
        const Real found = fastest(count, hertz, rate);
        INFO(count << " rods, " << hertz << " Hz, steps at " << rate << " Hz: " << found << " m/s, "
                   << right << " at 3840 Hz");
        CHECK(found < 1.5 * right);
      }
    }
}

TEST_CASE("a free body that spins fast keeps its energy and angular momentum") {
  for (const Real spin : {20.0, 100.0, 400.0}) {
    World w;
    Body b;
    b.mass = 1, b.drag = 0, b.inertia = Vec3(1, 2, 2.5);
    b.angular_velocity = spin * glm::normalize(Vec3(1, 0.5, 0.3));
    w.gravity = Vec3(0);
    const Entity e = w.add_body(b);
    const Vec3 start = b.inertia * b.angular_velocity;
    Simulation sim(std::move(w), {1.0 / 60});
    for (int i = 0; i < 120; ++i) sim.step();
    const Body& end = sim.world.bodies[e];
    const Vec3 spun = glm::conjugate(end.pose.rotation) * end.angular_velocity;
    const Real ratio = glm::dot(end.inertia, spun * spun) / glm::dot(start, b.angular_velocity);
    INFO(spin << " rad/s: energy x" << ratio);
    CHECK(std::abs(ratio - 1) < 0.01);
    CHECK(glm::length(end.pose.rotation * (end.inertia * spun) - start) <
          1e-6 * glm::length(start));
  }
}
