// Sensors: what overlaps them is told, and nothing is pushed.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>
#include <string>

#include "tests/pantin/bodies.hpp"

using namespace pantin;
using namespace pantin::detail;
using test::add_ball;

namespace {

constexpr Collision kSensor{.sensor = true};

Entity add_box(World& world, Motion motion, Vec3 at, Vec3 half, Collision collision = kSensor) {
  return world
      .add(RigidBody{.motion = motion,
                     .shape = BoxShape{.half_extents = half},
                     .position = at,
                     .collision = collision})
      .value();
}

/// "12b3": begins, persists and ends (b, p, e) with the bodies' indices, in order.
std::string told(std::span<const ContactEvent> events) {
  std::string all;
  for (const ContactEvent& e : events) {
    const char* phase = e.phase == ContactPhase::begin     ? "b"
                        : e.phase == ContactPhase::persist ? "p"
                                                           : "e";
    all += (all.empty() ? "" : " ") + std::to_string(e.a.index) + phase + std::to_string(e.b.index);
  }
  return all;
}

}  // namespace

TEST_CASE(
    "a ball falls through a sensor: begin and end at the right steps, not a bit of it moved") {
  const Solver solver = GENERATE(Solver::articulated, Solver::lagrangian);
  CAPTURE(name_of(solver));
  World world, alone;
  world.default_settings.solver = alone.default_settings.solver = solver;
  const Entity ball = add_ball(world, {0, 1, 0});
  const Entity same = add_ball(alone, {0, 1, 0});
  const Entity gate = add_box(world, Motion::fixed, {0, 0, 0}, {1, 0.2, 1});
  Simulation simulation = Simulation::copy_of(world), without = Simulation::copy_of(alone);
  ContactEvents events(simulation.world);
  int begun = 0, persisted = 0, ended = 0;
  bool was_within = false;
  for (int i = 0; i < 90; ++i) {
    REQUIRE(simulation.step().status == Status::ok);
    without.step();
    const Body &b = simulation.world.bodies[ball], &free = without.world.bodies[same];
    REQUIRE(b.pose.position == free.pose.position);
    REQUIRE(b.velocity == free.velocity);
    const bool is_within = std::abs(b.pose.position.y) < 0.3;
    const auto list = events.update(simulation.world);
    REQUIRE(list.size() == (is_within || was_within ? 1u : 0u));
    for (const ContactEvent& e : list) {
      CHECK((e.a == gate && e.b == ball && e.is_sensor));
      CHECK(e.impulse == Vec3(0));
      CHECK(e.phase == (is_within && was_within ? ContactPhase::persist
                        : is_within             ? ContactPhase::begin
                                                : ContactPhase::end));
      begun += e.phase == ContactPhase::begin, ended += e.phase == ContactPhase::end;
      persisted += e.phase == ContactPhase::persist;
      if (e.phase == ContactPhase::begin) {
        CHECK(e.depth == Approx(0.3 - b.pose.position.y));
        CHECK(e.normal.y == Approx(-1));
        CHECK(e.point.y == Approx(b.pose.position.y - 0.1));
      }
    }
    was_within = is_within;
  }
  CHECK((begun == 1 && persisted > 2 && ended == 1));
}

TEST_CASE("a sensor tells the bodies of two islands, each pair once, and no sensor") {
  World world;
  world.gravity = Vec3(0);
  const Entity gate = add_box(world, Motion::fixed, {0, 0, 0}, {1, 1, 1});
  // A pendulum of two balls, one without, one within; a single ball; a second sensor.
  const Entity out = add_ball(world, {0, 3, 0}), in = add_ball(world, {0, 0.5, 0});
  world.add(BallJoint{.a = out, .b = in, .anchor = {0, 2, 0}}).value();
  const Entity single = add_ball(world, {0.5, 0, 0});
  add_box(world, Motion::kinematic, {0, 0, 0}, {1, 1, 1});
  add_box(world, Motion::fixed, {-1, -1, -1}, {0.2, 0.2, 0.2}, {});  // both fixed: not told
  Simulation simulation = Simulation::copy_of(world);
  ContactEvents events(simulation.world);
  simulation.step();
  events.update(simulation.world);
  std::string seen;
  for (const ContactEvent& e : events.events())
    if (e.is_sensor && e.a == gate) seen += std::to_string(e.b.index) + ' ';
  CHECK(seen == std::to_string(in.index) + ' ' + std::to_string(single.index) + ' ');
}

TEST_CASE("a sensor on a kinematic body that passes balls, and one that a joint carries") {
  World world;
  world.gravity = Vec3(0);
  const Entity cart = add_box(world, Motion::kinematic, {-1, 0, 0}, {0.2, 0.2, 0.2});
  world.paths.add(cart, KinematicPath{Keyframes{{{.time = 0, .pose = {{-1, 0, 0}, kIdentity}},
                                                 {.time = 1, .pose = {{1, 0, 0}, kIdentity}}}}});
  const Entity hand =
      world
          .add(RigidBody{
              .shape = SphereShape{.radius = 0.05}, .position = {-1, 0.5, 0}, .collision = kSensor})
          .value();
  world.add(FixedJoint{.a = cart, .b = hand}).value();
  const Entity ball = add_ball(world, {0, 0, 0}), above = add_ball(world, {0.2, 0.5, 0});
  const Entity wall = add_box(world, Motion::fixed, {0.8, 0.5, 0}, {0.05, 0.1, 0.1}, {});
  Simulation simulation = Simulation::copy_of(world);
  ContactEvents events(simulation.world);
  std::string cart_saw, hand_saw;
  for (int i = 0; i < 75; ++i) {
    simulation.step();
    for (const ContactEvent& e : events.update(simulation.world)) {
      if (e.phase == ContactPhase::persist) continue;
      (e.a == cart ? cart_saw : hand_saw) +=
          (e.phase == ContactPhase::begin ? '+' : '-') + std::to_string(e.b.index) + ' ';
    }
  }
  const auto passed = [](Entity e) {
    return '+' + std::to_string(e.index) + " -" + std::to_string(e.index) + ' ';
  };
  CHECK(cart_saw == passed(ball));
  CHECK(hand_saw == passed(above) + passed(wall));
  CHECK(simulation.world.bodies[ball].velocity == Vec3(0));
}

TEST_CASE("a plane as a sensor tells what is below it; layers that do not agree see nothing") {
  World world;
  const Collision below =
      in_layers(collision_layer(1), collision_layer(2), Collision{.sensor = true});
  const Entity sea =
      world.add(RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = below})
          .value();
  const Entity seen = add_ball(world, {0, -0.5, 0}, in_layers(collision_layer(2)));
  add_ball(world, {1, -0.5, 0}, in_layers(collision_layer(3)));
  add_ball(world, {2, -0.5, 0}, in_layers(collision_layer(2), collision_layer(2)));
  Simulation simulation = Simulation::copy_of(world);
  ContactEvents events(simulation.world);
  simulation.step();
  events.update(simulation.world);
  REQUIRE(events.events().size() == 1);
  CHECK((events.events()[0].a == sea && events.events()[0].b == seen));
  CHECK(events.events()[0].normal.y == Approx(-1));
  CHECK(events.events()[0].depth == Approx(0.6).epsilon(0.01));
}

TEST_CASE("a copy, and a World saved and loaded, tell the same events from there on") {
  World world;
  world.add(RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}})
      .value();
  for (int i = 0; i < 4; ++i) add_ball(world, {0.35 * i, 0.3 + 0.6 * i, 0});
  for (int i = 0; i < 3; ++i) add_box(world, Motion::fixed, {0.4 * i, 0.5, 0}, {0.35, 0.2, 0.2});
  Simulation one = Simulation::copy_of(world);
  for (int i = 0; i < 20; ++i) one.step();
  REQUIRE_FALSE(sensor_overlaps_of(one.world).empty());
  Simulation copy = Simulation::copy_of(one.world);
  Simulation loaded(world_from_bytes(world_to_bytes(one.world).value()).value());
  ContactEvents first(one.world), second(copy.world), third(loaded.world);
  std::size_t changes = 0;
  for (int i = 0; i < 100; ++i) {
    one.step(), copy.step(), loaded.step();
    const std::string now = told(first.update(one.world));
    changes += now.find_first_of("be") != std::string::npos;
    REQUIRE(told(second.update(copy.world)) == now);
    REQUIRE(told(third.update(loaded.world)) == now);
    REQUIRE(state_hash(loaded.world) == state_hash(one.world));
    REQUIRE(sensor_overlaps_of(copy.world).size() == sensor_overlaps_of(one.world).size());
  }
  CHECK(changes > 3);
}

TEST_CASE("a body that sleeps within a sensor goes on being told; one destroyed ends") {
  World world;
  world.add(RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}})
      .value();
  const Entity ball = add_ball(world, {0, 0.1, 0});
  const Entity gate = add_box(world, Motion::fixed, {0, 0.2, 0}, {1, 0.2, 1});
  Simulation simulation = Simulation::copy_of(world);
  ContactEvents events(simulation.world);
  int asleep = 0;
  const auto pair = std::to_string(gate.index), who = std::to_string(ball.index);
  for (int i = 0; i < 120; ++i) {
    asleep += simulation.step().asleep;
    const std::string now = told(events.update(simulation.world));
    REQUIRE(now.find(pair + (i == 0 ? "b" : "p") + who) != std::string::npos);
  }
  CHECK(asleep > 30);
  simulation.world.destroy(ball);
  CHECK(told(events.update(simulation.world)).find(pair + "e" + who) != std::string::npos);
  simulation.step();
  CHECK(events.update(simulation.world).empty());
}

TEST_CASE("what lies on a body falls when that becomes a sensor; rays pass it") {
  World world;
  const Entity table = add_box(world, Motion::fixed, {0, 0, 0}, {1, 0.1, 1}, {});
  const Entity ball = add_ball(world, {0, 0.2, 0});
  Simulation simulation = Simulation::copy_of(world);
  for (int i = 0; i < 120; ++i) simulation.step();
  CHECK(simulation.world.bodies[ball].pose.position.y == Approx(0.2).margin(1e-3));
  const Ray down{{0.5, 1, 0}, {0, -2, 0}};
  CHECK(Queries(simulation.world).cast_ray(down));
  simulation.world.collisions[table].sensor = true;
  simulation.world.mark_dirty();
  CHECK_FALSE(Queries(simulation.world).cast_ray(down));
  for (int i = 0; i < 60; ++i) simulation.step();
  CHECK(simulation.world.bodies[ball].pose.position.y < -1);
}
