// A ragdoll falls down a flight of stairs.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  RigidBody stairs{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}};
  for (int i = 0; i < 8; ++i)  // one box a step, the highest one last
    stairs.shapes.push_back(
        BoxShape{.half_extents = {1, 0.1 * (i + 1), 0.15}, .at = {{0, 0.1 * (i + 1), -0.3 * i}}});
  must(world.add(stairs));
  const Ragdoll doll = must(
      build_ragdoll(world, {.position = {0, 1.65, -1.9}, .collision = Collision{.friction = 0.3}}));
  world.bodies[doll.chest].velocity = {0, 0, 2.5};  // a push in the back

  Simulation simulation(std::move(world));
  for (int i = 0; i < 300; ++i)
    if (simulation.step().status != Status::ok) return 1;
  const Vec3 pelvis = simulation.world.bodies[doll.pelvis].pose.position;
  std::printf("pelvis %.1f m from where it stood, %.1f m lower\n", pelvis.z + 1.9, 2.6 - pelvis.y);
}
// prints: pelvis [0-9.]+ m from where it stood, [1-2]\.[0-9] m lower
