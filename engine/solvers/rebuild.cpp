#include "engine/solvers/rebuild.hpp"

#include <algorithm>
#include <numeric>

#include "engine/base/check.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/solvers/takeover.hpp"

namespace pantin::detail {
namespace {

constexpr std::uint32_t kNone = Owner::kNone;

/// Whether the stores remember what was removed or replaced since the last build.
bool is_tracked(const World& world) {
  bool all = true;
  for_each_structural_store(
      world, [&](const auto& store) { all = all && store.gone() && store.first_new() != kNoSlot; });
  return all;
}

/// Whether a body was replaced by one that moves otherwise.
bool has_other_motion(const World& world) {
  return std::any_of(world.bodies.gone()->begin(), world.bodies.gone()->end(),
                     [&](const auto& gone) {
                       const Body* now = world.bodies.find(gone.owner);
                       return now && now->motion != gone.value.motion;
                     });
}

/// Whether the kinds of components that only other solvers know are absent, now and before.
bool is_plain(const World& world) {
  const auto none = [](const auto& store) { return store.empty() && store.gone()->empty(); };
  return none(world.gears) && none(world.belts) && none(world.surface_contacts);
}

/// Whether an entity that does not exist was given a component.
bool has_strays(const World& world) {
  bool any = false;
  for_each_store(world, [&](const auto& store) {
    const std::size_t from = store.first_new() == kNoSlot ? 0 : store.first_new();
    const auto owners = store.owners().subspan(std::min(from, store.size()));
    any = any ||
          !std::all_of(owners.begin(), owners.end(), [&](Entity e) { return world.is_alive(e); });
  });
  return any;
}

bool can_rebuild(const World& world) {
  const Partition& was = partition_of(world);
  const auto is_own = [](const Partition::Place& p) {
    return p.solver == kArticulated && !p.unfit && !p.beyond;
  };
  return was.built_for != 0 && was.built_for != UINT64_MAX && !was.islands.empty() &&
         was.edit_count == world.edit_count && was.faults.empty() &&
         was.column.empty() == world.collisions.empty() &&
         world.memory.of<Takeovers>().list.empty() && is_tracked(world) && is_plain(world) &&
         !has_other_motion(world) && !has_strays(world) &&
         std::all_of(was.islands.begin(), was.islands.end(), is_own);
}

/// Which islands of the last build a change concerns.
class Changes {
 public:
  Changes(const World& world, const Partition& was)
      : island(was.island), touched(was.islands.size(), 0), world_(world) {
    if (world.bodies.has_moved()) {
      island.assign(world.bodies.size(), kNone);
      for (std::uint32_t slot = 0; slot < was.island.size(); ++slot) {
        const std::uint32_t now = world.bodies.slot_now(slot), own = was.island[slot];
        if (now != kNoSlot)
          island[now] = own;
        else if (own != kNone)
          touched[own] = 1;
      }
    }
    island.resize(world.bodies.size(), kNone);
    mark_changes(world.bodies), mark_changes(world.links), mark_changes(world.cables),
        mark_changes(world.pins);
    mark_changes(world.joint_drives), mark_changes(world.settings), mark_changes(world.collisions);
  }

  /// Whether the body is compiled anew.
  bool is_loose(std::uint32_t slot) const {
    return island[slot] == kNone ? world_.bodies.is_new(slot) : touched[island[slot]] != 0;
  }
  bool is_loose(Entity body) const {
    const std::uint32_t slot = world_.bodies.slot(body);
    return slot != kNoSlot && is_loose(slot);
  }

  std::vector<std::uint32_t> island;  // of the last build, by slot now; kNone also for new bodies
  std::vector<std::uint8_t> touched;  // by island of the last build

 private:
  void mark(Entity body) {
    const std::uint32_t slot = world_.bodies.slot(body);
    if (slot != kNoSlot && island[slot] != kNone) touched[island[slot]] = 1;
  }
  void mark_ends(Entity body, const Body&) { mark(body); }
  void mark_ends(Entity, const Link& link) { mark(link.a), mark(link.b); }
  void mark_ends(Entity, const Pin& pin) { mark(pin.body), mark(pin.to); }
  void mark_ends(Entity, const Cable& cable) {
    mark(cable.a), mark(cable.b);
    for (const CableGuide& g : cable.guides) mark(g.body);
  }
  void mark_ends(Entity joint, const JointDrive&) {
    if (const Link* link = world_.links.find(joint)) mark_ends(joint, *link);
  }
  void mark_ends(Entity body, const SolverSettings&) { mark(body); }
  void mark_ends(Entity body, const Collision&) { mark(body); }

  template <class T>
  void mark_changes(const Store<T>& store) {
    for (const auto& gone : *store.gone()) {
      mark_ends(gone.owner, gone.value);
      if (const T* now = store.find(gone.owner)) mark_ends(gone.owner, *now);
    }
    for (std::uint32_t slot = store.first_new(); slot < store.size(); ++slot)
      mark_ends(store.owners()[slot], store.values()[slot]);
  }

  const World& world_;
};

/// Slots of the values that `is_in(value, slot)`.
template <class T, class IsIn>
std::vector<std::uint32_t> list_slots(const Store<T>& store, const IsIn& is_in) {
  std::vector<std::uint32_t> slots;
  for (std::uint32_t i = 0; i < store.size(); ++i)
    if (store.is_new(i) || is_in(store.values()[i])) slots.push_back(i);
  return slots;
}

Scope scope_of(const World& world, const Changes& changes) {
  const auto loose = [&](Entity e) { return changes.is_loose(e); };
  Scope scope;
  for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot) {
    if (!changes.is_loose(slot)) continue;
    scope.bodies.push_back(slot);
    const std::uint32_t solid = world.collisions.slot(world.bodies.owners()[slot]);
    if (solid != kNoSlot) scope.collisions.push_back(solid);
  }
  std::sort(scope.collisions.begin(), scope.collisions.end());
  scope.links = list_slots(world.links, [&](const Link& l) { return loose(l.a) || loose(l.b); });
  scope.pins = list_slots(world.pins, [&](const Pin& p) { return loose(p.body) || loose(p.to); });
  scope.cables = list_slots(world.cables, [&](const Cable& c) {
    return loose(c.a) || loose(c.b) ||
           std::any_of(c.guides.begin(), c.guides.end(),
                       [&](const CableGuide& g) { return loose(g.body); });
  });
  return scope;
}

/// Numbers all islands by their lowest slots.
void number_islands(World& world, const Changes& changes, Rebuild& r) {
  Partition& all = world.memory.of<Partition>();
  const std::vector<Partition::Place> before = std::exchange(all.islands, {});
  all.islands.reserve(before.size() + r.plans.size());
  r.now.assign(before.size(), Rebuild::kGone), r.places.clear();
  std::vector<std::uint32_t> plan_of(world.bodies.size(), kNone);
  for (std::uint32_t i = 0; i < r.plans.size(); ++i)
    for (const std::uint32_t slot : r.plans[i].slots) plan_of[slot] = i;
  const auto add = [&](Partition::Place place) {
    place.island = static_cast<std::uint32_t>(all.islands.size());
    all.islands.push_back(place);
    return place.island;
  };
  all.island.assign(world.bodies.size(), kNone);
  for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot) {
    const std::uint32_t plan = plan_of[slot], was = changes.island[slot];
    if (plan != kNone) {
      if (plan == r.places.size())
        r.places.push_back(add({kArticulated, kSolvers[kArticulated]->feels_contacts, 0, false,
                                r.plans[plan].beyond}));
      all.island[slot] = r.places[plan];
    } else if (was != kNone) {
      if (r.now[was] == Rebuild::kGone) r.now[was] = add(before[was]);
      all.island[slot] = r.now[was];
    }
  }
  PANTIN_ASSERT(r.places.size() == r.plans.size());
}

/// Moves the columns to the present slots.
void renumber_columns(const World& world, Partition& all) {
  if (world.bodies.has_moved() && !all.column.empty()) {
    std::vector<std::uint32_t> columns(world.bodies.size(), kNone);
    for (std::uint32_t slot = 0; slot < all.column.size(); ++slot)
      if (const std::uint32_t now = world.bodies.slot_now(slot); now != kNoSlot)
        columns[now] = all.column[slot];
    all.column = std::move(columns);
  }
  if (!all.column.empty()) all.column.resize(world.bodies.size(), kNone);
}

/// Lists the bodies of no solver; returns whether they are the same as before.
bool list_obstacles(const World& world, Partition& all) {
  std::vector<std::uint32_t> before = std::exchange(all.kinematic, {});
  for (std::uint32_t slot = 0; slot < all.island.size(); ++slot)
    if (all.island[slot] == kNone) all.kinematic.push_back(slot);
  for (std::uint32_t& slot : before) slot = world.bodies.slot_now(slot);
  return before == all.kinematic;
}

/// Lists the kept islands whose bodies, joints, pins, cables, drives or anchors are in other slots.
void list_moved(const World& world, Rebuild& r) {
  const Partition& all = partition_of(world);
  std::vector<std::uint8_t> moved(all.islands.size(), 0);
  const std::uint32_t bodies = world.bodies.first_moved();
  const auto mark = [&](std::uint32_t slot) {
    if (slot != kNoSlot && all.island[slot] != kNone) moved[all.island[slot]] = 1;
  };
  for (std::uint32_t slot = bodies; slot < world.bodies.size(); ++slot) mark(slot);
  const auto is_later = [&](std::uint32_t slot) { return slot != kNoSlot && slot >= bodies; };
  const auto mark_ties = [&](const auto& store, const auto& ends_of) {
    const std::uint32_t from = store.first_moved();
    if (from == kNoSlot && bodies == kNoSlot) return;
    for (std::uint32_t i = 0; i < store.size(); ++i) {
      const auto [a, b] = ends_of(i);
      const std::uint32_t one = world.bodies.slot(a), two = world.bodies.slot(b);
      if (i >= from || is_later(one) || is_later(two)) mark(one), mark(two);
    }
  };
  using Ends = std::pair<Entity, Entity>;
  mark_ties(world.links, [&](std::uint32_t i) {
    const Link& l = world.links.values()[i];
    return Ends{l.a, l.b};
  });
  mark_ties(world.pins, [&](std::uint32_t i) {
    const Pin& p = world.pins.values()[i];
    return Ends{p.body, p.to};
  });
  mark_ties(world.cables, [&](std::uint32_t i) {
    const Cable& c = world.cables.values()[i];
    return Ends{c.a, c.b};
  });
  mark_ties(world.joint_drives, [&](std::uint32_t i) {
    const Link* link = world.links.find(world.joint_drives.owners()[i]);
    return link ? Ends{link->a, link->b} : Ends{};
  });
  for (const std::uint32_t made : r.places) moved[made] = 0;
  for (std::uint32_t i = 0; i < moved.size(); ++i)
    if (moved[i]) r.moved.push_back(i);
}

}  // namespace

std::optional<Rebuild> find_rebuild(World& world) {
  if (!can_rebuild(world)) return std::nullopt;
  Partition& all = world.memory.of<Partition>();
  const Changes changes(world, all);
  Rebuild r;
  r.scope = scope_of(world, changes);
  r.plans = find_islands(world, r.scope);
  if (!std::all_of(r.plans.begin(), r.plans.end(),
                   [](const IslandPlan& p) { return p.solver == kArticulated && !p.beyond; }))
    return std::nullopt;
  number_islands(world, changes, r);
  renumber_columns(world, all);
  r.same_obstacles = list_obstacles(world, all);
  list_moved(world, r);
  return r;
}

}  // namespace pantin::detail
