// A crate on a rope is hoisted, pushed, and cut loose: events that happen at their times.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  const Entity beam = must(world.add(RigidBody{.motion = Motion::fixed, .position = {0, 5, 0}}));
  const Entity crate =
      must(world.add(RigidBody{.shape = BoxShape{{0.2, 0.2, 0.2}}, .position = {0, 1, 0}}));
  const Entity rope = must(
      world.add(CableJoint{.a = beam, .b = crate, .anchor_a = {0, 5, 0}, .anchor_b = {0, 1, 0}}));

  // From 0.5 s on, in 2 s, from 4 m to 2 m.
  must(world.add(WinchEvent{.cable = rope, .length = 2, .at = 0.5, .over = 2}));
  // 2000 N for 0.1 s: the same impulse at any step.
  must(world.add(PushEvent{.body = crate, .force = {2e3, 0, 0}, .from = 3, .to = 3.1}));
  must(world.add(CutEvent{.tie = rope, .at = 3.5}));

  Simulation simulation(std::move(world));
  const auto height_at = [&](Real time) {
    while (simulation.world.time < time) simulation.step();
    return simulation.world.bodies[crate].pose.position.y;
  };
  const Real start = height_at(0), hoisted = height_at(2.8);
  height_at(4);
  std::printf("hoisted by %.2f m, cut loose: it flies with %.1f m/s along x, %zu ropes left\n",
              hoisted - start, simulation.world.bodies[crate].velocity.x,
              simulation.world.cables.size());
}
// prints: hoisted by 2\.00 m, cut loose: it flies with [01]\.[0-9] m/s along x, 0 ropes left
