#include <algorithm>
#include <numeric>

#include "engine/base/archive.hpp"
#include "engine/base/check.hpp"
#include "engine/base/disjoint_sets.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::articulated {
namespace {

/// A possible anchor of a tree: a link to a kinematic body, or a pin.
struct Anchorage {
  std::uint32_t body = 0;  // slot of the dynamic body
  Vec3 anchor{0};          // in it
  std::uint32_t held_body = kNoSlot, held_pin = kNoSlot, link = kNoSlot;
  Vec3 held_anchor{0};
  int priority = 0;
  Real compliance = 0;
};

/// A joint or a pin between two dynamic bodies that is not part of the tree.
struct Loop {
  std::uint32_t body = 0, partner = 0;  // slots
  Vec3 anchor{0}, partner_anchor{0};
  std::uint32_t link = kNoSlot, pin = kNoSlot;
  int priority = 0;
  Real compliance = 0;
};

struct Neighbour {
  std::uint32_t body, link;
};

/// Lookup tables for packing trees.
struct Builder {
  World& world;
  Partition& partition;
  std::vector<std::uint32_t> neighbour_start;  // by slot, into neighbours
  std::vector<Neighbour> neighbours;
  std::vector<Anchorage> anchorages;  // sorted by body slot
  std::vector<Loop> loops;
  std::vector<std::uint32_t> column;  // by slot, in its island
  std::vector<std::uint32_t> island;  // by slot

  explicit Builder(World& w) : world(w), partition(w.memory.of<Partition>()) {}
  /// Whether this solver moves the body.
  bool is_dynamic(std::uint32_t slot) const {
    const Owner owner = owner_of(partition, slot);
    return owner && owner.solver == kArticulated;
  }
  /// Whether another one does.
  bool is_foreign(std::uint32_t slot) const {
    const Owner owner = owner_of(partition, slot);
    return owner && owner.solver != kArticulated;
  }
  void fault(Entity e, const char* reason) {
    partition.faults.push_back({e, reason, StructureFault::left_out, false});
  }
};

/// Sorts links into neighbour lists of dynamic bodies and anchors; reports unusable ones.
void read_links(Builder& b) {
  World& world = b.world;
  DisjointSets forest(world.bodies.size());
  std::vector<std::pair<std::uint32_t, Neighbour>> pairs;
  for (std::uint32_t i = 0; i < world.links.size(); ++i) {
    const Link& link = world.links.values()[i];
    const Entity owner = world.links.owners()[i];
    const std::uint32_t sa = world.bodies.slot(link.a), sb = world.bodies.slot(link.b);
    if (sa == kNoSlot || sb == kNoSlot) {
      b.fault(owner, "names a body that does not exist");
    } else if (sa == sb) {
      b.fault(owner, "ties a body to itself");
    } else if (b.is_foreign(sa) || b.is_foreign(sb)) {
      continue;  // kept by that solver
    } else if (!b.is_dynamic(sa) && !b.is_dynamic(sb)) {
      b.fault(owner, "ties two bodies that joints cannot move");
    } else if (!is_articulated(link.joint.kind)) {
      b.fault(owner, "is of a kind that only the Lagrangian solver knows");
    } else if (!b.is_dynamic(sa)) {
      b.anchorages.push_back({sb, link.joint.anchor_b, sa, kNoSlot, i, link.joint.anchor_a, 0, 0});
    } else if (!b.is_dynamic(sb)) {
      b.anchorages.push_back({sa, link.joint.anchor_a, sb, kNoSlot, i, link.joint.anchor_b, 0, 0});
    } else if (forest.root(sa) == forest.root(sb)) {
      b.loops.push_back({sb, sa, link.joint.anchor_b, link.joint.anchor_a, i, kNoSlot, 0, 0});
    } else {
      forest.join(sa, sb);
      pairs.push_back({sa, {sb, i}}), pairs.push_back({sb, {sa, i}});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const auto& x, const auto& y) { return x.first < y.first; });
  b.neighbour_start.assign(world.bodies.size() + 1, 0);
  for (const auto& [slot, n] : pairs) ++b.neighbour_start[slot + 1], b.neighbours.push_back(n);
  std::partial_sum(b.neighbour_start.begin(), b.neighbour_start.end(), b.neighbour_start.begin());
}

void read_pins(Builder& b) {
  World& world = b.world;
  for (std::uint32_t i = 0; i < world.pins.size(); ++i) {
    const Pin& pin = world.pins.values()[i];
    const std::uint32_t slot = world.bodies.slot(pin.body);
    if (slot == kNoSlot) {
      b.fault(world.pins.owners()[i], "names a body that does not exist");
      continue;
    }
    const Real compliance = pin.grip == Grip::exact ? 0 : 1 / pin.stiffness;
    if (!b.is_dynamic(slot)) {  // a kinematic body needs no pin, but may be an anchor
      const std::uint32_t to = pin.to ? world.bodies.slot(pin.to) : kNoSlot;
      if (b.is_foreign(slot) && to != kNoSlot && b.is_dynamic(to))
        b.anchorages.push_back(
            {to, pin.target, slot, i, kNoSlot, pin.anchor, pin.priority, compliance});
      continue;
    }
    if (pin.to) {
      const std::uint32_t to = world.bodies.slot(pin.to);
      if (to == kNoSlot)
        b.fault(world.pins.owners()[i], "holds on to a body that does not exist");
      else if (to == slot)
        b.fault(world.pins.owners()[i], "holds a body on to itself");
      else if (!b.is_dynamic(to))
        b.anchorages.push_back(
            {slot, pin.anchor, to, i, kNoSlot, pin.target, pin.priority, compliance});
      else
        b.loops.push_back({slot, to, pin.anchor, pin.target, kNoSlot, i, pin.priority, compliance});
      continue;
    }
    b.anchorages.push_back({slot, pin.anchor, kNoSlot, i, kNoSlot, {}, pin.priority, compliance});
  }
  std::stable_sort(b.anchorages.begin(), b.anchorages.end(), [](const auto& x, const auto& y) {
    return x.body != y.body ? x.body < y.body : x.priority > y.priority;
  });
}

void check_strings(Builder& b) {
  for (std::uint32_t i = 0; i < b.world.cables.size(); ++i) {
    const Cable& s = b.world.cables.values()[i];
    const std::uint32_t sa = b.world.bodies.slot(s.a), sb = b.world.bodies.slot(s.b);
    if (sa == kNoSlot || sb == kNoSlot)
      b.fault(b.world.cables.owners()[i], "names a body that does not exist");
    else if (sa == sb)
      b.fault(b.world.cables.owners()[i], "ties a body to itself");
  }
}

/// Anchors of a set of bodies, best first.
std::vector<Anchorage> anchorages_of(const Builder& b, const std::vector<std::uint32_t>& slots) {
  std::vector<Anchorage> found;
  for (std::uint32_t slot : slots) {
    auto it = std::lower_bound(b.anchorages.begin(), b.anchorages.end(), slot,
                               [](const Anchorage& a, std::uint32_t s) { return a.body < s; });
    for (; it != b.anchorages.end() && it->body == slot; ++it) found.push_back(*it);
  }
  std::stable_sort(found.begin(), found.end(), [](const Anchorage& x, const Anchorage& y) {
    if ((x.compliance == 0) != (y.compliance == 0)) return x.compliance == 0;
    return x.priority > y.priority;
  });
  return found;
}

/// Bodies reachable from `start` over links, parents before children, each with its joint.
struct Visit {
  std::uint32_t slot, link;
  std::int32_t parent;  // place in the list, or -1
};
std::vector<Visit> walk(const Builder& b, std::uint32_t start) {
  std::vector<Visit> order, stack{{start, kNoSlot, -1}};
  while (!stack.empty()) {
    const Visit v = stack.back();
    stack.pop_back();
    order.push_back(v);
    const std::uint32_t from = b.neighbour_start[v.slot], to = b.neighbour_start[v.slot + 1];
    for (std::uint32_t i = to; i-- > from;)
      if (b.neighbours[i].link != v.link)
        stack.push_back({b.neighbours[i].body, b.neighbours[i].link,
                         static_cast<std::int32_t>(order.size()) - 1});
  }
  return order;
}

Vec3 anchor_in(const World& world, std::uint32_t link, std::uint32_t body_slot) {
  const Link& l = world.links.values()[link];
  return world.bodies.slot(l.a) == body_slot ? l.joint.anchor_a : l.joint.anchor_b;
}

/// Reach of a pin: sum of the distances between consecutive joint points on the path from the root.
void measure_reach(const Island& a, PackedPin& constraint) {
  Vec3 exit = constraint.anchor;
  Real longest = 0;
  constraint.reach = 0;
  for (std::int32_t i = static_cast<std::int32_t>(constraint.column); i >= 0;) {
    const auto c = static_cast<std::size_t>(i);
    const Real span = glm::length(exit - a.constants.vec(kOwnAnchor, c));
    constraint.reach += span;
    longest = std::max(longest, span);
    exit = a.constants.vec(kParentAnchor, c);
    i = a.parents[c];
  }
  constraint.dead_reach = std::max(Real(0), 2 * longest - constraint.reach);
}

/// Longest path from a root through the joints, outermost arm included.
Real longest_way(const Island& a) {
  Real longest = 0;
  std::vector<Real> way(a.count(), 0);
  for (std::size_t i = 0; i < a.count(); ++i) {
    const Real arm = glm::length(a.constants.vec(kOwnAnchor, i));
    if (a.parents[i] >= 0) {
      const auto p = static_cast<std::size_t>(a.parents[i]);
      way[i] =
          way[p] + glm::length(a.constants.vec(kParentAnchor, i) - a.constants.vec(kOwnAnchor, p));
    }
    const Vec3 moments = a.constants.vec(kInertia, i);
    const Real gyration = std::sqrt((moments.x + moments.y + moments.z) / a.constants.at(kMass, i));
    longest = std::max(longest, way[i] + std::max(2 * arm, gyration));
  }
  return longest;
}

void set_constants(Island& a, std::size_t c, const Body& body) {
  a.constants.at(kMass, c) = body.mass;
  a.constants.set(kInertia, c, body.inertia);
  a.constants.at(kDrag, c) = body.drag;
  a.constants.at(kGravityScale, c) = body.gravity_scale;
}

/// The joint of a column; stiff if it constrains rotations.
PackedJoint packed_joint(const World& world, std::uint32_t link, std::uint32_t body_slot) {
  PackedJoint j;
  if (link == kNoSlot) return j;
  const Link& l = world.links.values()[link];
  j.joint = l.joint;
  j.own_is_a = world.bodies.slot(l.a) == body_slot;
  const JointDrive* drive = world.joint_drives.find(world.links.owners()[link]);
  if (drive) j.drive = world.joint_drives.slot(world.links.owners()[link]);
  j.stiff = drive || info_of(j.joint.kind).uses_axes || j.joint.limits.any();
  return j;
}

void pack_joints(const World& world, Island& a) {
  std::vector<PackedJoint> joints;
  for (std::size_t c = 0; c < a.count(); ++c) {
    PackedJoint joint = packed_joint(world, a.links[c], a.slots[c]);
    if (!joint.stiff && joints.empty()) continue;
    joints.resize(c);  // free joints before this one
    joints.push_back(std::move(joint));
  }
  if (!joints.empty()) joints.resize(a.count());
  a.joint_memory.assign(joints.size(), {});
  a.joints = std::move(joints);
}

/// Packs one island: trees by links, best anchors as roots, other anchors as pins.
Island pack(Builder& b, const IslandPlan& plan, std::uint32_t index) {
  World& world = b.world;
  Island a;
  a.settings = plan.settings;
  const std::vector<std::uint32_t>& slots = plan.slots;
  const std::vector<Anchorage> anchorages = anchorages_of(b, slots);
  std::vector<Visit> all;
  std::vector<const Anchorage*> roots;
  const auto add_tree = [&](std::uint32_t start, const Anchorage* root) {
    Tree tree;
    tree.first = static_cast<std::uint32_t>(all.size());
    for (Visit v : walk(b, start)) {
      b.column[v.slot] = static_cast<std::uint32_t>(all.size());
      b.island[v.slot] = index;
      if (v.parent >= 0) v.parent += static_cast<std::int32_t>(tree.first);
      all.push_back(v);
    }
    tree.count = static_cast<std::uint32_t>(all.size()) - tree.first;
    if (root) {
      tree.held_body = root->held_body, tree.held_pin = root->held_pin;
      tree.anchor = root->held_anchor;
    }
    a.trees.push_back(tree), roots.push_back(root);
  };
  for (const Anchorage& g : anchorages)
    if (g.compliance == 0 && b.column[g.body] == kNoSlot) add_tree(g.body, &g);
  for (std::uint32_t slot : slots)
    if (b.column[slot] == kNoSlot) add_tree(slot, nullptr);
  PANTIN_ASSERT(all.size() == slots.size());

  const std::size_t padded = (all.size() + kLanes - 1) / kLanes * kLanes;
  a.bodies.reserve(all.size()), a.links.reserve(all.size());
  a.slots.reserve(padded), a.parents.reserve(padded);
  a.constants.resize(kConstantRows, all.size());
  a.memory.resize(kMemoryRows, all.size());
  for (std::size_t c = 0; c < all.size(); ++c) {
    const Visit& v = all[c];
    PANTIN_ASSERT(v.parent < static_cast<std::int32_t>(c));
    a.bodies.push_back(world.bodies.owners()[v.slot]);
    a.slots.push_back(v.slot), a.links.push_back(v.link), a.parents.push_back(v.parent);
    set_constants(a, c, world.bodies.values()[v.slot]);
    if (v.parent >= 0) {
      a.constants.set(kOwnAnchor, c, anchor_in(world, v.link, v.slot));
      const auto p = static_cast<std::size_t>(v.parent);
      a.constants.set(kParentAnchor, c, anchor_in(world, v.link, all[p].slot));
    }
    a.mass += world.bodies.values()[v.slot].mass;
  }
  a.is_chain = a.trees.size() == 1;
  for (std::size_t t = 0; t < a.trees.size(); ++t) {
    const std::size_t first = a.trees[t].first;
    a.parents[first] = roots[t] ? kHeld : kFree;
    if (!roots[t]) continue;
    a.links[first] = roots[t]->link;
    a.constants.set(kOwnAnchor, first, roots[t]->anchor);
  }
  for (std::size_t c = 1; c < all.size(); ++c)
    a.is_chain = a.is_chain && a.parents[c] == static_cast<std::int32_t>(c) - 1;
  for (const Anchorage& g : anchorages) {
    if (std::find(roots.begin(), roots.end(), &g) != roots.end()) continue;
    PackedPin h;
    h.column = b.column[g.body], h.anchor = g.anchor, h.priority = g.priority;
    h.held_body = g.held_body, h.held_pin = g.held_pin, h.held_anchor = g.held_anchor;
    h.held_link = g.link;
    h.compliance = g.compliance;
    while (h.tree + 1 < a.trees.size() && a.trees[h.tree + 1].first <= h.column) ++h.tree;
    if (a.parents[a.trees[h.tree].first] == kHeld) measure_reach(a, h);
    a.pins.push_back(h);
  }
  // Padding repeats the last body, so that padding lanes stay finite.
  while (a.slots.size() % kLanes != 0) {
    set_constants(a, a.slots.size(), world.bodies.values()[a.slots.back()]);
    a.slots.push_back(a.slots.back());
    a.parents.push_back(kFree);
  }
  a.size = longest_way(a);
  pack_joints(world, a);
  return a;
}

void tie_loops(const Builder& b, std::vector<Island>& made) {
  for (const Loop& loop : b.loops) {
    Island& a = made[b.island[loop.body]];
    PackedPin h;
    h.column = b.column[loop.body], h.partner = b.column[loop.partner];
    h.anchor = loop.anchor, h.held_anchor = loop.partner_anchor;
    h.held_link = loop.link, h.held_pin = loop.pin;
    h.priority = loop.priority, h.compliance = loop.compliance;
    while (h.tree + 1 < a.trees.size() && a.trees[h.tree + 1].first <= h.column) ++h.tree;
    a.pins.push_back(h);
  }
}

void tie_cords(Builder& b, std::vector<Island>& made) {
  World& world = b.world;
  for (std::uint32_t i = 0; i < world.cables.size(); ++i) {
    const Cable& s = world.cables.values()[i];
    PackedCable cord;
    cord.cable = i;
    cord.slot_a = world.bodies.slot(s.a), cord.slot_b = world.bodies.slot(s.b);
    if (cord.slot_a == kNoSlot || cord.slot_b == kNoSlot || cord.slot_a == cord.slot_b) continue;
    cord.column_a = b.column[cord.slot_a], cord.column_b = b.column[cord.slot_b];
    const std::uint32_t owner = cord.column_a != kNoSlot ? cord.slot_a : cord.slot_b;
    if (b.column[owner] == kNoSlot) continue;  // between two kinematic bodies
    made[b.island[owner]].cables.push_back(cord);
  }
}

/// Whether another solver moves a body that holds any part of the island.
bool follows_others(const Builder& b, const Island& a) {
  const World& world = b.world;
  const auto foreign_pin = [&](const auto& held) {
    if (held.held_pin == kNoSlot) return false;
    const Pin& pin = world.pins.values()[held.held_pin];
    return b.is_foreign(world.bodies.slot(pin.body)) ||
           (pin.to && b.is_foreign(world.bodies.slot(pin.to)));
  };
  const auto foreign_cable = [&](const PackedCable& cable) {
    return b.is_foreign(cable.slot_a) || b.is_foreign(cable.slot_b);
  };
  return std::any_of(a.trees.begin(), a.trees.end(), foreign_pin) ||
         std::any_of(a.pins.begin(), a.pins.end(), foreign_pin) ||
         std::any_of(a.cables.begin(), a.cables.end(), foreign_cable);
}

/// Slots of trees, holds and cables, from an island to one that was built from the same things.
void copy_slots(const IslandMemory& from, IslandMemory& to) {
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

bool is_same(const AngleLimit& a, const AngleLimit& b) {
  return a.on == b.on && a.low == b.low && a.high == b.high;
}

bool is_same(const JointLimits& a, const JointLimits& b) {
  return is_same(a.angle, b.angle) && is_same(a.second, b.second) && a.swing.on == b.swing.on &&
         a.swing.y == b.swing.y && a.swing.z == b.swing.z && a.soft_zone == b.soft_zone &&
         a.soft_stiffness == b.soft_stiffness && a.soft_damping == b.soft_damping;
}

bool is_same(const PackedJoint& a, const PackedJoint& b) {
  return a.stiff == b.stiff && a.own_is_a == b.own_is_a &&
         (a.drive == kNoSlot) == (b.drive == kNoSlot) && a.joint.kind == b.joint.kind &&
         a.joint.anchor_a == b.joint.anchor_a && a.joint.anchor_b == b.joint.anchor_b &&
         a.joint.frames.a() == b.joint.frames.a() && a.joint.frames.b() == b.joint.frames.b() &&
         is_same(*a.joint.limits, *b.joint.limits);
}

/// Whether an island is built just as it was: then nothing that it remembers is to change.
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
           a.constants.numbers() == b.constants.numbers() && a.unfit == b.unfit &&
           all(a.trees, b.trees) && all(a.pins, b.pins) && all(a.cables, b.cables) &&
           all(a.links, b.links) && all(a.joints, b.joints);
  }
};

/// The island as it was, with the slots of today.
Island renumbered(Island old, Island& made) {
  copy_slots(made, old);
  old.slots = std::move(made.slots), old.links = std::move(made.links);
  old.follows = made.follows;
  for (std::size_t i = 0; i < old.joints.size(); ++i) old.joints[i].drive = made.joints[i].drive;
  return old;
}

/// Islands that are built as they were go on as they were; so does what a repeated step of theirs
/// starts from.
void keep_unchanged(World& world, std::vector<Island>& before, std::vector<Island>& made) {
  Islands& all = world.memory.of<Islands>();
  const bool edited = world.edit_count != partition_of(world).edit_count;
  std::vector<Islands::Saved> saved(made.size());
  all.scratch.saved.resize(before.size());
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
    a.was = was;
    if (edited) a.asleep = false, a.quiet_time = 0;
    saved[i] = std::move(all.scratch.saved[was]);
    copy_slots(a, saved[i].memory);
  }
  all.scratch.saved = std::move(saved);
}

/// Location of a body's state in the previous compilation.
struct Remembered {
  const Island* island = nullptr;
  std::size_t column = 0;
};

void carry_memory(const std::vector<Island>& before, const World& world,
                  std::vector<Island>& made) {
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
    const Remembered& first = old[a.slots.front()];
    if (!first.island || first.island->bodies != a.bodies) continue;
    // A free tree keeps its angular momentum only while its structure is unchanged.
    const Island& was = *first.island;
    for (std::size_t t = 0; t < a.trees.size() && a.trees.size() == was.trees.size(); ++t) {
      const std::uint32_t root = a.trees[t].first;
      if (was.trees[t].first != root || was.parents[root] != a.parents[root]) continue;
      a.trees[t].angular_momentum = was.trees[t].angular_momentum;
      a.trees[t].knows_angular_momentum = was.trees[t].knows_angular_momentum;
    }
  }
}

}  // namespace

void compile(World& world, std::span<const IslandPlan> plans) {
  Builder b(world);
  read_links(b);
  read_pins(b);
  check_strings(b);
  b.column.assign(world.bodies.size(), kNoSlot);
  b.island.assign(world.bodies.size(), kNoSlot);
  std::vector<Island> made;
  made.reserve(plans.size());
  for (const IslandPlan& plan : plans)
    made.push_back(pack(b, plan, static_cast<std::uint32_t>(made.size())));
  tie_cords(b, made);
  tie_loops(b, made);
  for (const Island& a : made)
    for (std::uint32_t c = 0; c < a.count(); ++c) b.partition.set_column(a.slots[c], c);
  for (std::size_t i = 0; i < made.size(); ++i) {
    made[i].unfit = plans[i].unfit;
    made[i].follows = follows_others(b, made[i]);
  }
  std::vector<Island>& list = world.memory.of<Islands>().list;
  carry_memory(list, world, made);
  keep_unchanged(world, list, made);
  list = std::move(made);
  world.memory.of<Islands>().scratch.prepared = false;
}

}  // namespace pantin::detail::articulated
