// Events of contacts.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>
#include <string>

using namespace pantin;
using namespace pantin::detail;

namespace {

Entity add_ground(World& world, std::uint32_t layers = 1) {
  return world
      .add(
          RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = in_layers(layers)})
      .value();
}

Entity add_ball(World& world, Vec3 at, Collision collision = {}) {
  return world
      .add(RigidBody{.shape = SphereShape{.radius = 0.1},
                     .mass = 2.0,
                     .position = at,
                     .collision = collision,
                     .drag = 0})
      .value();
}

char letter(ContactPhase phase) {
  return phase == ContactPhase::begin ? 'b' : phase == ContactPhase::persist ? 'p' : 'e';
}

}  // namespace

TEST_CASE("a ball that lies down begins once and goes on bearing its weight") {
  World world;
  const Entity ground = add_ground(world), ball = add_ball(world, {0, 0.3, 0});
  Simulation simulation(world);
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
  // The step of the impact overstates its load: 83.27 N s are told of the 78.48 that gravity gave.
  CHECK(impulse.y < -2 * 9.81 * 4);
  CHECK(impulse.y == Approx(-2 * 9.81 * 4).epsilon(0.08));
  CHECK(last.point.y == Approx(0).margin(1e-3));
}

TEST_CASE("a ball taken away ends its contact; one destroyed as well") {
  World world;
  add_ground(world);
  const Entity ball = add_ball(world, {0, 0.1, 0});
  Simulation simulation(world);
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
  Simulation simulation(world);
  ContactEvents events(simulation.world);
  simulation.step();
  events.update(simulation.world);
  REQUIRE(events.events().size() == 1);
  CHECK(events.events().front().b == other);
}
