#pragma once
// Worlds with one exact drive.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

namespace pantin::test {

using namespace detail;

constexpr Real kG = 9.81;

struct Driven {
  World world;
  Entity body, joint;
};

/// A pendulum of mass 2 kg, 0.5 m below a driven hinge about z at the origin.
inline Driven pendulum(const JointDrive& drive, Solver solver = Solver::lagrangian) {
  Driven d;
  d.world.default_settings.solver = solver;
  const Entity wall = must(d.world.add(RigidBody{.motion = Motion::fixed}));
  d.body = must(d.world.add(
      RigidBody{.shape = SphereShape{0.1}, .mass = 2, .position = {0, -0.5, 0}, .drag = 0}));
  d.joint =
      must(d.world.add(HingeJoint{.a = wall, .b = d.body, .axis = {0, 0, 1}, .drive = drive}));
  return d;
}

/// A cart of 3 kg on a horizontal slide.
inline Driven cart(const JointDrive& drive, Solver solver = Solver::lagrangian) {
  Driven d;
  d.world.default_settings.solver = solver;
  const Entity wall = must(d.world.add(RigidBody{.motion = Motion::fixed}));
  d.body = must(d.world.add(RigidBody{.shape = SphereShape{0.1}, .mass = 3, .drag = 0}));
  d.joint =
      must(d.world.add(PrismaticJoint{.a = wall, .b = d.body, .axis = {1, 0, 0}, .drive = drive}));
  return d;
}

inline JointDrive exactly(DriveMotion motion, Real most = 1e300) {
  return {.max_torque = most, .keys = {}, .exact = true, .motion = std::move(motion)};
}

inline const DriveMotion kSwing{.amplitude = 0.8, .frequency = 0.7, .phase = 0.3, .knots = {}};

/// The largest error of a driven pendulum's torque, mean over each step, over 1 s.
inline Real torque_error(Solver solver, Integrator integrator, Real rate) {
  Driven d = pendulum(exactly(kSwing), solver);
  d.world.default_settings.integrator = integrator;
  Simulation sim(std::move(d.world));
  sim.settings.h = 1 / rate;
  sim.step();
  const DriveMotion motion = sim.world.joint_drives[d.joint].motion;
  const Real inertia = sim.world.bodies[d.body].inertia.z + 2 * 0.25;
  Real worst = 0;
  for (int i = 0; i < rate; ++i) {
    const Real from = sim.world.time;
    REQUIRE(sim.step().status == Status::ok);
    const Real to = sim.world.time, h = to - from;
    const auto weight = [&](Real t) { return 2 * kG * 0.5 * std::sin(motion_at(motion, t).value); };
    const Real mean = inertia * (motion_at(motion, to).rate - motion_at(motion, from).rate) / h +
                      (weight(from) + 4 * weight(from + h / 2) + weight(to)) / 6;
    worst = std::max(worst, std::abs(motor_force(sim.world, d.joint) - mean));
    CHECK(joint_angle(sim.world, d.joint) == Approx(motion_at(motion, to).value).margin(1e-12));
    CHECK(joint_angular_speed(sim.world, d.joint) ==
          Approx(motion_at(motion, to).rate).margin(1e-10));
  }
  return worst;
}

}  // namespace pantin::test
