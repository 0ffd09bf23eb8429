// The order of one step, and steps that must do nothing.
#include <catch2/catch.hpp>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/puppets.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();
constexpr Real kInfinity = std::numeric_limits<Real>::infinity();

}  // namespace

TEST_CASE("systems run at their places, in the order of the step and of their insertion") {
  Simulation simulation(hung_chain(2).world);
  std::vector<std::string> ran;
  const auto note = [&](const char* word) {
    return [&ran, word](World&, Real) { ran.push_back(word); };
  };
  simulation.insert(Stage::after_step, note("after"));
  simulation.insert(Stage::before_measure, note("measure"));
  simulation.insert(Stage::before_contacts, note("touch"));
  simulation.insert(Stage::before_adjust, note("adjust"));
  simulation.insert(Stage::before_update, note("update"));
  simulation.insert(Stage::before_drive, note("drive"));
  simulation.insert(Stage::before_drive, note("drive again"));
  simulation.step();
  CHECK(ran == std::vector<std::string>{"drive", "drive again", "update", "touch", "adjust",
                                        "measure", "after"});
}

TEST_CASE("a system sees the stage before it and is told the length of the step") {
  Puppet p = swaying_puppet();
  Simulation simulation = Simulation::copy_of(p.world);
  simulation.settings.h = 1.0 / 50;
  Vec3 before(0), after(0);
  Real told = 0;
  std::uint64_t ticks[2];
  simulation.insert(Stage::before_drive, [&](World& w, Real h) {
    before = w.bodies[p.bar].pose.position, told = h, ticks[0] = w.tick;
  });
  simulation.insert(Stage::before_update,
                    [&](World& w, Real) { after = w.bodies[p.bar].pose.position; });
  simulation.insert(Stage::after_step, [&](World& w, Real) { ticks[1] = w.tick; });
  simulation.step();
  CHECK(told == 1.0 / 50);
  CHECK(glm::length(after - before) > 1e-3);
  CHECK(ticks[0] == 0);
  CHECK(ticks[1] == 1);
}

TEST_CASE("a force pushed by a system acts in the same step, and in that step only") {
  World world;
  world.gravity = Vec3(0);
  Body body;
  body.drag = 0;
  body.mass = 2;
  const Entity e = world.add_body(body);
  Simulation simulation = Simulation::copy_of(world);
  bool push = true;
  simulation.insert(Stage::before_update, [&](World& w, Real) {
    if (push) w.push(e, {3, 0, 0}, w.bodies[e].pose.position);
  });
  simulation.step();
  const Real speed = simulation.world.bodies[e].velocity.x;
  CHECK(speed == Approx(1.5 / 60));
  push = false;
  for (int i = 0; i < 10; ++i) simulation.step();
  CHECK(simulation.world.bodies[e].velocity.x == Approx(speed));
}

TEST_CASE("a kinematic body is on its path after the step, with the path's velocity") {
  Puppet p = swaying_puppet();
  Simulation simulation = Simulation::copy_of(p.world);
  for (int i = 0; i < 30; ++i) simulation.step();
  const World& w = simulation.world;
  const Body& bar = w.bodies[p.bar];
  CHECK(glm::length(bar.pose.position - pose_at(w.paths[p.bar], w.time).position) < 1e-12);
  const Vec3 ahead = pose_at(w.paths[p.bar], w.time + 0.5 / 60).position;
  const Vec3 behind = pose_at(w.paths[p.bar], w.time - 0.5 / 60).position;
  CHECK(glm::length(bar.velocity - 60.0 * (ahead - behind)) < 0.05);
}

TEST_CASE("tick and time count whole steps") {
  Simulation simulation(hung_chain(3).world);
  simulation.settings.h = 1.0 / 64;
  simulation.settings.substeps = 4;
  for (int i = 0; i < 64; ++i) simulation.step();
  CHECK(simulation.world.time == Approx(1).epsilon(1e-12));
  const StepReport report = simulation.step();
  CHECK(report.time == simulation.world.time);
  CHECK(report.tick == simulation.world.tick);
}

TEST_CASE("a step of zero, negative or non-finite length does nothing") {
  const Real h = GENERATE(0.0, -0.0, -0.01, kNan, kInfinity, -kInfinity);
  Simulation simulation(swaying_puppet().world);
  for (int i = 0; i < 10; ++i) simulation.step();
  const std::uint64_t before = state_hash(simulation.world);
  const std::uint64_t tick = simulation.world.tick;
  simulation.settings.h = h;
  const StepReport report = simulation.step();
  CHECK(report.status == Status::ok);
  CHECK(state_hash(simulation.world) == before);
  CHECK(simulation.world.tick == tick);
  CHECK(simulation.advance(1).steps == 0);
  CHECK(state_hash(simulation.world) == before);
}

TEST_CASE("an empty World can be stepped") {
  Simulation simulation;
  const StepReport report = simulation.step();
  CHECK(report.status == Status::ok);
  CHECK(simulation.world.tick == 1);
  CHECK(measure(simulation.world).energy() == 0);
}

TEST_CASE("a number that is not finite is reported with its body, and its neighbours stay put") {
  Chain chain = hung_chain(4);
  const Entity sick = chain.rods[2];
  const auto spoil = GENERATE(0, 1, 2, 3);
  Simulation simulation = Simulation::copy_of(chain.world);
  for (int i = 0; i < 3; ++i) simulation.step();
  Body& body = simulation.world.bodies[sick];
  body.restart = true;
  if (spoil == 0) body.velocity.x = kNan;
  if (spoil == 1) body.angular_velocity.y = kInfinity;
  if (spoil == 2) simulation.world.push(sick, {kNan, 0, 0}, Vec3(0));
  if (spoil == 3) body.pose.position.z = -kInfinity;
  INFO("way " << spoil);
  const Pose healthy = simulation.world.bodies[chain.rods[0]].pose;
  const StepReport report = simulation.step();
  CHECK(report.status == Status::diverged);
  CHECK(report.body);
  CHECK(simulation.world.bodies[chain.rods[0]].pose.position == healthy.position);
}

TEST_CASE("structures that cannot be solved are left out and named") {
  Chain chain = hung_chain(3);
  World& w = chain.world;
  const Entity self = add_link(w, {chain.rods[1], chain.rods[1], {Vec3(0), Vec3(0)}});
  const Entity nobody = add_link(w, {chain.rods[1], Entity{77, 0}, {Vec3(0), Vec3(0)}});
  Simulation simulation = Simulation::copy_of(w);
  simulation.step();
  std::vector<Entity> named;
  for (const StructureFault& f : partition_of(simulation.world).faults) named.push_back(f.link);
  CHECK(named == std::vector<Entity>{self, nobody});
}

TEST_CASE("an exception of a system does not leave the step, and is reported") {
  Simulation simulation(hung_chain(2).world), calm(hung_chain(2).world);
  int later = 0;
  simulation.insert(Stage::before_update, [](World&, Real) { throw std::runtime_error("no"); });
  simulation.insert(Stage::before_update, [&](World&, Real) { ++later; });
  const StepReport report = simulation.step();
  calm.step();
  CHECK(report.status == Status::system_failed);
  CHECK(later == 1);
  CHECK(state_hash(simulation.world) == state_hash(calm.world));
}

TEST_CASE("solvers are switched while the simulation runs") {
  Chain chain = hung_chain(6);
  Simulation simulation = Simulation::copy_of(chain.world);
  simulation.settings.measure = true;
  for (Solver solver : {Solver::articulated, Solver::sweep, Solver::shake2, Solver::articulated}) {
    simulation.world.settings.add(chain.rods[3], {solver});
    for (int i = 0; i < 30; ++i) {
      const StepReport report = simulation.step();
      REQUIRE(report.status == Status::ok);
      REQUIRE(report.measures.worst_gap_rel <= 1e-12);
    }
  }
  CHECK(articulated::islands_of(simulation.world)[0].settings.solver == Solver::articulated);
}
