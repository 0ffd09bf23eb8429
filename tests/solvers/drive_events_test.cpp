// Events that change the motions of exact drives.
#include "engine/runtime/save.hpp"
#include "tests/solvers/driven.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

void run_to(Simulation& sim, Real time) {
  while (sim.world.time < time - 1e-9) REQUIRE(sim.step().status == Status::ok);
}

Simulation started(Driven& d) {
  Simulation sim(std::move(d.world));
  sim.settings.h = 0.01;
  return sim;
}

}  // namespace

TEST_CASE("a drive goes on by the motion of an event, from where its joint stands") {
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  Driven d = pendulum(exactly({.speed = 9, .knots = {}}), solver);
  must(d.world.add(
      DriveEvent{.joint = d.joint, .motion = DriveMotion{.speed = -3, .knots = {}}, .at = 1}));
  Simulation sim = started(d);
  run_to(sim, 1);
  CHECK(sim.world.bodies[d.body].angular_velocity.z == Approx(9));
  for (int i = 1; i <= 100; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    CHECK(sim.world.bodies[d.body].angular_velocity.z == Approx(-3));
    const Real angle = 9 - 3 * 0.01 * i;
    CHECK(std::remainder(joint_angle(sim.world, d.joint) - angle, 2 * kPi) ==
          Approx(0).margin(1e-10));
  }
}

TEST_CASE("the time of an event's motion counts from the event") {
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  const bool stands = GENERATE(true, false);
  CAPTURE(static_cast<int>(solver), stands);
  DriveMotion first{.travels = true, .at_start = false, .speed = 0.5, .knots = {}};
  Driven d = cart(exactly(first), solver);
  DriveMotion motion{.travels = true,
                     .at_start = stands,
                     .offset = 0.2,
                     .speed = 0.1,
                     .amplitude = 0.3,
                     .frequency = 0.5,
                     .knots = {{0, 0}, {1, 0.5}}};
  must(d.world.add(
      DriveEvent{.joint = d.joint, .motion = motion, .max_torque = stands ? 1e300 : 1e6, .at = 1}));
  Simulation sim = started(d);
  run_to(sim, 1.5);
  // 0.5 m is where it stands at the event; `offset` is without effect then.
  const Real rise = 0.1 * 0.5 + 0.3 * std::sin(kPi / 2) + 0.25;
  CHECK(sim.world.joint_drives[d.joint].max_torque == (stands ? 1e300 : 1e6));
  if (stands) CHECK(joint_travel(sim.world, d.joint) == Approx(0.5 + rise).epsilon(1e-9));
  if (!stands) run_to(sim, 3);  // it has caught up
  if (!stands)
    CHECK(joint_travel(sim.world, d.joint) ==
          Approx(0.2 + 0.1 * 2 + 0.3 * std::sin(2 * kPi) + 0.5).epsilon(1e-6));
}

TEST_CASE("a drive that is turns behind stays where its joint stands") {
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  CAPTURE(static_cast<int>(solver));
  Driven d = pendulum(exactly({.speed = 20, .knots = {}}, 5), solver);
  must(d.world.add(
      DriveEvent{.joint = d.joint, .motion = DriveMotion{.knots = {}}, .max_torque = 50, .at = 2}));
  Simulation sim = started(d);
  run_to(sim, 2);
  CHECK(sim.world.joint_drives[d.joint].capped);
  const Real stood = joint_angle(sim.world, d.joint);
  run_to(sim, 4);
  CHECK_FALSE(sim.world.joint_drives[d.joint].capped);
  CHECK(joint_angle(sim.world, d.joint) == Approx(stood).margin(1e-9));
  CHECK(motor_force(sim.world, d.joint) == Approx(kG * std::sin(stood)).margin(1e-6));
}

TEST_CASE("a World with an event of a drive goes on from a file with the same bits") {
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  Driven d = pendulum(exactly(kSwing), solver);
  must(d.world.add(
      DriveEvent{.joint = d.joint, .motion = DriveMotion{.speed = 7, .knots = {}}, .at = 0.5}));
  Simulation sim = started(d);
  run_to(sim, 0.3);
  const auto bytes = world_to_bytes(sim.world);
  REQUIRE(bytes);
  auto loaded = world_from_bytes(*bytes);
  REQUIRE(loaded);
  Simulation twin(std::move(*loaded));
  twin.settings = sim.settings;
  run_to(sim, 1), run_to(twin, 1);
  CHECK(state_hash(sim.world) == state_hash(twin.world));
}

TEST_CASE("an event with a motion that no drive can follow is refused") {
  Driven d = pendulum(exactly(kSwing));
  const auto refused = [&](const DriveMotion& motion, const char* word) {
    const auto added = d.world.add(DriveEvent{.joint = d.joint, .motion = motion});
    REQUIRE_FALSE(added);
    CAPTURE(added.errors().front().message);
    CHECK(added.errors().front().message.find(word) != std::string::npos);
  };
  refused({.travels = true, .knots = {}}, "coordinate");
  refused({.speed = std::nan(""), .knots = {}}, "finite");
  refused({.knots = {{1, 0}, {0, 1}}}, "increase");
  d.world.joint_drives[d.joint].exact = false;
  refused({.speed = 1, .knots = {}}, "spring");
}

TEST_CASE("an event changes what it says alone, after earlier events too") {
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  Driven d = pendulum(exactly(kSwing, 80), solver);
  must(d.world.add(DriveEvent{.joint = d.joint, .max_torque = 50, .at = 0.1}));
  must(d.world.add(
      DriveEvent{.joint = d.joint, .motion = DriveMotion{.speed = 0.1, .knots = {}}, .at = 0.2}));
  Simulation sim = started(d);
  run_to(sim, 0.15);
  CHECK(sim.world.joint_drives[d.joint].max_torque == 50);
  run_to(sim, 1);
  CHECK(sim.world.joint_drives[d.joint].max_torque == 50);
  CHECK(joint_angular_speed(sim.world, d.joint) == Approx(0.1));
}

TEST_CASE("a drive on a turning body goes on from where its joint stands at the event") {
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  CAPTURE(static_cast<int>(solver));
  World w;
  w.default_settings.solver = solver;
  const Entity table = must(w.add(RigidBody{.motion = Motion::kinematic}));
  SteadyMotion turning;
  turning.angular_velocity = {0, 0, 3};
  w.paths.add(table, {turning});
  const Entity arm = must(
      w.add(RigidBody{.shape = SphereShape{0.1}, .mass = 1, .position = {0.5, 0, 0}, .drag = 0}));
  const Entity joint = must(w.add(HingeJoint{
      .a = table, .b = arm, .axis = {0, 0, 1}, .drive = exactly({.speed = 1, .knots = {}})}));
  must(w.add(DriveEvent{.joint = joint, .motion = DriveMotion{.knots = {}}, .at = 0.5}));
  Simulation sim(std::move(w));
  sim.settings.h = 0.01;
  run_to(sim, 1);
  CHECK(joint_angle(sim.world, joint) == Approx(0.5).margin(1e-9));
}
