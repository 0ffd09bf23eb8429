#include <array>
#include <catch2/catch.hpp>

#include "engine/runtime/simulation.hpp"
#include "tests/runtime/puppets.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

TEST_CASE("destroying a body takes the links, strings and pins that refer to it") {
  Puppet p = swaying_puppet();
  World& w = p.world;
  REQUIRE(w.links.size() == 2);
  REQUIRE(w.cables.size() == 3);
  REQUIRE(w.pins.size() == 2);
  w.destroy(p.left);
  CHECK_FALSE(w.is_alive(p.left));
  CHECK_FALSE(w.is_alive(p.link));
  CHECK_FALSE(w.is_alive(p.string));
  CHECK_FALSE(w.is_alive(p.pin));
  CHECK(w.links.size() == 1);
  CHECK(w.cables.size() == 2);
  CHECK(w.pins.size() == 1);
  CHECK_FALSE(w.find("pull"));
  CHECK_FALSE(w.find("left"));
  CHECK(w.find("right") == p.right);
}

TEST_CASE("destroying a link leaves its bodies") {
  Puppet p = swaying_puppet();
  p.world.destroy(p.link);
  CHECK(p.world.links.size() == 1);
  CHECK(p.world.is_alive(p.trunk));
  CHECK(p.world.is_alive(p.left));
}

TEST_CASE("destroying a kinematic body takes its path") {
  Puppet p = swaying_puppet();
  p.world.destroy(p.bar);
  CHECK(p.world.paths.empty());
  CHECK(p.world.cables.empty());
}

TEST_CASE("destroying dead, unknown and repeated handles harms nobody") {
  Puppet p = swaying_puppet();
  p.world.destroy(p.left);
  const Entity heir = p.world.create();
  const std::size_t bodies = p.world.bodies.size(), alive = p.world.entities.alive();
  const std::array<Entity, 4> nobody{p.left, Entity{}, Entity{12345, 6}, p.left};
  p.world.destroy(nobody);
  CHECK(p.world.bodies.size() == bodies);
  CHECK(p.world.entities.alive() == alive);
  CHECK(p.world.is_alive(heir));
}

TEST_CASE("a World goes on after part of it was destroyed") {
  Chain chain = hung_chain(6);
  Simulation simulation = Simulation::copy_of(chain.world);
  simulation.settings.measure = true;
  for (int i = 0; i < 20; ++i) simulation.step();
  simulation.world.destroy(chain.rods[3]);
  for (int i = 0; i < 20; ++i) {
    const StepReport report = simulation.step();
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.measures.worst_gap_rel <= 1e-12);
  }
  // What is left below the gap is in free fall, what is above still hangs.
  CHECK(simulation.world.bodies[chain.rods[5]].pose.position.y <
        simulation.world.bodies[chain.rods[2]].pose.position.y - 0.1);
}

TEST_CASE("names are found, and nameless entities have a number") {
  World world;
  const Entity named = world.add_body({}, "head"), nameless = world.add_body({});
  CHECK(world.find("head") == named);
  CHECK_FALSE(world.find("hat"));
  CHECK_FALSE(world.find(""));
  CHECK(world.name_of(named) == "head");
  CHECK(world.name_of(nameless) == "#1");
}

TEST_CASE("a push at a point turns the body about its mass centre") {
  World world;
  Body body;
  body.pose.position = {1, 0, 0};
  const Entity e = world.add_body(body);
  world.push(e, {0, 2, 0}, {4, 0, 0});
  world.push(e, {1, 0, 0}, {1, 0, 0});
  CHECK(world.forces[e].force == Vec3(1, 2, 0));
  CHECK(world.forces[e].torque == Vec3(0, 0, 6));
}

TEST_CASE("the pose of a body's own frame follows its mass centre") {
  World world;
  Body body;
  body.pose = {{1, 2, 3}, Quat(std::sqrt(0.5), 0, 0, std::sqrt(0.5))};  // a quarter turn about z
  const Entity e = world.add_body(body);
  CHECK(world.origin_pose(e).position == Vec3(1, 2, 3));
  world.origins.add(e, {{0.5, 0, 0}, Quat(1, 0, 0, 0)});
  CHECK(glm::length(world.origin_pose(e).position - Vec3(1, 2.5, 3)) < 1e-15);
}
