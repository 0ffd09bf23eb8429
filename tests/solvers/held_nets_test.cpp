// Bridges and nets that pins hold besides their roots, with something on them.
#include <catch2/catch.hpp>
#include <vector>

#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

Collision touching() {
  Collision c;
  c.friction = 0.5, c.others = true;
  return c;
}

Entity add(World& w, const Shape& shape, const Pose& at, Real mass) {
  const Entity e = add_solid(w, shape, at, Motion::dynamic, touching(), 1);
  Body& b = w.bodies[e];
  b.inertia *= mass / b.mass, b.mass = mass, b.drag = 0.2;
  return e;
}

/// Planks between two posts, at first in a zigzag, longer than the way by `slack`, and crates that
/// fall on them.
World bridge(int planks, Real slack, PinKind kind = PinKind::exact) {
  World w;
  const Real way = 4, length = (1 + slack) * way / planks;
  Entity last;
  const Vec3 end(0.5 * length, 0, 0);
  for (int i = 0; i < planks; ++i) {
    const Real x = way * ((i + 0.5) / planks - 0.5), tilt = std::acos(1 / (1 + slack));
    const Pose pose{{x, 2 + 0.5 * length * std::sin(tilt), 0},
                    glm::angleAxis(i % 2 == 0 ? tilt : -tilt, Vec3(0, 0, 1))};
    const Entity e = add(w, box_shape({0.45 * length, 0.015, 0.4}), pose, 0.9);
    if (i == 0) {
      Pin pin;
      pin.body = e, pin.anchor = -end, pin.target = {-0.5 * way, 2, 0};
      w.add_pin(pin);
    } else {
      add_link(w, {last, e, {end, -end}});
    }
    last = e;
  }
  for (const Real z : {-0.3, 0.3}) {
    Pin pin;
    pin.body = last, pin.anchor = end + Vec3(0, 0, z), pin.target = {0.5 * way, 2, z};
    pin.kind = kind;
    w.add_pin(pin);
  }
  for (int i = 0; i < 6; ++i) {
    const Pose pose{{0.5 * i - 1.25, 2.7 + 0.3 * i, 0}, kIdentity};
    add(w, box_shape(Vec3(0.15)), pose, 8);
  }
  return w;
}

/// Rods between knots, held by the four corners, and a ball above it.
World net(int side, Real ball) {
  World w;
  const Real mesh = 0.2;
  std::vector<Entity> knots;
  const auto at = [&](int i, int k) {
    return mesh * Vec3(i - 0.5 * (side - 1), 0, k - 0.5 * (side - 1)) + Vec3(0, 2, 0);
  };
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      knots.push_back(add(w, ball_shape(0.02), {at(i, k), kIdentity}, 0.02));
      if (i % (side - 1) == 0 && k % (side - 1) == 0) w.bodies[knots.back()].motion = Motion::fixed;
    }
  const auto rod = [&](int from, int to, Vec3 middle, Quat turn) {
    const Entity e = add(w, rod_shape(0.012, 0.075), {middle, turn}, 0.02);
    add_link(w, {knots[static_cast<std::size_t>(from)], e, {Vec3(0), {0, -0.5 * mesh, 0}}});
    add_link(w, {e, knots[static_cast<std::size_t>(to)], {{0, 0.5 * mesh, 0}, Vec3(0)}});
  };
  const Quat along_x = glm::angleAxis(-0.5 * kPi, Vec3(0, 0, 1)),
             along_z = glm::angleAxis(0.5 * kPi, Vec3(1, 0, 0));
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      const int n = i * side + k;
      if (i + 1 < side) rod(n, n + side, 0.5 * (at(i, k) + at(i + 1, k)), along_x);
      if (k + 1 < side) rod(n, n + 1, 0.5 * (at(i, k) + at(i, k + 1)), along_z);
    }
  add(w, ball_shape(0.3), {{0.03, 2.5, 0.02}, kIdentity}, ball);
  return w;
}

struct Told {
  Real gap = 0, late = 0;  // m, of pins and joints; in the last second
  Real gained = 0;         // J, above the start
  Real lowest = 1e9;       // m, of the crates
};

Told run(World world, int crates, Real seconds, Real h) {
  Simulation sim(std::move(world), {h, 1, 1, true});
  Told told;
  const Real start = measure(sim.world).energy();
  const int steps = static_cast<int>(seconds / h);
  for (int i = 0; i < steps; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const World& w = sim.world;
    Real gap = 0;
    for (const auto& l : w.links.values())
      gap = std::max(gap, glm::length(residual(l.joint, w.bodies[l.a].pose, w.bodies[l.b].pose)));
    for (const Pin& p : w.pins.values())
      gap = std::max(gap, glm::length(to_world(w.bodies[p.body].pose, p.anchor) - p.target));
    told.gap = std::max(told.gap, gap);
    if (i >= steps - 1 / h) told.late = std::max(told.late, gap);
    told.gained = std::max(told.gained, measure(w).energy() - start);
  }
  const std::size_t n = sim.world.bodies.size();
  for (std::size_t k = n - static_cast<std::size_t>(crates); k < n; ++k)
    told.lowest = std::min(told.lowest, sim.world.bodies.values()[k].pose.position.y);
  return told;
}

}  // namespace

TEST_CASE("a bridge that pins hold at both ends stays shut under crates") {
  const int planks = GENERATE(8, 30);
  const Real slack = GENERATE(0.02, 0.2);
  INFO(planks << " planks, slack " << slack);
  const Told told = run(bridge(planks, slack), 6, 4, 1.0 / 60);
  CHECK(told.gap < 1e-4);
  CHECK(told.gained < 1e-3);
}

TEST_CASE("a net stretched flat and hung by its corners catches a ball") {
  const Real ball = GENERATE(1, 20);
  INFO("ball of " << ball << " kg");
  const Told told = run(net(6, ball), 1, 3, 1.0 / 60);
  CHECK(told.gap < 1e-2);
  CHECK(told.late < (ball > 10 ? 1e-2 : 1e-3));
  CHECK(told.gained < 1e-3);
  CHECK(told.lowest > 1.7);  // the ball
}

// Where the ball rolls to the edge, rods turn over within a step: gaps are closed by ever smaller
// turns then, or they would tear by 0.3 m.
TEST_CASE("a large net stays shut while a heavy ball rolls in it") {
  const Real aside = GENERATE(0.0, 0.1);
  INFO("ball " << aside << " m aside");
  World w = net(10, 20);
  for (Body& b : w.bodies.values()) b.drag = 0;
  w.bodies.values().back().pose.position += Vec3(aside, 0.1, 0);
  const Told told = run(std::move(w), 1, 4, 1.0 / 60);
  CHECK(told.gap < 2e-2);
  CHECK(told.gained < 1e-3);
  CHECK(told.lowest > 1.2);  // the ball
}
