// What is alike on both sides stays so: which of two blows comes first is no matter of the step.
#include <catch2/catch.hpp>

#include "engine/scene/scene.hpp"
#include "tests/paths.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// m: the largest distance between a body and the mirror image of its pair on the other side of the
/// plane z = 0.
Real largest_difference(const World& w) {
  Real most = 0;
  for (const Entity left : w.bodies.owners()) {
    const std::string name(w.name_of(left));
    if (!name.ends_with("_l")) continue;
    const Entity right = w.find(name.substr(0, name.size() - 1) + "r");
    const Vec3 p = w.bodies[right].pose.position;
    most = std::max(most, glm::distance(w.bodies[left].pose.position, Vec3(p.x, p.y, -p.z)));
  }
  return most;
}

}  // namespace

TEST_CASE("a puppet that is pushed straight ahead falls alike on both sides") {
  for (const int rate : {60, 240, 960, 3840}) {
    const auto read = load_scene(asset("scenes/stairs.json"));
    REQUIRE(read);
    Simulation sim(read->world, {1.0 / rate});
    for (int i = 0; 2 * i < rate; ++i) sim.step();
    INFO(rate << " Hz");
    CHECK(largest_difference(sim.world) < 5e-4);
  }
}
