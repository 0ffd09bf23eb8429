// Belts, rolling friction and pairs of materials in copies, hashes and files of a World.
#include <catch2/catch.hpp>
#include <limits>
#include <pantin/shapes.hpp>

#include "engine/contact/contact.hpp"
#include "engine/runtime/save.hpp"
#include "engine/runtime/simulation.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

/// A ball of material 1 that rolls over a belt of material 2 towards a wall.
World rolling_world() {
  World w;
  w.materials.resize(3);
  REQUIRE(w.add(MaterialPair{.a = 2, .b = 1, .friction = 0.7, .rolling = 0.002}));
  REQUIRE(w.add(RigidBody{.motion = Motion::fixed,
                          .shape = BoxShape{{5, 0.5, 5}},
                          .position = {0, -0.5, 0},
                          .collision = Collision{.spinning = 0.01, .surface_velocity = {0, 0, 0.3}},
                          .material = 2}));
  REQUIRE(w.add(RigidBody{.shape = SphereShape{0.1},
                          .position = {0, 0.1, 0},
                          .velocity = {1, 0, 0},
                          .angular_velocity = {0, 9, -10},
                          .collision = Collision{},
                          .material = 1,
                          .name = "ball"}));
  return w;
}

std::string error_of(World& w, const MaterialPair& pair) {
  const auto made = w.add(pair);
  return made ? "" : made.errors().front().message;
}

}  // namespace

TEST_CASE("a ball on a belt goes on from a copy and from a file as it would have") {
  Simulation sim(rolling_world(), {1.0 / 60});
  for (int i = 0; i < 30; ++i) sim.step();
  REQUIRE(contacts_of(sim.world).size() == 1);
  const Contact& c = contacts_of(sim.world)[0];
  CHECK((c.friction == 0.7 && c.rolling == 0.002 && c.spinning == 0.01));
  CHECK(c.torque_lambda != Vec3(0));
  const Result<std::string> bytes = world_to_bytes(sim.world);
  REQUIRE(bytes);
  const Result<World> read = world_from_bytes(*bytes, World{}, "test");
  REQUIRE(read);
  CHECK(state_hash(*read) == state_hash(sim.world));
  Simulation again = Simulation::copy_of(*read, {1.0 / 60}),
             copy = Simulation::copy_of(sim.world, {1.0 / 60});
  for (int i = 0; i < 60; ++i) {
    sim.step(), again.step(), copy.step();
    REQUIRE(state_hash(again.world) == state_hash(sim.world));
    REQUIRE(state_hash(copy.world) == state_hash(sim.world));
  }
}

TEST_CASE("the hash knows surfaces and, where pairs are given, what shapes are of") {
  const World w = rolling_world();
  const auto differs = [&](auto change) {
    World other = w;
    change(other);
    return state_hash(other) != state_hash(w);
  };
  const Entity ball = w.find("ball");
  CHECK_FALSE(differs([](World&) {}));
  CHECK(differs([&](World& o) { o.collisions[ball].rolling = 0.1; }));
  CHECK(differs([&](World& o) { o.collisions[ball].spinning = 0.1; }));
  CHECK(differs([&](World& o) { o.collisions[ball].surface_velocity.x = 1; }));
  CHECK(differs([](World& o) { o.material_pairs[0].friction = 0.1; }));
  CHECK(differs([](World& o) { o.material_pairs[0].rolling.reset(); }));
  CHECK(differs([&](World& o) { o.shapes[ball].list[0].material = 0; }));
  World plain = w, painted = w;
  plain.material_pairs.clear(), painted.material_pairs.clear();
  painted.shapes[ball].list[0].material = 0;
  CHECK(state_hash(plain) == state_hash(painted));
}

TEST_CASE("a World whose pairs name a material that is none is not written") {
  World w = rolling_world();
  w.material_pairs[0].a = 3;
  const Result<std::string> bytes = world_to_bytes(w);
  REQUIRE_FALSE(bytes);
  CHECK(bytes.errors().front().message.find("material_pairs name a material that does not exist") !=
        std::string::npos);
}

TEST_CASE("pairs of materials that cannot be meant are not added") {
  World w = rolling_world();
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  CHECK(error_of(w, {.a = 1, .b = 3, .friction = 1}) ==
        "MaterialPair: b: found 3, expected an index into World::materials");
  CHECK(
      error_of(w, {.a = 1, .b = 2, .friction = 1}) ==
      "MaterialPair: a and b: found two materials that already form a pair, expected another pair");
  for (const MaterialPair& bad :
       {MaterialPair{.a = 1, .b = 1, .friction = -1}, MaterialPair{.a = 1, .b = 1, .friction = nan},
        MaterialPair{.a = 1, .b = 1, .restitution = 1.5},
        MaterialPair{.a = 1, .b = 1, .rolling = -0.1},
        MaterialPair{.a = 1, .b = 1, .spinning = nan}})
    CHECK_FALSE(error_of(w, bad).empty());
  CHECK(w.material_pairs.size() == 1);
  CHECK(error_of(w, {.a = 1, .b = 1, .friction = 0}).empty());
}

TEST_CASE("bodies whose surface cannot be meant are not added") {
  World w;
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  const auto refused = [&](const Collision& c) {
    return !w.add(RigidBody{.shape = SphereShape{0.1}, .collision = c});
  };
  CHECK(refused({.rolling = -1}));
  CHECK(refused({.spinning = nan}));
  CHECK(refused({.surface_velocity = {0, nan, 0}}));
  CHECK_FALSE(refused({.rolling = 1, .spinning = 1, .surface_velocity = {0, 1, 0}}));
}
