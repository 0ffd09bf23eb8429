// Loops over entities that have several components.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>
#include <type_traits>

using namespace pantin;
using namespace pantin::detail;

namespace {

struct Wind {
  Real strength = 0;
};

}  // namespace

TEST_CASE("a view visits the entities that have all components, in the order of the first") {
  World world;
  std::vector<Entity> bodies;
  for (int i = 0; i < 5; ++i) bodies.push_back(world.add_body({}));
  for (int i : {4, 1, 3}) world.collisions.add(bodies[std::size_t(i)], {});
  world.store<Wind>().add(bodies[3], {3}), world.store<Wind>().add(bodies[4], {4});
  world.store<Wind>().add(bodies[0], {5});

  std::vector<Entity> seen;
  for (auto [entity, body, collision] : world.view<Body, Collision>()) {
    seen.push_back(entity);
    body.mass = 7, collision.friction = 0.25;
  }
  CHECK(seen == std::vector<Entity>{bodies[1], bodies[3], bodies[4]});
  CHECK(world.bodies[bodies[1]].mass == 7);
  CHECK(world.bodies[bodies[0]].mass == 1);
  CHECK(world.collisions[bodies[4]].friction == 0.25);

  seen.clear();
  for (auto [entity, collision, wind, body] : world.view<Collision, Wind, Body>()) {
    seen.push_back(entity);
    wind.strength += body.mass * collision.friction;
  }
  CHECK(seen == std::vector<Entity>{bodies[4], bodies[3]});
  CHECK(world.store<Wind>()[bodies[4]].strength == 4 + 7 * 0.25);
}

TEST_CASE("a view of a const World is const, and knows no store that nobody made") {
  World world;
  world.add_body({});
  const World& seen = world;
  for (auto [entity, body] : seen.view<Body>()) {
    static_assert(std::is_same_v<decltype(body), const Body&>);
    CHECK(entity);
  }
  CHECK_FALSE(seen.view<Body>().empty());
  CHECK(seen.view<Body, Wind>().empty());
  CHECK(seen.view<Wind, Body>().empty());
  CHECK(world.view<Wind>().empty());
}
