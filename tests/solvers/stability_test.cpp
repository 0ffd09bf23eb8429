// What never happens: energy out of nothing, numbers that are not finite, joints that open. Long
// runs of the same: pantin_tests "[.soak]"
#include <catch2/catch.hpp>

#include "engine/solvers/articulated/island.hpp"
#include "tests/solvers/chains.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

struct Setting {
  const char* name;
  Real decades;        // masses within 10^-decades .. 10^decades kg
  Real h_low, h_high;  // s, a new one at every step
  Real speed;          // m/s, of the hand
  Real drag_high;      // 1/s
};

const Setting kSettings[] = {
    {"mild", 0, 1.0 / 60, 1.0 / 60, 2, 0},
    {"masses 1e-6 to 1e6", 6, 1.0 / 60, 1.0 / 60, 2, 0},
    {"steps 0.1 ms to 1 s", 0, 1e-4, 1, 2, 0},
    {"a hand at 1000 m/s", 0, 1.0 / 60, 1.0 / 60, 1000, 0},
    {"all of these, with drag", 6, 1e-4, 1, 1000, 5},
    {"all of these", 6, 1e-4, 1, 1000, 0},
};

struct Outcome {
  bool finite = true;
  Real gap = 0;     // largest, parts of the tree's size and of how far a step drags it
  Real growth = 0;  // largest energy while held, parts of that at the start of the hold
};

/// A tree dragged by its first body in random directions for 150 steps, then held for 150.
///
/// Its energy is counted from the lowest potential that its joints allow, every body as far below
/// the hand as it can hang: so it is never negative, and 1.02 of it is a gain of 2 % of what could
/// be gained back by falling. A hold at its end begins with the drag's velocities.
Outcome torture(const Setting& how, std::uint64_t seed) {
  Random dice(seed);
  TreeSpec spec;
  spec.bodies = 2 + dice.below(29), spec.decades = how.decades;
  spec.drag = dice.between(0, how.drag_high);
  RandomTree t = random_tree(spec, dice);
  Simulation sim = Simulation::copy_of(t.world);
  sim.settings.measure = true;
  Outcome o;
  Real start = 0;
  for (int i = 0; i < 300; ++i) {
    const bool dragged = i < 150;
    const Real h = how.h_low * std::pow(how.h_high / how.h_low, dice.between(0, 1));
    const Real moved = dragged ? how.speed * h : 0;
    sim.settings.h = h;
    if (dragged) sim.world.pins[t.pin].target += moved * dice.direction();
    const StepReport report = sim.step();
    t.world.pins[t.pin].target = sim.world.pins[t.pin].target;
    o.finite = o.finite && report.status == Status::ok && is_finite(sim.world);
    if (!o.finite) return o;
    const Real far = glm::length(sim.world.pins[t.pin].target);
    const Real gap = std::max(report.measures.worst_gap, worst_pin_gap(sim.world));
    o.gap = std::max(o.gap, gap / (articulated::islands_of(sim.world)[0].size + moved + far));
    const Real energy = report.measures.energy() - t.lowest_potential();
    if (i == 149) start = energy;
    if (!dragged) o.growth = std::max(o.growth, energy / start);
  }
  return o;
}

Outcome worst_of(const Setting& how, std::uint64_t first, int trees) {
  Outcome worst;
  for (int i = 0; i < trees; ++i) {
    const Outcome o = torture(how, first + static_cast<std::uint64_t>(i));
    worst.finite = worst.finite && o.finite;
    worst.gap = std::max(worst.gap, o.gap), worst.growth = std::max(worst.growth, o.growth);
  }
  return worst;
}

void check_torture(const Setting& how, std::uint64_t first, int trees) {
  const Outcome o = worst_of(how, first, trees);
  INFO(how.name << ": gap " << o.gap << ", growth " << o.growth);
  CHECK(o.finite);
  CHECK(o.gap <= 1e-12);
  CHECK(o.growth <= 1.02);
}

}  // namespace

TEST_CASE("random trees survive any drag, any step and any masses, and gain no energy when held") {
  for (const Setting& how : kSettings) check_torture(how, 1, 20);
}

TEST_CASE("thousands of random trees survive the same", "[.soak]") {
  for (const Setting& how : kSettings) check_torture(how, 1000, 500);
}

TEST_CASE("a chain of 20 links at 15 Hz keeps its energy and never gains any") {
  ChainSpec spec;
  spec.links = 20;
  const SwingResult r = swing(spec, 15, 10, {}, false);
  // The swing's own energy: from the start to hanging straight down.
  const Real swing_energy = 20 * 9.81 * 0.5 * (1 - std::cos(spec.angle));
  INFO("start " << r.energy_start << " J, most " << r.energy_max << " J, end " << r.energy_end);
  CHECK(r.energy_max <= r.energy_start + 1e-6 * swing_energy);
  CHECK(r.energy_end > r.energy_start - 0.01 * swing_energy);
  CHECK(r.worst_gap <= 1e-14);
}

TEST_CASE("a hundred simulated minutes of a hanging chain end at rest", "[.soak]") {
  std::vector<Entity> bodies;
  ChainSpec spec;
  World w = chain(spec, &bodies);
  for (Entity e : bodies) w.bodies[e].drag = 0.3;
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 100 * 60 * 60; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(measure(sim.world).kinetic < 1e-20);
  CHECK(glm::length(tip_of(sim.world, bodies.back(), spec) - Vec3(0, -1, 0)) < 1e-9);
}
