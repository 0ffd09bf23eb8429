// A slider-crank: where the piston is follows from the crank's angle.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("slider_crank");
  const Entity crank = scene.world.find("crank"), piston = scene.world.find("piston");
  constexpr Real kCrank = 0.3, kRod = 0.8;
  Real worst_place = 0, way = 0, last = 0;
  demos::Extras extras;
  extras.last_picture = 1.4;
  extras.check = [&](const World&, const demos::Outcome& worst, demos::Findings& f) {
    f.expect("piston off its place, m", worst_place, 0, 2e-9);
    f.expect("turns of the crank", way / (2 * kPi), 2.8, 3.5);
    f.expect("joints open at the worst, part of the size", worst.worst_gap, 0, 1e-12);
  };
  const auto script = [&](Simulation& sim, int step) {
    const Vec3 x = sim.world.origin_pose(crank).rotation * Vec3(1, 0, 0);
    const Real angle = std::atan2(x.y, x.x);
    if (step == 0) worst_place = way = 0, last = angle;
    way += std::remainder(angle - last, 2 * kPi), last = angle;
    const Real across = kCrank * std::sin(angle);
    const Real place = kCrank * std::cos(angle) + std::sqrt(kRod * kRod - across * across);
    const Real found = sim.world.origin_pose(piston).position.x;
    worst_place = std::max(worst_place, std::abs(found - place));
  };
  return demos::run(argc, argv,
                    {.name = "slider_crank", .scene = scene, .script = script, .extras = extras});
}
