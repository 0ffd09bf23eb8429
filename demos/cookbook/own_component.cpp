// A component and two systems of one's own: a wind that blows on sails, and a log of the fastest.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

struct Sail {
  Real area = 0;  // m^2
  // What of it belongs to the state, for state_hash().
  static void fields(auto& self, auto&& field) { field("area", self.area); }
};

int main() {
  World world;
  world.gravity = Vec3(0);
  for (int i = 0; i < 3; ++i) {
    const Entity boat = must(
        world.add(RigidBody{.shape = SphereShape{.radius = 0.2}, .position = {0, 0, 1.0 * i}}));
    world.store<Sail>().add(boat, {0.5 * i});
  }
  Simulation simulation(std::move(world));
  Real fastest = 0;
  // A system that only looks takes a const World.
  must(simulation.insert(Stage::after_step, {.name = "log"}, [&](const World& w, Real) {
    for (auto [boat, body, sail] : w.view<Body, Sail>())
      fastest = std::max(fastest, body.velocity.x);
  }));
  must(simulation.insert(Stage::before_update, {.name = "wind"}, [](World& w, Real) {
    for (auto [boat, body, sail] : w.view<Body, Sail>())
      w.push(boat, {20 * sail.area, 0, 0}, body.pose.position);
  }));
  for (int i = 0; i < 60; ++i) simulation.step();
  must(simulation.remove("wind"));
  simulation.step();
  std::printf("fastest %.2f m/s\n", fastest);
}
// prints: fastest 0\.[56][0-9] m/s
