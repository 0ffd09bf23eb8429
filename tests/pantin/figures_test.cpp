// Chains and ragdolls in one call.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/base/rotation.hpp"

using namespace pantin;
using namespace pantin::detail;

TEST_CASE("a chain hangs from what holds its ends, closed from the start") {
  World world;
  const Entity left = world.add(RigidBody{.motion = Motion::fixed}).value();
  const Entity right = world.add(RigidBody{.motion = Motion::fixed, .position = {1, 1, 0}}).value();
  const auto joint = GENERATE(ChainJoint::ball, ChainJoint::universal);
  const Chain chain = build_chain(world, {.from = {0, 0, 0},
                                          .to = {1, 1, 0},
                                          .links = 12,
                                          .start = left,
                                          .end = right,
                                          .joint = joint,
                                          .name = "chain"})
                          .value();
  CHECK(chain.links.size() == 12);
  CHECK(chain.joints.size() == 13);
  CHECK(world.find("chain/11") == chain.links.back());
  CHECK(measure(world).worst_gap < 1e-15);
  Simulation simulation = Simulation::copy_of(world, {.measure = true});
  for (int i = 0; i < 120; ++i) {
    const StepReport report = simulation.step();
    REQUIRE(report.status == Status::ok);
    // The method for other joints than balls lets the second end of a taut chain give way.
    REQUIRE(report.measures.worst_gap < (joint == ChainJoint::ball ? 1e-6 : 0.02));
  }
}

TEST_CASE("a chain that cannot be is refused and leaves nothing behind") {
  World world;
  const auto chain = build_chain(world, {.to = {1, 0, 0}, .links = 10, .radius = 0.06});
  REQUIRE_FALSE(chain);
  CHECK(chain.errors().front().message ==
        "Chain: radius: found 0.06, expected less than half a link, 0.05");
  // Found only while building: the density is the bodies' business.
  CHECK_FALSE(build_chain(world, {.to = {1, 0, 0}, .links = 3, .density = -1}));
  CHECK(world.entities.alive() == 0);
}

TEST_CASE("a ragdoll stands where it is put, weighs what it should and has human ranges") {
  World world;
  const Quat rotation = from_rotation_vector(Vec3(0, 1.2, 0));
  const Ragdoll doll =
      build_ragdoll(
          world,
          {.position = {3, 0.5, 1}, .rotation = rotation, .height = 1.5, .mass = 40, .name = "ann"})
          .value();
  CHECK(world.bodies.size() == 13);
  CHECK(doll.bodies().size() == 13);
  CHECK(doll.joints().size() == 12);
  CHECK(world.find("ann/shin_l") == doll.shins[0]);
  Real mass = 0;
  for (const Body& b : world.bodies.values()) mass += b.mass;
  CHECK(mass == Approx(40));
  CHECK(world.bodies[doll.head].pose.position.y == Approx(0.5 + 1.65 * 1.5 / 1.76));
  for (const Entity e : doll.joints()) {
    const Link& link = world.links[e];
    CHECK(glm::length(residual(link.joint, world.bodies[link.a].pose, world.bodies[link.b].pose)) <
          1e-14);
    const Quat q = relative_rotation(link.joint, world.bodies[link.a].pose.rotation,
                                     world.bodies[link.b].pose.rotation);
    CHECK(violation(link.joint, q) < 1e-9);  // upright lies within all ranges
  }
}

TEST_CASE("a ragdoll falls onto the ground and stays whole") {
  World world;
  const RigidBody ground{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}};
  REQUIRE(world.add(ground));
  const Ragdoll doll = build_ragdoll(world, {.position = {0, 0.3, 0}}).value();
  Simulation simulation = Simulation::copy_of(world, {.measure = true});
  for (int i = 0; i < 240; ++i) {
    const StepReport report = simulation.step();
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.measures.worst_gap < 1e-9);
  }
  const Real head = simulation.world.bodies[doll.head].pose.position.y;
  CHECK(head > 0);
  CHECK(head < 1.2);
}
