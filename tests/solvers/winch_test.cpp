// Winches: the rate and the tension of what hangs on a cable whose length changes.
#include <catch2/catch.hpp>
#include <pantin/must.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;

namespace {

constexpr Real kG = 9.81, kMass = 50, kFrom = 1.8, kTo = 1, kStart = 1, kOver = 2;

struct Hoist {
  World world;
  Entity load, cable;
};

/// A load on a winch that starts at 1 s and takes 2 s.
Hoist hoist(Solver solver, Vec3 at) {
  Hoist h;
  h.world.default_settings.solver = solver;
  const Entity beam = must(h.world.add(RigidBody{.motion = Motion::fixed}));
  h.load = must(h.world.add(
      RigidBody{.shape = BoxShape{{0.2, 0.2, 0.2}}, .mass = kMass, .position = at, .drag = 0}));
  h.cable = must(h.world.add(CableJoint{.a = beam, .b = h.load, .anchor_b = at, .length = kFrom}));
  must(h.world.add(WinchEvent{.cable = h.cable, .length = kTo, .at = kStart, .over = kOver}));
  return h;
}

/// The part of the way of the winch, 0 to 1.
Real part_at(Real time) { return std::clamp((time - kStart) / kOver, Real(0), Real(1)); }
Real rate_at(Real time) {
  const Real x = part_at(time);
  return (kTo - kFrom) * 6 * x * (1 - x) / kOver;
}

}  // namespace

TEST_CASE("a small load that is wound fast keeps its speed when the cable is cut") {
  const Real h = GENERATE(1.0 / 30, 1.0 / 60, 1.0 / 120, 1.0 / 240);
  CAPTURE(h);
  World w;
  const Entity beam = must(w.add(RigidBody{.motion = Motion::fixed, .position = {0, 2, 0}}));
  const Entity ball = must(
      w.add(RigidBody{.shape = SphereShape{0.1}, .mass = 1, .position = {0, 0.1, 0}, .drag = 0}));
  const Entity cable =
      must(w.add(CableJoint{.a = beam, .b = ball, .anchor_a = {0, 2, 0}, .anchor_b = {0, 0.2, 0}}));
  must(w.add(WinchEvent{.cable = cable, .length = 0.8, .at = 0.5, .over = 1}));
  Simulation sim(std::move(w));
  sim.settings.h = h;
  while (sim.world.time < 1 - h / 2) CHECK(sim.step().energy_removed < 1e-9);
  // Half-way it winds 1 m in 1 s at one and a half times the mean rate.
  CHECK(sim.world.bodies[ball].velocity.y == Approx(1.5).epsilon(0.01));
  CHECK(cable_tension(sim.world, cable) == Approx(kG).margin(10 * h));
  CHECK(sim.findings().empty());
}

TEST_CASE("a load on a winch has the rate and the tension of the winding") {
  const Solver solver = GENERATE(Solver::articulated, Solver::lagrangian);
  const Real h = GENERATE(1.0 / 60, 0.005);
  CAPTURE(static_cast<int>(solver), h);
  Hoist made = hoist(solver, {0, -kFrom, 0});
  Simulation sim(std::move(made.world));
  sim.settings.h = h;
  while (sim.world.time < 4) {
    const Real from = sim.world.time;
    const StepReport report = sim.step();
    REQUIRE(report.status == Status::ok);
    CHECK(report.rescued == 0);
    CHECK(report.energy_removed < 1e-9);
    const Real to = sim.world.time;
    const Body& b = sim.world.bodies[made.load];
    CHECK(b.velocity.y == Approx(-rate_at(to)).margin(1e-9));
    // The mean over the step, but where it starts and ends.
    const Real due = kMass * (kG - (rate_at(to) - rate_at(from)) / (to - from));
    CHECK(cable_tension(sim.world, made.cable) == Approx(due).margin(0.02 * kMass * kG));
  }
  CHECK(sim.findings().empty());
}

TEST_CASE("a swinging load that is hoisted moves alike under two solvers, to order 2") {
  const auto end_of = [](Solver solver, Real h) {
    Hoist made = hoist(solver, {0.9, -std::sqrt(kFrom * kFrom - 0.81), 0});
    Simulation sim(std::move(made.world));
    sim.settings.h = h;
    while (sim.world.time < 3.5 - 1e-9) REQUIRE(sim.step().status == Status::ok);
    return sim.world.bodies[made.load].pose.position;
  };
  const Vec3 exact = end_of(Solver::lagrangian, 1.0 / 1920);
  const Real coarse = glm::distance(end_of(Solver::articulated, 1.0 / 120), exact),
             fine = glm::distance(end_of(Solver::articulated, 1.0 / 480), exact);
  CAPTURE(coarse, fine);
  CHECK(coarse < 0.02);
  CHECK(fine < coarse / 12);
  CHECK(glm::length(exact) == Approx(kTo).margin(1e-6));
}
