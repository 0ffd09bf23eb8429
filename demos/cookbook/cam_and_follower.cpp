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
  const Entity frame = world.add(RigidBody{.motion = Motion::fixed}).value();
  const Entity cam =
      world.add(RigidBody{.mass = 1, .inertia = Mat3(1e3), .angular_velocity = {0, 0, 3}}).value();
  const Entity face =
      world
          .add(
              RigidBody{.mass = 1, .inertia = Mat3(0.01), .position = {0, 0.13, 0}, .name = "face"})
          .value();
  world.add(HingeJoint{.a = frame, .b = cam, .axis = {0, 0, 1}}).value();
  world.add(PrismaticJoint{.a = frame, .b = face, .anchor = {0, 0.13, 0}, .axis = {0, 1, 0}})
      .value();
  SurfaceJoint touch{.a = cam,
                     .b = face,
                     .curve_a = NurbsCurve::around(points).value(),
                     .curve_b = NurbsCurve::line({-1, 0, 0}, {1, 0, 0})};
  touch.motion = SurfaceMotion::sliding;
  world.add(touch).value();
  Simulation sim(world, {0.005});
  for (int i = 0; i < 200; ++i) sim.step();
  return sim.world.bodies[face].pose.position.y;
}

}  // namespace

int main() { std::printf("%.4f %.4f\n", lift(Solver::planar), lift(Solver::lagrangian)); }
// prints: 0\.1243 0\.1243
