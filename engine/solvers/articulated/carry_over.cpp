// Keeps the state of islands when the islands are compiled again.
#include <algorithm>

#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Copies slots of trees, pins and cables from an island to one compiled from the same components.
void copy_slots(const IslandMemory& from, IslandMemory& to) {
  PANTIN_ASSERT(to.trees.size() <= from.trees.size() && to.pins.size() <= from.pins.size());
  PANTIN_ASSERT(to.cables.size() <= from.cables.size());
  for (std::size_t i = 0; i < to.trees.size(); ++i)
    to.trees[i].held_body = from.trees[i].held_body, to.trees[i].held_pin = from.trees[i].held_pin;
  for (std::size_t i = 0; i < to.pins.size(); ++i) {
    PackedPin& h = to.pins[i];
    h.held_body = from.pins[i].held_body, h.held_pin = from.pins[i].held_pin;
    h.held_link = from.pins[i].held_link;
  }
  for (std::size_t i = 0; i < to.cables.size(); ++i) {
    PackedCable& c = to.cables[i];
    c.cable = from.cables[i].cable, c.slot_a = from.cables[i].slot_a;
    c.slot_b = from.cables[i].slot_b;
  }
}

bool is_same(const PackedJoint& a, const PackedJoint& b) {
  return a.stiff == b.stiff && a.own_is_a == b.own_is_a &&
         (a.drive == kNoSlot) == (b.drive == kNoSlot) && a.joint.kind == b.joint.kind &&
         a.joint.anchor_a == b.joint.anchor_a && a.joint.anchor_b == b.joint.anchor_b &&
         a.joint.frames.a() == b.joint.frames.a() && a.joint.frames.b() == b.joint.frames.b();
}

bool has_same_masses(const Island& a, const Island& b) {
  PANTIN_ASSERT(a.count() == b.count());
  for (std::size_t c = 0; c < a.count(); ++c)
    if (a.constants.at(kMass, c) != b.constants.at(kMass, c) ||
        a.constants.vec(kInertia, c) != b.constants.vec(kInertia, c))
      return false;
  return true;
}

bool has_same_anchors(const Island& a, const Island& b) {
  PANTIN_ASSERT(a.count() == b.count());
  for (std::size_t c = 0; c < a.count(); ++c)
    if (a.constants.vec(kOwnAnchor, c) != b.constants.vec(kOwnAnchor, c) ||
        a.constants.vec(kParentAnchor, c) != b.constants.vec(kParentAnchor, c))
      return false;
  return true;
}

/// Whether an island has the same structure as before: then its state must not change.
struct Unchanged {
  const World& world;

  bool body(std::uint32_t old, std::uint32_t now) const {
    return is_same_value(world.bodies, old, now);
  }
  bool pin(std::uint32_t old, std::uint32_t now) const {
    return is_same_value(world.pins, old, now);
  }
  bool link(std::uint32_t old, std::uint32_t now) const {
    return is_same_value(world.links, old, now);
  }
  bool operator()(const Tree& a, const Tree& b) const {
    return a.first == b.first && a.count == b.count && a.anchor == b.anchor &&
           body(a.held_body, b.held_body) && pin(a.held_pin, b.held_pin);
  }
  bool operator()(const PackedPin& a, const PackedPin& b) const {
    return a.column == b.column && a.partner == b.partner && a.tree == b.tree &&
           a.anchor == b.anchor && a.held_anchor == b.held_anchor && a.priority == b.priority &&
           a.compliance == b.compliance && body(a.held_body, b.held_body) &&
           pin(a.held_pin, b.held_pin) && link(a.held_link, b.held_link);
  }
  bool operator()(const PackedCable& a, const PackedCable& b) const {
    return a.column_a == b.column_a && a.column_b == b.column_b && body(a.slot_a, b.slot_a) &&
           body(a.slot_b, b.slot_b) && is_same_value(world.cables, a.cable, b.cable);
  }
  bool operator()(const PackedJoint& a, const PackedJoint& b) const { return is_same(a, b); }
  bool operator()(std::uint32_t a, std::uint32_t b) const { return link(a, b); }

  template <class T>
  bool all(const std::vector<T>& a, const std::vector<T>& b) const {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), *this);
  }
  bool operator()(const Island& a, const Island& b) const {
    return a.bodies == b.bodies && a.parents == b.parents && a.settings == b.settings &&
           a.unfit == b.unfit && a.rests.size() == b.rests.size() && has_same_anchors(a, b) &&
           has_same_masses(a, b) && all(a.trees, b.trees) && all(a.pins, b.pins) &&
           all(a.cables, b.cables) && all(a.links, b.links) && all(a.joints, b.joints);
  }
};

/// The island of the last build, with the current slots, joint laws, drags and gravity scales.
Island renumbered(Island old, Island& made) {
  PANTIN_ASSERT(old.count() == made.count() && old.joint_memory.size() == made.joint_memory.size());
  copy_slots(made, old);
  old.slots = std::move(made.slots), old.links = std::move(made.links);
  old.joints = std::move(made.joints), old.constants = std::move(made.constants);
  return old;
}

/// Keeps the state of islands whose structure is unchanged.
void keep_unchanged(World& world, IslandVector& before, IslandVector& made) {
  const bool edited = world.edit_count != partition_of(world).edit_count;
  std::vector<std::uint32_t> at(world.bodies.size(), kNoSlot);  // by slot of the first body
  for (std::uint32_t i = 0; i < before.size(); ++i)
    if (const std::uint32_t slot = world.bodies.slot(before[i].bodies.front()); slot != kNoSlot)
      at[slot] = i;
  const Unchanged unchanged{world};
  for (std::size_t i = 0; i < made.size(); ++i) {
    Island& a = made[i];
    const std::uint32_t was = at[a.slots.front()];
    if (was == kNoSlot || !unchanged(before[was], a)) continue;
    a = renumbered(std::move(before[was]), a);
    if (edited) stir(a);
  }
}

/// Location of a body's state in the previous compilation.
struct Remembered {
  const Island* island = nullptr;
  std::size_t column = 0;
};

void carry_memory(const IslandVector& before, const World& world, IslandVector& made) {
  std::vector<Remembered> old(world.bodies.size());
  for (const Island& a : before)
    for (std::size_t c = 0; c < a.count(); ++c)
      if (const std::uint32_t slot = world.bodies.slot(a.bodies[c]); slot != kNoSlot)
        old[slot] = {&a, c};
  for (Island& a : made) {
    for (std::size_t c = 0; c < a.count(); ++c) {
      const Remembered& r = old[a.slots[c]];
      if (!r.island) continue;
      a.fresh = a.fresh && r.island->fresh;
      a.last_step = r.island->last_step;
      for (std::size_t row = 0; row < kLambda; ++row)
        a.memory.at(row, c) = r.island->memory.at(row, r.column);
      // A joint keeps its lambda while its parent is the same.
      const auto parent_of = [](const Island& x, std::size_t column) {
        const std::int32_t p = x.parents[column];
        return p >= 0 ? x.bodies[static_cast<std::size_t>(p)] : Entity{};
      };
      if (parent_of(a, c) == parent_of(*r.island, r.column))
        a.memory.set(kLambda, c, r.island->memory.vec(kLambda, r.column));
      if (a.joints.empty() || r.island->joints.empty()) continue;
      const PackedJoint& was_joint = r.island->joints[r.column];
      const PackedJoint& joint = a.joints[c];
      if (joint.own_is_a != was_joint.own_is_a || joint.joint.kind != was_joint.joint.kind)
        continue;
      a.joint_memory[c] = r.island->joint_memory[r.column];
    }
    PANTIN_ASSERT(a.joint_memory.size() == a.joints.size());
    const Remembered& first = old[a.slots.front()];
    if (!first.island || first.island->bodies != a.bodies) continue;
    // A free tree keeps its angular momentum only while structure and masses are unchanged.
    const Island& was = *first.island;
    if (!has_same_masses(a, was)) continue;
    for (std::size_t t = 0; t < a.trees.size() && a.trees.size() == was.trees.size(); ++t) {
      const std::uint32_t root = a.trees[t].first;
      if (was.trees[t].first != root || was.parents[root] != a.parents[root]) continue;
      a.trees[t].angular_momentum = was.trees[t].angular_momentum;
      a.trees[t].knows_angular_momentum = was.trees[t].knows_angular_momentum;
    }
  }
}

/// By slot: whether a joint, a cable or a pin is attached to the body.
std::vector<std::uint8_t> list_tied(const World& world) {
  std::vector<std::uint8_t> tied(world.bodies.size(), 0);
  const auto tie = [&](Entity e) {
    if (const std::uint32_t slot = world.bodies.slot(e); slot != kNoSlot) tied[slot] = 1;
  };
  for (const Link& l : world.links.values()) tie(l.a), tie(l.b);
  for (const Cable& c : world.cables.values()) tie(c.a), tie(c.b);
  for (const Pin& p : world.pins.values()) tie(p.body), tie(p.to);
  return tied;
}

/// Whether an island of one free body is unchanged.
bool is_as_before(const World& world, const IslandPlan& plan, const Island& a) {
  if (a.count() != 1 || plan.slots.size() != 1 || a.unfit || plan.unfit) return false;
  const std::uint32_t slot = plan.slots.front();
  const Body& b = world.bodies.values()[slot];
  const bool is_solid = world.collisions.find(a.bodies[0]) != nullptr;
  return a.bodies[0] == world.bodies.owners()[slot] && a.settings == plan.settings &&
         a.parents[0] == kFree && !is_tied(a) && a.rests.empty() != is_solid &&
         a.constants.at(kMass, 0) == b.mass && a.constants.vec(kInertia, 0) == b.inertia &&
         a.constants.at(kDrag, 0) == b.drag && a.constants.at(kGravityScale, 0) == b.gravity_scale;
}

}  // namespace

std::size_t keep_first(World& world, std::span<const IslandPlan> plans, IslandVector& list) {
  Partition& partition = world.memory.of<Partition>();
  if (world.edit_count != partition.edit_count) return 0;  // sleeping islands have to wake
  const std::vector<std::uint8_t> tied = list_tied(world);
  std::size_t kept = 0;
  for (; kept < std::min(plans.size(), list.size()); ++kept) {
    const IslandPlan& plan = plans[kept];
    Island& a = list[kept];
    const std::uint32_t slot = plan.slots.front();
    if (tied[slot] != 0 || !is_as_before(world, plan, a)) break;
    std::fill(a.slots.begin(), a.slots.end(), slot);
    partition.set_column(slot, 0);
  }
  return kept;
}

/// Takes over the turns that another solver has counted.
void take_turns(const World& world, IslandVector& made) {
  const TurnCounts& counts = partition_of(world).turns;
  if (counts.empty()) return;
  for (Island& a : made)
    for (std::size_t c = 0; c < a.joints.size(); ++c)
      if (counts_turns(a, c))
        if (const Real* angle =
                find_count(counts, world.links.owners()[a.links[c]], Coordinate::angle))
          a.joint_memory[c].angle = *angle;
}

void carry_over(World& world, IslandVector& before, IslandVector& made) {
  take_turns(world, made), carry_memory(before, world, made);
  keep_unchanged(world, before, made);
}

}  // namespace pantin::detail::articulated
