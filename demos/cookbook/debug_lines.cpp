// Lines for a picture of your own: joints, limits, contacts and cables by draw_debug.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  must(world.add(
      RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}}));
  const Entity post = must(world.add(RigidBody{.motion = Motion::fixed, .position = {0, 1, 0}}));
  const Entity lid = must(world.add(RigidBody{
      .shape = BoxShape{{0.3, 0.02, 0.2}}, .position = {0.3, 1, 0}, .collision = Collision{}}));
  must(world.add(HingeJoint{
      .a = post, .b = lid, .anchor = {0, 1, 0}, .axis = {0, 0, 1}, .limits = Interval{-0.5, 1}}));
  must(world.add(RigidBody{
      .shape = SphereShape{0.1}, .mass = 2, .position = {2, 0.1, 0}, .collision = Collision{}}));
  Simulation simulation(std::move(world));
  for (int i = 0; i < 240; ++i) simulation.step();

  // Each line goes to your renderer; here into lines of an OBJ file on the screen.
  int points = 0;
  const auto draw = [&](const DebugLine& line) {
    for (const Vec3 p : {line.from, line.to}) std::printf("v %.3f %.3f %.3f\n", p.x, p.y, p.z);
    std::printf("l %d %d\n", points + 1, points + 2);
    points += 2;
  };
  draw_debug(simulation.world, {.size = 0.15}, draw);

  Vec3 borne(0);  // what the contacts bear, read off the lines of the forces
  draw_debug(simulation.world,
             {.joints = false, .limits = false, .contacts = false, .force_scale = 1},
             [&](const DebugLine& line) { borne += line.to - line.from; });
  std::printf("%d lines, contacts bear %.1f N\n", points / 2, borne.y);
}
// prints: [0-9]+ lines, contacts bear 19\.6 N
