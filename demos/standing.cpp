// A puppet stands by its joint drives: it bears a small push and falls over after a big one.
#include <algorithm>

#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("standing");
  constexpr int kSmall = 120, kBig = 324, kLong = 12;  // steps: when it is pushed, and how long
  const auto height = [](const World& w) {
    return w.bodies[w.find("puppet/pelvis")].pose.position.y;
  };
  const Real start = height(scene.world);
  Real before = 0, lowest = 0, after = 0;  // m, height of the pelvis
  demos::Extras extras;
  extras.columns = 5, extras.width = 288;
  extras.last_picture = 6;
  extras.check = [&](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    f.expect("pelvis before the small push, part of its height", before / start, 0.95, 1.05);
    f.expect("lowest during 3 s after it", lowest / start, 0.9, 1.05);
    f.expect("3 s after it", after / start, 0.95, 1.05);
    f.expect("and long after the big push", height(w) / start, 0.05, 0.4);
    f.expect("worst depth of a contact, m", worst.worst_depth, 0, 0.01);
    f.expect("worst turn beyond a limit, rad", worst.worst_violation, 0, 1e-12);
  };
  const auto script = [&](Simulation& sim, int step) {
    World& w = sim.world;
    const auto push = [&](Vec3 force) {
      const Entity chest = w.find("puppet/chest");
      w.push(chest, force, w.bodies[chest].pose.position);
    };
    if (step == kSmall) before = lowest = height(w);
    if (step >= kSmall && step < kSmall + kLong) push({0, 0, 90});
    if (step > kSmall && step <= kSmall + kLong + 180) lowest = std::min(lowest, height(w));
    if (step == kSmall + kLong + 180) after = height(w);
    if (step >= kBig && step < kBig + kLong) push({60, 0, 450});
  };
  return demos::run(argc, argv,
                    {.name = "standing", .scene = scene, .script = script, .extras = extras});
}
