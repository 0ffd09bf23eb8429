// The cost of a step grows with the number of links and no faster.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>

#include "tests/solvers/chains.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Seconds of one step of a chain, per link: the least of many, since other work only adds.
Real time_per_link(int links, Solver solver) {
  ChainSpec spec;
  spec.links = links;
  World w = chain(spec);
  w.default_settings.solver = solver;
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 5; ++i) sim.step();
  const int at_once = std::max(1, 2000 / links);
  Real least = 1e9;
  for (int sample = 0; sample < 60; ++sample) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < at_once; ++i) sim.step();
    const std::chrono::duration<Real> taken = std::chrono::steady_clock::now() - start;
    least = std::min(least, taken.count() / at_once / links);
  }
  return least;
}

}  // namespace

TEST_CASE("a link of a chain of a thousand costs what one of fifty costs") {
  const Solver solver = GENERATE(Solver::automatic, Solver::sweep);
  Real ratio = 1e9;
  // A machine with other work to do may disturb one measurement, not all.
  for (int attempt = 0; attempt < 10 && ratio > 1.5; ++attempt)
    ratio = time_per_link(1000, solver) / time_per_link(50, solver);
  INFO(name_of(solver) << ": " << ratio);
  CHECK(ratio <= 1.5);
}

TEST_CASE("an articulation takes less than a kibibyte a link") {
  ChainSpec spec;
  spec.links = 1000;
  Simulation sim(chain(spec), {1.0 / 60});
  sim.step();
  const Articulation& a = sim.world.articulations[0];
  const auto bytes = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  const std::size_t all =
      bytes(a.constants.numbers()) + bytes(a.memory.numbers()) + bytes(a.room.work.numbers()) +
      bytes(a.room.nodes) + bytes(a.room.blocks) + bytes(a.room.slide) +
      bytes(a.room.turn) + bytes(a.room.loads) + bytes(a.bodies) + bytes(a.slots) +
      bytes(a.parents) + bytes(a.links) + spec.links * (sizeof(Body) + sizeof(Link));
  CHECK(all < 1024u * static_cast<std::size_t>(spec.links));
}
