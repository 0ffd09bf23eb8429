// A ball falls on the ground, bounces and comes to rest: who touches whom, when, how hard.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  must(world.add(RigidBody{
      .motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}, .name = "ground"}));
  must(world.add(RigidBody{.shape = SphereShape{.radius = 0.1},
                           .position = {0, 1.1, 0},
                           .collision = Collision{.restitution = 0.5},
                           .name = "ball"}));

  Simulation simulation(std::move(world));
  ContactEvents contacts(simulation.world);
  int begun = 0;
  for (int i = 0; i < 240; ++i) {
    simulation.step();
    for (const ContactEvent& e : contacts.update(simulation.world)) {
      if (e.phase != ContactPhase::begin || ++begun > 3) continue;
      std::printf("%.2f s: %s meets %s, %.1f N s\n", simulation.world.time,
                  simulation.world.name_of(e.b).c_str(), simulation.world.name_of(e.a).c_str(),
                  glm::length(e.impulse));
    }
  }
}
// prints: 0\.4[0-9] s: ball meets ground, .*\n.* s: ball meets ground
