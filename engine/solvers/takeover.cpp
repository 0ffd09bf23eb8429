// Islands that may touch within the next steps form a group. If its islands ask for several
// solvers, `lagrangian` steps them all, since it supports every kind of joint and of surface.
// Islands separate at twice the distance at which they met.
#include "engine/solvers/takeover.hpp"

#include <algorithm>

#include "engine/base/check.hpp"
#include "engine/base/disjoint_sets.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/memory.hpp"
#include "engine/geometry/usable.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail {
namespace {

/// Steps within which a contact counts as near, and a margin, as a fraction of a shape's extent.
constexpr Real kSteps = 2, kMargin = 0.05;
/// Distance at which islands separate, as a multiple of that at which they meet.
constexpr Real kParting = 2;

struct NearShape {
  Aabb near, far;
  std::uint32_t slot = 0, island = 0;  // in World::bodies, in Partition::islands
};

struct TakeoverScratch {
  static constexpr std::string_view name = "takeover scratch";
  struct Lists {
    std::vector<NearShape> shapes;
    std::vector<Aabb> boxes;
    AabbTree tree;
    DisjointSets sets{0};
    std::vector<std::uint8_t> asked, taken;  // by island: the row asked for; whether taken over
    std::vector<std::uint32_t> met;          // by island: a slot that it can touch
    std::vector<std::uint32_t> first;        // by island: its lowest slot
    std::vector<std::uint8_t> mixed;         // by group, the root's island: asks for several
    std::vector<Takeover> list;
  };
  Scratch<Lists> lists;

  static void fields(auto& self, auto&& field) { field("lists", derived(self.lists)); }
};

using Lists = TakeoverScratch::Lists;

bool is_solid(const World& world, Entity e) {
  const Collision* c = world.collisions.find(e);
  return c && !c->sensor;
}

SolverSettings asked_settings(const World& world, std::uint32_t island) {
  const Partition& partition = partition_of(world);
  SolverSettings asked = world.default_settings;
  for (std::uint32_t slot = 0; slot < partition.island.size(); ++slot)
    if (partition.island[slot] == island)
      if (const SolverSettings* s = world.settings.find(world.bodies.owners()[slot])) {
        asked = *s;
        break;
      }
  if (partition.islands[island].beyond) asked.solver = Solver::lagrangian;
  return asked;
}

[[maybe_unused]] bool is_no_row(std::uint8_t row) { return row >= kSolverCount; }

/// Lists the solvers that islands ask for. False: all solid ones ask for the same.
bool list_asked(World& world, Lists& lists) {
  const Partition& partition = partition_of(world);
  const std::size_t count = partition.islands.size();
  lists.asked.assign(count, UINT8_MAX), lists.first.assign(count, kNoSlot);
  const std::uint8_t otherwise = row_of(world.default_settings.solver);
  bool solid[kSolverCount] = {};
  for (std::uint32_t slot = 0; slot < partition.island.size(); ++slot) {
    const std::uint32_t island = partition.island[slot];
    if (island == Owner::kNone) continue;
    if (lists.first[island] == kNoSlot) lists.first[island] = slot;
    if (lists.asked[island] != UINT8_MAX) continue;
    if (const SolverSettings* s = world.settings.find(world.bodies.owners()[slot]))
      lists.asked[island] = row_of(s->solver);
  }
  for (std::size_t i = 0; i < count; ++i)
    if (partition.islands[i].beyond)
      lists.asked[i] = kLagrangian;
    else if (lists.asked[i] == UINT8_MAX)
      lists.asked[i] = otherwise;
  for (const Entity e : world.collisions.owners()) {
    const std::uint32_t slot = world.bodies.slot(e);
    if (slot >= partition.island.size() || !is_solid(world, e)) continue;
    if (const std::uint32_t island = partition.island[slot]; island != Owner::kNone)
      solid[lists.asked[island]] = true;
  }
  PANTIN_ASSERT(std::none_of(lists.asked.begin(), lists.asked.end(), is_no_row));
  return solid[kPlanar] + solid[kLagrangian] + solid[kArticulated] > 1;
}

void list_shapes(const World& world, Lists& lists, Real h) {
  const Partition& partition = partition_of(world);
  lists.shapes.clear(), lists.boxes.clear();
  for (std::uint32_t slot = 0; slot < partition.island.size(); ++slot) {
    const std::uint32_t island = partition.island[slot];
    const Entity e = world.bodies.owners()[slot];
    if (island == Owner::kNone || lists.asked[island] == kQuasistatic || !is_solid(world, e))
      continue;
    const Shapes* shapes = world.shapes.find(e);
    if (!shapes) continue;
    const Body& b = world.bodies.values()[slot];
    const Real extent = contact::extent_of(*shapes);
    Real way = h * (glm::length(b.velocity) + extent * glm::length(b.angular_velocity)) +
               2 * h * h * glm::length(world.gravity);
    if (const Force* f = world.forces.find(e)) way += h * h * glm::length(f->force) / b.mass;
    const Real near = kSteps * way + kMargin * extent;
    if (!(near >= 0 && std::isfinite(near))) continue;
    for (std::uint32_t i = 0; i < shapes->list.size(); ++i) {
      const Shape& shape = shapes->list[i];
      if (!can_move(shape.kind) || !is_usable(shape)) continue;
      contact::ColliderShape at{compose(b.pose, shape.local), {}, 0, slot, i, &shape};
      if (!contact::bound_shape(at)) continue;
      lists.shapes.push_back({at.box.grown(near), at.box.grown(kParting * near), slot, island});
      lists.boxes.push_back(lists.shapes.back().far);
    }
  }
}

/// Joins islands that may touch.
void join_near(const World& world, Lists& lists) {
  const Partition& partition = partition_of(world);
  lists.sets.reset(partition.islands.size());
  lists.met.assign(partition.islands.size(), kNoSlot);
  PANTIN_ASSERT(lists.boxes.size() == lists.shapes.size() &&
                lists.asked.size() == partition.islands.size());
  contact::update_tree(lists.tree, lists.boxes);
  for (std::uint32_t i = 0; i < lists.shapes.size(); ++i) {
    const NearShape& a = lists.shapes[i];
    lists.tree.query(lists.boxes[i], [&](std::uint32_t j) {
      const NearShape& b = lists.shapes[j];
      if (j <= i || a.island == b.island) return;
      const bool together =
          partition.islands[a.island].solver == partition.islands[b.island].solver &&
          (lists.taken[a.island] || lists.taken[b.island]);
      if (!together && !a.near.overlaps(b.near)) return;
      const Collision &on_a = world.collisions[world.bodies.owners()[a.slot]],
                      &on_b = world.collisions[world.bodies.owners()[b.slot]];
      if (!do_groups_agree(on_a, on_b) || !(on_a.others || on_b.others)) return;
      lists.sets.join(a.island, b.island);
      const auto meet = [&](const NearShape& one, const NearShape& other) {
        std::uint32_t& met = lists.met[one.island];
        const bool differs = lists.asked[other.island] != lists.asked[one.island];
        if (met == kNoSlot ||
            (differs && lists.asked[partition.island[met]] == lists.asked[one.island]))
          met = other.slot;
      };
      meet(a, b), meet(b, a);
    });
  }
}

/// Finds the groups whose islands ask for several solvers.
void find_mixed(Lists& lists) {
  lists.mixed.assign(lists.asked.size(), 0);
  for (std::uint32_t i = 0; i < lists.asked.size(); ++i)
    if (const std::uint32_t root = lists.sets.root(i); lists.asked[i] != lists.asked[root])
      lists.mixed[root] = 1;
}

void list_takeovers(const World& world, Lists& lists) {
  lists.list.clear();
  for (std::uint32_t i = 0; i < lists.asked.size(); ++i) {
    if (!lists.mixed[lists.sets.root(i)] || lists.asked[i] == kLagrangian) continue;
    PANTIN_ASSERT(lists.first[i] != kNoSlot);
    Takeover t;
    t.body = world.bodies.owners()[lists.first[i]];
    if (lists.met[i] != kNoSlot) t.other = world.bodies.owners()[lists.met[i]];
    t.by.solver = Solver::lagrangian;
    for (std::uint32_t k = 0; k < lists.asked.size(); ++k)
      if (lists.asked[k] == kLagrangian && lists.sets.root(k) == lists.sets.root(i)) {
        t.by = asked_settings(world, k);
        break;
      }
    lists.list.push_back(t);
  }
}

}  // namespace

void take_over(World& world, Real h) {
  Takeovers& now = world.memory.of<Takeovers>();
  const auto is_left = [](const Partition::Place& island) { return bool(island.beyond); };
  const auto& islands = partition_of(world).islands;
  if (world.settings.empty() && now.list.empty() &&
      std::none_of(islands.begin(), islands.end(), is_left))
    return;
  Lists& lists = world.memory.of<TakeoverScratch>().lists;
  if (!list_asked(world, lists)) {
    if (now.list.empty()) return;
    now.list.clear();
  } else {
    lists.taken.assign(lists.asked.size(), 0);
    for (std::size_t i = 0; i < lists.asked.size(); ++i)
      lists.taken[i] = partition_of(world).islands[i].solver != lists.asked[i];
    list_shapes(world, lists, h);
    join_near(world, lists);
    find_mixed(lists);
    list_takeovers(world, lists);
    const auto same = [](const Takeover& a, const Takeover& b) {
      return a.body == b.body && a.by == b.by;
    };
    if (std::equal(now.list.begin(), now.list.end(), lists.list.begin(), lists.list.end(), same))
      return;
    now.list = lists.list;
  }
  world.memory.of<Partition>().built_for = UINT64_MAX;  // no structure has that number
  compile_if_changed(world);
}

std::vector<std::string> takeover_lines(const World& world) {
  std::vector<std::string> lines;
  for (const Takeover& t : world.memory.of<Takeovers>().list) {
    const std::uint32_t slot = world.bodies.slot(t.body);
    if (slot >= partition_of(world).island.size()) continue;
    const SolverSettings asked = asked_settings(world, partition_of(world).island[slot]);
    lines.push_back(world.name_of(t.body) + " (" + pantin::name_of(asked.solver) +
                    ") is stepped by " + pantin::name_of(t.by.solver) + ": it can touch " +
                    world.name_of(t.other));
  }
  return lines;
}

std::vector<std::string> lines_beyond_auto(const World& world) {
  std::vector<std::string> lines;
  const Partition& partition = partition_of(world);
  std::vector<bool> told(partition.islands.size(), false);
  for (std::uint32_t slot = 0; slot < partition.island.size(); ++slot) {
    const std::uint32_t island = partition.island[slot];
    if (island == Owner::kNone || told[island] || !partition.islands[island].beyond) continue;
    told[island] = true;
    lines.push_back(world.name_of(world.bodies.owners()[slot]) +
                    " (auto) is stepped by lagrangian, because of \"" +
                    world.name_of(partition.islands[island].beyond) + "\"");
  }
  return lines;
}

}  // namespace pantin::detail
