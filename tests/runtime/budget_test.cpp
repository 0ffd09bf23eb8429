// StepSettings::budget: bodies in contact give way, joints do not; what is given up is told.
#include <catch2/catch.hpp>
#include <pantin/must.hpp>

#include "engine/runtime/save.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"
#include "engine/solvers/articulated/internal.hpp"
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

TEST_CASE("budget: what does not collide waits for three steps, then takes one for all", "") {
  const World start = hung_chain(6).world;
  StepSettings whole;
  whole.h = 4.0 / 60;
  StepSettings part = with_budget(kNoTime);
  part.h = whole.h / 4;
  Simulation once = Simulation::copy_of(start, whole), sim = Simulation::copy_of(start, part);
  once.step();
  // The first step is always taken.
  World& w = sim.world;
  w = once.world;
  for (int n = 0; n < 20; ++n) {
    once.step();
    for (int i = 0; i < 4; ++i) {
      const Pose before = w.bodies.values().back().pose;
      const StepReport report = sim.step();
      CHECK(report.left_out == (i < 3 ? 1 : 0));
      CHECK(report.left_out_at == (i < 3 ? w.bodies.owners()[1] : Entity{}));
      if (i < 3) CHECK(w.bodies.values().back().pose.position == before.position);
    }
    for (std::size_t i = 0; i < w.bodies.size(); ++i) {
      const Body &a = w.bodies.values()[i], &b = once.world.bodies.values()[i];
      CHECK(a.pose.position == b.pose.position);
      CHECK(a.pose.rotation == b.pose.rotation);
      CHECK(a.velocity == b.velocity);
    }
  }
}

TEST_CASE("budget: without time impacts do not divide steps, and add no energy", "") {
  const World start = must(load_scene(asset("scenes/crowd.json"))).world;
  StepSettings how = with_budget(kNoTime);
  how.measure = how.watch = true;
  Simulation late = Simulation::copy_of(start, how),
             sim = Simulation::copy_of(start, with_budget(kMuchTime));
  Real apart = 0;
  for (int n = 0; n < 120; ++n) {
    const StepReport report = late.step();
    REQUIRE(report.status == Status::ok);
    CHECK(report.hurried == 100);
    CHECK(report.left_out == 0);  // what hangs on cables never waits
    CHECK(report.limited == 0);
    CHECK(report.measures.worst_gap < 1e-11);
    CHECK(late.world.bodies.find(report.hurried_at) != nullptr);
    CHECK(sim.step().hurried == 0);
    for (std::size_t i = 0; i < start.bodies.size(); ++i)
      apart = std::max(apart, glm::distance(late.world.bodies.values()[i].pose.position,
                                            sim.world.bodies.values()[i].pose.position));
  }
  CHECK(late.findings().empty());
  CHECK(apart < 0.05);
  // With time again, impacts are followed.
  late.settings.budget = kMuchTime;
  for (int n = 0; n < 200; ++n) late.step();
  CHECK(late.step().hurried == 0);
}

TEST_CASE("budget: without time loops in contact stay closed", "") {
  Simulation sim = Simulation::copy_of(must(load_scene(asset("scenes/rope_bridge.json"))).world,
                                       with_budget(kNoTime));
  sim.settings.measure = true;
  for (int n = 0; n < 240; ++n) {
    const StepReport report = sim.step();
    REQUIRE(report.status == Status::ok);
    CHECK(report.measures.worst_gap_rel < 1e-5);
  }
}

TEST_CASE("budget: a World saved while chains wait goes on with the same bits", "") {
  Simulation sim = Simulation::copy_of(hung_chain(6).world, with_budget(kNoTime));
  int waited = 0;
  for (int n = 0; n < 16; ++n) {
    const StepReport report = sim.step();
    if (n < 8 || report.left_out == 0) continue;
    ++waited;
    Simulation on = Simulation::copy_of(sim.world, with_budget(kNoTime));
    Simulation loaded = Simulation::copy_of(must(world_from_bytes(must(world_to_bytes(sim.world)))),
                                            with_budget(kNoTime));
    for (int i = 0; i < 8; ++i) {
      CHECK(on.step().left_out == loaded.step().left_out);
      CHECK(state_hash(on.world) == state_hash(loaded.world));
    }
  }
  CHECK(waited == 6);
}

TEST_CASE("budget: what matters less, and waits for less time, waits first") {
  detail::articulated::UpdateRates rates;
  rates.cost = 2, rates.weight = 8;
  rates.candidates = {{1, 2, 0, false}, {3, 3, 1, false}, {2, 1, 2, false}, {2, 2, 3, false}};
  const auto waiting = [&](Real time, Real least) {
    rates.weight = 8;
    fit_into(time, least, rates);
    std::vector<std::uint32_t> list;
    for (const auto& c : rates.candidates)
      if (c.waits) list.push_back(c.island);
    return list;
  };
  CHECK(waiting(9, 0) == std::vector<std::uint32_t>{3, 0});  // for a weight of 4.5
  CHECK(rates.weight == 4);
  CHECK(waiting(-1, 6) == std::vector<std::uint32_t>{0});
  CHECK(rates.weight == 6);
}
