// Sensors of points, distances, angles and forces, against closed forms; and from scene files.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>
#include <pantin/scene.hpp>

using namespace pantin;
using namespace pantin::detail;

namespace {

constexpr Real kG = 9.81;

Entity box(World& world, Motion motion, Vec3 at) {
  return must(world.add(RigidBody{
      .motion = motion, .shape = BoxShape{{0.1, 0.1, 0.1}}, .mass = 2, .position = at, .drag = 0}));
}

Vec3 read(const World& world, SensorKind kind, SensorPoint a, SensorPoint b = {}) {
  Sensor sensor{.kind = kind, .a = a, .b = b};
  return read_sensor(world, sensor);
}

}  // namespace

TEST_CASE("an accelerometer shows nothing in free fall, and weight at rest") {
  World world;
  const Entity falling = box(world, Motion::dynamic, {0, 5, 0}),
               still = box(world, Motion::fixed, {1, 5, 0});
  Simulation sim(std::move(world));
  Sensor in_fall{.kind = SensorKind::accelerometer, .a = {falling, {0.1, 0, 0}}},
      at_rest{.kind = SensorKind::accelerometer, .a = {still}},
      plain{.kind = SensorKind::acceleration, .a = {falling}};
  CHECK(std::isnan(read_sensor(sim.world, in_fall).x));
  read_sensor(sim.world, at_rest), read_sensor(sim.world, plain);
  for (int i = 0; i < 5; ++i) {
    sim.step();
    CHECK(glm::length(read_sensor(sim.world, in_fall)) < 1e-9);
    CHECK(glm::length(read_sensor(sim.world, at_rest) - Vec3(0, kG, 0)) < 1e-12);
    CHECK(glm::length(read_sensor(sim.world, plain) - Vec3(0, -kG, 0)) < 1e-9);
  }
}

TEST_CASE("points, velocities, distances and angles of bodies that turn") {
  World world;
  world.gravity = Vec3(0);
  const Entity wheel = box(world, Motion::dynamic, {0, 0, 0}),
               post = box(world, Motion::fixed, {2, 0, 0});
  world.bodies[wheel].angular_velocity = {0, 0, 3};
  Simulation sim(std::move(world));
  sim.settings.h = 1e-3;
  Sensor pull{.kind = SensorKind::acceleration, .a = {wheel, {0.5, 0, 0}}};
  for (int i = 0; i < 200; ++i) {
    sim.step();
    read_sensor(sim.world, pull);
  }
  sim.step();
  const Real angle = 3 * sim.world.time;
  const Vec3 arm{0.5 * std::cos(angle), 0.5 * std::sin(angle), 0};
  const SensorPoint rim{wheel, {0.5, 0, 0}};
  CHECK(glm::length(read(sim.world, SensorKind::point, rim) - arm) < 1e-6);
  CHECK(glm::length(read(sim.world, SensorKind::velocity, rim) - 3.0 * Vec3(-arm.y, arm.x, 0)) <
        1e-5);
  // Centripetal, at the middle of the step.
  const Vec3 middle{0.5 * std::cos(angle - 1.5e-3), 0.5 * std::sin(angle - 1.5e-3), 0};
  CHECK(glm::length(read_sensor(sim.world, pull) + 9.0 * middle) < 1e-5);
  CHECK(read(sim.world, SensorKind::distance, rim, {post}).x ==
        Approx(glm::length(Vec3(2, 0, 0) - arm)));
  CHECK(read(sim.world, SensorKind::angle, {post}, {wheel}).x == Approx(angle));
  Sensor seen{.kind = SensorKind::angle, .a = {post}, .b = {wheel}, .c = rim, .by_points = true};
  CHECK(read_sensor(sim.world, seen).x == Approx(angle));
  sim.world.destroy(wheel);
  CHECK(std::isnan(read(sim.world, SensorKind::point, rim).x));
  CHECK(std::isnan(read(sim.world, SensorKind::distance, rim, {post}).x));
}

TEST_CASE("forces of a joint and of contacts bear the weight") {
  World world;
  world.default_settings.solver = GENERATE(Solver::articulated, Solver::lagrangian);
  const Entity ground = must(world.add(RigidBody{
      .motion = Motion::fixed, .shape = BoxShape{{5, 0.1, 5}}, .position = {0, -0.1, 0}}));
  const Entity stands = box(world, Motion::dynamic, {0, 0.1, 0}),
               hangs = box(world, Motion::dynamic, {2, 2, 0});
  for (const Entity e : {ground, stands}) world.collisions.add(e, {});
  const Entity joint = must(world.add(BallJoint{.a = ground, .b = hangs, .anchor = {2, 2.5, 0}}));
  Simulation sim(std::move(world));
  for (int i = 0; i < 20; ++i) sim.step();
  const Vec3 weight{0, 2 * kG, 0};
  CHECK(glm::length(read(sim.world, SensorKind::contact, {stands}) - weight) < 1e-3);
  CHECK(glm::length(read(sim.world, SensorKind::contact, {ground}) + weight) < 1e-3);
  CHECK(glm::length(read(sim.world, SensorKind::force, {joint}) - weight) < 1e-6);
  CHECK(glm::length(read(sim.world, SensorKind::torque, {joint})) < 1e-6);
  CHECK(std::isnan(read(sim.world, SensorKind::motor, {joint}).x));
}

namespace {

std::string scene_with(const std::string& sensors) {
  return R"({"version": 1, "bodies": [
    {"name": "arm", "position": [1, 0, 0], "shape": {"type": "sphere", "radius": 0.1, "position": [0.5, 0, 0]}}],
    "joints": [{"name": "hinge", "kind": "hinge", "a": "world", "b": "arm", "anchor": [0, 0, 0], "axis": [0, 0, 1],
                "motor": {"position": 0}}],
    "sensors": [)" +
         sensors + "]}";
}

std::string error_of(const std::string& sensors) {
  const auto scene = parse_scene(scene_with(sensors), "s.json");
  REQUIRE_FALSE(scene);
  return scene.errors().front().message;
}

}  // namespace

TEST_CASE("sensors of a scene file measure from the bodies' own frames") {
  const auto scene = parse_scene(
      scene_with(R"({"name": "tip", "type": "point", "body": "arm", "anchor": [0.25, 0, 0]},
                    {"name": "far", "type": "distance", "body": "arm", "to": "world", "to_anchor": [1, 2, 0]},
                    {"name": "effort", "type": "motor", "joint": "hinge"})"),
      "s.json");
  REQUIRE(scene);
  std::vector<Sensor> sensors = scene->sensors;
  REQUIRE(sensors.size() == 3);
  CHECK(glm::length(read_sensor(scene->world, sensors[0]) - Vec3(1.25, 0, 0)) < 1e-12);
  CHECK(read_sensor(scene->world, sensors[1]).x == Approx(2));
  CHECK(components_of(sensors[2].kind) == 1);
}

TEST_CASE("faulty sensors are told with their place") {
  CHECK(error_of(R"({"name": "t", "type": "point", "body": "leg"})").find("\"leg\"") !=
        std::string::npos);
  CHECK(error_of(R"({"name": "t", "type": "point"})").find("found no \"body\"") !=
        std::string::npos);
  CHECK(error_of(R"({"name": "t", "type": "motor", "body": "arm", "joint": "hinge"})")
            .find("found \"body\" of a sensor of type motor") != std::string::npos);
  CHECK(error_of(R"({"name": "t", "type": "distance", "body": "arm"})").find("found no \"to\"") !=
        std::string::npos);
  CHECK(error_of(R"({"name": "arm", "type": "point", "body": "arm"})").find("arm") !=
        std::string::npos);
  CHECK(
      error_of(R"({"name": "t", "type": "motor", "joint": "knee"})").find("the name of a joint") !=
      std::string::npos);
}
