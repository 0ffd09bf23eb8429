// A rod on two fingers that approach each other: they take turns to slide on it.
#include <cstdio>
#include <pantin/pantin.hpp>
#include <pantin/scene.hpp>

using namespace pantin;

constexpr const char* kRod = R"({
  "version": 1, "gravity": [0, -10, 0],
  "laminas": [{"name": "rod", "outline": [[-0.6, 0], [0.6, 0], [0.6, 0.02], [-0.6, 0.02]],
    "fingers": [
      {"name": "left", "point": [-0.4, 0], "velocity": [0.01, 0], "friction": [0.5, 0.3]},
      {"name": "right", "point": [0.25, 0], "velocity": [-0.01, 0], "friction": [0.5, 0.3]}]}]
})";

int main() {
  Simulation simulation(must(parse_scene(kRod, "rod")).world);
  const Entity rod = simulation.world.find("rod"), left = simulation.world.find("rod/left");
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
