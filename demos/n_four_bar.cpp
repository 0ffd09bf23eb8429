// Ten four-bar windows side by side. Where all links lie level the joints lose rank, and the
// linkage could fold; it goes on as it came.
#include <string>

#include "demos/demo.hpp"

using namespace pantin;

namespace {
constexpr int kPosts = 11;
}

int main(int argc, char** argv) {
  const Scene scene = demos::load("n_four_bar");
  const Real start = measure(scene.world).energy();
  Entity posts[kPosts];
  for (int i = 0; i < kPosts; ++i) posts[i] = scene.world.find("post" + std::to_string(i));
  Real worst_energy = 0, worst_angle = 0, way = 0, last = 0;
  demos::Extras extras;
  extras.columns = 4, extras.width = 400, extras.height = 180;
  extras.last_picture = 2.4;
  extras.check = [&](const World&, const demos::Outcome& worst, demos::Findings& f) {
    f.expect("energy gained or lost of 190, J", worst_energy, 0, 1e-2);
    f.expect("posts that should be parallel are, but for rad", worst_angle, 0, 1e-6);
    f.expect("turns", -way / (2 * kPi), 1, 20);
    f.expect("joints open at the worst, part of the size", worst.worst_gap, 0, 1e-12);
  };
  const auto script = [&](Simulation& sim, int step) {
    if (step == 0) worst_energy = worst_angle = way = 0, last = kPi / 2;
    worst_energy = std::max(worst_energy, std::abs(measure(sim.world).energy() - start));
    Real first = 0;
    for (int i = 0; i < kPosts; ++i) {
      const Vec3 x = sim.world.origin_pose(posts[i]).rotation * Vec3(1, 0, 0);
      const Real angle = std::atan2(x.y, x.x);
      if (i == 0) first = angle;
      worst_angle = std::max(worst_angle, std::abs(std::remainder(angle - first, 2 * kPi)));
    }
    way += std::remainder(first - last, 2 * kPi), last = first;
  };
  return demos::run(argc, argv,
                    {.name = "n_four_bar", .scene = scene, .script = script, .extras = extras});
}
