// A belt round two circles is two other circles that roll on one another: they touch at the pitch
// point, which divides the distance of the axles in the ratio of the pulleys, between the axles if
// the belt is crossed, beyond the smaller one if it is open (Nelson and Cohen, figure 3).
#include <catch2/catch.hpp>

#include "engine/pantin/joints.hpp"
#include "tests/solvers/planar.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kSmall = 0.5, kLarge = 1, kApart = 3;  // m
constexpr Real kInertia[] = {1, 4};                   // kg m^2
constexpr Real kTorque = 6, kSpin = 5, kTime = 4;     // N m, rad/s, s

enum class Drive : std::uint8_t { belt, rolling };
enum class Way : std::uint8_t { open, crossed };

struct Turned {
  Real angle[2] = {0, 0}, rate[2] = {0, 0};
};

void couple(World& w, const std::array<Entity, 2>& wheels, Drive drive, Way way) {
  if (drive == Drive::belt) {
    BeltJoint belt{.pulleys = {{.body = wheels[0], .radius = kSmall},
                               {.body = wheels[1], .point = {kApart, 0, 0}, .radius = kLarge}}};
    belt.crossed = way == Way::crossed;
    REQUIRE(w.add(belt));
    return;
  }
  const Real whole = way == Way::crossed ? kSmall + kLarge : kLarge - kSmall;
  SurfaceJoint joint{.a = wheels[0],
                     .b = wheels[1],
                     .curve_a = NurbsCurve::circle(kSmall / whole * kApart),
                     .curve_b = NurbsCurve::circle(kLarge / whole * kApart)};
  joint.curve_b->inside_out = way == Way::open;
  const Result<Entity> made = w.add(joint);
  if (!made) FAIL(made.errors().front().message);
}

Turned turn(Solver solver, Drive drive, Way way) {
  World w = planar_world({0, 0, 0});
  w.default_settings.solver = solver;
  const Entity frame = add_fixed(w);
  std::array<Entity, 2> wheels;
  for (int i = 0; i < 2; ++i) {
    Body b;
    b.mass = 1, b.inertia = Vec3(kInertia[i]), b.drag = 0, b.pose.position = {i * kApart, 0, 0};
    wheels[i] = w.add_body(b);
    add_hinge(w, frame, wheels[i], b.pose.position);
  }
  couple(w, wheels, drive, way);
  const Real ratio = kSmall / kLarge * (way == Way::crossed ? -1 : 1);
  w.bodies[wheels[0]].angular_velocity.z = kSpin;
  w.bodies[wheels[1]].angular_velocity.z = kSpin * ratio;
  Turned turned;
  Simulation sim(std::move(w), {1.0 / 60});
  Real last[2] = {0, 0};
  for (int n = 0; n < static_cast<int>(60 * kTime); ++n) {
    // The plane's step is exact without forces, the other one with these, too.
    if (solver == Solver::lagrangian) sim.world.forces.add(wheels[0], {Vec3(0), {0, 0, kTorque}});
    REQUIRE(sim.step().status == Status::ok);
    for (int i = 0; i < 2; ++i) {
      const Body& b = sim.world.bodies[wheels[i]];
      const Real now = 2 * std::atan2(b.pose.rotation.z, b.pose.rotation.w);
      turned.angle[i] += std::remainder(now - last[i], 2 * kPi), last[i] = now;
      turned.rate[i] = b.angular_velocity.z;
    }
  }
  return turned;
}

}  // namespace

TEST_CASE("a belt turns its pulleys as two circles do that roll on one another") {
  for (const Solver solver : {Solver::planar, Solver::lagrangian})
    for (const Way way : {Way::open, Way::crossed}) {
      CAPTURE(name_of(solver), way == Way::crossed);
      const Real ratio = kSmall / kLarge * (way == Way::crossed ? -1 : 1);
      const Real torque = solver == Solver::lagrangian ? kTorque : 0;
      const Real rise = torque / (kInertia[0] + kInertia[1] * ratio * ratio);  // rad/s^2
      const Real angle = kSpin * kTime + rise / 2 * kTime * kTime, rate = kSpin + rise * kTime;
      for (const Drive drive : {Drive::belt, Drive::rolling}) {
        const Turned made = turn(solver, drive, way);
        // The plane's steps are those of Box2D in time, in single precision. Rolling is a row of
        // speeds for the other solver, and of ways for the plane.
        const Real error = drive == Drive::rolling || solver == Solver::planar ? 1e-6 : 1e-7;
        const bool by_speed = drive == Drive::rolling && solver == Solver::lagrangian;
        CHECK(made.angle[0] == Approx(angle).epsilon(error));
        CHECK(made.angle[1] == Approx(ratio * made.angle[0]).margin(by_speed ? 2e-5 : 1e-9));
        CHECK(made.rate[0] == Approx(rate).epsilon(1e-9));
        CHECK(made.rate[1] == Approx(ratio * rate).epsilon(1e-9));
      }
    }
}
