// Motors without a gain: critically damped for the inertia that they see, held against gravity.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;
using namespace pantin::detail;

namespace {

constexpr Real kG = 9.81;

/// A uniform rod of length 0.4 m whose end is at the origin, along x, on a motor about z.
struct Rod {
  World world;
  Entity body, hinge;
  Real mass = 1, length = 0.4;
  /// kg m^2, about the hinge.
  Real inertia() const { return world.bodies[body].inertia.z + mass * length * length / 4; }
  Real torque_of_weight() const { return mass * kG * length / 2; }
};

Rod rod_on(Solver solver, Real mass, const JointMotor& motor) {
  Rod rod;
  rod.mass = mass;
  rod.world.default_settings.solver = solver;
  const Entity wall = must(rod.world.add(RigidBody{.motion = Motion::fixed}));
  rod.body = must(rod.world.add(RigidBody{.shape = BoxShape{{0.2, 0.01, 0.01}},
                                          .mass = mass,
                                          .position = {rod.length / 2, 0, 0},
                                          .drag = 0}));
  rod.hinge =
      must(rod.world.add(HingeJoint{.a = wall, .b = rod.body, .axis = {0, 0, 1}, .motor = motor}));
  return rod;
}

constexpr JointMotor kHold{.kind = MotorKind::position};

}  // namespace

TEST_CASE("a motor without a gain holds a rod level, whatever it weighs") {
  const Solver solver = GENERATE(Solver::articulated, Solver::lagrangian, Solver::planar);
  const Real rate = GENERATE(60.0, 240.0), mass = GENERATE(1e-3, 1.0, 1e3);
  CAPTURE(name_of(solver), rate, mass);
  const Rod rod = rod_on(solver, mass, kHold);
  Simulation sim = Simulation::copy_of(rod.world);
  sim.settings.h = 1 / rate;
  Real deepest = 0;
  for (int i = 0; i < rate; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    deepest = std::max(deepest, std::abs(joint_angle(sim.world, rod.hinge)));
  }
  const JointMotor chosen = motor_of(sim.world, rod.hinge);
  CHECK(chosen.gain == Approx(rod.inertia() * 4 * rate * rate).epsilon(1e-9));
  CHECK(chosen.damping == Approx(rod.inertia() * 4 * rate).epsilon(1e-9));
  // It sags by weight over gain, without overshoot, and comes to rest.
  const Real sag = rod.torque_of_weight() / chosen.gain;
  CHECK(joint_angle(sim.world, rod.hinge) == Approx(-sag).epsilon(1e-3));
  CHECK(deepest < 1.02 * sag);
  CHECK(std::abs(joint_angular_speed(sim.world, rod.hinge)) < 1e-7);
  CHECK(motor_force(sim.world, rod.hinge) == Approx(rod.torque_of_weight()).epsilon(1e-3));
}

TEST_CASE("a velocity motor without a gain reaches its speed within a few steps") {
  const Solver solver = GENERATE(Solver::articulated, Solver::lagrangian, Solver::planar);
  const Real mass = GENERATE(1e-3, 1e3);
  CAPTURE(name_of(solver), mass);
  Rod rod = rod_on(solver, mass, {.kind = MotorKind::velocity, .target = 2});
  rod.world.gravity = Vec3(0);
  Simulation sim(std::move(rod.world));
  for (int i = 0; i < 10; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    CHECK(joint_angular_speed(sim.world, rod.hinge) < 2.001);
  }
  CHECK(joint_angular_speed(sim.world, rod.hinge) == Approx(2).epsilon(1e-3));
  CHECK(motor_of(sim.world, rod.hinge).damping == 0);
}

TEST_CASE("a velocity motor that holds a weight exerts its torque, under every solver") {
  const Solver solver = GENERATE(Solver::articulated, Solver::lagrangian, Solver::planar);
  CAPTURE(name_of(solver));
  const Rod rod = rod_on(solver, 2, {.kind = MotorKind::velocity});
  Simulation sim = Simulation::copy_of(rod.world);
  sim.settings.h = 1.0 / 240;
  for (int i = 0; i < 24; ++i) REQUIRE(sim.step().status == Status::ok);
  const Real weight = rod.torque_of_weight() * std::cos(joint_angle(sim.world, rod.hinge));
  CHECK(motor_force(sim.world, rod.hinge) == Approx(weight).epsilon(1e-2));
}

TEST_CASE("the motor of an arm's base sees the whole arm, that of its end only the end") {
  World world;
  world.default_settings.solver = GENERATE(Solver::articulated, Solver::lagrangian);
  Entity before = must(world.add(RigidBody{.motion = Motion::fixed})), hinge[3], link[3];
  for (int i = 0; i < 3; ++i) {
    link[i] = must(world.add(RigidBody{
        .shape = BoxShape{{0.5, 0.02, 0.02}}, .mass = 1.0 + i, .position = {0.5 + i, 0, 0}}));
    hinge[i] = must(world.add(HingeJoint{
        .a = before, .b = link[i], .anchor = {1.0 * i, 0, 0}, .axis = {0, 0, 1}, .motor = kHold}));
    before = link[i];
  }
  Simulation sim(std::move(world));
  sim.settings.h = 0.01;
  sim.step();
  for (int i = 0; i < 3; ++i) {
    Real inertia = 0;
    for (int k = i; k < 3; ++k)
      inertia += sim.world.bodies[link[k]].inertia.z + (1.0 + k) * (0.5 + k - i) * (0.5 + k - i);
    CHECK(motor_of(sim.world, hinge[i]).gain == Approx(4e4 * inertia).epsilon(1e-9));
  }
}

TEST_CASE("a motor sees through a gear, and along a slide") {
  World world;
  world.default_settings.solver = Solver::lagrangian;
  const Entity wall = must(world.add(RigidBody{.motion = Motion::fixed}));
  const auto wheel = [&](Real x, Real radius) {
    return must(
        world.add(RigidBody{.shape = SphereShape{radius}, .mass = 1, .position = {x, 0, 0}}));
  };
  const Entity small = wheel(0, 0.1), large = wheel(1, 0.3), cart = wheel(3, 0.2);
  const JointMotor spin{.kind = MotorKind::velocity, .target = 1};
  const Entity driven =
      must(world.add(HingeJoint{.a = wall, .b = small, .axis = {0, 0, 1}, .motor = spin}));
  const Entity free =
      must(world.add(HingeJoint{.a = wall, .b = large, .anchor = {1, 0, 0}, .axis = {0, 0, 1}}));
  must(world.add(GearJoint{.first = driven, .second = free, .ratio = -0.5}));
  const Entity slide = must(world.add(PrismaticJoint{
      .a = wall, .b = cart, .anchor = {3, 0, 0}, .axis = {1, 0, 0}, .motor = kHold}));
  Simulation sim(std::move(world));
  sim.settings.h = 0.01;
  sim.step();
  const Real seen = sim.world.bodies[small].inertia.z + 0.25 * sim.world.bodies[large].inertia.z;
  CHECK(motor_of(sim.world, driven).gain == Approx(200 * seen).epsilon(1e-9));
  CHECK(motor_of(sim.world, slide).gain == Approx(4e4).epsilon(1e-9));
}

TEST_CASE("a motor that gets no gain at run time has one in the next step") {
  Rod rod = rod_on(Solver::articulated, 1, {});
  Simulation sim(std::move(rod.world));
  sim.step();
  must(set_motor(sim.world, rod.hinge, {.kind = MotorKind::velocity, .target = 1}));
  sim.step();
  const Real gain = motor_of(sim.world, rod.hinge).gain;
  CHECK(gain > 0);
  // An event that names no gain keeps it; one of another kind gets its own.
  must(sim.world.add(MotorEvent{rod.hinge, {.kind = MotorKind::velocity, .target = 3}, 0}));
  sim.step();
  CHECK(motor_of(sim.world, rod.hinge).gain == gain);
  CHECK(motor_of(sim.world, rod.hinge).target == 3);
  must(sim.world.add(MotorEvent{rod.hinge, {.kind = MotorKind::position, .target = 1}, 0}));
  sim.step(), sim.step();
  CHECK(motor_of(sim.world, rod.hinge).gain == Approx(120 * gain).epsilon(0.2));
  const auto refused = set_motor(sim.world, rod.hinge, {.kind = MotorKind::position, .damping = 2});
  REQUIRE_FALSE(refused);
  CHECK(refused.errors().front().message.find("without a gain") != std::string::npos);
}
