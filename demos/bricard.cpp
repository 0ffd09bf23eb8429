// Bricard's loop falls and swings: six hinges hold thirty freedoms of five rods, and it moves.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("bricard");
  const Real start = measure(scene.world).energy();
  Real worst_energy = 0;
  demos::Extras extras;
  extras.last_picture = 1.5;
  extras.check = [&](const World&, const demos::Outcome& worst, demos::Findings& f) {
    f.expect("energy gained or lost, J", worst_energy, 0, 2e-3);
    f.expect("joints open at the worst, part of the size", worst.worst_gap, 0, 1e-12);
    f.expect("equations of its hinges", worst.last.rows, 30, 30);
    f.expect("that do not follow from others", worst.last.rank, 29, 29);
  };
  const auto script = [&](Simulation& sim, int step) {
    if (step == 0) worst_energy = 0;
    worst_energy = std::max(worst_energy, std::abs(measure(sim.world).energy() - start));
  };
  return demos::run(argc, argv,
                    {.name = "bricard", .scene = scene, .script = script, .extras = extras});
}
