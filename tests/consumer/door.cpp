// A door on a hinge and a chain on its handle, through the installed headers only.
#include <cmath>
#include <cstdio>
#include <pantin/pantin.hpp>

int main() {
  using namespace pantin;
  World world;
  world.default_settings.solver = Solver::lagrangian;
  const Entity wall = world.add(RigidBody{.motion = Motion::fixed}).value();
  const Entity door = world
                          .add(RigidBody{.shape = BoxShape{.half_extents = {0.45, 1, 0.02}},
                                         .density = 600,
                                         .position = {0.45, 1, 0}})
                          .value();
  const Entity hinge =
      world
          .add(HingeJoint{.a = wall,
                          .b = door,
                          .axis = {0, 1, 0},
                          .motor = {.kind = MotorKind::velocity, .target = 0.5, .gain = 200}})
          .value();
  const Chain chain =
      build_chain(world, {.from = {0.8, 1, 0.02}, .to = {0.8, 0.5, 0.02}, .start = door}).value();

  StepSettings settings;
  settings.measure = true;
  Simulation simulation = Simulation::copy_of(world, settings);
  for (int i = 0; i < 240; ++i) {
    const StepReport report = simulation.step();
    if (report.status != Status::ok || !(report.measures.worst_gap_rel <= 1e-6)) {
      std::printf("step %d: joints open by %g of the size\n", i, report.measures.worst_gap_rel);
      return 1;
    }
  }
  const Real angle = joint_angle(simulation.world, hinge);
  const Vec3 end = simulation.world.bodies[chain.links.back()].pose.position;
  std::printf("door at %.3f rad, end of the chain at %.3f %.3f %.3f m\n", angle, end.x, end.y,
              end.z);
  return angle > 1.5 && angle < 2.5 && end.z < -0.3 ? 0 : 1;
}
