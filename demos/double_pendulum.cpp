// A double pendulum by RATTLE: its energy sways a little and never drifts.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("double_pendulum");
  const Real start = measure(scene.world).energy();
  Real least = 0, most = 0;
  demos::Extras extras;
  extras.last_picture = 1.2;
  extras.check = [&](const World&, const demos::Outcome& worst, demos::Findings& f) {
    f.expect("most energy gained, J", most, 0, 0.02);
    f.expect("most energy lost of 14.7, J", -least, 0, 0.2);
    f.expect("joints open at the worst, part of the size", worst.worst_gap, 0, 1e-12);
  };
  const auto script = [&](Simulation& sim, int step) {
    if (step == 0) least = most = 0;
    const Real change = measure(sim.world).energy() - start;
    least = std::min(least, change), most = std::max(most, change);
  };
  return demos::run(
      argc, argv, {.name = "double_pendulum", .scene = scene, .script = script, .extras = extras});
}
