// Measures of the present state of a World.
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/cable_route.hpp"

namespace pantin {

using namespace detail;

namespace {

/// Energy of elastic cables and spring pins that can move a body, J.
Real energy_of_ties(const World& world) {
  const auto moves = [&](Entity e) {
    const Body* b = world.bodies.find(e);
    return b && b->motion == Motion::dynamic;
  };
  const auto exists = [&](Entity e) { return world.bodies.find(e) != nullptr; };
  Real sum = 0;
  const auto pose_of = [&](Entity e) {
    const Body* b = world.bodies.find(e);
    return b ? &b->pose : nullptr;
  };
  for (const Cable& c : world.cables.values()) {
    if (!(c.joint.compliance > 0) || !exists(c.a) || !exists(c.b)) continue;
    if (!moves(c.a) && !moves(c.b) && c.guides.empty()) continue;
    sum += energy_of(c.joint, stretch_of(c, pose_of));
  }
  for (const Pin& p : world.pins.values()) {
    if (p.kind != PinKind::spring || !exists(p.body) || (p.to && !exists(p.to))) continue;
    if (!moves(p.body) && !(p.to && moves(p.to))) continue;
    const Vec3 to = p.to ? to_world(world.bodies[p.to].pose, p.target) : p.target;
    const Vec3 gap = to - to_world(world.bodies[p.body].pose, p.anchor);
    sum += 0.5 * p.stiffness * glm::dot(gap, gap);
  }
  return sum;
}

}  // namespace

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
  m.elastic += energy_of_ties(world);
  return m;
}

}  // namespace pantin
