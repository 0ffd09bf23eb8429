// The Lagrangian solver with what is stiff, capped or struck: springs, motors, friction, stops;
// and what it says of it.
#include <catch2/catch.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

const Quat kZ = frame_along({0, 0, 1});

/// A rod of 1 m that hangs from a hinge at the origin, level.
struct Arm {
  World world;
  Entity body, link;
  JointParameters& parameters() { return world.links[link].joint.parameters.edit(); }
};
Arm arm(Integrator integrator, Vec3 gravity = {0, -9.81, 0}) {
  Arm a;
  a.world = exact_world(integrator, gravity);
  const Entity ground = add_ground(a.world);
  a.body = a.world.add_body(rod(1, 1, {{0.5, 0, 0}, kIdentity}));
  a.link = add_link(
      a.world, {ground, a.body, joint_at(a.world, ground, a.body, JointKind::hinge, Vec3(0), kZ)});
  return a;
}

}  // namespace

TEST_CASE("springs far too stiff for the step give no energy, whatever the integrator") {
  for (Integrator integrator : kAll)
    for (const Real stiffness : {1e2, 1e4, 1e6, 1e8}) {
      Arm a = arm(integrator, Vec3(0));
      a.parameters().rotation.spring = {stiffness, 0, 0.1};
      Simulation sim = Simulation::copy_of(a.world, {1e-2});
      const Real start = 0.5 * stiffness * 0.01;
      Real most = 0;
      for (int i = 0; i < 300; ++i) {
        REQUIRE(sim.step().status == Status::ok);
        most = std::max(most, measure(sim.world).energy());
      }
      INFO(name_of(integrator) << ", " << stiffness << " N m/rad: " << most / start);
      // Generalised alpha overshoots at first where a spring is stretched that is so stiff.
      if (integrator == Integrator::implicit && stiffness > 1e4) continue;
      CHECK(most <= 1.01 * start);
    }
}

TEST_CASE("motors with gains far too high hold their speed") {
  for (Integrator integrator :
       {Integrator::euler, Integrator::rk4, Integrator::implicit, Integrator::radau})
    for (const Real cap : {1e2, 1e4, 1e300}) {
      Arm a = arm(integrator);
      JointMotor& motor = a.parameters().rotation.motor;
      motor.kind = MotorKind::velocity, motor.target = 3, motor.gain = 1e4, motor.cap = cap;
      Simulation sim = Simulation::copy_of(a.world, {1e-2});
      int rescued = 0;
      for (int i = 0; i < 200; ++i) {
        const StepReport report = sim.step();
        REQUIRE(report.status == Status::ok);
        rescued += report.rescued;
      }
      INFO(name_of(integrator) << ", cap " << cap << ": "
                               << sim.world.bodies[a.body].angular_velocity.z);
      CHECK(std::abs(sim.world.bodies[a.body].angular_velocity.z - 3) <= 0.02);
      // One matrix for three stages knows a motor at its bound or off it: where that changes within
      // a step, Euler takes it and the next few.
      const bool changes = integrator == Integrator::radau && cap == 1e2;
      if (integrator != Integrator::rk4) CHECK(rescued <= (changes ? 8 : 0));
    }
}

TEST_CASE("dry friction that is all but a step takes energy only") {
  for (Integrator integrator : kAll) {
    Arm a = arm(integrator);
    a.parameters().rotation.friction = {0, 1e4, 1e-3};
    Simulation sim = Simulation::copy_of(a.world, {1e-2});
    for (int i = 0; i < 200; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      CHECK(measure(sim.world).energy() <= 1e-3);
    }
    CHECK(std::abs(coordinate_of(sim.world, a.link, Coordinate::angle)) <= 1e-2);
  }
}

TEST_CASE("steps by tolerance meet stops and go on") {
  for (const Integrator by : {Integrator::rk4, Integrator::radau}) {
    Arm a = arm(by);
    a.world.links[a.link].joint.limits.edit().angle = {true, -1.5, 0.5};
    a.parameters().restitution = 0.5;
    a.world.default_settings.step_tolerance = 1e-8;
    Simulation sim = Simulation::copy_of(a.world, {1.0 / 60});
    for (int i = 0; i < 300; ++i) REQUIRE(sim.step().status == Status::ok);
    CHECK(coordinate_of(sim.world, a.link, Coordinate::angle) == Approx(-1.5).margin(1e-8));
  }
}

TEST_CASE("forces of constraint are means over the whole step, however it was taken") {
  for (Integrator integrator :
       {Integrator::euler, Integrator::rattle, Integrator::rk4, Integrator::radau}) {
    Arm a = arm(integrator);
    a.world.bodies[a.body].angular_velocity = {0, 0, 20},
    a.world.bodies[a.body].velocity = {0, 10, 0};
    const Real h = 1.0 / 15;
    Simulation sim = Simulation::copy_of(a.world, {h});
    for (int i = 0; i < 5; ++i) {
      const Vec3 before = sim.world.bodies[a.body].velocity;
      const StepReport report = sim.step();
      CHECK(report.substeps > 1);
      const lagrangian::Island& m = lagrangian::islands_of(sim.world)[0];
      const Vec3 change = (sim.world.bodies[a.body].velocity - before) / h - sim.world.gravity;
      const Real off = glm::length(lagrangian::joint_wrench(m, 0).force - change);
      INFO(name_of(integrator) << ": " << off << " of " << glm::length(change));
      // What projections change of the speed is not of the joints' forces.
      CHECK(off <= (integrator == Integrator::euler ? 25 : 1.0));
    }
  }
}

TEST_CASE("what rests on a stop is held by its joint") {
  for (Integrator integrator : kAll) {
    World w = exact_world(integrator);
    const Entity ground = add_ground(w);
    const Entity body = w.add_body(solid(2, Vec3(0.1), {{0, 0.3, 0}, kIdentity}));
    const Entity link = add_link(w, {ground, body,
                                     joint_at(w, ground, body, JointKind::prismatic,
                                              Vec3(0, 0.3, 0), frame_along({0, 1, 0}))});
    w.links[link].joint.parameters.edit().travel = {true, -0.3, 1};
    Simulation sim = Simulation::copy_of(w, {1e-2});
    for (int i = 0; i < 100; ++i) REQUIRE(sim.step().status == Status::ok);
    const Vec3 force = lagrangian::joint_wrench(lagrangian::islands_of(sim.world)[0], 0).force;
    INFO(name_of(integrator) << ": " << force.y);
    CHECK(glm::length(force - Vec3(0, 2 * 9.81, 0)) <= 1e-6);
  }
}

TEST_CASE("rank and freedoms of loops that run through one body on many joints") {
  for (int legs : {3, 4, 5, 8}) {
    World w = exact_world(Integrator::rk4);
    const Entity ground = add_ground(w);
    const Entity top = w.add_body(solid(3, Vec3(0.5), {{0.5, 1, 0}, kIdentity}));
    for (int i = 0; i < legs; ++i) {
      const Real x = i / 4.0;
      const Entity leg =
          w.add_body(rod(1, 1, {{x, 0.5, 0}, from_rotation_vector({0, 0, kPi / 2})}));
      add_link(w, {ground, leg, joint_at(w, ground, leg, JointKind::hinge, {x, 0, 0}, kZ)});
      add_link(w, {leg, top, joint_at(w, leg, top, JointKind::hinge, {x, 1, 0}, kZ)});
    }
    w.bodies[top].velocity = {1, 0, 0};
    Simulation sim = Simulation::copy_of(w, {1e-2});
    for (int i = 0; i < 20; ++i) REQUIRE(sim.step().status == Status::ok);
    const StepReport report = sim.step();
    CAPTURE(legs);
    CHECK(report.rows == 10 * legs);
    CHECK(6 * (legs + 1) - report.rank == 1);
  }
}

TEST_CASE("a contradiction is told far from the origin too") {
  for (const Real away : {0.0, 1e2, 1e4}) {
    World w = exact_world(Integrator::rk4);
    const Entity ground = add_ground(w);
    const Entity body = w.add_body(rod(1, 1, {{away + 0.5, 0, 0}, kIdentity}));
    Joint near = joint_at(w, ground, body, JointKind::ball, {away, 0, 0});
    Joint far = joint_at(w, ground, body, JointKind::ball, {away + 1, 0, 0});
    far.anchor_a.x += 1e-3;
    add_link(w, {ground, body, near}), add_link(w, {ground, body, far});
    Simulation sim = Simulation::copy_of(w, {1e-2});
    CHECK(sim.step().status == Status::inconsistent);
  }
}
