// A puppet on five cables, held by a crossbar that sways.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  const Ragdoll puppet = must(build_ragdoll(world, {.height = 0.6, .mass = 2}));
  const Vec3 hand{0, 1, 0};
  const Entity bar = must(world.add(RigidBody{.motion = Motion::kinematic, .position = hand}));
  Lissajous sway;
  sway.centre.position = hand, sway.rise = 1;
  sway.amplitude = {0.1, 0.03, 0.05}, sway.frequency = {0.4, 0.8, 0.3};
  world.paths.add(bar, {sway});

  std::vector<Entity> cables;
  for (const Entity limb :
       {puppet.head, puppet.forearms[0], puppet.forearms[1], puppet.shins[0], puppet.shins[1]}) {
    const Vec3 below = world.bodies[limb].pose.position;
    const CableJoint string{
        .a = bar, .b = limb, .anchor_a = {below.x, hand.y, 0}, .anchor_b = below};
    cables.push_back(must(world.add(string)));
  }
  Simulation simulation(std::move(world));
  for (int i = 0; i < 600; ++i)
    if (simulation.step().status != Status::ok) return 1;
  Real borne = 0;
  for (const Entity string : cables) borne += cable_tension(simulation.world, string);
  std::printf("the cables pull with %.0f N together\n", borne);
}
// prints: the cables pull with [1-4][0-9] N together
