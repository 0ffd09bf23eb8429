// Motions that are alike stay so: neither which of two blows falls into the earlier step decides
// them, nor sweeps that are cut short.
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

TEST_CASE("crates on a bridge of planks go where they go if weight is a millionth more") {
  std::vector<Vec3> places[2];
  for (const int heavier : {0, 1}) {
    const auto read = load_scene(asset("scenes/rope_bridge.json"));
    REQUIRE(read);
    World w = read->world;
    w.gravity *= 1 + 1e-6 * heavier;
    Simulation sim(std::move(w), {1.0 / 3840});
    while (sim.world.time < 0.8) sim.step();
    for (const Body& b : sim.world.bodies.values()) places[heavier].push_back(b.pose.position);
  }
  Real most = 0;
  for (std::size_t i = 0; i < places[0].size(); ++i)
    most = std::max(most, glm::distance(places[0][i], places[1][i]));
  CHECK(most < 3e-5);  // 3e-6 as they fall
}
