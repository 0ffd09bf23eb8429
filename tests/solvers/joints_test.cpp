// One way up the tree and one down close every joint, whatever hangs on it.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/stages.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

struct Drag {
  Real speed = 1;  // m/s, of the hand; its direction changes at every step
  Real h = 1.0 / 60;
};

/// Largest gap of any joint or of the hand, over the size of the tree and one step of the drag.
Real worst_gap(Solver solver, const TreeSpec& spec, const Drag& drag, std::uint64_t seed,
               int steps) {
  Random dice(seed);
  RandomTree t = random_tree(spec, dice);
  t.world.default_settings.solver = solver;
  Simulation sim = Simulation::copy_of(t.world, {drag.h, 1, 1, true});
  Real worst = 0;
  for (int i = 0; i < steps; ++i) {
    if (t.pin) sim.world.pins[t.pin].target += drag.speed * drag.h * dice.direction();
    const StepReport report = sim.step();
    // Solvers that do not keep the energy say so; their joints are closed all the same.
    const bool told = solver != Solver::articulated && report.status == Status::energy_grew;
    REQUIRE((report.status == Status::ok || told));
    const Real far = t.pin ? glm::length(sim.world.pins[t.pin].target) : 0;
    const Real scale = articulated::islands_of(sim.world)[0].size + drag.speed * drag.h + far;
    worst = std::max(worst, report.measures.worst_gap / scale);
    if (t.pin) worst = std::max(worst, worst_pin_gap(sim.world) / scale);
  }
  return worst;
}

}  // namespace

TEST_CASE("every step closes all joints of any tree to the last bits") {
  const Solver solver =
      GENERATE(Solver::articulated, Solver::sweep, Solver::shake2, Solver::procedural);
  INFO(name_of(solver));
  Real worst = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    TreeSpec spec;
    spec.bodies = 2 + static_cast<int>(seed) * 2;
    spec.held = seed % 3 != 0;
    spec.chain = seed % 4 == 1;
    worst = std::max(worst, worst_gap(solver, spec, {}, seed, 60));
  }
  CHECK(worst <= 1e-14);
}

TEST_CASE("masses a million million times apart and a hand at 1000 m/s leave the joints closed") {
  const Solver solver = GENERATE(Solver::articulated, Solver::sweep, Solver::shake2);
  INFO(name_of(solver));
  Real worst = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    TreeSpec spec;
    spec.bodies = 30, spec.decades = 6;
    for (Real h : {1e-4, 1.0 / 60, 1.0})
      worst = std::max(worst, worst_gap(solver, spec, {1000, h}, 100 + seed, 30));
  }
  CHECK(worst <= 1e-14);
}

TEST_CASE("a single sweep closes predicted poses that are torn wide apart") {
  Real worst = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random dice(seed);
    RandomTree t = random_tree({3 + static_cast<int>(seed) % 20, 3, 0, false}, dice);
    for (Entity e : t.bodies) {
      Body& b = t.world.bodies[e];
      b.pose = {10.0 * dice.in_cube(1), dice.rotation()};
    }
    Stages s(t.world);
    s.sweep();
    for (const Link& l : t.world.links.values()) {
      const Vec3 gap = residual(l.joint, s.final(l.a), s.final(l.b));
      worst = std::max(worst, glm::length(gap) / (10 + s.articulation().size));
    }
  }
  CHECK(worst <= 1e-15);
}

TEST_CASE("joint loads are what the neighbours feel: equal, opposite, and of the right size") {
  // Two links at rest, hanging: after one step from rest the upper joint bears both weights.
  World world;
  Body wall;
  wall.motion = Motion::fixed;
  const Entity holder = world.add_body(wall);
  Body b;
  b.mass = 2, b.inertia = Vec3(0.02, 0.001, 0.02), b.drag = 0;
  b.pose.position = {0, -0.25, 0};
  const Entity upper = world.add_body(b);
  b.mass = 3, b.pose.position = {0, -0.75, 0};
  const Entity lower = world.add_body(b);
  add_link(world, {holder, upper, {Vec3(0), {0, 0.25, 0}}});
  add_link(world, {upper, lower, {{0, -0.25, 0}, {0, 0.25, 0}}});
  Simulation sim = Simulation::copy_of(world, {1.0 / 60});
  for (int i = 0; i < 20; ++i) sim.step();
  const articulated::Island& a = articulated::islands_of(sim.world)[0];
  const Real to_force = 1 / (sim.settings.h * sim.settings.h);
  const Vec3 top = to_force * a.memory.vec(articulated::kLambda, 0),
             middle = to_force * a.memory.vec(articulated::kLambda, 1);
  CHECK(top.y == Approx(5 * 9.81).epsilon(1e-12));
  CHECK(middle.y == Approx(3 * 9.81).epsilon(1e-12));
  CHECK(std::abs(top.x) + std::abs(top.z) + std::abs(middle.x) + std::abs(middle.z) < 1e-12);
}
