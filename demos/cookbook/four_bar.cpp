// A four-bar linkage whose crank is turned by a motor, with exact joints.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  world.default_settings.solver = Solver::lagrangian;
  const Vec3 a{0, 0, 0}, b{0, 0.3, 0}, c{0.871904, 0.789677, 0}, d{1, 0, 0}, out{0, 0, 1};
  const auto bar = [&](Vec3 from, Vec3 to) {
    const Vec3 along = to - from;
    return must(world.add(
        RigidBody{.shape = CapsuleShape{.radius = 0.02, .half_length = glm::length(along) / 2},
                  .position = (from + to) / 2.0,
                  .rotation = glm::angleAxis(std::atan2(-along.x, along.y), out)}));
  };
  const Entity frame = must(world.add(RigidBody{.motion = Motion::fixed}));
  const Entity crank = bar(a, b), coupler = bar(b, c), rocker = bar(c, d);
  const JointMotor motor{.kind = MotorKind::velocity, .target = 2 * kPi, .gain = 50};
  const Entity drive =
      must(world.add(HingeJoint{.a = frame, .b = crank, .anchor = a, .axis = out, .motor = motor}));
  must(world.add(HingeJoint{.a = crank, .b = coupler, .anchor = b, .axis = out}));
  must(world.add(HingeJoint{.a = coupler, .b = rocker, .anchor = c, .axis = out}));
  const Entity swing =
      must(world.add(HingeJoint{.a = rocker, .b = frame, .anchor = d, .axis = out}));

  Simulation simulation(std::move(world), {.h = 1.0 / 240, .measure = true});
  Real low = 0, high = 0, gap = 0;
  for (int i = 0; i < 480; ++i) {
    gap = std::max(gap, simulation.step().measures.worst_gap);
    low = std::min(low, joint_angle(simulation.world, swing));
    high = std::max(high, joint_angle(simulation.world, swing));
  }
  std::printf("%.1f turns, rocker swings by %.2f rad, joints open by less than 1e-9 m: %s\n",
              joint_angle(simulation.world, drive) / (2 * kPi), high - low,
              gap < 1e-9 ? "yes" : "no");
}
// prints: [12]\.[0-9] turns, rocker swings by 0\.[6-9][0-9] rad, .* yes
