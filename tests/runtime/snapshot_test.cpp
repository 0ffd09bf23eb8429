// Copying the World is a snapshot; continuing from it repeats every bit.
#include <catch2/catch.hpp>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/puppets.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

std::vector<std::uint64_t> hashes(Simulation& simulation, int steps) {
  std::vector<std::uint64_t> all;
  for (int i = 0; i < steps; ++i) {
    simulation.step();
    all.push_back(state_hash(simulation.world));
  }
  return all;
}

World start_of(const char* which, Solver solver) {
  World world = std::string(which) == "chain" ? hung_chain(12).world : swaying_puppet().world;
  world.default_settings.solver = solver;
  return world;
}

}  // namespace

TEST_CASE("a World copied in mid-run goes on bit by bit as the original") {
  const auto solver =
      GENERATE(Solver::articulated, Solver::sweep, Solver::shake2, Solver::procedural);
  const char* which = GENERATE("chain", "puppet");
  INFO(which << ", " << name_of(solver));
  Simulation original(start_of(which, solver));
  hashes(original, 60);
  const World snapshot = original.world;
  const auto expected = hashes(original, 60);

  Simulation other = Simulation::copy_of(snapshot);
  CHECK(hashes(other, 60) == expected);
  original.world = snapshot;  // back in time
  CHECK(hashes(original, 60) == expected);
}

TEST_CASE("the same start gives the same bits twice, and motion changes them") {
  Simulation a(swaying_puppet().world), b(swaying_puppet().world);
  const auto once = hashes(a, 30);
  CHECK(hashes(b, 30) == once);
  CHECK(once[0] != once[1]);
  CHECK(once[28] != once[29]);
}

TEST_CASE("a snapshot restores links that were cut after it") {
  Chain chain = hung_chain(8);
  Simulation simulation = Simulation::copy_of(chain.world);
  hashes(simulation, 30);
  const World snapshot = simulation.world;
  const auto expected = hashes(simulation, 30);
  simulation.world.destroy(chain.links[4]);
  const auto cut = hashes(simulation, 30);
  simulation.world = snapshot;
  CHECK(hashes(simulation, 30) == expected);
  CHECK(cut != expected);
}

TEST_CASE("a copy hands out the handles that the original would") {
  World world = hung_chain(3).world;
  world.destroy(world.bodies.owners()[2]);
  World copy = world;
  CHECK(copy.create() == world.create());
  CHECK(copy.create() == world.create());
}

TEST_CASE("the number of threads does not change a bit") {
  World world;
  for (int i = 0; i < 20; ++i) {
    Body hook;
    hook.motion = Motion::fixed;
    hook.pose.position = {0, 0, 1.0 * i};
    const Entity above = world.add_body(hook);
    const Entity below = world.add_body(rod({kHalfLink, 0, 1.0 * i}));
    add_link(world, {above, below, {Vec3(0), {-kHalfLink, 0, 0}}});
  }
  Simulation one = Simulation::copy_of(world), four = Simulation::copy_of(world);
  four.settings.threads = 4;
  CHECK(hashes(one, 30) == hashes(four, 30));
}
