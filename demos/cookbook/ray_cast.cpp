// A ray picks the link of a chain that it meets first, and a push there sets it swinging.
#include <cstdio>
#include <pantin/pantin.hpp>

using namespace pantin;

int main() {
  World world;
  const Entity hook = must(world.add(RigidBody{.motion = Motion::fixed, .position = {0, 2, 0}}));
  must(build_chain(world, {.from = {0, 2, 0},
                           .to = {0, 1, 0},
                           .links = 5,
                           .start = hook,
                           .collision = Collision{},
                           .name = "chain"}));
  Simulation simulation(std::move(world));

  const Ray ray{.origin = {0, 1.3, 3}, .way = {0, 0, -10}};  // from the eye, 10 m far
  const Queries queries(simulation.world);                   // refit() it after the World has moved
  const RayAnswer seen = queries.cast_ray(ray);
  if (!seen) return 1;
  const Entity link = seen.hit->body;
  for (int i = 0; i < 6; ++i) {  // a push of 20 N for a tenth of a second
    simulation.world.push(link, {0, 0, -20}, seen.hit->point);
    simulation.step();
  }
  std::printf("%s, met at %.2f m, moves at %.1f m/s\n", simulation.world.name_of(link).c_str(),
              10 * seen.hit->fraction, glm::length(simulation.world.bodies[link].velocity));
}
// prints: chain/3, met at 2\.98 m, moves at [1-9][0-9]*\.[0-9] m/s
