// A fast top on a point: it nods and walks around, as the closed form for fast tops says.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("spinning_top");
  const Entity top = scene.world.find("top");
  const Real start = measure(scene.world).energy();
  Real worst_energy = 0, way = 0, last = 0;
  demos::Extras extras;
  extras.last_picture = 1.1;
  extras.check = [&](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    // Precession m g h / (I3 w3).
    const Real rate = 0.5 * 9.81 * 0.12 / (0.0036 * 150);
    f.expect("way around over that of a fast top", way / (rate * w.time), 0.95, 1.1);
    f.expect("energy gained or lost of 46, J", worst_energy, 0, 2e-5);
    f.expect("joint open at the worst, part of the size", worst.worst_gap, 0, 1e-11);
  };
  const auto script = [&](Simulation& sim, int step) {
    if (step == 0) worst_energy = way = 0, last = 0;
    worst_energy = std::max(worst_energy, std::abs(measure(sim.world).energy() - start));
    const Vec3 at = sim.world.origin_pose(top).position;
    const Real angle = std::atan2(-at.z, at.x);
    way += std::remainder(angle - last, 2 * kPi), last = angle;
  };
  return demos::run(argc, argv,
                    {.name = "spinning_top", .scene = scene, .script = script, .extras = extras});
}
