// The implicit method of order 5: what is stiff costs it no steps, of whatever kind it is, and ends
// where closed forms say.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"
#include "tools/study/stiff.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// A run, and what it took.
struct Run {
  World world;
  long substeps = 0, solves = 0;
};
Run run(World w, Integrator by, Real tolerance, Real h, int steps) {
  w.default_settings.integrator = by, w.default_settings.step_tolerance = tolerance;
  Simulation sim(std::move(w), {h});
  Run r;
  for (int i = 0; i < steps; ++i) {
    const StepReport report = sim.step();
    CAPTURE(name_of(by), tolerance, i, static_cast<int>(report.status));
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.rescued == 0);
    const lagrangian::Island& m = lagrangian::islands_of(sim.world).at(0);
    r.substeps += m.substeps, r.solves += m.solves;
  }
  r.world = sim.world;
  return r;
}

/// Motion of x'' = -k x - c x', overdamped.
Real overdamped(Real k, Real c, Real x, Real v, Real t) {
  const Real root = std::sqrt(c * c / 4 - k), slow = -k / (c / 2 + root), fast = -c / 2 - root;
  const Real of_fast = (v - slow * x) / (fast - slow);
  return (x - of_fast) * std::exp(slow * t) + of_fast * std::exp(fast * t);
}

/// A slider of 2 kg along x with a spring and a damper to the ground, out by 0.3 m.
World slider(Real stiffness, Real damping) {
  World w = exact_world(Integrator::radau, Vec3(0));
  const Entity ground = add_ground(w);
  const Entity body = w.add_body(solid(2, Vec3(0.1)));
  const Entity link = add_link(
      w, {ground, body,
          joint_at(w, ground, body, JointKind::prismatic, Vec3(0), frame_along({1, 0, 0}))});
  w.links[link].joint.parameters.edit().translation.spring = {stiffness, damping, 0};
  w.bodies[body].pose.position.x = 0.3;
  return w;
}
Real place(const World& w) { return w.bodies.values()[1].pose.position.x; }

}  // namespace

TEST_CASE("a stiff governor costs a fifth of what the explicit pair takes, at equal error") {
  const World start = study::governor(8e5, 4e4);
  constexpr Real kStep = 0.02;
  constexpr int kSteps = 50;
  const Run exact = run(start, Integrator::rk4, 1e-10, kStep, kSteps);
  // Two methods that share no coefficients meet.
  CHECK(study::difference(run(start, Integrator::radau, 1e-10, kStep, kSteps).world, exact.world) <=
        1e-11);
  const std::pair<Real, Real> pairs[] = {{1e-3, 1e-5}, {1e-6, 5e-8}};  // tolerances
  for (const auto& [of_pair, of_radau] : pairs) {
    const Run pair = run(start, Integrator::rk4, of_pair, kStep, kSteps);
    const Run radau = run(start, Integrator::radau, of_radau, kStep, kSteps);
    const Real error = study::difference(radau.world, exact.world);
    CAPTURE(of_pair, of_radau, study::difference(pair.world, exact.world), error);
    CHECK(error <= study::difference(pair.world, exact.world));
    CHECK(5 * radau.solves <= pair.solves);
  }
}

TEST_CASE("order 5 for a spring that the steps resolve, and a bounded error where they do not") {
  const Real stiffness = 800, damping = 20;  // 20 rad/s, damped by a quarter
  const auto error = [&](int steps) {        // the largest of five times
    const Real decay = damping / 4, turn = std::sqrt(stiffness / 2 - decay * decay);
    World w = slider(stiffness, damping);
    Real worst = 0;
    for (const Real time : {0.1, 0.2, 0.3, 0.4, 0.5}) {
      w = run(w, Integrator::radau, 0, 0.1 / steps, steps).world;
      const Real exact = 0.3 * std::exp(-decay * time) *
                         (std::cos(time * turn) + decay / turn * std::sin(time * turn));
      worst = std::max(worst, std::abs(place(w) - exact));
    }
    return worst;
  };
  const Real one = error(5), half = error(10);
  CAPTURE(one, half);
  CHECK(std::log2(one / half) == Approx(5).margin(0.3));
  // Rates of 1e6 and 10 per second, steps of 10 ms: the slow one is followed to the order.
  const Real k = 2e7, c = 2e6;
  const World stiff = slider(k, c);
  const Real exact = overdamped(k / 2, c / 2, 0.3, 0, 0.5);
  CHECK(place(run(stiff, Integrator::radau, 0, 0.01, 50).world) == Approx(exact).epsilon(1e-8));
  CHECK(place(run(stiff, Integrator::radau, 0, 0.05, 10).world) == Approx(exact).epsilon(1e-4));
}

TEST_CASE("steps by tolerance do not depend on how stiff a damped spring is") {
  for (const Real rate : {1e3, 1e5, 1e7}) {
    const Real k = 2 * 10 * rate, c = 2 * rate;  // 10 and `rate` per second
    const Run r = run(slider(k, c), Integrator::radau, 1e-8, 0.1, 10);
    CAPTURE(rate, r.substeps);
    CHECK(place(r.world) == Approx(overdamped(k / 2, c / 2, 0.3, 0, 1)).margin(1e-7));
    CHECK(r.substeps <= 350);
  }
}

TEST_CASE("drag, spring pins, joint drives and elastic cables are implicit too") {
  const auto compare = [](const char* what, const World& w, int fewer) {
    const Run pair = run(w, Integrator::rk4, 1e-6, 0.02, 10);
    const Run radau = run(w, Integrator::radau, 1e-6, 0.02, 10);
    UNSCOPED_INFO(what << ": " << radau.substeps << " steps of " << pair.substeps);
    CHECK(study::difference(pair.world, radau.world) <= 1e-5);
    CHECK(fewer * radau.substeps <= pair.substeps);
    return radau.world;
  };
  {
    World w = exact_world(Integrator::radau);
    Body b = solid(2, Vec3(0.1));
    b.drag = 1e4, b.velocity = {1, 0, 0};
    w.add_body(b);
    const World end = compare("drag", w, 4);
    CHECK(end.bodies.values()[0].velocity.y == Approx(-9.81e-4).epsilon(1e-6));
  }
  {
    World w = exact_world(Integrator::radau);
    Pin pin;
    pin.body = w.add_body(rod(2, 1)), pin.kind = PinKind::spring, pin.stiffness = 2e8;
    pin.damping = 4e4;  // critical for the mass alone
    pin.anchor = {0.5, 0, 0}, pin.target = {0.5, 0, 0};
    w.add_pin(pin);
    compare("spring pin", w, 4);
  }
  {
    World w = exact_world(Integrator::radau);
    const Entity ground = add_ground(w), body = w.add_body(rod(2, 1));
    const Entity link =
        add_link(w, {ground, body, joint_at(w, ground, body, JointKind::ball, {-0.5, 0, 0})});
    JointDrive drive;
    drive.target = from_rotation_vector({0, 0.2, 0.3});
    drive.stiffness = drive.damping = 1e2;
    w.joint_drives.add(link, drive);
    compare("joint drive", w, 4);
  }
  {
    World w = exact_world(Integrator::radau);
    const Entity ground = add_ground(w), body = w.add_body(rod(2, 1));
    w.bodies[body].drag = 1e4;
    add_cable(w, {ground, body, {Vec3(0, 1, 0), Vec3(0, 0.01, 0), 0.9, 1e-7}});
    compare("elastic cable", w, 4);
  }
}

TEST_CASE("steps by tolerance find where a motor comes off its bound") {
  World w = slider(0, 0);
  const Real gain = 2e4, cap = 200, speed = 3, mass = 2;
  Dof& dof = w.links.values()[0].joint.parameters.edit().translation;
  dof.motor = {MotorKind::velocity, speed, gain, 0, cap};
  const Run r = run(w, Integrator::radau, 1e-8, 0.1, 2);
  const Real ramp = mass * (speed - cap / gain) / cap, settles = mass / gain;
  const Real way = 0.5 * cap / mass * ramp * ramp + speed * (0.2 - ramp) - cap / gain * settles;
  CAPTURE(r.substeps);
  CHECK(place(r.world) == Approx(0.3 + way).margin(1e-7));
  CHECK(r.substeps <= 300);
}

TEST_CASE("chains of thin rods keep their energy with fixed steps and by tolerance") {
  for (const Real thin : {1e-1, 1e-3, 1e-6})
    for (const Real tolerance : {0.0, 1e-6}) {
      World w = study::chain({.links = 5, .length = 1, .angle = 0.3});
      w.gravity = Vec3(0);
      const Vec3 spin(0.5, 2, 1);
      for (Body& b : w.bodies.values()) {
        if (b.motion != Motion::dynamic) continue;
        b.inertia = {thin / 12, 1.0 / 12, 1.0 / 12};
        b.angular_velocity = spin, b.velocity = glm::cross(spin, b.pose.position);
      }
      const Real start = measure(w).energy();
      const Real end = measure(run(w, Integrator::radau, tolerance, 1.0 / 120, 240).world).energy();
      CAPTURE(thin, tolerance, end / start - 1);
      CHECK(std::abs(end - start) <= 1e-6 * start);
    }
}

TEST_CASE("a chain of stiff joints costs the same for each link, however many") {
  const auto solves_of = [](int links) {
    World w = study::chain(links, 0.1, 0.3, JointKind::hinge);
    for (Link& l : w.links.values()) l.joint.parameters.edit().rotation.spring = {1, 1e3, 0};
    return run(w, Integrator::radau, 1e-6, 0.02, 5).solves;
  };
  const long few = solves_of(5), many = solves_of(80);
  CAPTURE(few, many);
  CHECK(many <= 2 * few);
}
