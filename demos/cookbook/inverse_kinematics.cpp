// A figure reaches for a ball and looks at it, its feet stay: inverse kinematics within limits.
#include <cmath>
#include <cstdio>
#include <pantin/assembler.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  world.default_settings.solver = Solver::lagrangian;
  const Ragdoll doll = must(build_ragdoll(world, {}));
  Assembler figure(world);
  for (const Entity foot : doll.feet) figure.hold(foot);
  const Vec3 tip{0, -0.13, 0};  // of the forearm, whose own frame has y along the bone
  const Vec3 rest = to_world(world.bodies[doll.forearms[1]].pose, tip);
  const Target hand =
      must(figure.add(PointTarget{.body = doll.forearms[1], .point = tip, .target = rest}));
  const Target gaze = must(figure.add(
      AimTarget{.body = doll.head, .direction = {0, 0, 1}, .target = {0, 1.6, 1}, .weight = 0.1}));

  Real joints = 0, far = 0;
  for (int i = 0; i < 600; ++i) {  // the ball circles in front of the figure
    const Real angle = 2 * kPi * i / 600;
    const Vec3 ball = rest + Vec3(0.15 * (std::cos(angle) - 1), 0.3 + 0.2 * std::sin(angle), 0.3);
    figure.move(hand, ball), figure.move(gaze, ball);
    const AssemblerErrors errors = figure.iterate();
    joints = std::max(joints, errors.joints);
    if (i > 100) far = std::max(far, errors.targets);
  }
  const Vec3 at = to_world(figure.world().bodies[doll.forearms[1]].pose, tip);
  std::printf("the hand is at (%.2f, %.2f, %.2f), targets within %.0e m, joints within %.0e\n",
              at.x, at.y, at.z, far, joints);
}
// prints: the hand is at .*, targets within .e-0[5-9] m, joints within .e-(0[6-9]|1.)
