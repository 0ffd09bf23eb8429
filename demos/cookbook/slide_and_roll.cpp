// A ball that is thrown slides, then rolls at five sevenths of its speed: surfaces that touch.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  world.default_settings.solver = Solver::lagrangian;
  // A lane of NURBS: degree 1, 20 m by 2 m, its outer side up.
  NurbsShape lane;
  lane.faces = {{.degree_u = 1,
                 .degree_v = 1,
                 .knots_u = {0, 0, 1, 1},
                 .knots_v = {0, 0, 1, 1},
                 .points = {{-10, 0, -1}, {10, 0, -1}, {-10, 0, 1}, {10, 0, 1}}}};
  const Entity ground = must(world.add(RigidBody{.motion = Motion::fixed, .shape = lane}));
  const Entity ball = must(world.add(RigidBody{
      .shape = SphereShape{.radius = 0.1}, .position = {-9, 0.1, 0}, .velocity = {7, 0, 0}}));
  const Entity joint = must(world.add(SurfaceJoint{.a = ball,
                                                   .b = ground,
                                                   .motion = SurfaceMotion::sliding,
                                                   .may_lift = true,
                                                   .friction = 0.2}));

  Simulation simulation(std::move(world), {1.0 / 120});
  bool slid = false;
  for (int i = 0; i < 240; ++i) {
    simulation.step();
    const SurfaceTouch touch = surface_touch(simulation.world, joint).value();
    const Real speed = simulation.world.bodies[ball].velocity.x;
    if (slid && !touch.slips)
      std::printf("%.2f s: rolls at %.3f m/s\n", simulation.world.time, speed);
    slid = touch.slips;
  }
}
// prints: 1\.0[23] s: rolls at 5\.000 m/s
