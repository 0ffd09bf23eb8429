// Exact drives against closed forms.
#include "tests/solvers/driven.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

TEST_CASE("a drive's motion has the derivatives that it says, and passes its knots") {
  DriveMotion motion;
  motion.offset = 0.2, motion.speed = 0.4;
  motion.amplitude = 0.3, motion.frequency = 0.6, motion.phase = 1;
  motion.law =
      GENERATE(MotionLaw::linear, MotionLaw::spline, MotionLaw::cycloidal, MotionLaw::polynomial);
  motion.loop = GENERATE(false, true);
  motion.knots = {{0, 0}, {0.7, 1}, {1, 1}, {1.9, -0.5}, {2.5, 0.25}};
  fit_spline(motion);
  CAPTURE(static_cast<int>(motion.law), motion.loop);
  const auto value = [&](Real t) { return motion_at(motion, t).value; };
  for (const Real t : {-1.1, 0.31, 0.86, 1.3, 2.2, 2.9, 7.77}) {
    constexpr Real d = 1e-4;
    const CoordinateMotion at = motion_at(motion, t);
    CHECK(at.rate == Approx((value(t + d) - value(t - d)) / (2 * d)).margin(1e-6));
    CHECK(at.acceleration ==
          Approx((value(t + d) - 2 * value(t) + value(t - d)) / (d * d)).margin(1e-5));
  }
  DriveMotion bare = motion;
  bare.offset = bare.speed = bare.amplitude = 0;
  for (const MotionKnot& knot : bare.knots)
    CHECK(motion_at(bare, knot.time + (knot.time < 2.5 ? 0 : -1e-12)).value ==
          Approx(knot.value).margin(1e-10));
  // Smooth laws join without a jump of the rate; the spline's curvature is continuous, too.
  for (std::size_t i = 1; i + 1 < bare.knots.size(); ++i) {
    const CoordinateMotion left = motion_at(bare, bare.knots[i].time - 1e-9),
                           right = motion_at(bare, bare.knots[i].time + 1e-9);
    if (bare.law == MotionLaw::linear) continue;
    CHECK(left.rate == Approx(right.rate).margin(1e-6));
    CHECK(left.acceleration == Approx(right.acceleration).margin(1e-4));
  }
  const Real ahead = motion.loop ? 0.25 : 0;
  CHECK(motion_at(bare, 2.6 + 0.1).value ==
        Approx(motion.loop ? motion_at(bare, 0.2).value + ahead : 0.25).margin(1e-9));
}

TEST_CASE("a driven pendulum needs m g l sin(x) + I a, to the order of the integrator") {
  CHECK(torque_error(Solver::lagrangian, Integrator::rk4, 120) < 2e-5);
  const Real rk4 = torque_error(Solver::lagrangian, Integrator::rk4, 60) /
                   torque_error(Solver::lagrangian, Integrator::rk4, 120);
  CHECK(rk4 > 10);
  const Real rattle = torque_error(Solver::lagrangian, Integrator::rattle, 60) /
                      torque_error(Solver::lagrangian, Integrator::rattle, 120);
  CHECK(rattle > 3.5);
  CHECK(torque_error(Solver::lagrangian, Integrator::rattle, 120) < 2e-2);
  CHECK(torque_error(Solver::lagrangian, Integrator::radau, 60) < 1e-4);
}

TEST_CASE("a crank at exact speed moves its slider as geometry says") {
  World world;
  const Solver solver = GENERATE(Solver::articulated, Solver::lagrangian, Solver::planar);
  world.default_settings.solver = solver;
  world.default_settings.integrator =
      GENERATE(Integrator::rk4, Integrator::rattle, Integrator::radau, Integrator::euler,
               Integrator::implicit);
  constexpr Real kArm = 0.3, kRod = 0.8, kSpeed = 5;
  const Entity wall = must(world.add(RigidBody{.motion = Motion::fixed}));
  const Entity crank = must(world.add(
      RigidBody{.shape = BoxShape{{0.15, 0.02, 0.02}}, .mass = 1, .position = {0.15, 0, 0}}));
  const Entity rod = must(world.add(
      RigidBody{.shape = BoxShape{{0.4, 0.02, 0.02}}, .mass = 1, .position = {0.7, 0, 0}}));
  const Entity slider =
      must(world.add(RigidBody{.shape = SphereShape{0.1}, .mass = 2, .position = {1.1, 0, 0}}));
  const Vec3 z{0, 0, 1};
  const JointDrive drive = exactly({.speed = kSpeed, .knots = {}});
  must(world.add(HingeJoint{.a = wall, .b = crank, .axis = z, .drive = drive}));
  must(world.add(HingeJoint{.a = crank, .b = rod, .anchor = {0.3, 0, 0}, .axis = z}));
  must(world.add(HingeJoint{.a = rod, .b = slider, .anchor = {1.1, 0, 0}, .axis = z}));
  must(world.add(PrismaticJoint{.a = wall, .b = slider, .anchor = {1.1, 0, 0}, .axis = {1, 0, 0}}));
  Simulation sim(std::move(world));
  sim.settings.h = 1.0 / 120;
  Real worst = 0;
  for (int i = 0; i < 600; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const Real angle = kSpeed * sim.world.time, across = kArm * std::sin(angle);
    const Real place = kArm * std::cos(angle) + std::sqrt(kRod * kRod - across * across);
    worst = std::max(worst, std::abs(sim.world.bodies[slider].pose.position.x - place));
  }
  CHECK(worst < 1e-10);
}

TEST_CASE("a drive stalls at its maximum torque, exactly") {
  // 9.81 N m hold the pendulum level; 5 N m hold it at asin(5 / 9.81).
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  Driven d = pendulum(exactly({.speed = 0.5, .knots = {}}, 5), solver);
  Simulation sim(std::move(d.world));
  sim.settings.h = 1.0 / 240;
  Real before = 0;
  bool stalled = false;
  for (int i = 0; i < 960; ++i) {
    const StepReport report = sim.step();
    REQUIRE(report.status == Status::ok);
    const Real torque = motor_force(sim.world, d.joint);
    CHECK(std::abs(torque) <= 5 * (1 + 1e-9));
    if (sim.world.joint_drives[d.joint].capped) {
      CHECK(torque == 5);
      CHECK(report.drives_capped == 1);
      stalled = true;
    }
    before = joint_angle(sim.world, d.joint);
  }
  CHECK(stalled);
  CHECK(sim.world.joint_drives[d.joint].capped);
  CHECK(before < 1.2);
  // Without gravity it catches up with its motion, without overshoot, and stays on it exactly.
  sim.world.gravity = Vec3(0);
  Real ahead = -1e300;
  for (int i = 0; i < 480; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const Real target = motion_at(sim.world.joint_drives[d.joint].motion, sim.world.time).value;
    ahead = joint_angle(sim.world, d.joint) - target;
  }
  CHECK(std::abs(ahead) < 1e-9);
  CHECK_FALSE(sim.world.joint_drives[d.joint].capped);
}

TEST_CASE("a cart that its drive cannot accelerate at once moves by its maximum force") {
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  Driven d = cart(exactly({.travels = true, .speed = 1, .knots = {}}, 6), solver);
  Simulation sim(std::move(d.world));
  sim.settings.h = 0.01;
  for (int i = 0; i < 20; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    CHECK(joint_speed(sim.world, d.joint) == Approx(2 * sim.world.time).epsilon(1e-9));
    CHECK(motor_force(sim.world, d.joint) == 6);
  }
  for (int i = 0; i < 200; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(joint_travel(sim.world, d.joint) == Approx(sim.world.time).epsilon(1e-9));
  CHECK(std::abs(motor_force(sim.world, d.joint)) < 1e-6);
}

TEST_CASE("a drive that presses against a wall presses with its maximum force") {
  const bool wall = GENERATE(true, false);
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  Driven d = cart(exactly({.travels = true, .speed = 0.5, .knots = {}}, 20), solver);
  d.world.collisions.add(d.body, {});
  if (wall) {
    const Entity block = must(d.world.add(RigidBody{
        .motion = Motion::fixed, .shape = BoxShape{{0.1, 1, 1}}, .position = {0.6, 0, 0}}));
    d.world.collisions.add(block, {});
  } else {
    must(set_limits(d.world, d.joint, Interval{-1, 0.4}));
  }
  Simulation sim(std::move(d.world));
  sim.settings.h = 1.0 / 240;
  for (int i = 0; i < 480; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(joint_travel(sim.world, d.joint) == Approx(0.4).margin(1e-3));
  CHECK(motor_force(sim.world, d.joint) == Approx(20).epsilon(1e-6));
}

TEST_CASE("a driven cart pushes a ball ahead of it") {
  const Solver solver = GENERATE(Solver::articulated, Solver::planar);
  Driven d = cart(exactly({.travels = true, .speed = 0.5, .knots = {}}), solver);
  d.world.gravity = Vec3(0);
  d.world.collisions.add(d.body, {});
  const Entity ball = must(d.world.add(
      RigidBody{.shape = SphereShape{0.1}, .mass = 5, .position = {0.5, 0, 0}, .drag = 0}));
  d.world.collisions.add(ball, {});
  CHECK(check(d.world).empty());
  Simulation sim(std::move(d.world));
  for (int i = 0; i < 120; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(joint_travel(sim.world, d.joint) == Approx(0.5 * sim.world.time).epsilon(1e-9));
  CHECK(sim.world.bodies[ball].velocity.x > 0.49);
  CHECK(sim.world.bodies[ball].pose.position.x > 0.5 * sim.world.time + 0.199);
}

TEST_CASE("drives: where they start, after a copy, and what refuses them") {
  Driven d = pendulum(exactly(kSwing));
  Simulation sim = Simulation::copy_of(d.world);
  for (int i = 0; i < 30; ++i) sim.step();
  // It starts where it stands, moving at once.
  const DriveMotion motion = sim.world.joint_drives[d.joint].motion;
  CHECK_FALSE(motion.at_start);
  CHECK(motion_at(motion, 0).value == Approx(0).margin(1e-15));
  Simulation twin = Simulation::copy_of(sim.world);
  for (int i = 0; i < 30; ++i) sim.step(), twin.step();
  CHECK(state_hash(sim.world) == state_hash(twin.world));

  d.world.default_settings.solver = Solver::sweep;
  d.world.mark_dirty();
  const auto faults = check(d.world);
  REQUIRE(faults.size() == 1);
  CHECK(faults.front().reason.find("an exact joint drive") != std::string::npos);
  CHECK(faults.front().reason.find("\"lagrangian\"") != std::string::npos);

  World world;
  world.default_settings.solver = Solver::lagrangian;
  const Entity wall = must(world.add(RigidBody{.motion = Motion::fixed}));
  const Entity ball = must(world.add(RigidBody{.shape = SphereShape{0.1}}));
  const auto of_ball = world.add(BallJoint{.a = wall, .b = ball, .drive = exactly({})});
  REQUIRE_FALSE(of_ball);
  CHECK(of_ball.errors().front().message.find("drive.motion") != std::string::npos);
  const auto back = world.add(HingeJoint{
      .a = wall, .b = ball, .axis = {0, 0, 1}, .drive = exactly({.knots = {{1, 0}, {0.5, 1}}})});
  REQUIRE_FALSE(back);
  CHECK(back.errors().front().message.find("do not increase") != std::string::npos);
}
