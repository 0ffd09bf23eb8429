// A kinematic ball moves through a curtain of ropes, which give way and swing back.
#include <algorithm>
#include <string>

#include "demos/demo.hpp"

using namespace pantin;

namespace {
constexpr int kRopes = 16;

/// How far the lower end of a rope is from where it hangs at rest, m.
Real aside(const World& w, const Scene& scene, int rope) {
  const Entity end = w.find("rope" + std::to_string(rope) + "/13");
  return glm::length(w.bodies[end].pose.position - scene.world.bodies[end].pose.position);
}
}  // namespace

int main(int argc, char** argv) {
  const Scene scene = demos::load("curtain");
  Real farthest[kRopes] = {};
  demos::Extras extras;
  extras.last_picture = 4.8;
  extras.check = [&](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    Real left = 0;
    for (int i = 0; i < kRopes; ++i) left = std::max(left, aside(w, scene, i));
    f.expect("least that a rope was pushed aside, m", *std::ranges::min_element(farthest), 0.15, 1);
    f.expect("most that a rope is still aside, m", left, 0, 0.05);
    f.expect("worst depth of a contact, m", worst.worst_depth, 0, 0.01);
    f.expect("worst turn beyond a limit, rad", worst.worst_violation, 0, 1e-12);
  };
  const auto script = [&](Simulation& sim, int step) {
    for (int i = 0; i < kRopes; ++i)
      farthest[i] = std::max(step == 0 ? 0 : farthest[i], aside(sim.world, scene, i));
  };
  return demos::run(argc, argv,
                    {.name = "curtain", .scene = scene, .script = script, .extras = extras});
}
