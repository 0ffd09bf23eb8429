// A chain held at both ends, cut in the middle while it hangs.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("pinned_chain");
  return demos::run(argc, argv, "cut", scene, [&](Simulation& sim, int step) {
    if (step != 30) return;
    const auto links = sim.world.links.owners();
    sim.world.destroy(links[links.size() / 2]);
  });
}
