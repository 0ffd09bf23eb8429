// A cam through points lifts a flat face, in the plane and in space.
#include <cmath>
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

namespace {

/// How high the face stands after a second, m.
Real lift(Solver solver) {
  World world;
  world.default_settings.solver = solver;
  world.default_settings.integrator = Integrator::rk4;
  std::vector<Vec3> points;  // an egg: 0.1 m, and 0.14 m on one side
  for (int i = 0; i < 12; ++i) {
    const Real angle = i * kPi / 6, radius = 0.12 + 0.02 * std::cos(angle);
    points.push_back(radius * Vec3(std::cos(angle), std::sin(angle), 0));
  }
  const Entity frame = must(world.add(RigidBody{.motion = Motion::fixed}));
  const Entity cam =
      must(world.add(RigidBody{.mass = 1, .inertia = Mat3(1e3), .angular_velocity = {0, 0, 3}}));
  const Entity face = must(world.add(
      RigidBody{.mass = 1, .inertia = Mat3(0.01), .position = {0, 0.13, 0}, .name = "face"}));
  must(world.add(HingeJoint{.a = frame, .b = cam, .axis = {0, 0, 1}}));
  must(world.add(PrismaticJoint{.a = frame, .b = face, .anchor = {0, 0.13, 0}, .axis = {0, 1, 0}}));
  SurfaceJoint touch{.a = cam,
                     .b = face,
                     .curve_a = must(NurbsCurve::around(points)),
                     .curve_b = NurbsCurve::line({-1, 0, 0}, {1, 0, 0})};
  touch.motion = SurfaceMotion::sliding;
  must(world.add(touch));
  Simulation sim(std::move(world), {0.005});
  for (int i = 0; i < 200; ++i) sim.step();
  return sim.world.bodies[face].pose.position.y;
}

}  // namespace

int main() { std::printf("%.4f %.4f\n", lift(Solver::planar), lift(Solver::lagrangian)); }
// prints: 0\.1243 0\.1243
