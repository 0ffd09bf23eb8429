// Cables, ratios, joints from outside, frames and pins that are moved: with the Lagrangian solver.
#include <catch2/catch.hpp>
#include <pantin/must.hpp>
#include <pantin/pantin.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81;
const Quat kZ = frame_along({0, 0, 1});

/// A wheel about z at `at`, on a hinge to `carrier`.
struct Wheel {
  Entity body, hinge;
};
Wheel wheel(World& w, Entity carrier, Vec3 at, Real inertia = 0.1) {
  Wheel made;
  made.body = w.add_body(solid(1, Vec3(inertia), {at, kIdentity}));
  made.hinge =
      add_link(w, {carrier, made.body, joint_at(w, carrier, made.body, JointKind::hinge, at, kZ)});
  return made;
}

/// A joint from outside: a point and a common axis z, like a hinge.
class OwnHinge : public CustomJoint {
 public:
  OwnHinge(Vec3 a, Vec3 b) : a_(a), b_(b) {}
  int rows() const override { return 5; }
  void residual(const Pose& a, const Pose& b, std::span<Real> c) const override {
    const Vec3 d = to_world(b, b_) - to_world(a, a_);
    const Vec3 z = b.rotation * Vec3(0, 0, 1);
    c[0] = d.x, c[1] = d.y, c[2] = d.z;
    c[3] = glm::dot(a.rotation * Vec3(1, 0, 0), z), c[4] = glm::dot(a.rotation * Vec3(0, 1, 0), z);
  }

 private:
  Vec3 a_, b_;
};

}  // namespace

TEST_CASE("a string lets a body fall, then holds it") {
  for (Integrator integrator : kAll) {
    World w = exact_world(integrator);
    const Entity ground = add_ground(w),
                 body = w.add_body(solid(2, Vec3(0.1), {{0, -0.5, 0}, kIdentity}));
    add_cable(w, {ground, body, {Vec3(0), Vec3(0), 1, 0}});
    Simulation sim = Simulation::copy_of(w, {1e-3});
    const Real touch = std::sqrt(2 * 0.5 / kG);
    Real worst = 0;
    for (int i = 1; i <= 1000; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Real t = i * 1e-3, y = sim.world.bodies[body].pose.position.y;
      worst = std::max(worst, std::abs(y - (t < touch ? -0.5 - 0.5 * kG * t * t : -1)));
    }
    INFO(name_of(integrator) << ": " << worst);
    CHECK(worst <= (integrator == Integrator::euler ? 3e-3 : 1e-8));
    CHECK(glm::length(sim.world.bodies[body].velocity) <= 1e-10);
    // The load of its row is the weight.
    const lagrangian::Island& m = lagrangian::islands_of(sim.world)[0];
    CHECK(std::abs(m.mean_lambda[0] - 2 * kG) <= 1e-8);
  }
}

TEST_CASE("two gears keep their angles over fifty turns, and a touch or a push by hand") {
  for (Integrator integrator : kAll) {
    World w = exact_world(integrator);
    const Entity ground = add_ground(w);
    const Wheel a = wheel(w, ground, {0, 0, 0}, 0.1), b = wheel(w, ground, {1.5, 0, 0}, 0.4);
    w.bodies[b.body].pose.rotation =
        from_rotation_vector({0, 0, 0.3});  // an offset that is not zero
    Gear r;
    r.first = a.hinge, r.second = b.hinge, r.ratio = -0.5;
    add_gear(w, r);
    w.bodies[a.body].angular_velocity = {0, 0, 40}, w.bodies[b.body].angular_velocity = {0, 0, -20};
    Simulation sim = Simulation::copy_of(w, {2e-3});
    Real first = 0, second = 0, worst = 0;
    int i = 0;
    for (; first < 100 * kPi && i < 6000; ++i) {
      if (i == 500) sim.world.bodies[a.body].restart = true;
      if (i == 600) sim.world.mark_dirty();
      if (i == 700) sim.world.add_body(Body{});
      REQUIRE(sim.step().status == Status::ok);
      first = coordinate_of(sim.world, a.hinge, Coordinate::angle, first);
      second = coordinate_of(sim.world, b.hinge, Coordinate::angle, second);
      worst = std::max(worst, std::abs(second + 0.5 * first - 0.3));
    }
    INFO(name_of(integrator) << ": " << worst << " after " << first);
    CHECK(worst <= 1e-10);
    // Runge-Kutta's quaternions fall behind at 0.08 rad a step.
    CHECK(std::abs(first - 40 * 2e-3 * i) <= (integrator == Integrator::rk4 ? 5e-6 : 1e-8));
  }
}

TEST_CASE("a rack falls against its pinion, and a planet goes round its sun") {
  // m y'' = -m g + f, I w' = -f r, y = -r angle.
  const Real radius = 0.2, mass = 2, inertia = 0.1;
  for (Integrator integrator : kAll) {
    World w = exact_world(integrator);
    const Entity ground = add_ground(w);
    const Wheel pinion = wheel(w, ground, {1, 0, 0}, inertia);
    const Entity rack = w.add_body(solid(mass, Vec3(0.1)));
    const Entity translation = add_link(
        w, {ground, rack,
            joint_at(w, ground, rack, JointKind::prismatic, Vec3(0), frame_along({0, 1, 0}))});
    Gear r;
    r.first = pinion.hinge, r.second = translation, r.second_travels = true, r.ratio = -radius;
    add_gear(w, r);
    Simulation sim = Simulation::copy_of(w, {2e-3});
    for (int i = 0; i < 500; ++i) REQUIRE(sim.step().status == Status::ok);
    const Real way = 0.5 * kG * mass / (mass + inertia / (radius * radius));
    const Real miss = std::abs(sim.world.bodies[rack].pose.position.y + way);
    INFO(name_of(integrator) << ": " << miss);
    CHECK(miss <= (integrator == Integrator::euler ? 6e-3 : 1e-9));
  }
  // Sun fixed, the carrier turns: the planet's angle on its carrier is -(sun / planet) times the
  // carrier's; with teeth 2 : 1 it turns 1 + 2 = 3 times as fast as the carrier.
  World w = exact_world(Integrator::rk4, Vec3(0));
  const Entity ground = add_ground(w);
  const Wheel carrier = wheel(w, ground, {0, 0, 0}, 0.5);
  const Wheel planet = wheel(w, carrier.body, {1, 0, 0}, 0.05);
  Gear r;
  r.first = carrier.hinge, r.second = planet.hinge, r.ratio = 2;
  add_gear(w, r);
  w.bodies[carrier.body].angular_velocity = {0, 0, 2},
  w.bodies[planet.body].angular_velocity = {0, 0, 6};
  w.bodies[planet.body].velocity = {0, 2, 0};
  Simulation sim = Simulation::copy_of(w, {2e-3});
  const Real start = measure(w).kinetic;
  for (int i = 0; i < 5000; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(std::abs(sim.world.bodies[planet.body].angular_velocity.z - 6) <= 1e-9);
  CHECK(std::abs(sim.world.bodies[carrier.body].angular_velocity.z - 2) <= 1e-9);
  CHECK(std::abs(measure(sim.world).kinetic / start - 1) <= 1e-9);
  CHECK(glm::length(sim.world.bodies[planet.body].pose.position -
                    Vec3(std::cos(20), std::sin(20), 0)) <= 1e-8);
}

TEST_CASE("a joint from outside moves as the built-in one") {
  for (Integrator integrator : kAll) {
    World w[2] = {exact_world(integrator), exact_world(integrator)};
    Entity last[2];
    for (int i = 0; i < 2; ++i) {
      Entity before = add_ground(w[i]);
      for (int n = 0; n < 3; ++n) {
        const Entity e = w[i].add_body(rod(1, 1, {{n + 0.5, 0, 0}, kIdentity}));
        Joint j = joint_at(w[i], before, e, JointKind::hinge, {n, 0, 0}, kZ);
        if (i == 1) {
          j.kind = JointKind::custom;
          j.parameters.edit().custom = std::make_shared<OwnHinge>(j.anchor_a, j.anchor_b);
        }
        add_link(w[i], {before, e, j});
        before = last[i] = e;
      }
    }
    Simulation one = Simulation::copy_of(w[0], {2e-3}), two = Simulation::copy_of(w[1], {2e-3});
    Real worst = 0;
    for (int i = 0; i < 1000; ++i) {
      REQUIRE(one.step().status == Status::ok);
      REQUIRE(two.step().status == Status::ok);
      worst = std::max(worst, glm::length(one.world.bodies[last[0]].pose.position -
                                          two.world.bodies[last[1]].pose.position));
    }
    INFO(name_of(integrator) << ": " << worst);
    CHECK(worst <= 1e-6);
  }
}

TEST_CASE("a kinematic crank moves its slider as closed form has it") {
  // Crank of radius r turning as a sin(w t), rod of length l, slider along x.
  const Real r = 0.3, l = 1;
  for (Integrator integrator : kAll) {
    World w = exact_world(integrator);
    const Entity ground = add_ground(w);
    Body c;
    c.motion = Motion::kinematic;
    const Entity crank = w.add_body(c);
    Lissajous sway;
    sway.turn_amplitude = {0, 0, 2}, sway.turn_frequency = {0, 0, 0.5};
    w.paths.add(crank, KinematicPath{sway});
    const Entity bar = w.add_body(rod(1, l, {{r + l / 2, 0, 0}, kIdentity}));
    const Entity slider = w.add_body(solid(1, Vec3(0.1), {{r + l, 0, 0}, kIdentity}));
    add_link(w, {crank, bar, joint_at(w, crank, bar, JointKind::hinge, {r, 0, 0}, kZ)});
    add_link(w, {bar, slider, joint_at(w, bar, slider, JointKind::ball, {r + l, 0, 0})});
    add_link(w, {ground, slider, joint_at(w, ground, slider, JointKind::prismatic, Vec3(0))});
    Simulation sim = Simulation::copy_of(w, {2e-3});
    Real worst = 0, gap = 0;
    for (int i = 0; i < 2000; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Real a = 2 * std::sin(kPi * sim.world.time);
      const Real x = r * std::cos(a) + std::sqrt(l * l - r * r * std::sin(a) * std::sin(a));
      worst = std::max(worst, std::abs(sim.world.bodies[slider].pose.position.x - x));
      gap = std::max(gap, worst_gap(sim.world));
    }
    INFO(name_of(integrator) << ": " << worst << ", gap " << gap);
    CHECK(worst <= 1e-10);
    CHECK(gap <= 1e-9);
  }
}

TEST_CASE("a pin whose place is moved by hand takes its point along") {
  for (Integrator integrator : kAll) {
    World w = exact_world(integrator);
    Entity before, first;
    for (int n = 0; n < 4; ++n) {
      const Entity e = w.add_body(rod(1, 1, {{n + 0.5, 0, 0}, kIdentity}));
      if (n > 0)
        add_link(w, {before, e, joint_at(w, before, e, JointKind::ball, {n, 0, 0})});
      else
        first = e;
      before = e;
    }
    Pin pin;
    pin.body = first, pin.anchor = {-0.5, 0, 0};
    const Entity hand = w.add_pin(pin);
    Simulation sim = Simulation::copy_of(w, {1.0 / 240});
    Real worst = 0;
    for (int i = 0; i < 480; ++i) {
      sim.world.pins[hand].target = {0.5 * std::sin(0.02 * i), 0.2 * std::cos(0.03 * i) - 0.2, 0};
      REQUIRE(sim.step().status == Status::ok);
      worst = std::max(worst, glm::length(to_world(sim.world.bodies[first].pose, {-0.5, 0, 0}) -
                                          sim.world.pins[hand].target));
    }
    INFO(name_of(integrator) << ": " << worst);
    CHECK(worst <= 1e-11);
  }
}

TEST_CASE("joints that say the same twice are consistent where no load acts") {
  // A box on two parallel slides that moves, and one that is locked twice and rests.
  for (const bool moves : {true, false}) {
    World w;
    w.gravity = Vec3(0);
    w.default_settings.solver = Solver::lagrangian;
    const Entity wall = must(w.add(RigidBody{.motion = Motion::fixed}));
    const Entity box =
        must(w.add(RigidBody{.shape = BoxShape{{0.2, 0.1, 0.1}}, .mass = 1, .drag = 0}));
    if (moves) {
      for (const Real z : {-0.2, 0.2})
        must(w.add(PrismaticJoint{.a = wall, .b = box, .anchor = {0, 0, z}, .axis = {1, 0, 0}}));
      w.bodies[box].velocity = {1, 0, 0};
    } else {
      must(w.add(FixedJoint{.a = wall, .b = box}));
      must(w.add(UniversalJoint{
          .a = wall, .b = box, .anchor = {0.1, 0, 0}, .axis_a = {0, 1, 0}, .axis_b = {0, 0, 1}}));
    }
    Simulation sim(std::move(w), {1.0 / 60, 1, 1, false, true});
    for (int i = 0; i < 60; ++i) {
      if (!moves && i == 10) sim.world.forces.add(box, {{20, 3, 0}, {0, 1, 0}});
      if (!moves && i == 20) sim.world.forces.remove(box);
      REQUIRE(sim.step().status == Status::ok);
    }
    CHECK(sim.world.bodies[box].velocity.x == Approx(moves ? 1 : 0).margin(1e-12));
    CHECK(sim.findings().empty());
  }
}
