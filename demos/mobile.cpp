// A branching mobile that a gust of wind pushes now and then.
#include "demos/demo.hpp"

using namespace pantin;

int main(int argc, char** argv) {
  const Scene scene = demos::load("mobile");
  const auto script = [&](Simulation& sim, int step) {
    if (step % 180 >= 12) return;
    for (Entity e : sim.world.bodies.owners()) {
      const Body& body = sim.world.bodies[e];
      if (body.motion == Motion::dynamic)
        sim.world.push(e, Vec3(0.4 * body.mass, 0, 0.2 * body.mass), body.pose.position);
    }
  };
  return demos::run(argc, argv, {.name = "mobile", .scene = scene, .script = script});
}
