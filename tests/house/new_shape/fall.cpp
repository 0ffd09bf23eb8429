// Loads a scene, lets four seconds pass and prints what became of every dynamic body.
#include <cstdio>
#include <iostream>

#include "engine/geometry/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/scene/keys/keys.hpp"
#include "engine/scene/keys/schema.hpp"
#include "engine/scene/scene.hpp"
#include "engine/world/queries.hpp"

int main(int count, char** arguments) {
  using namespace pantin;
  using namespace pantin::detail;
  if (count != 2) return 2;
  auto scene = load_scene(arguments[1]);
  if (!scene) {
    for (const Error& e : scene.errors()) std::cerr << e.message << '\n';
    return 2;
  }
  Simulation simulation(std::move(scene->world), {scene->step, scene->substeps});
  World& world = simulation.world;
  for (int i = 0; i < 240; ++i)
    if (simulation.step().status != Status::ok) return 1;
  const Entity first = world.find("standing");
  for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot) {
    const Body& b = world.bodies.values()[slot];
    if (b.motion != Motion::dynamic) continue;
    const Vec3 p = b.pose.position, axis = b.pose.rotation * Vec3(0, 1, 0);
    std::printf(
        "body %s height %.17g upright %.17g speed %.17g mass %.17g inertia %.17g %.17g %.17g\n",
        world.name_of(world.bodies.owners()[slot]).c_str(), p.y, std::abs(axis.y),
        glm::length(b.velocity), b.mass, b.inertia.x, b.inertia.y, b.inertia.z);
  }
  const Queries queries(world);
  const Body& body = world.bodies[first];
  const RayAnswer seen = queries.cast_ray({body.pose.position + Vec3(2, 0.01, 0.02), {-4, 0, 0}});
  const ClosestAnswer near = queries.closest_point(body.pose.position + Vec3(0.3, 0, 0), 1);
  std::printf("ray %.17g\nnear %.17g\n", seen ? seen.hit->point.x - body.pose.position.x : -1,
              near ? near.hit->distance : -1);
  std::printf("schema %s\n", schema_of(keys_of(world.shapes[first].list[0].kind)).c_str());
  return 0;
}
