// A chain hung by one end and let go; drag brings it to rest.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  const Entity hook = must(world.add(RigidBody{.motion = Motion::fixed, .position = {0, 2, 0}}));
  const Chain chain = must(build_chain(
      world, {.from = {0, 2, 0}, .to = {1, 2, 0}, .links = 20, .start = hook, .drag = 0.5}));

  Simulation simulation(std::move(world));  // 60 steps a second
  for (int i = 0; i < 1800; ++i) simulation.step();
  const Vec3 tip = simulation.world.bodies[chain.links.back()].pose.position;
  std::printf("after 30 s the last link hangs %.2f m below the hook\n", 2 - tip.y);
}
// prints: hangs 0\.9[0-9] m below
