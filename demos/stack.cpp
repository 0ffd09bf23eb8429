// Ten boxes are set one on the other, stay where they are and fall asleep.
#include <algorithm>

#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("stack");
  demos::Extras extras;
  extras.columns = 3;
  extras.check = [&](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    Real aside = 0;
    for (std::size_t i = 0; i < w.bodies.size(); ++i) {
      const Vec3 way =
          w.bodies.values()[i].pose.position - scene.world.bodies.values()[i].pose.position;
      aside = std::max({aside, std::abs(way.x), std::abs(way.z)});
    }
    f.expect("farthest that a box moved aside, m", aside, 0, 2e-3);
    f.expect("boxes asleep", worst.last.asleep, 10, 10);
    f.expect("worst depth of a contact, m", worst.worst_depth, 0, 2e-3);
  };
  return demos::run(argc, argv, {.name = "stack", .scene = scene, .extras = extras});
}
