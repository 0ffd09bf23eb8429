// Rods with limits on elastic cables, in which a step is left to sweeps: these know no elastic
// force, and may not let the cable store energy that the rods do not lose.
#include "engine/runtime/simulation.hpp"
#include "tests/paths.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::test;

TEST_CASE("a step without elastic forces stretches no elastic cable") {
  const char* const name = GENERATE("two_rods", "three_rods", "stiff_cable");
  CAPTURE(name);
  const auto scene = load_scene(test_data(std::string("elastic_puppets/") + name + ".json"));
  REQUIRE(scene);
  Simulation sim = Simulation::copy_of(scene->world, {scene->step});
  const Real first = measure(sim.world).energy();
  for (int i = 0; i < 120; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    CHECK(measure(sim.world).energy() < first + 1e-3 * std::abs(first));
  }
}
