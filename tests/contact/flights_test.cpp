// Bodies that fly together touch one another as they would if they stood still.
#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/contact/memory.hpp"
#include "engine/runtime/simulation.hpp"
#include "tests/base/random.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

Collision solid() {
  Collision c;
  c.others = true, c.friction = 0.4;
  return c;
}

/// Solid balls and boxes in a loose cloud that collide at some m/s, and all fly at `common`.
struct Cloud {
  World world;
  std::vector<Entity> bodies;

  explicit Cloud(Vec3 common) {
    Random dice{5};
    world.gravity = Vec3(0);
    for (int i = 0; i < 27; ++i) {
      const Vec3 at{0.3 * (i % 3), 0.3 * (i / 3 % 3), 0.3 * (i / 9)};
      const Shape shape = i % 2 ? ball_shape(0.1) : box_shape({0.1, 0.08, 0.06});
      const Entity e = add_solid(world, shape, {at, kIdentity}, Motion::dynamic, solid());
      world.bodies[e].velocity = common + dice.in_cube(1.5);
      world.bodies[e].angular_velocity = dice.in_cube(3);
      bodies.push_back(e);
    }
  }
};

}  // namespace

TEST_CASE("a cloud of bodies collides in the same way whatever its common speed") {
  const auto run = [](Vec3 common, std::size_t& most) {
    Cloud cloud(common);
    Simulation sim(std::move(cloud.world));
    for (int i = 0; i < 12; ++i) {
      sim.step();
      most = std::max(most, contacts_of(sim.world).size());
    }
    std::vector<Vec3> places;
    for (const Entity e : cloud.bodies)
      places.push_back(sim.world.bodies[e].pose.position - sim.world.time * common);
    return places;
  };
  std::size_t most_still = 0, most_flying = 0;
  const std::vector<Vec3> still = run(Vec3(0), most_still);
  const std::vector<Vec3> flying = run({40, -10, 20}, most_flying);
  CHECK(most_still > 4);
  CHECK(most_flying <= 2 * most_still);
  // Contacts that are listed some steps earlier join bodies to one group earlier.
  for (std::size_t i = 0; i < still.size(); ++i) CHECK(glm::distance(still[i], flying[i]) < 2e-3);
}

TEST_CASE("a file of balls that flies into a wall stops in order, within the step of the blow") {
  for (const Real speed : {5.0, 20.0, 60.0}) {
    World world;
    world.gravity = Vec3(0);
    add_solid(world, box_shape({0.1, 2, 2}), {{0.1, 0, 0}, kIdentity}, Motion::fixed);
    std::vector<Entity> balls;
    for (int i = 0; i < 6; ++i) {
      balls.push_back(add_solid(world, ball_shape(0.1), {{-0.45 - 0.21 * i, 0, 0}, kIdentity},
                                Motion::dynamic, solid()));
      world.bodies[balls.back()].velocity = {speed, 0, 0};
    }
    Simulation sim(std::move(world));
    Real deepest = 0;
    for (int n = 0; n < 30; ++n) {
      sim.step();
      Real last = 0.1;
      for (const Entity e : balls) {
        const Real x = sim.world.bodies[e].pose.position.x;
        deepest = std::max(deepest, x - last + 0.2);
        last = x;
      }
    }
    INFO("speed " << speed << " m/s");
    CHECK(deepest < 0.05);
  }
}

TEST_CASE("balls beside one another that fly with a kinematic body touch it alone") {
  World world;
  const Entity head =
      add_solid(world, box_shape({0.3, 0.05, 0.3}), {{0, 1.05, 0}, kIdentity}, Motion::kinematic);
  std::vector<Entity> balls;
  for (int i = 0; i < 49; ++i) {
    const Vec3 at{0.08 * (i % 7) - 0.24, 0.98, 0.08 * (i / 7) - 0.24};
    balls.push_back(add_solid(world, ball_shape(0.02), {at, kIdentity}, Motion::dynamic, solid()));
    world.bodies[balls.back()].velocity = {0, -30, 0};
  }
  world.bodies[head].velocity = {0, -30, 0};
  Simulation sim(std::move(world));
  for (int n = 0; n < 20; ++n) {
    sim.step();
    CHECK(contacts_of(sim.world).size() <= 49);  // one each with the head at most
  }
}
