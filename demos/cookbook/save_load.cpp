// A running World is saved and loaded: what goes on from the file does so with the same bits.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  must(world.add(
      RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}}));
  must(build_ragdoll(world, {.position = {0, 1, 0}}));

  Simulation simulation(std::move(world));
  for (int i = 0; i < 40; ++i) simulation.step();  // in the midst of its fall
  must(save_world(simulation.world, "falling.world"));

  Simulation loaded(must(load_world("falling.world")));
  for (int i = 0; i < 120; ++i) simulation.step(), loaded.step();
  std::printf("tick %d and tick %d, same bits: %s\n", static_cast<int>(simulation.world.tick),
              static_cast<int>(loaded.world.tick),
              state_hash(simulation.world) == state_hash(loaded.world) ? "yes" : "no");
}
// prints: tick 160 and tick 160, same bits: yes
