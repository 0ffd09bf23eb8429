// Measures of the present state of a World.
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin {

using namespace detail;

Measures measure(const World& world) {
  if (partition_of(world).built_for != world.structure()) {  // changed since the last step
    World built = world;
    compile_if_changed(built);
    return measure(built);
  }
  Measures m;
  for (auto solver = kSolvers.rbegin(); solver != kSolvers.rend(); ++solver)
    (*solver)->measure(world, m);
  for (const Body& b : world.bodies.values()) {
    if (b.motion != Motion::dynamic) continue;
    const Vec3 local = glm::conjugate(b.pose.rotation) * b.angular_velocity;
    const Vec3 l = b.pose.rotation * (b.inertia * local);
    m.kinetic +=
        0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(l, b.angular_velocity));
    m.potential -= b.mass * b.gravity_scale * glm::dot(world.gravity, b.pose.position);
    m.momentum += b.mass * b.velocity;
    m.angular_momentum += l + b.mass * glm::cross(b.pose.position, b.velocity);
  }
  return m;
}

}  // namespace pantin
