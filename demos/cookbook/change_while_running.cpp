// A door's motor and stops are changed while it runs, and a ball is kicked through it.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World start;
  must(start.add(
      RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}}));
  const Entity frame = must(start.add(RigidBody{.motion = Motion::fixed}));
  const Entity door = must(start.add(RigidBody{.shape = BoxShape{{0.4, 1, 0.02}},
                                               .mass = 20,
                                               .position = {0.4, 1.02, 0},
                                               .collision = Collision{}}));
  const Entity hinge = must(start.add(HingeJoint{.a = frame, .b = door, .axis = {0, 1, 0}}));
  const Entity ball = must(start.add(RigidBody{.shape = SphereShape{0.1},
                                               .mass = 0.5,
                                               .position = {0.5, 0.1, -1.5},
                                               .collision = Collision{}}));
  // The Simulation takes the World over: what is changed from here on is `world`.
  Simulation simulation(std::move(start), {1.0 / 120});
  World& world = simulation.world;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) simulation.step();
    return joint_angle(world, hinge);
  };
  // Checked like what is added; they count from the next step on.
  must(set_motor(world, hinge, {.kind = MotorKind::velocity, .target = 1.5, .gain = 200}));
  const Real opened = run(120);
  must(set_limits(world, hinge, Interval{0, 1}));
  const Real stopped = run(120);
  must(set_motor(world, hinge,
                 {.kind = MotorKind::position, .target = 0, .gain = 80, .damping = 40}));
  const Real shut = run(240);

  must(ignore(world, ball, door, 1));
  must(impulse(world, ball, {0, 0, 3}, world.bodies[ball].pose.position));
  run(60);
  std::printf(
      "opened by %.2f rad, held at %.2f, shut at %.2f; the ball is %.0f m behind the door\n",
      opened, stopped, shut, world.bodies[ball].pose.position.z);
}
// prints: opened by 1.47 rad, held at 0.99, shut at 0.01; the ball is 1 m behind the door
