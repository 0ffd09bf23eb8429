// The Lagrangian solver against closed forms and long double solutions, and the properties that its
// integrators are chosen for.
#include <catch2/catch.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/lagrangian/lagrangian.hpp"
#include "tests/paths.hpp"
#include "tools/study/problems.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::study;

namespace {

const std::string kFolder = test_data("references");

void set_exact(World& w, Integrator integrator, Real tolerance = 0) {
  w.default_settings.integrator = integrator;
  w.default_settings.step_tolerance = tolerance;
}

World run(World start, Integrator integrator, Real h, int steps) {
  set_exact(start, integrator);
  Simulation sim(std::move(start), {h});
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
  return sim.world;
}

struct Range {
  Real low = 0, high = 0;
  void add(Real x) { low = std::min(low, x), high = std::max(high, x); }
  Real most() const { return std::max(-low, high); }
};

}  // namespace

TEST_CASE("reference problems are met with fixed steps, and joints stay closed") {
  for (const Problem& p : read_problems(kFolder)) {
    CAPTURE(p.file, p.id);
    const Score s = score(p, p.divisions);
    CHECK(s.status == Status::ok);
    CHECK(s.error <= p.allowed);
    // Close to a dead point no double precision closes a joint any better.
    const bool dead = p.id.starts_with("chebyshev");
    CHECK(s.constraint <= (dead ? 1e-9 : p.id == "A02_N40" ? 4e-11 : 1e-12));
    if (p.file == "a02_n_four_bar") CHECK(s.energy <= 1e-3);
  }
}

TEST_CASE(
    "the implicit method of order 5 meets the reference problems closer than that of order 4") {
  for (Problem& p : read_problems(kFolder)) {
    if (p.id == "A02_N40") continue;  // takes seconds
    CAPTURE(p.file, p.id);
    const Score explicitly = score(p, p.divisions);
    set_exact(p.world, Integrator::radau);
    const Score s = score(p, p.divisions);
    CHECK(s.status == Status::ok);
    CHECK(s.error <= p.allowed);
    CHECK(s.error <= std::max(0.2 * explicitly.error, 1e-11));
    CHECK(s.constraint <= (p.id.starts_with("chebyshev") ? 1e-9 : 1e-12));
  }
}

TEST_CASE("reference problems are met with steps by tolerance") {
  for (Problem& p : read_problems(kFolder)) {
    if (p.id == "A02_N40") continue;  // takes seconds
    for (const Integrator by : {Integrator::rk4, Integrator::radau}) {
      // Where rows lose rank, rates off the joints have no bound: implicit stages feel it first.
      const bool loses_rank = p.id == "A02_N2" && by == Integrator::radau;
      CAPTURE(p.file, p.id, name_of(by));
      set_exact(p.world, by, loses_rank ? 1e-8 : 1e-10);
      const Score s = score(p, 1);
      CHECK(s.status == Status::ok);
      CHECK(s.error <= p.allowed_adaptive);
      if (p.conserves) CHECK(s.energy <= 1e-6);
    }
  }
}

TEST_CASE("the redundant joint of a loop is counted and named") {
  for (const Problem& p : read_problems(kFolder)) {
    const bool bricard = p.id == "A04", windows = p.id == "A02_N2";
    if (!bricard && !windows) continue;
    Simulation sim = Simulation::copy_of(p.world, {0.01});
    const StepReport r = sim.step();
    CHECK(r.rows == (bricard ? 30 : 35));
    CHECK(r.rank == 29);
    const lagrangian::Island& m = lagrangian::islands_of(sim.world).at(0);
    int rows = 0;
    for (const lagrangian::Fault& f : m.faults) {
      CHECK(f.kind == lagrangian::Fault::redundant);
      rows += f.rows;
      CHECK(sim.world.links.find(lagrangian::joint_of(sim.world, m.blocks[f.block])) != nullptr);
    }
    CHECK(rows == r.rows - r.rank);
  }
}

TEST_CASE("a hanging chain stays in its shape of rest, and finds it") {
  for (const HangingStart start : {HangingStart::at_rest, HangingStart::straight_halves})
    for (const Problem& p : read_hanging_chains(kFolder, start)) {
      CAPTURE(p.id);
      const Score s = score(p, p.divisions);
      CHECK(s.status == Status::ok);
      CHECK(s.error <= p.allowed);
      CHECK(s.least_rank < s.rows);
    }
}

TEST_CASE("integrators have their orders") {
  const World start = chain(5, 1, kPi / 2);
  World exact = start;
  set_exact(exact, Integrator::rk4, 1e-13);
  Simulation reference = Simulation::copy_of(exact, {0.5});
  REQUIRE(reference.step().status == Status::ok);
  for (const IntegratorInfo& info : kIntegrators) {
    CAPTURE(info.name);
    Integrator integrator{};
    REQUIRE(integrator_from_name(info.name, integrator));
    const Real one = difference(run(start, integrator, 0.005, 100), reference.world);
    const Real half = difference(run(start, integrator, 0.0025, 200), reference.world);
    CHECK(std::log2(one / half) == Approx(info.order).margin(0.2));
  }
}

TEST_CASE("a double pendulum keeps its energy for a minute as each integrator can") {
  struct Row {
    Integrator integrator;
    Real lost, gained;  // J, of 20 J that the pendulum can fall
  };
  const Row rows[] = {{Integrator::euler, 20, 0.1},
                      {Integrator::rattle, 0.24, 0.01},
                      {Integrator::rk4, 0.0104, 0.001},
                      {Integrator::implicit, 2.7, 0.01},
                      {Integrator::radau, 1e-4, 1e-4}};
  for (const Row& row : rows) {
    CAPTURE(name_of(row.integrator));
    World w = chain(2, 1, kPi / 2);
    for (Body& b : w.bodies.values())
      if (b.motion == Motion::dynamic)
        b.inertia = {0.02, 0.09, 0.09}, b.angular_velocity = b.pose.rotation * Vec3(0.5, 0, 0);
    set_exact(w, row.integrator);
    Simulation sim = Simulation::copy_of(w, {0.01});
    const Real start = measure(sim.world).energy();
    Range first, second;
    Real worst = 0;
    for (int i = 0; i < 6000; ++i) {
      const StepReport r = sim.step();
      REQUIRE(r.status == Status::ok);
      worst = std::max(worst, r.worst_constraint);
      (i < 3000 ? first : second).add(measure(sim.world).energy() - start);
    }
    CHECK(std::min(first.low, second.low) >= -row.lost);
    CHECK(std::max(first.high, second.high) <= row.gained);
    CHECK(worst <= 1e-12);
    if (row.integrator == Integrator::rattle) CHECK(second.most() <= 1.2 * first.most());
  }
}

TEST_CASE("a free chain keeps its momenta") {
  World w = chain({.links = 4, .length = 1, .angle = 0.3, .held = false});
  w.gravity = Vec3(0);
  int i = 0;
  for (Body& b : w.bodies.values()) {
    b.velocity = {0.3, 0.1 * i, -0.2};
    b.angular_velocity = {1.0 - 0.5 * i, 0.4 * i, 1.5 - i};
    ++i;
  }
  const std::pair<Integrator, Real> allowed[] = {{Integrator::euler, 2e-2},
                                                 {Integrator::rattle, 1e-12},
                                                 {Integrator::rk4, 1e-8},
                                                 {Integrator::implicit, 1e-3},
                                                 {Integrator::radau, 1e-11}};
  for (const auto& [integrator, spin_drift] : allowed) {
    CAPTURE(name_of(integrator));
    const World before = run(w, integrator, 0.01, 1);
    const World after = run(w, integrator, 0.01, 500);
    const Measures a = measure(before), b = measure(after);
    CHECK(glm::length(a.momentum - b.momentum) <= 1e-12);
    CHECK(glm::length(a.angular_momentum - b.angular_momentum) <=
          spin_drift * glm::length(a.angular_momentum));
  }
}

TEST_CASE("RATTLE comes back the way it went") {
  const World start = run(chain(4, 1, 1, JointKind::hinge), Integrator::rattle, 0.005, 1);
  World there = run(start, Integrator::rattle, 0.005, 200);
  for (Body& b : there.bodies.values())
    b.velocity = -b.velocity, b.angular_velocity = -b.angular_velocity;
  CHECK(distance(start, there) > 0.1);
  CHECK(difference(start, run(there, Integrator::rattle, 0.005, 200)) <= 1e-11);
}

TEST_CASE("RATTLE keeps its order where rows are redundant, however short the steps") {
  for (const Problem& given : read_problems(kFolder)) {
    const bool bricard = given.id == "A04";
    if (!bricard && given.id != "A02_N2") continue;
    // Four-bars side by side lose rank where all bars are level; up to there they are redundant.
    Problem p = given;
    p.world.default_settings.integrator = Integrator::rattle;
    if (!bricard) p.rows.resize(27), p.at_step.resize(27);
    Real before = 0;
    for (const int finer : {1, 2, 4, 8}) {
      const int divisions = (bricard ? 4 : 2) * finer;
      const Score s = score(p, divisions);
      CAPTURE(p.id, p.every / divisions, s.error, before);
      CHECK(s.status == Status::ok);
      CHECK(s.constraint <= 1e-12);
      if (before > 0) CHECK(std::log2(before / s.error) == Approx(2).margin(0.1));
      before = s.error;
    }
    CHECK(before <= 1e-4);
  }
}
