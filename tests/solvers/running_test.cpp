// Changes in mid-run: solver, step, structure, teleports, snapshots.
#include <catch2/catch.hpp>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/puppets.hpp"
#include "tests/solvers/chains.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kClosed = 1e-13;  // of the island's size

/// Largest way that any body of a World moves in the next step, m.
Real next_move(Simulation& sim) {
  std::vector<Vec3> before;
  for (const Body& b : sim.world.bodies.values()) before.push_back(b.pose.position);
  REQUIRE(sim.step().status == Status::ok);
  Real most = 0;
  for (std::size_t i = 0; i < before.size(); ++i)
    most = std::max(most, glm::length(sim.world.bodies.values()[i].pose.position - before[i]));
  return most;
}

Simulation swinging(Real drag = 0) {
  std::vector<Entity> bodies;
  World w = chain({}, &bodies);
  for (Entity e : bodies) w.bodies[e].drag = drag;
  return Simulation(std::move(w), {1.0 / 60, 1, 1, true});
}

}  // namespace

TEST_CASE("switching the solver keeps joints closed and moves nothing farther than a step does") {
  Simulation start = swinging();
  for (int i = 0; i < 40; ++i) start.step();
  const Entity body = start.world.bodies.owners()[3];
  const Solver all[] = {Solver::articulated, Solver::sweep, Solver::shake2, Solver::procedural};
  for (Solver from : all)
    for (Solver to : all) {
      // Each pair from the same motion: sweep and procedural leave faster ones to the next.
      Simulation sim = Simulation::copy_of(start.world, start.settings);
      SolverSettings how;
      how.solver = from;
      sim.world.settings.add(body, how);
      Real usual = 0;
      for (int i = 0; i < 5; ++i) usual = std::max(usual, next_move(sim));
      how.solver = to;
      sim.world.settings.add(body, how);
      INFO(name_of(from) << " to " << name_of(to));
      CHECK(next_move(sim) <= 2 * usual + 0.01);
      CHECK(measure(sim.world).worst_gap <= kClosed);
    }
}

TEST_CASE("the step may change at any time: nothing jumps and no energy comes in") {
  Simulation sim = swinging();
  const Real start = measure(sim.world).energy(), swing = 10 * 9.81 * 0.5 * (1 - std::cos(kPi / 6));
  const Real rates[] = {60, 240, 30, 1000, 61, 15, 120};
  Real highest = start;
  for (int i = 0; i < 420; ++i) {
    sim.settings.h = 1 / rates[i / 20 % 7];
    const Real speed_before = std::sqrt(2 * measure(sim.world).kinetic);
    const Real moved = next_move(sim);
    CHECK(moved <= sim.settings.h * (3 * speed_before + 9.81 * sim.settings.h) + 1e-3);
    highest = std::max(highest, measure(sim.world).energy());
    CHECK(measure(sim.world).worst_gap <= kClosed);
  }
  CHECK(highest <= start + 0.01 * swing);
}

TEST_CASE("joint loads are carried over to another step as forces, and dropped after a teleport") {
  Simulation sim = swinging();
  for (int i = 0; i < 20; ++i) sim.step();
  const articulated::Island before = articulated::islands_of(sim.world)[0];
  World w = sim.world;
  articulated::prepare(w);
  articulated::update(w, articulated::islands_of(w)[0], 0.5 * sim.settings.h);
  for (std::size_t c = 0; c < before.count(); ++c) {
    const Vec3 load = before.memory.vec(articulated::kLambda, c);
    CHECK(articulated::islands_of(w)[0].memory.vec(articulated::kLambda, c) == 0.25 * load);
    CHECK(glm::length(load) > 0);
  }

  w = sim.world;
  articulated::prepare(w);
  w.teleport(w.bodies.owners()[4], w.bodies.values()[4].pose);
  articulated::update(w, articulated::islands_of(w)[0], sim.settings.h);
  for (std::size_t c = 0; c < before.count(); ++c)
    CHECK(articulated::islands_of(w)[0].memory.vec(articulated::kLambda, c) == Vec3(0));
}

TEST_CASE("substeps are steps: four of them are a step four times as fine") {
  Simulation fine = swinging(), parts = swinging();
  fine.settings.h = 1.0 / 256, parts.settings.h = 1.0 / 64, parts.settings.substeps = 4;
  for (int i = 0; i < 64; ++i) parts.step();
  for (int i = 0; i < 256; ++i) fine.step();
  for (std::size_t i = 0; i < fine.world.bodies.size(); ++i)
    CHECK(fine.world.bodies.values()[i].pose.position ==
          parts.world.bodies.values()[i].pose.position);
}

TEST_CASE("a chain teleported with its holder swings on as it did") {
  Simulation sim = swinging(0.3), stays = swinging(0.3);
  for (int i = 0; i < 100; ++i) sim.step(), stays.step();
  const Vec3 jump(30, 10, -5);
  const std::vector<Entity> all(sim.world.bodies.owners().begin(), sim.world.bodies.owners().end());
  for (Entity e : all) {
    Pose to = sim.world.bodies[e].pose;
    to.position += jump;
    sim.world.teleport(e, to);
  }
  Real worst = 0;
  for (int i = 0; i < 60; ++i) {
    REQUIRE(sim.step().measures.worst_gap <= 100 * kClosed);  // rounding 30 m from the origin
    stays.step();
    for (Entity e : all) {
      const Body& b = sim.world.bodies[e];
      REQUIRE_FALSE((b.teleport || b.restart));
      worst = std::max(worst,
                       glm::length(b.pose.position - jump - stays.world.bodies[e].pose.position));
    }
  }
  // Only the order dropped for a few steps.
  CHECK(worst <= 0.02);
  CHECK(worst > 0);
}

TEST_CASE("a body teleported alone is pulled back by its joints, and nothing blows up") {
  Simulation sim = swinging(0.3);
  for (int i = 0; i < 50; ++i) sim.step();
  const Entity e = sim.world.bodies.owners()[5];
  sim.world.teleport(e, {{5, 5, 5}, from_rotation_vector({1, 2, 0})});
  const Real height = measure(sim.world).energy();
  for (int i = 0; i < 200; ++i) {
    const StepReport report = sim.step();
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.measures.worst_gap <= kClosed);
    REQUIRE(report.measures.energy() <= height + 1);
  }
}

TEST_CASE("cutting a link leaves both halves moving as they did") {
  Chain c = hung_chain(10);
  for (Body& b : c.world.bodies.values()) b.drag = 0;
  Simulation sim = Simulation::copy_of(c.world, {1.0 / 240});
  for (int i = 0; i < 100; ++i) sim.step();
  std::vector<Vec3> before;
  for (Entity e : c.rods) before.push_back(sim.world.bodies[e].velocity);
  // Of the half that flies away the momenta are kept too.
  const auto lower = [&](auto&& sum) {
    for (std::size_t i = 5; i < 10; ++i) sum(sim.world.bodies[c.rods[i]]);
  };
  Vec3 momentum(0), after(0);
  Real mass = 0;
  lower([&](const Body& b) { momentum += b.mass * b.velocity, mass += b.mass; });
  sim.world.destroy(c.links[5]);
  sim.step();
  lower([&](const Body& b) { after += b.mass * b.velocity; });
  CHECK(articulated::islands_of(sim.world).size() == 2);
  const Vec3 expected = momentum + mass / 240 * sim.world.gravity;
  CHECK(glm::length(after - expected) <= 1e-12 * glm::length(expected));
  for (std::size_t i = 0; i < c.rods.size(); ++i)
    CHECK(glm::length(sim.world.bodies[c.rods[i]].velocity - before[i]) <= 0.5);
}

TEST_CASE("a free tree that is rebuilt keeps its angular momentum") {
  Random dice(4);
  TreeSpec spec;
  spec.bodies = 6, spec.held = false;
  RandomTree t = random_tree(spec, dice);
  t.world.gravity = Vec3(0);
  for (Entity e : t.bodies) {
    Body& b = t.world.bodies[e];
    b.angular_velocity = {0.5, 3, -1}, b.velocity = glm::cross(b.angular_velocity, b.pose.position);
  }
  Simulation sim = Simulation::copy_of(t.world, {1.0 / 60});
  for (int i = 0; i < 30; ++i) sim.step();
  const Vec3 l = measure(sim.world).angular_momentum;
  sim.world.mark_dirty();
  for (int i = 0; i < 30; ++i) sim.step();
  CHECK(glm::length(measure(sim.world).angular_momentum - l) <= 1e-10 * glm::length(l));
  // A hand that catches a body and lets it go roots the tree elsewhere in between. It takes energy,
  // but the tree swings on, and flies on as it was let go.
  const Real kinetic = measure(sim.world).kinetic;
  Pin pin;
  pin.body = t.bodies[4], pin.target = sim.world.bodies[t.bodies[4]].pose.position;
  const Entity held = sim.world.add_pin(pin);
  for (int i = 0; i < 30; ++i) sim.step();
  CHECK(measure(sim.world).kinetic > 0.1 * kinetic);
  CHECK(measure(sim.world).kinetic <= kinetic);
  sim.world.destroy(held);
  const Measures then = measure(sim.world);
  for (int i = 0; i < 30; ++i) sim.step();
  const Vec3 lost = measure(sim.world).angular_momentum - then.angular_momentum;
  CHECK(glm::length(lost) <= 1e-10 * glm::length(then.angular_momentum));
  CHECK(glm::length(measure(sim.world).momentum - then.momentum) <=
        1e-12 * glm::length(then.momentum));
}

TEST_CASE("solver settings hold for the island that has them") {
  Chain c = hung_chain(4);
  Body loose = rod({5, 0, 0});
  const Entity other = c.world.add_body(loose);
  SolverSettings how;
  how.solver = Solver::sweep, how.rotation_stiffness = 3;
  c.world.settings.add(c.rods[2], how);
  Simulation sim = Simulation::copy_of(c.world);
  sim.step();
  REQUIRE(articulated::islands_of(sim.world).size() == 2);
  for (const articulated::Island& a : articulated::islands_of(sim.world)) {
    const bool is_chain = a.bodies[0] != other;
    CHECK(a.settings.solver == (is_chain ? Solver::sweep : Solver::articulated));
    CHECK(a.settings.rotation_stiffness == (is_chain ? 3 : 1));
  }
}

TEST_CASE("two chains beside one another do not know of each other") {
  std::vector<Entity> bodies;
  World one = chain({}, &bodies), two = chain({}, nullptr);
  Simulation alone = Simulation::copy_of(one, {1.0 / 60});
  // The second World holds the same chain twice, the copy added after it.
  std::vector<Entity> copies;
  for (const Body& b : one.bodies.values()) copies.push_back(two.add_body(b));
  for (const Link& l : one.links.values())
    add_link(two, {copies[one.bodies.slot(l.a)], copies[one.bodies.slot(l.b)], l.joint});
  Simulation both = Simulation::copy_of(two, {1.0 / 60});
  for (int i = 0; i < 120; ++i) alone.step(), both.step();
  for (std::size_t i = 0; i < copies.size(); ++i) {
    const Pose& expected = alone.world.bodies.values()[i].pose;
    CHECK(both.world.bodies[copies[i]].pose.position == expected.position);
    CHECK(both.world.bodies.values()[i].pose.position == expected.position);
  }
}
