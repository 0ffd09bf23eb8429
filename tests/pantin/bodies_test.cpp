// Bodies made of shapes.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/base/rotation.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

std::string complaint(const RigidBody& described) {
  World world;
  const Result<Entity> made = world.add(described);
  CHECK(world.bodies.size() == (made ? 1 : 0));
  return made ? "" : made.errors().front().message;
}

}  // namespace

TEST_CASE("mass, inertia and principal frame follow from shapes and density") {
  World world;
  const Quat rotation = from_rotation_vector(Vec3(0.2, 0.5, -0.7));
  const Entity e = world
                       .add(RigidBody{.shape = BoxShape{.half_extents = {0.1, 0.2, 0.3}},
                                      .density = 500,
                                      .position = {1, 2, 3},
                                      .rotation = rotation,
                                      .name = "brick"})
                       .value();
  const Body& b = world.bodies[e];
  CHECK(b.mass == Approx(500 * 8 * 0.006));
  CHECK(b.inertia.x == Approx(b.mass / 3 * (0.04 + 0.09)));
  CHECK(b.pose.position == Vec3(1, 2, 3));
  CHECK(b.pose.rotation == rotation);
  CHECK(world.find("brick") == e);
}

TEST_CASE("a body of two shapes is placed by its own frame, not by its mass centre") {
  World world;
  const Entity e = world
                       .add(RigidBody{.shape = SphereShape{.radius = 0.1},
                                      .shapes = {SphereShape{.radius = 0.1, .at = {{1, 0, 0}}}},
                                      .position = {5, 0, 0}})
                       .value();
  CHECK(world.bodies[e].pose.position.x == Approx(5.5));
  CHECK(glm::length(world.origin_pose(e).position - Vec3(5, 0, 0)) < 1e-14);
  // Both balls stand where they were put.
  const Body& b = world.bodies[e];
  CHECK(glm::length(to_world(b.pose, world.shapes[e].list[1].local.position) - Vec3(6, 0, 0)) <
        1e-14);
}

TEST_CASE("a mass that is given scales what the shapes weigh") {
  World world;
  const Entity e = world.add(RigidBody{.shape = SphereShape{.radius = 0.5}, .mass = 3.0}).value();
  CHECK(world.bodies[e].mass == Approx(3));
  CHECK(world.bodies[e].inertia.x == Approx(0.4 * 3 * 0.25));
}

TEST_CASE("bodies that cannot be are refused") {
  CHECK(complaint({.shape = SphereShape{.radius = 1}, .density = -3, .name = "door"}) ==
        "RigidBody 'door': density: found -3, expected a number above 0");
  CHECK(complaint({.shape = SphereShape{}}) ==
        "RigidBody: shape.radius: found 0, expected a number above 0");
  CHECK(complaint({.shape = PlaneShape{}}) ==
        "RigidBody: shape: found a plane on a dynamic body, expected a sphere, a capsule, a "
        "cylinder, a cone, an ellipsoid, a box or a hull");
  CHECK(complaint({.mass = 1.0}) ==
        "RigidBody: inertia: found none, and no shape, expected an inertia, or a shape that "
        "determines it");
  CHECK(complaint({.mass = 1.0, .inertia = Mat3(1, 0, 0, 0, 1, 0, 0, 0, 5)}) ==
        "RigidBody: mass and inertia: found 1 kg, (1, 1, 5) kg m^2, expected a finite mass above 0 "
        "and three moments, each at most the sum of the others");
  CHECK(complaint({.shape = SphereShape{.radius = 1}, .rotation = {0, 0, 0, 0}}) ==
        "RigidBody: rotation: found (w 0, x 0, y 0, z 0), expected a quaternion that is not zero");
  CHECK(complaint({.shape = SphereShape{.radius = 1}, .material = 7}) ==
        "RigidBody: material: found 7, expected an index into World::materials");
  const RigidBody flat{.shape = HullShape{.points = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 0, 1}}}};
  CHECK(complaint(flat).find("RigidBody: shape: found ") == 0);
}
