// StepSettings::budget: bodies in contact give way, joints do not; what is given up is told.
#include <catch2/catch.hpp>
#include <pantin/must.hpp>

#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"
#include "tests/paths.hpp"
#include "tests/runtime/running.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kNoTime = 1e-9, kMuchTime = 1e4;  // s

World ragdolls() { return must(load_scene(asset("scenes/stairs_five.json"))).world; }

struct Outcome {
  std::uint64_t hash = 0;
  int shortened = 0;
  Real given_up = 0, gap = 0, energy = 0;
};

Outcome run(const World& start, StepSettings how, int steps) {
  how.measure = true;
  Simulation sim = Simulation::copy_of(start, how);
  Outcome o;
  o.energy = measure(sim.world).energy();
  const Real at_first = o.energy;
  for (int i = 0; i < steps; ++i) {
    const StepReport report = sim.step();
    REQUIRE(report.status == Status::ok);
    o.shortened += report.shortened, o.given_up = std::max(o.given_up, report.given_up);
    o.gap = std::max(o.gap, report.measures.worst_gap);
    o.energy = std::max(o.energy, report.measures.energy());
    if (report.shortened > 0) CHECK(sim.world.bodies.find(report.shortened_at) != nullptr);
  }
  o.energy -= at_first, o.hash = state_hash(sim.world);
  return o;
}

StepSettings with_budget(Real seconds) {
  StepSettings how;
  how.budget = seconds;
  return how;
}

}  // namespace

TEST_CASE("budget: enough time changes nothing") {
  const World start = ragdolls();
  const Outcome free = run(start, {}, 120), bound = run(start, with_budget(kMuchTime), 120);
  CHECK(bound.hash == free.hash);
  CHECK(bound.shortened == 0);
}

TEST_CASE("budget: without time joints stay closed, no energy is gained, and it is told", "") {
  const Outcome o = run(ragdolls(), with_budget(kNoTime), 240);
  CHECK(o.shortened > 50);
  CHECK(o.given_up > 0.2);
  CHECK(o.given_up < 1);
  CHECK(o.gap < 1e-11);
  CHECK(o.energy < 1);
}

TEST_CASE("budget: what matters less gives way first") {
  // Bodies of no importance have no time, however much there is.
  World w = falling_pile();
  const Entity last = w.bodies.owners()[w.bodies.size() - 1];
  StepSettings how = with_budget(kMuchTime);
  how.importance = [&](Entity) { return Real(0); };
  Simulation sim = Simulation::copy_of(w, how);
  int shortened = 0;
  for (int i = 0; i < 60; ++i) {
    shortened += sim.step().shortened;
    for (const GroupCost& cost : group_costs(sim.world)) {
      CHECK(cost.seconds > 0);
      CHECK(cost.substeps >= 1);
      CHECK(cost.substeps <= cost.planned);
      CHECK(sim.world.bodies.find(cost.body) != nullptr);
    }
  }
  CHECK(shortened > 0);
  REQUIRE(sim.world.bodies.find(last) != nullptr);
  CHECK(is_finite(sim.world.bodies.find(last)->pose));
}
