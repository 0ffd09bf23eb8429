// Exact drives of the planar solver: the motion and the torques of the Lagrangian one, order 2.
#include "engine/runtime/save.hpp"
#include "engine/world/flat.hpp"
#include "tests/solvers/driven.hpp"
#include "tests/solvers/planar.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

struct Course {
  std::vector<Real> torques;  // N m or N, means over windows of 1/30 s
  Vec3 end{0};
};

/// Runs for 1 s.
Course course_of(World w, Entity joint, Entity body, int rate) {
  Course course;
  Simulation sim(std::move(w));
  sim.settings.h = 1.0 / rate;
  for (int i = 0; i < 30; ++i) {
    Real sum = 0;
    const int steps = rate / 30;
    for (int k = 0; k < steps; ++k) {
      REQUIRE(sim.step().status == Status::ok);
      sum += motor_force(sim.world, joint) / steps;
    }
    course.torques.push_back(sum);
  }
  course.end = sim.world.bodies[body].pose.position;
  return course;
}

struct Distance {
  Real torque = 0, place = 0;
};
Distance between(const Course& a, const Course& b) {
  Distance d{0, glm::length(a.end - b.end)};
  // The start is an impact, which the torque of the exact solver does not include.
  for (std::size_t i = 1; i < a.torques.size(); ++i)
    d.torque = std::max(d.torque, std::abs(a.torques[i] - b.torques[i]));
  return d;
}

/// A rod on a driven pendulum, or below a driven cart.
Driven with_rod(bool travels) {
  DriveMotion motion = kSwing;
  motion.travels = travels;
  Driven d =
      travels ? cart(exactly(motion), Solver::planar) : pendulum(exactly(motion), Solver::planar);
  const Vec3 at = d.world.bodies[d.body].pose.position;
  const Entity rod = add_rod(d.world, at, at + Vec3(0.4, -0.3, 0));
  add_hinge(d.world, d.body, rod, at);
  d.body = rod;
  return d;
}

/// A driven slider-crank with a rod that swings on its slider.
Driven slider_crank() {
  Driven d;
  World& w = d.world;
  w = planar_world();
  const Entity frame = add_fixed(w), crank = add_rod(w, {0, 0, 0}, {0.3, 0, 0});
  const Entity rod = add_rod(w, {0.3, 0, 0}, {1.3, 0, 0});
  const Entity piston = add_rod(w, {1.2, 0, 0}, {1.4, 0, 0});
  d.body = add_rod(w, {1.4, 0, 0}, {1.4, -0.5, 0});
  d.joint = add_hinge(w, frame, crank, {0, 0, 0});
  add_hinge(w, crank, rod, {0.3, 0, 0}), add_hinge(w, rod, piston, {1.3, 0, 0});
  add_link(w, {frame, piston,
               planar_joint(w, frame, piston, JointKind::prismatic, {1.3, 0, 0}, {1, 0, 0})});
  add_hinge(w, piston, d.body, {1.4, 0, 0});
  w.joint_drives.add(d.joint, exactly({.amplitude = 1.5, .frequency = 1, .knots = {}}));
  return d;
}

}  // namespace

TEST_CASE("a driven pendulum in the plane needs m g l sin(x) + I a, to order 2") {
  const auto error = [](Real rate) {
    return torque_error(Solver::planar, Integrator::rattle, rate);
  };
  CHECK(error(120) < 2e-2);
  CHECK(error(60) / error(120) > 3.5);
}

TEST_CASE("planar drives come to the motion and the torques of the exact solver by order 2") {
  for (const Driven& d : {with_rod(false), with_rod(true), slider_crank()}) {
    const auto run_at = [&](int rate) { return course_of(d.world, d.joint, d.body, rate); };
    World exact = d.world;
    exact.default_settings.solver = Solver::lagrangian;
    exact.default_settings.integrator = Integrator::rk4;
    const Course reference = course_of(exact, d.joint, d.body, 1920);
    const Distance coarse = between(run_at(60), reference), fine = between(run_at(240), reference),
                   finest = between(run_at(960), reference);
    INFO(coarse.place << " m " << coarse.torque << "; " << fine.place << " m " << fine.torque
                      << "; " << finest.place << " m " << finest.torque);
    CHECK(coarse.place < 5e-3);
    CHECK(fine.place < coarse.place / 12);
    CHECK(finest.place < fine.place / 12);
    CHECK(fine.torque < coarse.torque / 10);
    CHECK(finest.torque < fine.torque / 10);
  }
}

TEST_CASE("a planar drive counts whole turns, over a saved World too") {
  Driven d = pendulum(exactly({.speed = 7, .knots = {}}, 40), Solver::planar);
  Simulation sim(std::move(d.world));
  for (int i = 0; i < 600; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(planar::plane_of(sim.world).drives.at(0).value == Approx(70).epsilon(1e-9));
  const auto bytes = world_to_bytes(sim.world);
  REQUIRE(bytes);
  auto loaded = world_from_bytes(*bytes);
  REQUIRE(loaded);
  Simulation twin(std::move(*loaded));
  twin.settings = sim.settings;
  for (int i = 0; i < 60; ++i) sim.step(), twin.step();
  CHECK(state_hash(sim.world) == state_hash(twin.world));
  CHECK(planar::plane_of(sim.world).drives.at(0).value == Approx(77).epsilon(1e-9));
}

TEST_CASE("a planar drive moves a train of gears, and falls behind by its maximum") {
  World w = planar_world(Vec3(0));
  const Entity frame = add_fixed(w);
  Entity wheels[2], joints[2];
  for (int i = 0; i < 2; ++i) {
    Body b;
    b.mass = 1, b.inertia = Vec3(i == 0 ? 0.1 : 4.0), b.drag = 0, b.pose.position = {Real(i), 0, 0};
    wheels[i] = w.add_body(b);
    joints[i] = add_hinge(w, frame, wheels[i], b.pose.position);
  }
  Gear gear;
  gear.first = joints[0], gear.second = joints[1], gear.ratio = -0.5;
  add_gear(w, gear);
  // 0.1 + 4 / 4 kg m^2 at the driver: 2.2 N m accelerate it by 2 rad/s^2.
  w.joint_drives.add(joints[0], exactly({.speed = 1, .knots = {}}, 2.2));
  Simulation sim(std::move(w));
  sim.settings.h = 0.01;
  for (int i = 0; i < 20; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    CHECK(sim.world.bodies[wheels[0]].angular_velocity.z ==
          Approx(2 * sim.world.time).epsilon(1e-9));
    CHECK(motor_force(sim.world, joints[0]) == 2.2);
  }
  for (int i = 0; i < 300; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(joint_angle(sim.world, joints[0]) ==
        Approx(std::remainder(sim.world.time, 2 * kPi)).margin(1e-9));
  CHECK(sim.world.bodies[wheels[1]].angular_velocity.z == Approx(-0.5).epsilon(1e-9));
}

TEST_CASE("a driven joint that dwells does not sleep through its next move") {
  Driven d = cart(exactly({.travels = true, .knots = {{0, 0}, {2, 0}, {3, 0.5}}}), Solver::planar);
  d.world.gravity = Vec3(0);
  Simulation sim(std::move(d.world));
  for (int i = 0; i < 240; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(joint_travel(sim.world, d.joint) == Approx(0.5).margin(1e-12));
}

TEST_CASE("a drive out of the plane is told to the planar solver") {
  World w = planar_world();
  const Entity frame = add_fixed(w), rod = add_rod(w, {0, 0, 0}, {1, 0, 0});
  const Entity joint =
      add_link(w, {frame, rod, planar_joint(w, frame, rod, JointKind::cylindrical, Vec3(0))});
  w.joint_drives.add(joint, exactly({.travels = true, .speed = 1, .knots = {}}));
  const auto faults = check(w);
  REQUIRE(faults.size() == 1);
  CHECK(faults.front().link == joint);
  CHECK(faults.front().reason.find("travel") != std::string::npos);
  CHECK(plane_fault(w, rod).find("travel") != std::string::npos);
  w.joint_drives[joint].motion.travels = false;
  w.mark_dirty();
  CHECK(check(w).empty());
  CHECK(plane_fault(w, rod).empty());
}

TEST_CASE("a drive presses on the limit that its motion passes, and leaves it with its motion") {
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  const bool other = GENERATE(false, true);
  CAPTURE(static_cast<int>(solver), other);
  Driven d =
      cart(exactly({.travels = true, .amplitude = 0.5, .frequency = 0.5, .knots = {}}, 40), solver);
  must(set_limits(d.world, d.joint, Interval{-0.3, 0.3}));
  // A second drive, on the cart, goes on.
  Entity swing;
  if (other) {
    const Entity arm = must(d.world.add(
        RigidBody{.shape = SphereShape{0.05}, .mass = 0.1, .position = {0, -0.2, 0}, .drag = 0}));
    swing = must(d.world.add(HingeJoint{
        .a = d.body, .b = arm, .axis = {0, 0, 1}, .drive = exactly({.speed = 1, .knots = {}}, 9)}));
  }
  Simulation sim(std::move(d.world));
  sim.settings.h = 0.01;
  int pressed = 0;
  for (int i = 0; i < 400; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const Real meant = 0.5 * std::sin(kPi * sim.world.time), x = joint_travel(sim.world, d.joint);
    const Real clamped = std::clamp(meant, -0.3, 0.3), phase = std::fmod(sim.world.time, 1.0);
    CHECK(std::abs(x) < 0.3 + 2e-4);
    // It leaves in time to be as fast as its motion where that comes back.
    CHECK(std::abs(x - clamped) < 0.12);
    if (phase > 0.3 && phase < 0.65) {
      ++pressed;
      CHECK(x == Approx(std::copysign(0.3, meant)).margin(1e-6));
      CHECK(motor_force(sim.world, d.joint) == std::copysign(40, meant));
    }
    // Thrown back by the impacts on the stops, it has caught up.
    if (other && phase > 0.6 && phase < 0.65)
      CHECK(joint_angular_speed(sim.world, swing) == Approx(1).margin(2e-4));
  }
  CHECK(pressed > 130);
}

TEST_CASE("a drive without a maximum that demands more than its joint's limit is told") {
  const Solver solver = GENERATE(Solver::lagrangian, Solver::planar);
  CAPTURE(static_cast<int>(solver));
  Driven d =
      cart(exactly({.travels = true, .amplitude = 0.5, .frequency = 0.5, .knots = {}}), solver);
  must(set_limits(d.world, d.joint, Interval{-0.3, 0.3}));
  Simulation sim(std::move(d.world));
  sim.settings.h = 0.01;
  const Real reached = std::asin(0.6) / kPi;
  StepReport report;
  while (sim.world.time < 1 && report.status == Status::ok) report = sim.step();
  CHECK(report.status == Status::inconsistent);
  CHECK(report.worst_residual_at == d.joint);
  CHECK(sim.world.time == Approx(reached).margin(0.011));
}
