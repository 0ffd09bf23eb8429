// What a pendulum's hinge says: its angle, its speed, what it bears.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  world.default_settings.solver = Solver::lagrangian;
  const Entity frame = must(world.add(RigidBody{.motion = Motion::fixed}));
  const Entity bob = must(world.add(RigidBody{
      .shape = SphereShape{.radius = 0.05}, .mass = 2.0, .position = {1, 0, 0}, .drag = 0}));
  const Entity hinge = must(world.add(HingeJoint{.a = frame, .b = bob, .axis = {0, 0, 1}}));

  Simulation simulation(std::move(world), {.h = 1e-3});
  Real lowest = 0, strongest = 0;
  for (int i = 0; i < 2000; ++i) {
    simulation.step();
    lowest = std::min(lowest, joint_angle(simulation.world, hinge));
    strongest = std::max(strongest, glm::length(joint_reaction(simulation.world, hinge)->force));
  }
  // Let go from level it swings to the other side; below, the hinge bears three times the weight.
  std::printf("swings to %.2f rad, bears up to %.1f N\n", lowest, strongest);
}
// prints: swings to -3\.1[0-9] rad, bears up to 58\.[0-9] N
