// A chain of ten links, hung by one end and let go, through the installed headers only.
#include <cstdio>

#include "engine/runtime/simulation.hpp"
#include "engine/world/world.hpp"

int main() {
  using namespace pantin;
  constexpr Real kHalf = 0.1;  // m, half a link

  World world;
  Body hook;
  hook.motion = Motion::fixed;
  Entity above = world.add_body(hook, "hook");
  for (int i = 0; i < 10; ++i) {
    Body link;
    link.pose.position = {kHalf * (2 * i + 1), 0, 0};
    link.inertia = Vec3(kHalf * kHalf / 3);
    const Entity below = world.add_body(link);
    const Vec3 end = i == 0 ? Vec3(0) : Vec3(kHalf, 0, 0);
    world.add_link(above, below, {end, {-kHalf, 0, 0}});
    above = below;
  }

  StepSettings settings;
  settings.measure = true;
  Simulation simulation(world, settings);
  for (int i = 0; i < 240; ++i) {
    const StepReport report = simulation.step();
    if (report.status != Status::ok || !(report.measures.worst_gap_rel <= 1e-12)) {
      std::printf("step %d: joints open by %g of the chain\n", i, report.measures.worst_gap_rel);
      return 1;
    }
  }
  const Vec3 tip = simulation.world.bodies[above].pose.position;
  std::printf("tip at %.3f %.3f %.3f m\n", tip.x, tip.y, tip.z);
  return tip.y < -0.1 ? 0 : 1;  // a chain that never fell closes its joints too
}
