// A rope of the articulated solver hangs on a gate of the Lagrangian one: each feels the other.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("gate");
  const Entity gate = scene.world.find("gate"), end = scene.world.find("rope/13"),
               knot = scene.world.find("knot");
  Real farthest = 0, pulled = 0;
  demos::Extras extras;
  extras.last_picture = 2.4;
  extras.check = [&](const World& w, const demos::Outcome& worst, demos::Findings& f) {
    f.expect("rope swings out, m", farthest, 0.1, 1);
    f.expect("pull of the rope on the gate at most, N", pulled, 1, 60);
    f.expect("knot open at the worst, m", worst.worst_residual, 0, 1e-4);
    f.expect("joints open at the worst, part of the size", worst.worst_gap, 0, 1e-11);
    f.expect("gate still turns, rad/s", std::abs(w.bodies[gate].angular_velocity.y), 0, 1.6);
  };
  const auto script = [&](Simulation& sim, int step) {
    if (step == 0) farthest = pulled = 0;
    const Vec3 corner = to_world(sim.world.origin_pose(gate), {0.6, 0.45, 0});
    const Vec3 out = sim.world.bodies[end].pose.position - corner;
    farthest = std::max(farthest, std::hypot(out.x, out.z));
    if (step == 0) return;
    if (const auto force = pin_force(sim.world, knot))
      pulled = std::max(pulled, glm::length(*force));
  };
  return demos::run(argc, argv,
                    {.name = "gate", .scene = scene, .script = script, .extras = extras});
}
