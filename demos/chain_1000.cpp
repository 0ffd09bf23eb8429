// A thousand links by the exact solver, in time linear in their number; after a second one end is
// let go.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("chain_1000");
  const Real start = measure(scene.world).energy();
  Real most = 0;
  demos::Extras extras;
  extras.last_picture = 2.4;
  extras.check = [&](const World&, const demos::Outcome& worst, demos::Findings& f) {
    f.expect("energy gained, J", most, -1e9, 1e-6);
    f.expect("equations of its joints and its last pin", worst.last.rows, 3000, 3000);
    f.expect("joints open at the worst, part of the size", worst.worst_gap, 0, 1e-12);
  };
  const auto script = [&](Simulation& sim, int step) {
    if (step == 0) most = -1e9;
    if (step == 240) sim.world.destroy(sim.world.find("right"));
    if (step > 0) most = std::max(most, measure(sim.world).energy() - start);
  };
  return demos::run(argc, argv,
                    {.name = "chain_1000", .scene = scene, .script = script, .extras = extras});
}
