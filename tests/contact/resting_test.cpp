// Contacts of bodies at rest stay as they were; what comes finds them all the same.
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <tuple>

#include "engine/contact/memory.hpp"
#include "engine/runtime/simulation.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// Balls at rest in a square grid, and one aside.
struct Field {
  World world;
  std::vector<Entity> balls;
  Entity last;
};

Field field(int side) {
  Field f;
  add_ground(f.world);
  Collision solid;
  solid.others = true;
  const auto ball = [&](Vec3 at) {
    return add_solid(f.world, ball_shape(0.1), {at, kIdentity}, Motion::dynamic, solid);
  };
  for (int i = 0; i < side * side; ++i)
    f.balls.push_back(ball({0.5 * (i % side), 0.1, 0.5 * (i / side)}));
  f.last = ball({-1, 0.1, 0});
  return f;
}

/// Steps until all sleep.
Simulation at_rest(const World& world) {
  Simulation sim = Simulation::copy_of(world);
  for (int i = 0; i < 200; ++i) sim.step();
  REQUIRE(sim.step().asleep == static_cast<int>(world.bodies.size()) - 1);
  return sim;
}

void push(World& world, Entity body, Vec3 velocity) {
  world.bodies[body].velocity = velocity, world.bodies[body].restart = true;
}

}  // namespace

TEST_CASE("a World goes on as its copy does, which has no search to go on with") {
  const Field f = field(9);
  Simulation sim = at_rest(f.world);
  push(sim.world, f.last, {6, 0, 0.3});
  for (int i = 0; i < 120; ++i) {
    Simulation copy = Simulation::copy_of(sim.world);
    const StepReport report = sim.step();
    copy.step();
    REQUIRE(state_hash(copy.world) == state_hash(sim.world));
    if (i == 20) CHECK(report.asleep > 70);
    std::vector<Contact> contacts;
    each_contact(sim.world, [&](const Contact& c) { contacts.push_back(c); });
    const auto order = [](const Contact& c) { return std::tie(c.slot_a, c.slot_b, c.key); };
    for (std::size_t k = 1; k < contacts.size(); ++k)
      REQUIRE(order(contacts[k - 1]) < order(contacts[k]));
    // Every ball keeps the one contact that it has with the ground.
    const std::uint32_t ground = 0;
    CHECK(std::count_if(contacts.begin(), contacts.end(),
                        [&](const Contact& c) { return c.slot_b == ground; }) >= 70);
  }
  // It struck the first row.
  CHECK(sim.world.bodies[f.balls[0]].pose.position.x > 0.01);
}

TEST_CASE("sleeping bodies are found by fixed and kinematic ones that come") {
  const Field f = field(4);
  Simulation sim = at_rest(f.world);
  // A plate that is moved by hand, from above.
  Collision solid;
  solid.others = true;
  const Entity plate = add_solid(sim.world, box_shape({0.2, 0.02, 0.2}), {{0.5, 1, 0.5}, kIdentity},
                                 Motion::kinematic, solid);
  for (int i = 0; i < 200; ++i) sim.step();
  REQUIRE(sim.step().asleep == 17);
  Body& b = sim.world.bodies[plate];
  b.pose.position = {0.5, 0.1, 0.22}, b.teleport = true;
  sim.step();
  sim.world.bodies[plate].velocity = {0, 0, 1};
  for (int i = 0; i < 30; ++i) {
    sim.world.bodies[plate].pose.position.z += 1.0 / 60;
    sim.step();
  }
  CHECK(sim.world.bodies[f.balls[5]].pose.position.z > 0.7);  // it stood at 0.5
  CHECK(sim.world.bodies[f.balls[15]].pose.position.z == Approx(1.5).margin(1e-3));
}

TEST_CASE("a body that comes to rest among others is found again where it then lies") {
  const Field f = field(3);
  Simulation sim = at_rest(f.world);
  for (int round = 0; round < 3; ++round) {
    push(sim.world, f.last, {0.6, 0, 0});
    for (int i = 0; i < 600; ++i) sim.step();
  }
  each_contact(sim.world, [](const Contact& c) { CHECK(c.depth < 1e-3); });
  const Real x = sim.world.bodies[f.balls[2]].pose.position.x;
  CHECK(x > 1.0);  // the row was pushed on
}

TEST_CASE(
    "a shape whose size is none or that is out of reach collides with nothing, and stops nobody") {
  Field f = field(2);
  Shape& last = f.world.shapes[f.last].list[0];
  const auto falls_through = [&] {
    Simulation sim = Simulation::copy_of(f.world);
    for (int i = 0; i < 30; ++i) CHECK(sim.step().status == Status::ok);
    for (const Entity ball : f.balls)
      CHECK(sim.world.bodies[ball].pose.position.y == Approx(0.1).margin(1e-3));
    CHECK(sim.world.bodies[f.last].pose.position.y < -0.5);
  };
  SECTION("size none") {
    last.size.x = std::numeric_limits<Real>::quiet_NaN();
    falls_through();
  }
  SECTION("far away") {
    last.local.position.z = 2e183;
    falls_through();
  }
  SECTION("larger than anything") {
    last.size.x = 1e100;
    falls_through();
  }
}

TEST_CASE("a thin plate stops what a striker takes along, whether it came late or was there") {
  World w;
  w.gravity = Vec3(0);
  const Entity light = add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0, 0.5, 0}}, Motion::dynamic);
  const Entity heavy = add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0, 0.72, 0}}, Motion::dynamic);
  w.bodies[heavy].mass *= 80, w.bodies[heavy].inertia *= 80;
  Simulation sim(std::move(w));
  sim.step();
  add_solid(sim.world, box_shape({1, 0.02, 1}), {{0, 0.13, 0}}, Motion::fixed);
  sim.world.bodies[light].velocity = {0, -0.5, 0};
  sim.step();
  sim.world.bodies[heavy].velocity = {0, -30, 0};
  Simulation copy = Simulation::copy_of(sim.world);
  for (int i = 0; i < 8; ++i) {
    sim.step(), copy.step();
    CHECK(state_hash(copy.world) == state_hash(sim.world));
  }
  CHECK(sim.world.bodies[light].pose.position.y > 0.13);
  CHECK(copy.world.bodies[light].pose.position.y > 0.13);
}
