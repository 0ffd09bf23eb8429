// Trees that nothing holds: momentum, and the motion of single bodies.
#include <catch2/catch.hpp>

#include "tests/solvers/stages.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// A free tree in a tumble: every body with the velocity of one rigid motion, so that no joint
/// starts with a blow, and some bodies with a spin of their own.
RandomTree tumbling(std::uint64_t seed, int bodies) {
  Random dice(seed);
  TreeSpec spec;
  spec.bodies = bodies, spec.held = false;
  RandomTree t = random_tree(spec, dice);
  const Vec3 angular_velocity = 3.0 * dice.direction(), drift(0.3, -0.2, 0.1);
  for (Entity e : t.bodies) {
    Body& b = t.world.bodies[e];
    b.angular_velocity = angular_velocity + dice.in_cube(1);
    b.velocity = drift + glm::cross(angular_velocity, b.pose.position);
  }
  t.world.gravity = Vec3(0);
  return t;
}

struct Drift {
  Real momentum = 0, angular_momentum = 0;  // parts of what they are
};

Drift worst_drift(RandomTree t, Real rate, bool falling) {
  if (falling) t.world.gravity = Vec3(0, -9.81, 0);
  Simulation sim = Simulation::copy_of(t.world, {1 / rate, 1, 1, true});
  // The first step sorts the velocities out that the joints do not allow.
  for (int i = 0; i < 3; ++i) sim.step();
  Real mass = 0, size = 0;
  for (Entity e : t.bodies) mass += sim.world.bodies[e].mass;
  const auto about_centre = [&](const Measures& m) {
    Vec3 centre(0);
    for (Entity e : t.bodies)
      centre += sim.world.bodies[e].mass / mass * sim.world.bodies[e].pose.position;
    return m.angular_momentum - glm::cross(centre, m.momentum);
  };
  const Measures start = measure(sim.world);
  const Vec3 l = about_centre(start);
  size = glm::length(start.momentum);
  Drift worst;
  for (int i = 1; i <= 600; ++i) {
    const Measures m = sim.step().measures;
    const Vec3 expected = start.momentum + mass * (i / rate) * sim.world.gravity;
    worst.momentum = std::max(
        worst.momentum, glm::length(m.momentum - expected) / std::max(size, glm::length(expected)));
    worst.angular_momentum =
        std::max(worst.angular_momentum, glm::length(about_centre(m) - l) / glm::length(l));
  }
  return worst;
}

}  // namespace

TEST_CASE("a free tree keeps its momentum, and its angular momentum far better than the steps") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    for (Real rate : {60.0, 240.0}) {
      const Drift d = worst_drift(tumbling(seed, 4 + 3 * static_cast<int>(seed)), rate, false);
      INFO("tree " << seed << " at " << rate << " Hz: " << d.momentum << ", "
                   << d.angular_momentum);
      CHECK(d.momentum <= 1e-12);
      CHECK(d.angular_momentum <= 1e-12);
    }
  }
}

TEST_CASE("a free tree falls as its mass centre would alone") {
  const Drift d = worst_drift(tumbling(5, 9), 60, true);
  CHECK(d.momentum <= 1e-12);
  CHECK(d.angular_momentum <= 1e-11);
}

TEST_CASE("the linear answer of a free tree shifts no mass centre") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random dice(seed);
    RandomTree t = random_tree({2, 1, 0, false, true}, dice);
    t.world.bodies[t.bodies[1]].pose.position += 0.1 * dice.in_cube(1);
    Stages s(t.world);
    s.inward_pass();
    Pose root = s.predicted(t.bodies[0]), child = s.predicted(t.bodies[1]);
    const Vec3 before_root = root.position, before_child = child.position;
    s.answer_linearly(root, child);
    const Real ma = t.world.bodies[t.bodies[0]].mass, mb = t.world.bodies[t.bodies[1]].mass;
    const Vec3 shift = ma * (root.position - before_root) + mb * (child.position - before_child);
    CHECK(glm::length(shift) <= 1e-15 * (ma + mb));
  }
}

TEST_CASE("drag takes the momentum of a free tree at its rate") {
  RandomTree t = tumbling(6, 7);
  for (Entity e : t.bodies) t.world.bodies[e].drag = 0.5;
  Simulation sim = Simulation::copy_of(t.world, {1.0 / 60, 1, 1, true});
  for (int i = 0; i < 3; ++i) sim.step();
  const Vec3 start = measure(sim.world).momentum;
  for (int i = 0; i < 120; ++i) sim.step();
  const Vec3 end = measure(sim.world).momentum;
  // exp(-c t) with c = 0.5 1/s over 2 s, to the order of the step.
  CHECK(glm::length(end - std::exp(-1.0) * start) <= 1e-3 * glm::length(start));
}

TEST_CASE("a free body and a tree of one fall alike, and exactly so from given velocities") {
  World world;
  Body b;
  b.drag = 0, b.velocity = {1, 2, 3};
  const Entity e = world.add_body(b);
  Simulation sim = Simulation::copy_of(world, {1.0 / 60});
  Real worst = 0;
  for (int i = 1; i <= 600; ++i) {
    sim.step();
    const Real time = i / 60.0;
    const Vec3 exact = time * b.velocity + 0.5 * time * time * sim.world.gravity;
    const Vec3 miss = sim.world.bodies[e].pose.position - exact;
    worst = std::max(worst, glm::length(miss) / (1 + glm::length(exact)));
    REQUIRE(glm::length(sim.world.bodies[e].velocity - b.velocity - time * sim.world.gravity) <
            1e-10);
  }
  // The first steps are backward Euler; their offset stays and does not grow.
  CHECK(worst <= 2 * 9.81 / (60.0 * 60.0));
}

TEST_CASE("a push moves a free body by F / m, off its centre it turns it too") {
  World world;
  world.gravity = Vec3(0);
  Body b;
  b.drag = 0, b.mass = 4, b.inertia = Vec3(0.5);
  const Entity e = world.add_body(b);
  Simulation sim = Simulation::copy_of(world, {1.0 / 60});
  const Vec3 force(2, -1, 3), lever(0, 0.3, 0);
  sim.insert(Stage::before_update, [&](World& w, Real) {
    const Vec3 at = w.bodies[e].pose.position;
    w.push(e, force, at + lever);
  });
  for (int i = 1; i <= 120; ++i) sim.step();
  const Body& after = sim.world.bodies[e];
  CHECK(glm::length(after.velocity - 2.0 / b.mass * force) <= 1e-12);
  CHECK(glm::length(after.angular_velocity - 2.0 / 0.5 * glm::cross(lever, force)) <= 1e-11);
  CHECK(glm::length(after.pose.position - 0.5 * 4.0 / b.mass * force) <=
        2 / 3600.0 * glm::length(force) / b.mass);
}
