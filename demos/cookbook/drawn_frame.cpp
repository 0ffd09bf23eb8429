// What a game draws: poses between two steps in one array, who sleeps, how hard things met.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World start;
  start.materials = {{.name = "stone"}, {.name = "wood"}};
  must(start.add(
      RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}}));
  for (int i = 0; i < 3; ++i)
    must(start.add(RigidBody{.shape = BoxShape{{0.2, 0.1, 0.2}},
                             .position = {Real(i), 0.3 + 0.4 * i, 0},
                             .collision = Collision{},
                             .material = 1}));
  Simulation simulation(std::move(start), {1.0 / 120});
  ContactEvents contacts(simulation.world);

  Real loudest = 0;
  float highest = 0;
  for (int frame = 0; frame < 180; ++frame) {  // 60 a second
    const Advance passed = simulation.advance(1.0 / 60);
    for (const ContactEvent& e : contacts.update(simulation.world))
      if (e.phase == ContactPhase::begin) loudest = std::max(loudest, e.approach);
    highest = 0;
    for (const DrawnPose& drawn : simulation.drawn_poses(passed.fraction))
      highest = std::max(highest, drawn.position[1]);
  }
  std::printf("the hardest landing: %.1f m/s; at the end the highest is at %.2f m, %zu are awake\n",
              loudest, highest, simulation.awake_bodies().size());
}
// prints: the hardest landing: 4.4 m/s; at the end the highest is at 0.10 m, 0 are awake
