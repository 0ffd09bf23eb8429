// A rod on two fingers that approach each other: they take turns to slide on it.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  world.gravity = {0, -10, 0};
  // Friction is higher where the rod sticks to a finger than where it slides.
  const Entity rod = must(world.add(
      LaminaBody{.outline = {{-0.6, 0, 0}, {0.6, 0, 0}, {0.6, 0.02, 0}, {-0.6, 0.02, 0}},
                 .fingers = {{.point = {-0.4, 0, 0}, .slide = 0.3, .velocity = {0.01, 0, 0}},
                             {.point = {0.25, 0, 0}, .slide = 0.3, .velocity = {-0.01, 0, 0}}}}));
  const Entity left = fingers_of(world, rod)[0];
  for (const ContactMode& mode : contact_modes(world, rod))
    std::printf("it may move at %+.2f m/s\n", mode.velocity.x);

  Simulation simulation(std::move(world));
  int switches = 0, by_dynamics = 0;
  while (simulation.world.time < 31) {
    const StepReport report = simulation.step();
    switches += report.mode_switches, by_dynamics += report.handed_over;
    // At the start both modes hold, sticking left or right: dynamics decides which comes about.
    if (report.lamina)
      std::printf("%.2f s: %s\n", report.time, *report.changed ? report.changed : "by modes again");
  }
  const auto x = [&](Entity body) { return simulation.world.bodies[body].pose.position.x; };
  std::printf("%d switches, %d steps by dynamics, left finger %.2f m from the mass centre\n",
              switches, by_dynamics, x(rod) - x(left));
}
// prints: 6 switches, [1-9] steps by dynamics, left finger 0\.0[0-9] m from the mass centre
