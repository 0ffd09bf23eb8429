// A chain nailed at one end and pulled towards a place that it cannot reach: it settles as near as
// it gets, and says how far that is.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("unreachable");
  const auto script = [](Simulation& sim, int step) {
    if (step == 0 || step % 60 != 0) return;
    for (std::size_t i = 0; i < sim.world.pins.size(); ++i) {
      const Pin& pin = sim.world.pins.values()[i];
      std::printf("%6.2f s  pin %s: %.4f m from its target%s\n", sim.world.time,
                  sim.world.name_of(sim.world.pins.owners()[i]).c_str(), pin.residual,
                  pin.reachable ? "" : ", which is out of reach");
    }
  };
  return demos::run(argc, argv, {.name = "unreachable", .scene = scene, .script = script});
}
