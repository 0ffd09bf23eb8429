// A door on a hinge, opened by a motor.
#include <cstdio>
#include <pantin/pantin.hpp>
using namespace pantin;
int main() {
  World world;
  const Entity wall = must(world.add(RigidBody{.motion = Motion::fixed}));
  const RigidBody door{.shape = BoxShape{{0.45, 1, 0.02}}, .position = {0.45, 1, 0}};
  const JointMotor motor{.kind = MotorKind::velocity, .target = 0.5, .gain = 200};
  const HingeJoint edge{.a = wall, .b = must(world.add(door)), .axis = {0, 1, 0}, .motor = motor};
  const Entity hinge = must(world.add(edge));
  Simulation simulation(std::move(world));  // takes it over
  for (int i = 0; i < 120; ++i) simulation.step();
  const Vec3 middle = simulation.world.bodies[edge.b].pose.position;
  std::printf("open by %.2f rad, z %.2f m\n", joint_angle(simulation.world, hinge), middle.z);
}
// prints: open by 0\.9[0-9] rad, z -0\.3[0-9] m
