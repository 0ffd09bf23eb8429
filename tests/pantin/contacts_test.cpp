// Events of contacts.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>
#include <string>

#include "tests/pantin/bodies.hpp"

using namespace pantin;
using namespace pantin::detail;
using test::add_ball;

namespace {

Entity add_ground(World& world, std::uint32_t layers = 1) {
  return world
      .add(
          RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = in_layers(layers)})
      .value();
}

char letter(ContactPhase phase) {
  return phase == ContactPhase::begin ? 'b' : phase == ContactPhase::persist ? 'p' : 'e';
}

}  // namespace

TEST_CASE("a ball that lies down begins once and goes on bearing its weight") {
  World world;
  const Entity ground = add_ground(world), ball = add_ball(world, {0, 0.3, 0});
  Simulation simulation = Simulation::copy_of(world);
  ContactEvents events(simulation.world);
  int begun = 0, ended = 0;
  Vec3 impulse(0);
  for (int i = 0; i < 240; ++i) {
    REQUIRE(simulation.step().status == Status::ok);
    for (const ContactEvent& e : events.update(simulation.world)) {
      CHECK((e.a == ground && e.b == ball));
      begun += e.phase == ContactPhase::begin, ended += e.phase == ContactPhase::end;
      impulse += e.impulse;
    }
  }
  CHECK(begun == 1);
  CHECK(ended == 0);
  REQUIRE(events.events().size() == 1);
  const ContactEvent& last = events.events().front();
  CHECK(last.phase == ContactPhase::persist);
  // On the ground, downwards.
  CHECK(last.normal.y == Approx(-1));
  CHECK(last.impulse.y == Approx(-2 * 9.81 / 60).epsilon(0.01));
  // What gravity gave in that time, the ground gave back.
  CHECK(impulse.y == Approx(-2 * 9.81 * 4).epsilon(0.002));
  CHECK(last.point.y == Approx(0).margin(1e-3));
}

TEST_CASE("impulses are what momentum changes by, at every bounce and for whatever falls") {
  const Real bounce = GENERATE(0.0, 0.5, 0.9);
  const bool is_box = GENERATE(false, true);
  CAPTURE(bounce, is_box);
  World world;
  add_ground(world);
  RigidBody described{.mass = 2.0,
                      .position = {0, 0.8, 0},
                      .velocity = {0.5, -1, 0},
                      .collision = Collision{.friction = 0.3, .restitution = bounce},
                      .drag = 0};
  if (is_box) {
    described.shape = BoxShape{.half_extents = {0.2, 0.1, 0.15}};
    described.rotation = glm::normalize(Quat(1, 0.2, 0.1, 0.4));
  } else {
    described.shape = SphereShape{.radius = 0.1};
  }
  const Entity body = world.add(described).value();
  Simulation simulation = Simulation::copy_of(world);
  ContactEvents events(simulation.world);
  Vec3 before = described.velocity;
  Real hardest = 0;
  for (int i = 1; i <= 180; ++i) {
    const StepReport report = simulation.step();
    REQUIRE(report.status == Status::ok);
    Vec3 impulse(0);  // on b, the body
    for (const ContactEvent& e : events.update(simulation.world)) impulse -= e.impulse;
    hardest = std::max(hardest, glm::length(impulse));
    const Vec3 now = simulation.world.bodies[body].velocity;
    const Vec3 gained = 2.0 * (now - before), weight(0, -2 * 9.81 / 60, 0);
    before = now;
    // Where energy is limited, velocities are scaled without a force.
    if (report.limited == 0) REQUIRE(glm::length(impulse - (gained - weight)) < 0.08);
  }
  CHECK(hardest > (is_box ? 4 : 7));  // of the first impact, at 3.8 m/s; a box falls on a corner
}

TEST_CASE("a ball taken away ends its contact; one destroyed as well") {
  World world;
  add_ground(world);
  const Entity ball = add_ball(world, {0, 0.1, 0});
  Simulation simulation = Simulation::copy_of(world);
  ContactEvents events(simulation.world);
  std::string phases;
  const auto step = [&] {
    simulation.step();
    for (const ContactEvent& e : events.update(simulation.world)) phases += letter(e.phase);
    phases += ' ';
  };
  step(), step();
  simulation.world.teleport(ball, {{0, 5, 0}});
  step(), step();
  simulation.world.teleport(ball, {{0, 0.1, 0}});
  step();
  simulation.world.destroy(ball);
  step(), step();
  CHECK(phases == "b p e  b e  ");
}

TEST_CASE("layers that do not agree do not touch") {
  World world;
  add_ground(world, collision_layer(3));
  add_ball(world, {0, 0.1, 0}, in_layers(collision_layer(1), collision_layer(2)));
  const Entity other =
      add_ball(world, {1, 0.1, 0}, in_layers(collision_layer(1), collision_layer(3)));
  Simulation simulation = Simulation::copy_of(world);
  ContactEvents events(simulation.world);
  simulation.step();
  events.update(simulation.world);
  REQUIRE(events.events().size() == 1);
  CHECK(events.events().front().b == other);
}
