#include "engine/world/joined.hpp"

#include "engine/world/requests.hpp"

namespace pantin::detail {

void list_joined(const World& world, std::vector<std::uint64_t>& pairs) {
  pairs.clear();
  const auto join = [&](Entity a, Entity b) {
    const std::uint32_t one = world.bodies.slot(a), two = world.bodies.slot(b);
    if (one != kNoSlot && two != kNoSlot) pairs.push_back(body_pair(one, two));
  };
  const auto moves = [&](Entity e) {
    const Body* body = world.bodies.find(e);
    return body && body->motion == Motion::dynamic;
  };
  for (const Link& link : world.links.values()) join(link.a, link.b);
  for (const Pin& pin : world.pins.values())
    if (pin.kind == PinKind::exact) join(pin.body, pin.to);
  for (const SurfaceContact& c : world.surface_contacts.values())
    if (!c.over) join(c.a, c.b);
  for (const Gear& gear : world.gears.values()) {
    const Link *first = world.links.find(gear.first), *second = world.links.find(gear.second);
    if (!first || !second) continue;
    for (const Entity a : {first->a, first->b})
      for (const Entity b : {second->a, second->b})
        if (a != b && moves(a) && moves(b)) join(a, b);
  }
  std::sort(pairs.begin(), pairs.end());
}

void list_ignored(const World& world, std::vector<std::uint64_t>& pairs) {
  pairs.clear();
  const Store<IgnoredPair>* all = world.user.find<IgnoredPair>();
  if (!all) return;
  for (const IgnoredPair& pair : all->values()) {
    const std::uint32_t a = world.bodies.slot(pair.a), b = world.bodies.slot(pair.b);
    if (a != kNoSlot && b != kNoSlot) pairs.push_back(body_pair(a, b));
  }
  std::sort(pairs.begin(), pairs.end());
}

std::uint64_t joined_version(const World& world) {
  std::uint64_t over = 0;
  for (const SurfaceContact& c : world.surface_contacts.values()) over += c.over;
  return world.structure() + over;
}

}  // namespace pantin::detail
