#include "engine/runtime/requests.hpp"

#include <utility>

#include "engine/runtime/simulation.hpp"

namespace pantin::detail {
namespace {

void apply_impulses(World& world, Real h) {
  const Store<Impulse>* found = std::as_const(world).user.find<Impulse>();
  if (!found || found->empty()) return;
  Store<Impulse>& all = world.store<Impulse>();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Entity owner = all.owners()[i];
    const Body* body = world.bodies.find(owner);
    if (!body || body->motion != Motion::dynamic) continue;
    const Impulse& blow = all.values()[i];
    world.push(owner, blow.linear / h, body->pose.position);
    world.forces[owner].torque += blow.angular / h;
  }
  all.remove(all.owners());
}

void end_ignored(World& world) {
  const Store<IgnoredPair>* all = std::as_const(world).user.find<IgnoredPair>();
  if (!all || all->empty()) return;
  std::vector<Entity> over;
  for (std::size_t i = 0; i < all->size(); ++i) {
    const IgnoredPair& pair = all->values()[i];
    const bool both = world.bodies.find(pair.a) && world.bodies.find(pair.b);
    if (both && world.time < pair.until) continue;
    over.push_back(all->owners()[i]);
    rouse(world, pair.a), rouse(world, pair.b);
  }
  if (!over.empty()) world.destroy(over);
}

}  // namespace

void apply_requests(World& world, Real h) { end_ignored(world), apply_impulses(world, h); }

bool rouse(World& world, Entity body) {
  if (!is_asleep(world, body)) return false;
  world.bodies[body].restart = true;
  return true;
}

}  // namespace pantin::detail
