// A chain held at both ends, cut in the middle while it hangs.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("pinned_chain");
  const auto script = [&](Simulation& sim, int step) {
    if (step != 30) return;
    const auto links = sim.world.links.owners();
    sim.world.destroy(links[links.size() / 2]);
  };
  return demos::run(argc, argv, {.name = "cut", .scene = scene, .script = script});
}
