#include "engine/world/partition.hpp"

#include <numeric>

#include "engine/base/disjoint_sets.hpp"
#include "engine/world/features.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {
namespace {

bool is_dynamic(const World& world, std::uint32_t slot) {
  return slot != kNoSlot && world.bodies.values()[slot].motion == Motion::dynamic;
}

/// Merges the bodies that joints, surfaces, gears, belts, cables and pins connect.
void join_tied(const World& world, const Scope& scope, DisjointSets& sets) {
  std::uint32_t last = kNoSlot;
  const auto join = [&](Entity body) {
    const std::uint32_t slot = world.bodies.slot(body);
    if (!is_dynamic(world, slot)) return;
    if (last != kNoSlot) sets.join(last, slot);
    last = slot;
  };
  const auto join_all = [&](std::initializer_list<Entity> bodies) {
    last = kNoSlot;
    for (const Entity body : bodies) join(body);
  };
  for (const std::uint32_t i : scope.links) {
    const Link& link = world.links.values()[i];
    join_all({link.a, link.b});
  }
  for (const SurfaceContact& c : world.surface_contacts.values()) join_all({c.a, c.b});
  for (const Gear& r : world.gears.values()) {
    const Link *one = world.links.find(r.first), *two = world.links.find(r.second);
    if (one && two) join_all({one->a, one->b, two->a, two->b});
  }
  for (const Belt& belt : world.belts.values()) {
    last = kNoSlot;
    for (const BeltPulley& p : belt.pulleys) join(p.body);
  }
  for (const std::uint32_t i : scope.cables) {
    const Cable& c = world.cables.values()[i];
    join_all({c.a, c.b});
    for (const CableGuide& g : c.guides) join(g.body);
  }
  for (const std::uint32_t i : scope.pins) {
    const Pin& pin = world.pins.values()[i];
    join_all({pin.body, pin.to});
  }
}

/// The sets that contain dynamic bodies, ordered by their lowest slot.
std::vector<IslandPlan> list_sets(const World& world, const Scope& scope, DisjointSets& sets) {
  std::vector<IslandPlan> made;
  std::vector<std::uint32_t> at(world.bodies.size(), kNoSlot);
  for (const std::uint32_t slot : scope.bodies) {
    if (!is_dynamic(world, slot)) continue;
    std::uint32_t& place = at[sets.root(slot)];
    if (place == kNoSlot) place = static_cast<std::uint32_t>(made.size()), made.emplace_back();
    made[place].slots.push_back(slot);
  }
  for (IslandPlan& island : made) {
    island.settings = world.default_settings;
    for (const std::uint32_t slot : island.slots) {
      const SolverSettings* s = world.settings.find(world.bodies.owners()[slot]);
      if (!s) continue;
      island.settings = *s;
      break;
    }
  }
  return made;
}

/// The entities that "auto" does not support, by the slot of the first dynamic body of each.
std::vector<Entity> list_beyond(const World& world, const Scope& scope) {
  std::vector<Entity> beyond(world.bodies.size());
  each_feature(
      world, scope, [&](Entity owner, std::span<const Entity> bodies, Feature what, const char*) {
        if (solver_for(Solver::articulated, what) == Solver::articulated) return;
        for (const Entity body : bodies)
          if (const std::uint32_t slot = world.bodies.slot(body); is_dynamic(world, slot)) {
            if (!beyond[slot]) beyond[slot] = owner;
            return;
          }
      });
  return beyond;
}

}  // namespace

std::vector<IslandPlan> find_islands(const World& world) {
  return find_islands(world, Scope::all(world));
}

std::vector<IslandPlan> find_islands(const World& world, const Scope& scope) {
  DisjointSets sets(world.bodies.size());
  join_tied(world, scope, sets);
  std::vector<IslandPlan> islands = list_sets(world, scope, sets);
  const std::vector<Entity> beyond = list_beyond(world, scope);
  for (IslandPlan& island : islands) {
    island.solver = row_of(island.settings.solver);
    if (island.settings.solver != Solver::articulated) continue;
    for (const std::uint32_t slot : island.slots)
      if (beyond[slot] && !island.beyond) island.beyond = beyond[slot];
    if (!island.beyond) continue;
    island.settings.solver = Solver::lagrangian, island.solver = row_of(Solver::lagrangian);
  }
  return islands;
}

Scope Scope::all(const World& world) {
  const auto list = [](std::size_t count) {
    std::vector<std::uint32_t> slots(count);
    std::iota(slots.begin(), slots.end(), 0u);
    return slots;
  };
  return {list(world.bodies.size()), list(world.links.size()), list(world.cables.size()),
          list(world.pins.size()), list(world.collisions.size())};
}

const Partition& partition_of(const World& world) { return world.memory.of<Partition>(); }

}  // namespace pantin::detail

namespace pantin::detail {
template Partition& Memories::create();
template const Partition& Memories::none();
}  // namespace pantin::detail
