// A gate that counts the red balls falling through it and stops none: a sensor, and layers.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  constexpr std::uint32_t kGates = collision_layer(1), kRed = collision_layer(2),
                          kBlue = collision_layer(3);
  World world;
  must(world.add(RigidBody{.motion = Motion::fixed,
                           .shape = BoxShape{.half_extents = {5, 0.1, 1}},
                           .collision = in_layers(kGates, kRed, {.sensor = true})}));
  for (int i = 0; i < 6; ++i)
    must(world.add(RigidBody{.shape = SphereShape{.radius = 0.1},
                             .position = {i - 2.5, 1 + 0.5 * i, 0},
                             .collision = in_layers(i % 2 ? kRed : kBlue)}));

  Simulation simulation(std::move(world));
  ContactEvents contacts(simulation.world);
  int came = 0, left = 0;
  for (int i = 0; i < 120; ++i) {
    simulation.step();
    for (const ContactEvent& e : contacts.update(simulation.world)) {
      if (!e.is_sensor) continue;
      came += e.phase == ContactPhase::begin;
      left += e.phase == ContactPhase::end;
    }
  }
  std::printf("%d red balls came, %d left again\n", came, left);
}
// prints: 3 red balls came, 3 left again
