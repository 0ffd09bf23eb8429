// A pyramid of twenty-one boxes stands: none moves by a millimetre.
#include <algorithm>

#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("pyramid");
  demos::Extras extras;
  extras.columns = 3;
  extras.check = [&](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    Real moved = 0, fastest = 0;
    for (std::size_t i = 0; i < w.bodies.size(); ++i) {
      const Body& now = w.bodies.values()[i];
      const Body& then = scene.world.bodies.values()[i];
      moved = std::max(moved, glm::length(now.pose.position - then.pose.position));
      fastest = std::max(fastest, glm::length(now.velocity));
    }
    f.expect("farthest that a box moved, m", moved, 0, 1e-3);
    f.expect("fastest box at the end, m/s", fastest, 0, 1e-4);
    f.expect("worst depth of a contact, m", worst.worst_depth, 0, 1e-3);
  };
  return demos::run(argc, argv, {.name = "pyramid", .scene = scene, .extras = extras});
}
