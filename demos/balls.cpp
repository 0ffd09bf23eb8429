// A hundred balls drop into a bin: none gets out, and what they fell with is gone.
#include <algorithm>

#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("balls");
  demos::Extras extras;
  extras.last_picture = 2;
  extras.check = [](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    Real lowest = 1e300, farthest = 0, fastest = 0;
    for (const Body& b : w.bodies.values()) {
      if (b.motion != Motion::dynamic) continue;
      const Vec3 p = b.pose.position;
      lowest = std::min(lowest, p.y);
      farthest = std::max({farthest, std::abs(p.x), std::abs(p.z)});
      fastest = std::max(fastest, glm::length(b.velocity));
    }
    f.expect("lowest centre of a ball, m", lowest, 0.05, 0.2);
    f.expect("farthest centre from the middle of the bin, m", farthest, 0, 0.5);
    f.expect("fastest ball at the end, m/s", fastest, 0, 0.05);
    f.expect("worst depth of a contact, m", worst.worst_depth, 0, 0.04);
  };
  return demos::run(argc, argv, {.name = "balls", .scene = scene, .extras = extras});
}
