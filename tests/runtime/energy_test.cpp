// Energy that comes from nowhere is told: by the solvers that keep no account of it.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/puppets.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Solver kUnaccounted[] = {Solver::sweep, Solver::shake2, Solver::procedural};

/// A trunk with a head and four limbs of two rods each, on cables from a bar that rocks: what these
/// solvers throw.
World marionette() {
  World w;
  Body bar;
  bar.motion = Motion::kinematic, bar.pose.position = {0, 1.2, 0};
  const Entity b = w.add_body(bar);
  Lissajous rock;
  rock.centre = bar.pose, rock.amplitude = {0.05, 0.08, 0}, rock.frequency = {0.5, 0.9, 0};
  rock.turn_amplitude = {0, 0, 0.25}, rock.turn_frequency = {0, 0, 0.7};
  w.paths.add(b, {rock});
  const auto cable = [&](Entity e, Vec3 on_bar, Vec3 anchor) {
    const Vec3 from = bar.pose.position + on_bar, to = to_world(w.bodies[e].pose, anchor);
    add_cable(w, {b, e, {on_bar, anchor, glm::length(to - from), 0}});
  };
  const Entity trunk = w.add_body(rod({0, 0, 0}));
  w.bodies[trunk].mass = 4, w.bodies[trunk].inertia = {0.01, 0.04, 0.04};
  for (Real side : {-1.0, 1.0})
    for (Real up : {0.0, -0.15}) {
      const Entity upper = w.add_body(rod({side * 2 * kHalfLink, up, 0}));
      const Entity lower = w.add_body(rod({side * 4 * kHalfLink, up, 0}));
      add_link(w, {trunk, upper, {{side * kHalfLink, up, 0}, {-side * kHalfLink, 0, 0}}});
      add_link(w, {upper, lower, {{side * kHalfLink, 0, 0}, {-side * kHalfLink, 0, 0}}});
      cable(lower, {side * 0.3, 0, up}, {side * kHalfLink, 0, 0});
    }
  cable(trunk, {-0.05, 0, 0}, {-0.05, 0.05, 0}), cable(trunk, {0.05, 0, 0}, {0.05, 0.05, 0});
  return w;
}

/// Most energy beyond that of the first step, and whether it was told before it was tenfold.
struct Grown {
  Real most = 0, told_at = -1;  // J; s
};
Grown grown(World w, Real h, Real seconds) {
  Simulation sim(std::move(w), {h, 1, 1, true});
  Grown g;
  sim.step();
  const Real start = measure(sim.world).energy();
  while (sim.world.time < seconds) {
    const StepReport report = sim.step();
    if (report.status == Status::diverged) break;
    if (report.status == Status::energy_grew && g.told_at < 0) {
      g.told_at = sim.world.time;
      CHECK(sim.world.bodies.find(report.body));
    }
    g.most = std::max(g.most, report.measures.energy() - start);
  }
  return g;
}

/// Where energy of `most` J at most comes in, nothing is told.
void expect_calm(const World& start, const std::string& what, Real most) {
  for (Solver solver : kUnaccounted)
    for (Real h : {1.0 / 60, 1.0 / 240}) {
      World w = start;
      w.default_settings.solver = solver;
      const Grown g = grown(std::move(w), h, 4);
      INFO(what << ", " << name_of(solver) << ", " << h << ": " << g.most << " J, told at "
                << g.told_at);
      if (g.most <= most) CHECK(g.told_at < 0);
      if (g.most > 20 * most) CHECK(g.told_at > 0);
    }
}

}  // namespace

TEST_CASE("a puppet that a solver throws over its bar is told") {
  for (Solver solver : kUnaccounted)
    for (Real h : {1.0 / 60, 1.0 / 240, 1.0 / 500}) {
      World w = marionette();
      w.default_settings.solver = solver;
      const Grown g = grown(std::move(w), h, 3);
      INFO(name_of(solver) << " " << h << ": " << g.most << " J, told at " << g.told_at);
      // What it can swing with is some 30 J.
      if (g.most > 300) CHECK(g.told_at > 0);
      CHECK((g.most > 300 || g.told_at < 0));
    }
}

TEST_CASE("the accounted solvers keep the same puppet's energy") {
  World w = marionette();
  const Grown g = grown(std::move(w), 1.0 / 60, 3);
  CHECK(g.told_at < 0);
  CHECK(g.most < 60);
}

TEST_CASE("what swings, spins or is led by hands is not taken for a growth") {
  // Second: what each can swing with, a few times.
  expect_calm(hung_chain(12).world, "hung chain", 70);

  Chain driven = hung_chain(8);
  driven.world.bodies[driven.hook].motion = Motion::kinematic;
  Lissajous sway;
  sway.amplitude = {0.4, 0.3, 0.2}, sway.frequency = {1.5, 1.1, 0.7};
  driven.world.paths.add(driven.hook, {sway});
  expect_calm(driven.world, "chain swung by a hand", 100);

  Chain still = hung_chain(6);
  still.world.gravity = Vec3(0);
  expect_calm(still.world, "a chain at rest without weight", 1);
  for (Entity e : still.rods) still.world.bodies[e].drag = 0;
  still.world.bodies[still.rods[2]].angular_velocity = {3, 8, 2};
  expect_calm(still.world, "a spinning chain without weight", 1);

  World free;
  free.gravity = Vec3(0);
  Body b = rod(Vec3(0));
  b.drag = 0, b.angular_velocity = {1, 20, 0.5}, b.inertia = {0.001, 0.002, 0.0025};
  free.add_body(b);
  expect_calm(free, "a free body that tumbles", 0.5);

  Chain falling = hung_chain(6);
  falling.world.destroy(falling.hook);
  for (Entity e : falling.rods) falling.world.bodies[e].drag = 0;
  expect_calm(falling.world, "a chain that falls", 10);

  for (PinKind grip : {PinKind::exact, PinKind::spring}) {
    Chain pulled = hung_chain(8);
    Pin p;
    p.body = pulled.rods.back(), p.kind = grip, p.target = {0.3, 0.9, 0.4};
    pulled.world.add_pin(p);
    expect_calm(pulled.world, "a chain pulled by its end", 100);
  }
}

TEST_CASE("a solver that keeps a chain's energy is never blamed") {
  for (Solver solver : {Solver::shake2, Solver::procedural})
    for (Real h : {1.0 / 60, 1.0 / 240}) {
      World w = hung_chain(12).world;
      w.default_settings.solver = solver;
      const Grown g = grown(std::move(w), h, 4);
      INFO(name_of(solver) << " " << h);
      CHECK(g.most < 1);
      CHECK(g.told_at < 0);
    }
}

TEST_CASE("a sweep that throws a chain is told before it has ten times the energy") {
  World w = hung_chain(12).world;  // 70 J below where it starts
  w.default_settings.solver = Solver::sweep;
  Simulation sim = Simulation::copy_of(w, {1.0 / 60, 1, 1, true});
  StepReport report;
  for (int i = 0; i < 240 && report.status == Status::ok; ++i) report = sim.step();
  CHECK(report.status == Status::energy_grew);
  CHECK(report.measures.energy() > 70);
  CHECK(report.measures.energy() < 1500);
}

TEST_CASE("pushes are work") {
  for (Solver solver : {Solver::shake2, Solver::procedural}) {
    Chain c = hung_chain(5);
    c.world.default_settings.solver = solver;
    Simulation sim = Simulation::copy_of(c.world, {1.0 / 120});
    sim.insert(Stage::before_update, [&](World& w, Real) {
      w.push(c.rods.back(),
             4.0 * glm::normalize(w.bodies[c.rods.back()].velocity + Vec3(0, 1e-3, 0)),
             w.bodies[c.rods.back()].pose.position);
    });
    INFO(name_of(solver));
    for (int i = 0; i < 240; ++i) REQUIRE(sim.step().status == Status::ok);
  }
}

TEST_CASE("changing by hand starts a new account") {
  for (Solver solver : {Solver::shake2, Solver::procedural}) {
    Chain c = hung_chain(5);
    c.world.default_settings.solver = solver;
    Simulation sim = Simulation::copy_of(c.world, {1.0 / 120});
    for (int i = 0; i < 60; ++i) REQUIRE(sim.step().status == Status::ok);
    for (Entity e : c.rods) {
      sim.world.bodies[e].velocity = {0, 0, 20};
      sim.world.bodies[e].restart = true;
    }
    INFO(name_of(solver));
    for (int i = 0; i < 60; ++i) REQUIRE(sim.step().status == Status::ok);
  }
}
