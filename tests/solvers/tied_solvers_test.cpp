// Ropes tied to bodies that ask for the Lagrangian solver: one solver steps both.
#include <catch2/catch.hpp>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/pantin/measure.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "engine/world/ties.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

struct Tied {
  World world;
  Entity beam;
};

/// A beam of the exact solver, hinged at its left end or free, with a rope of 1 kg at its right
/// end.
Tied rope_on_beam(Real mass, bool hinged, bool string) {
  Tied t;
  World& w = t.world;
  if (!hinged) w.gravity = Vec3(0);
  SolverSettings exact;
  exact.solver = Solver::lagrangian;
  Body beam;
  beam.drag = 0, beam.mass = mass, beam.inertia = mass * Vec3(0.01, 0.09, 0.09);
  beam.pose.position = {0.5, 0, 0};
  t.beam = w.add_body(beam);
  w.settings.add(t.beam, exact);
  if (hinged) {
    Body ground;
    ground.motion = Motion::fixed;
    Joint hinge;
    hinge.kind = JointKind::hinge, hinge.anchor_b = {-0.5, 0, 0};
    const Quat rotation = from_rotation_vector({0, -kPi / 2, 0});
    hinge.frames.set(rotation, rotation);
    add_link(w, {w.add_body(ground), t.beam, hinge});
  } else {
    w.bodies[t.beam].velocity = {0, 1, 0};
  }
  Entity last;
  for (int i = 0; i < 10; ++i) {
    Body b;
    b.drag = 0, b.mass = 0.1, b.inertia = Vec3(1e-4);
    b.pose.position = {1, -0.05 - 0.1 * i - (string ? 0.1 : 0), 0};
    const Entity e = w.add_body(b);
    if (i > 0) {
      Joint j;
      j.anchor_a = {0, -0.05, 0}, j.anchor_b = {0, 0.05, 0};
      add_link(w, {last, e, j});
    } else if (string) {
      CableParameters s;
      s.anchor_a = {0.5, 0, 0}, s.anchor_b = {0, 0.05, 0}, s.length = 0.1;
      add_cable(w, {t.beam, e, s});
    } else {
      Pin p;
      p.body = e, p.anchor = {0, 0.05, 0}, p.to = t.beam, p.target = {0.5, 0, 0};
      w.add_pin(p);
    }
    last = e;
  }
  return t;
}

}  // namespace

TEST_CASE("what a rope gives a free beam it loses itself: momentum, step by step") {
  for (Real mass : {0.2, 10.0}) {
    Simulation sim(rope_on_beam(mass, false, false).world, {1.0 / 240});
    const Measures start = measure(sim.world);
    Real worst = 0, angular = 0;
    for (int i = 0; i < 1200; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Measures now = measure(sim.world);
      worst = std::max(worst, glm::length(now.momentum - start.momentum));
      angular = std::max(angular, glm::length(now.angular_momentum - start.angular_momentum));
    }
    INFO(mass);
    CHECK(worst <= 1e-11);
    CHECK(angular <= 1e-8);
  }
}

TEST_CASE("a rope five times as heavy as the beam it hangs on does not throw it") {
  for (bool string : {false, true})
    for (Real h : {1.0 / 60, 1.0 / 240}) {
      if (string && h > 0.01) continue;  // Runge-Kutta 4 does not follow its whip then, and says so
      const Tied tied = rope_on_beam(0.2, true, string);
      Simulation sim = Simulation::copy_of(tied.world, {h});
      const Real start = measure(sim.world).energy();
      Real most = -1e300;
      for (int i = 0; i < static_cast<int>(3 / h); ++i) {
        INFO(string << " " << h << " " << i);
        REQUIRE(sim.step().status == Status::ok);
        most = std::max(most, measure(sim.world).energy() - start);
      }
      INFO(string << " " << h);
      CHECK(most <= 0.1);  // of 10 J that it falls
    }
}

TEST_CASE("a rope that whips on a string gains no energy under auto") {
  for (Real h : {1.0 / 60, 1.0 / 120, 1.0 / 240}) {
    Tied tied = rope_on_beam(0.2, true, true);
    tied.world.settings.remove(tied.beam);
    Simulation sim = Simulation::copy_of(tied.world, {h});
    const Real start = measure(sim.world).energy();
    for (int i = 0; i < static_cast<int>(3 / h); ++i) {
      INFO(h << " s, step " << i);
      REQUIRE(sim.step().status == Status::ok);
      REQUIRE(measure(sim.world).energy() - start <= 1e-3);  // of 10 J that it falls
    }
  }
}

TEST_CASE("a beam at rest bears the rope's weight") {
  Tied tied = rope_on_beam(10, true, false);
  for (Body& b : tied.world.bodies.values()) b.drag = 3;
  Simulation sim = Simulation::copy_of(tied.world, {1.0 / 120});
  for (int i = 0; i < 120 * 20; ++i) sim.step();
  const std::optional<Vec3> rope = pin_force(sim.world, sim.world.pins.owners().front());
  REQUIRE(rope);
  CHECK(std::abs(rope->y) == Approx(9.81).epsilon(1e-6));
  CHECK(std::abs(rope->x) <= 1e-6);
}

namespace {

/// Where a plate on a spring and a ball on it come to rest, m.
struct Rest {
  Real plate = 0, ball = 0;
};
Rest rest_on_plate(Solver of_ball, Real h) {
  World w;
  SolverSettings exact;
  exact.solver = Solver::lagrangian;
  Body plate;
  plate.mass = 5, plate.inertia = Vec3(1), plate.drag = 1, plate.pose.position = {0, 1, 0};
  const Entity p = w.add_body(plate);
  w.settings.add(p, exact);
  Shape slab;
  slab.kind = ShapeKind::box, slab.size = {1, 0.05, 1};
  w.shapes.add(p, {{slab}});
  w.collisions.add(p, {});
  Body ground;
  ground.motion = Motion::fixed;
  Joint guide;
  guide.kind = JointKind::prismatic, guide.anchor_a = {0, 1, 0};
  const Quat up = from_rotation_vector({0, 0, kPi / 2});
  guide.frames.set(up, up);
  guide.parameters.edit().translation.spring = {2000, 200, 0};
  add_link(w, {w.add_body(ground), p, guide});
  Body ball;
  ball.mass = 2, ball.inertia = Vec3(0.008), ball.drag = 0.5, ball.pose.position = {0, 1.3, 0};
  const Entity e = w.add_body(ball);
  Shape round;
  round.size = {0.1, 0, 0};
  w.shapes.add(e, {{round}});
  w.collisions.add(e, {});
  exact.solver = of_ball;
  w.settings.add(e, exact);
  Simulation sim = Simulation::copy_of(w, {h});
  for (int i = 0; i < 6 / h; ++i) REQUIRE(sim.step().status == Status::ok);
  return {sim.world.bodies[p].pose.position.y, sim.world.bodies[e].pose.position.y};
}

}  // namespace

TEST_CASE("a ball of the articulated solver lies on a plate of the exact one, which bears it") {
  // As if both were exact, whose contacts are of first order: at 240 Hz 8e-4 m off.
  const Rest mixed = rest_on_plate(Solver::articulated, 1.0 / 240);
  const Rest exact = rest_on_plate(Solver::lagrangian, 1.0 / 240);
  CHECK(mixed.plate == Approx(exact.plate).margin(1e-4));
  CHECK(mixed.ball == Approx(mixed.plate + 0.15).margin(1e-4));
  const Rest fine = rest_on_plate(Solver::articulated, 1.0 / 4000);
  CHECK(fine.plate == Approx(1 - 7 * 9.81 / 2000).margin(1e-4));
}
