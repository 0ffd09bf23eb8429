// Elastic cables and spring pins store energy and give it back: what hangs on them swings.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/chains.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kGravity = 9.81;

Body ball(Vec3 position, Real mass = 1) {
  Body b;
  b.mass = mass, b.drag = 0;
  b.inertia = Vec3(0.4 * mass * 0.05 * 0.05);
  b.pose.position = position;
  return b;
}

/// A ball on an elastic cable from a nail at the origin.
struct Bungee {
  Real mass = 1, length = 1, compliance = 0.01;
  Vec3 start{0};
  Lissajous sway{};  // of the nail
  bool sways = false;

  World build(Entity* jumper, Entity* cable = nullptr) const {
    World w;
    w.default_settings.solver = Solver::articulated;
    Body nail;
    nail.motion = sways ? Motion::kinematic : Motion::fixed;
    const Entity top = w.add_body(nail);
    if (sways) w.paths.add(top, KinematicPath{sway});
    *jumper = w.add_body(ball(start, mass));
    const Entity e = add_cable(w, {top, *jumper, {Vec3(0), Vec3(0), length, compliance}});
    if (cable) *cable = e;
    return w;
  }
};

struct Height {
  Real highest = -1e9, lowest = 1e9, least_energy = 1e9, most_energy = -1e9;
  Real removed = 0;  // J, by the limiter
};

Height follow(Simulation& sim, Entity body, Real duration) {
  Height all;
  const int steps = static_cast<int>(std::lround(duration / sim.settings.h));
  for (int i = 0; i < steps; ++i) {
    const StepReport r = sim.step();
    REQUIRE(r.status == Status::ok);
    const Real y = sim.world.bodies[body].pose.position.y;
    all.highest = std::max(all.highest, y), all.lowest = std::min(all.lowest, y);
    all.least_energy = std::min(all.least_energy, r.measures.energy());
    all.most_energy = std::max(all.most_energy, r.measures.energy());
    all.removed += r.energy_removed;
  }
  return all;
}

}  // namespace

TEST_CASE("a ball on a stretched elastic string swings up as high as its energy takes it") {
  // k x^2 / 2 with x = 0.5 m under the length of 1 m, of which m g 1.274 m come out above.
  const Bungee bungee{.compliance = 0.01, .start = {0, -1.5, 0}};
  for (const Real rate : {60.0, 240.0, 960.0}) {
    Entity b;
    Simulation sim(bungee.build(&b), {1 / rate, 1, 1, true});
    const Real energy = measure(sim.world).energy();
    REQUIRE(energy == Approx(12.5 - 1.5 * kGravity));
    const Height up = follow(sim, b, 1);
    INFO(rate << " Hz: up to " << up.highest << " m");
    const Real apex = energy / kGravity;
    REQUIRE(std::abs(up.highest - apex) < (rate < 100 ? 1e-2 : 1e-3) * (apex + 1.5));
    const Height later = follow(sim, b, 2);
    CHECK(later.least_energy > energy - (rate < 100 ? 2e-2 : 1e-3) * 12.5);
    CHECK(up.most_energy < energy + 1e-3 * 12.5);
    CHECK(up.removed + later.removed < 1e-3 * 12.5);
  }
}

TEST_CASE("a bungee jumper turns round where the string has taken up the fall") {
  const Bungee bungee{.mass = 70, .length = 10, .compliance = 1.0 / 150, .start = {0.01, -0.5, 0}};
  // m g (10 - 0.5 + x) = k x^2 / 2.
  const Real weight = 70 * kGravity, k = 150;
  const Real x = (weight + std::sqrt(weight * weight + 2 * k * weight * 9.5)) / k;
  for (const Real rate : {60.0, 240.0}) {
    Entity b;
    Simulation sim(bungee.build(&b), {1 / rate, 1, 1, true});
    const Height down = follow(sim, b, 12);
    INFO(rate << " Hz: down to " << down.lowest << " m, " << -10 - x << " m due");
    CHECK(std::abs(down.lowest + 10 + x) < 1e-2 * (rate < 100 ? 1 : 0.1) * x);
    CHECK(down.removed < 1e-3 * weight * 9.5);
  }
}

TEST_CASE("a nail that shakes in resonance feeds the ball on its string") {
  // z'' = -w^2 (z - y), y = A sin w t, from rest: z = A (sin w t - w t cos w t) / 2.
  const Real w = 5, amplitude = 0.02;
  Bungee bungee{.compliance = 1 / (w * w), .sways = true};
  bungee.start = {0, -1 - kGravity / (w * w), 0};
  bungee.sway.amplitude.y = amplitude, bungee.sway.frequency.y = w / (2 * kPi);
  for (const Real rate : {60.0, 240.0}) {
    Entity b;
    Simulation sim(bungee.build(&b), {1 / rate, 1, 1, true});
    Real worst = 0, most = 0, removed = 0;
    while (sim.world.time < 6) {
      const StepReport r = sim.step();
      const Real t = w * sim.world.time;
      const Real due = 0.5 * amplitude * (std::sin(t) - t * std::cos(t));
      worst = std::max(worst, std::abs(sim.world.bodies[b].pose.position.y - bungee.start.y - due));
      most = std::max(most, std::abs(due)), removed += r.energy_removed;
    }
    INFO(rate << " Hz: off by " << worst << " of " << most);
    CHECK(worst < (rate < 100 ? 0.1 : 0.01) * most);
    CHECK(removed == 0);
  }
}

World drawn_ball(Solver solver, Real stiffness, Real damping) {
  World w;
  w.default_settings.solver = solver;
  w.default_settings.integrator = Integrator::rattle;
  w.gravity = Vec3(0);
  Pin pin;
  pin.body = w.add_body(ball({0.3, 0, 0}, 2));
  pin.kind = PinKind::spring, pin.stiffness = stiffness, pin.damping = damping;
  w.add_pin(pin);
  return w;
}

TEST_CASE("a spring pin that is let go pulls as its spring and its damper do, and no other") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian})
    for (const Real damping : {0.0, 2.0}) {
      // m x'' = -k x - c x'
      const Real k = 20.0 / 2, c = damping / 4, wd = std::sqrt(k - c * c);
      Simulation sim(drawn_ball(solver, 20, damping), {1.0 / 240, 1, 1, true});
      sim.settings.watch = true;
      Real worst = 0, before = measure(sim.world).energy(), rise = 0;
      for (int i = 0; i < 480; ++i) {
        const StepReport r = sim.step();
        const Real t = sim.world.time;
        const Real due = 0.3 * std::exp(-c * t) * (std::cos(wd * t) + c / wd * std::sin(wd * t));
        worst = std::max(worst, std::abs(sim.world.bodies.values()[0].pose.position.x - due));
        rise = std::max(rise, r.measures.energy() - before), before = r.measures.energy();
        CHECK(r.limited == 0);
      }
      INFO(name_of(solver) << ", damping " << damping << ": off by " << worst
                           << " m, energy rose by " << rise << " J in a step");
      CHECK(sim.findings().empty());
      CHECK(worst < 1e-3 * 0.3);
      CHECK(rise < (solver == Solver::articulated ? 1e-10 : 1e-4));
    }
}

TEST_CASE("a spring pin that no step resolves is told, and makes no energy") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian})
    for (const Real damping : {0.0, 1e3, 1e9})
      for (const Real stiffness : {1e5, 1e8, 1e12}) {
        Simulation sim(drawn_ball(solver, stiffness, damping), {1.0 / 60, 1, 1, true});
        sim.settings.watch = true;
        const Real start = measure(sim.world).energy();
        bool told = false;
        Real most = 0;
        for (int i = 0; i < 240; ++i) {
          const StepReport r = sim.step();
          most = std::max(most, r.measures.energy());
        }
        for (const Finding& f : sim.findings())
          told = told || f.kind == FindingKind::spring_unresolved;
        CAPTURE(name_of(solver), stiffness, damping);
        CHECK(most <= 1.2 * start);
        if (damping == 0) CHECK(told);
      }
}

TEST_CASE("two balls tied by an elastic string in free flight swing to and fro") {
  World w;
  w.default_settings.solver = Solver::articulated;
  w.gravity = Vec3(0);
  const Entity a = w.add_body(ball({0, 0, 0}, 1)), b = w.add_body(ball({1.2, 0, 0}, 3));
  w.bodies[a].velocity = {0.5, 0.3, 0};
  add_cable(w, {a, b, {Vec3(0), Vec3(0), 1, 1.0 / 200}});
  Simulation sim(std::move(w), {1.0 / 240, 1, 1, true});
  const Measures start = measure(sim.world);
  Real most = 0, least = 1e9;
  for (int i = 0; i < 480; ++i) {
    const StepReport r = sim.step();
    most = std::max(most, r.measures.energy()), least = std::min(least, r.measures.energy());
    CHECK(glm::length(r.measures.momentum - start.momentum) < 1e-12);
  }
  INFO("energy from " << start.energy() << " to " << least << ".." << most);
  CHECK(most < 1.001 * start.energy());
  CHECK(least > 0.99 * start.energy());
}

TEST_CASE("a mass laid into a stiff elastic cable stays there, however stiff, at every rate") {
  const Real compliance = GENERATE(1e-4, 1e-6, 1e-8, 1e-10), mass = GENERATE(0.1, 1.0, 100.0);
  const Real rate = GENERATE(30, 60, 240, 1000, 4000);
  CAPTURE(compliance, mass, rate);
  Bungee b;
  b.compliance = compliance, b.mass = mass, b.start = {0, -1, 0};
  Entity jumper;
  Simulation sim(b.build(&jumper), {1 / rate});
  sim.settings.measure = true;
  const Real start = measure(sim.world).energy();
  const Height all = follow(sim, jumper, 1);
  const Real sag = 2 * mass * kGravity * compliance;  // at most
  CHECK(all.highest <= -1 + 1e-9);
  CHECK(all.lowest >= -1 - sag - 1e-9);
  CHECK(all.most_energy <= start + 1e-9 * mass * kGravity);
  CHECK(all.least_energy >= start - 1e-6 * mass * kGravity);
}
