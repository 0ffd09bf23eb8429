#include <algorithm>
#include <limits>
#include <numeric>

#include "engine/base/archive.hpp"
#include "engine/base/check.hpp"
#include "engine/base/disjoint_sets.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/closing.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::articulated {
namespace {

/// A possible anchor of a tree: a link to a kinematic body, or a pin.
struct Anchorage {
  std::uint32_t body = 0;  // slot of the dynamic body
  Vec3 anchor{0};          // in the body's frame
  std::uint32_t held_body = kNoSlot, held_pin = kNoSlot, link = kNoSlot;
  Vec3 held_anchor{0};
  int priority = 0;
  Real compliance = 0, damping = 0;
};

/// A joint or a pin between two dynamic bodies that is not part of the tree.
struct Loop {
  std::uint32_t body = 0, partner = 0;  // slots
  Vec3 anchor{0}, partner_anchor{0};
  std::uint32_t link = kNoSlot, pin = kNoSlot;
  int priority = 0;
  Real compliance = 0, damping = 0;
};

struct Neighbour {
  std::uint32_t body, link;
};

/// Lookup tables for packing trees.
struct Builder {
  World& world;
  const Scope& scope;
  Partition& partition;
  std::vector<std::uint32_t> neighbour_start;  // by slot, into neighbours
  std::vector<Neighbour> neighbours;
  std::vector<Anchorage> anchorages;  // sorted by body slot
  std::vector<Loop> loops;
  std::vector<std::uint32_t> column;  // by slot, in its island
  std::vector<std::uint32_t> island;  // by slot, among those that are made

  Builder(World& w, const Scope& s)
      : world(w),
        scope(s),
        partition(w.memory.of<Partition>()),
        column(w.bodies.size(), kNoSlot),
        island(w.bodies.size(), kNoSlot) {}
  /// Whether this solver moves the body.
  bool is_dynamic(std::uint32_t slot) const {
    const Owner owner = owner_of(partition, slot);
    return owner && owner.solver == kArticulated;
  }
  /// Whether another solver moves it.
  bool is_foreign(std::uint32_t slot) const {
    const Owner owner = owner_of(partition, slot);
    return owner && owner.solver != kArticulated;
  }
  /// Rank by what a joint has besides its point (axes, limits, motors): trees prefer high ranks.
  int more_than_a_point(std::uint32_t link) const {
    return link == kNoSlot ? 0 : detail::more_than_a_point(world, link);
  }
  void fault(Entity e, const char* reason) {
    partition.faults.push_back({e, reason, StructureFault::left_out, false});
  }
};

/// Sorts links into neighbour lists of dynamic bodies, loops and anchors; reports unusable ones.
void read_links(Builder& b) {
  World& world = b.world;
  DisjointSets forest(world.bodies.size());
  std::vector<std::pair<std::uint32_t, Neighbour>> pairs;
  for (const std::uint32_t i : growing_order(world, b.scope.links)) {
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
      b.fault(owner, "is of a kind that only the Lagrangian solver supports");
    } else if (!b.is_dynamic(sa)) {
      b.anchorages.push_back({sb, link.joint.anchor_b, sa, kNoSlot, i, link.joint.anchor_a});
    } else if (!b.is_dynamic(sb)) {
      b.anchorages.push_back({sa, link.joint.anchor_a, sb, kNoSlot, i, link.joint.anchor_b});
    } else if (forest.root(sa) == forest.root(sb)) {
      b.loops.push_back({sb, sa, link.joint.anchor_b, link.joint.anchor_a, i, kNoSlot});
    } else {
      forest.join(sa, sb);
      pairs.push_back({sa, {sb, i}}), pairs.push_back({sb, {sa, i}});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const auto& x, const auto& y) { return x.first < y.first; });
  PANTIN_ASSERT(pairs.size() % 2 == 0);
  b.neighbour_start.assign(world.bodies.size() + 1, 0);
  for (const auto& [slot, n] : pairs) ++b.neighbour_start[slot + 1], b.neighbours.push_back(n);
  std::partial_sum(b.neighbour_start.begin(), b.neighbour_start.end(), b.neighbour_start.begin());
  PANTIN_ASSERT(b.neighbour_start.back() == b.neighbours.size());
}

void read_pins(Builder& b) {
  World& world = b.world;
  for (const std::uint32_t i : b.scope.pins) {
    const Pin& pin = world.pins.values()[i];
    const std::uint32_t slot = world.bodies.slot(pin.body);
    if (slot == kNoSlot) {
      b.fault(world.pins.owners()[i], "names a body that does not exist");
      continue;
    }
    const Real compliance = pin.kind == PinKind::exact ? 0 : 1 / pin.stiffness;
    if (!b.is_dynamic(slot)) {  // a kinematic body needs no pin, but may be an anchor
      const std::uint32_t to = pin.to ? world.bodies.slot(pin.to) : kNoSlot;
      if (to != kNoSlot && b.is_dynamic(to))
        b.anchorages.push_back(
            {to, pin.target, slot, i, kNoSlot, pin.anchor, pin.priority, compliance, pin.damping});
      continue;
    }
    if (pin.to) {
      const std::uint32_t to = world.bodies.slot(pin.to);
      if (to == kNoSlot)
        b.fault(world.pins.owners()[i], "is anchored to a body that does not exist");
      else if (to == slot)
        b.fault(world.pins.owners()[i], "anchors a body to itself");
      else if (!b.is_dynamic(to))
        b.anchorages.push_back(
            {slot, pin.anchor, to, i, kNoSlot, pin.target, pin.priority, compliance, pin.damping});
      else
        b.loops.push_back(
            {slot, to, pin.anchor, pin.target, kNoSlot, i, pin.priority, compliance, pin.damping});
      continue;
    }
    b.anchorages.push_back(
        {slot, pin.anchor, kNoSlot, i, kNoSlot, {}, pin.priority, compliance, pin.damping});
  }
  std::stable_sort(b.anchorages.begin(), b.anchorages.end(), [](const auto& x, const auto& y) {
    return x.body != y.body ? x.body < y.body : x.priority > y.priority;
  });
}

void check_strings(Builder& b) {
  for (const std::uint32_t i : b.scope.cables) {
    const Cable& s = b.world.cables.values()[i];
    const std::uint32_t sa = b.world.bodies.slot(s.a), sb = b.world.bodies.slot(s.b);
    const bool all_exist = std::all_of(s.guides.begin(), s.guides.end(), [&](const CableGuide& g) {
      return b.world.bodies.find(g.body) != nullptr;
    });
    if (sa == kNoSlot || sb == kNoSlot || !all_exist)
      b.fault(b.world.cables.owners()[i], "names a body that does not exist");
    else if (sa == sb && s.guides.empty())
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
  std::stable_sort(found.begin(), found.end(), [&](const Anchorage& x, const Anchorage& y) {
    if ((x.compliance == 0) != (y.compliance == 0)) return x.compliance == 0;
    const int more_x = b.more_than_a_point(x.link), more_y = b.more_than_a_point(y.link);
    if (more_x != more_y) return more_x > more_y;
    return x.priority > y.priority;
  });
  return found;
}

/// Bodies reachable from `start` over links, parents before children, each with its joint.
struct Visit {
  std::uint32_t slot, link;
  std::int32_t parent;  // index in the list, or -1
};
std::vector<Visit> walk(const Builder& b, std::uint32_t start) {
  std::vector<Visit> order, stack{{start, kNoSlot, -1}};
  while (!stack.empty()) {
    const Visit v = stack.back();
    stack.pop_back();
    order.push_back(v);
    PANTIN_ASSERT(order.size() <= b.world.bodies.size());
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
  PANTIN_ASSERT((world.bodies.slot(l.a) == body_slot) != (world.bodies.slot(l.b) == body_slot));
  return world.bodies.slot(l.a) == body_slot ? l.joint.anchor_a : l.joint.anchor_b;
}

/// Reach of a pin: sum of the distances between consecutive joint points on the path from the root.
void measure_reach(const Island& a, PackedPin& constraint) {
  Vec3 exit = constraint.anchor;
  Real longest = 0;
  constraint.reach = 0;
  for (std::int32_t i = static_cast<std::int32_t>(constraint.column); i >= 0;) {
    const auto c = static_cast<std::size_t>(i);
    PANTIN_ASSERT(c < a.count() && a.parents[c] < i);
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
      PANTIN_ASSERT(p < i);
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

/// rad: a ball joint whose cone is narrower is a hinge about the twist's axis, since the direction
/// in which such a cone is left is lost to rounding.
constexpr Real kLockedSwing = 1e-3;

/// The joint as this solver takes it.
Joint as_solved(Joint joint) {
  const SwingLimit& swing = joint.limits->swing;
  if (joint.kind != JointKind::ball || !swing.on || std::max(swing.y, swing.z) > kLockedSwing)
    return joint;
  joint.kind = JointKind::hinge, joint.limits.edit().swing.on = false;
  return joint;
}

/// The joint of a column; stiff if it constrains rotations.
PackedJoint packed_joint(const World& world, std::uint32_t link, std::uint32_t body_slot) {
  PackedJoint j;
  if (link == kNoSlot) return j;
  const Link& l = world.links.values()[link];
  j.joint = as_solved(l.joint);
  PANTIN_ASSERT((world.bodies.slot(l.a) == body_slot) != (world.bodies.slot(l.b) == body_slot));
  j.own_is_a = world.bodies.slot(l.a) == body_slot;
  const JointDrive* drive = world.joint_drives.find(world.links.owners()[link]);
  if (drive && !drive->exact) j.drive = world.joint_drives.slot(world.links.owners()[link]);
  j.stiff = drive || info_of(j.joint.kind).uses_axes || j.joint.limits.any();
  return j;
}

void pack_joints(const World& world, Island& a) {
  std::vector<PackedJoint> joints;
  for (std::size_t c = 0; c < a.count(); ++c) {
    PackedJoint joint = packed_joint(world, a.links[c], a.slots[c]);
    if (!joint.stiff && joints.empty()) continue;
    PANTIN_ASSERT(joints.size() <= c);
    joints.resize(c);  // free joints before this one
    joints.push_back(std::move(joint));
  }
  if (!joints.empty()) joints.resize(a.count());
  a.joint_memory.assign(joints.size(), {});
  a.joints = std::move(joints);
}

/// Reserves resting poses if the island has colliders.
void watch_rest(const World& world, Island& a) {
  const bool solid = std::any_of(a.bodies.begin(), a.bodies.end(),
                                 [&](Entity e) { return world.collisions.find(e) != nullptr; });
  a.rests.assign(solid ? a.count() : 0, {});
}

/// The trees of one island while it is packed.
struct Planting {
  std::vector<Visit> visits;              // by column
  std::vector<const Anchorage*> anchors;  // by tree; null: free
};

void add_tree(Builder& b, Island& a, Planting& all, std::uint32_t start) {
  Tree tree;
  tree.first = static_cast<std::uint32_t>(all.visits.size());
  for (Visit v : walk(b, start)) {
    PANTIN_ASSERT(b.is_dynamic(v.slot) && b.column[v.slot] == kNoSlot);
    b.column[v.slot] = static_cast<std::uint32_t>(all.visits.size());
    if (v.parent >= 0) v.parent += static_cast<std::int32_t>(tree.first);
    all.visits.push_back(v);
  }
  tree.count = static_cast<std::uint32_t>(all.visits.size()) - tree.first;
  a.trees.push_back(tree), all.anchors.push_back(nullptr);
}

/// Trees by links; the best anchors become roots.
Planting plant_trees(Builder& b, const std::vector<std::uint32_t>& slots,
                     const std::vector<Anchorage>& anchorages, Island& a) {
  Planting all;
  for (const Anchorage& g : anchorages) {
    if (g.compliance != 0 || b.column[g.body] != kNoSlot) continue;
    add_tree(b, a, all, g.body);
    Tree& tree = a.trees.back();
    tree.held_body = g.held_body, tree.held_pin = g.held_pin, tree.anchor = g.held_anchor;
    all.anchors.back() = &g;
  }
  for (std::uint32_t slot : slots)
    if (b.column[slot] == kNoSlot) add_tree(b, a, all, slot);
  PANTIN_ASSERT(all.visits.size() == slots.size());
  return all;
}

/// Whether the bodies are alike enough in mass, and thick enough, for iterations with the matrices
/// of the one before: among others a small rotation of one is a large change for another.
bool is_even(const Island& a) {
  constexpr Real kMostMassRatio = 8, kLeastMomentRatio = 1e-2;
  Real lightest = std::numeric_limits<Real>::infinity(), heaviest = 0;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Real mass = a.constants.at(kMass, c);
    const Vec3 i = a.constants.vec(kInertia, c);
    lightest = std::min(lightest, mass), heaviest = std::max(heaviest, mass);
    if (std::min({i.x, i.y, i.z}) < kLeastMomentRatio * std::max({i.x, i.y, i.z})) return false;
  }
  return heaviest <= kMostMassRatio * lightest;
}

void pack_bodies(const World& world, const Planting& all, Island& a) {
  PANTIN_ASSERT(all.anchors.size() == a.trees.size());
  const std::vector<Visit>& visits = all.visits;
  const std::size_t padded = (visits.size() + kLanes - 1) / kLanes * kLanes;
  a.bodies.reserve(visits.size()), a.links.reserve(visits.size());
  a.slots.reserve(padded), a.parents.reserve(padded);
  a.constants.resize(kConstantRows, visits.size());
  a.memory.resize(kMemoryRows, visits.size());
  for (std::size_t c = 0; c < visits.size(); ++c) {
    const Visit& v = visits[c];
    PANTIN_ASSERT(v.parent < static_cast<std::int32_t>(c));
    a.bodies.push_back(world.bodies.owners()[v.slot]);
    a.slots.push_back(v.slot), a.links.push_back(v.link), a.parents.push_back(v.parent);
    set_constants(a, c, world.bodies.values()[v.slot]);
    if (v.parent >= 0) {
      a.constants.set(kOwnAnchor, c, anchor_in(world, v.link, v.slot));
      const auto p = static_cast<std::size_t>(v.parent);
      a.constants.set(kParentAnchor, c, anchor_in(world, v.link, visits[p].slot));
    }
    a.mass += world.bodies.values()[v.slot].mass;
  }
  for (std::size_t t = 0; t < a.trees.size(); ++t) {
    const std::size_t first = a.trees[t].first;
    const Anchorage* anchor = all.anchors[t];
    a.parents[first] = anchor ? kHeld : kFree;
    if (!anchor) continue;
    a.links[first] = anchor->link;
    a.constants.set(kOwnAnchor, first, anchor->anchor);
  }
  a.is_even = is_even(a);
  a.is_chain = a.trees.size() == 1;
  for (std::size_t c = 1; c < visits.size(); ++c)
    a.is_chain = a.is_chain && a.parents[c] == static_cast<std::int32_t>(c) - 1;
  a.children.assign(a.is_chain ? 0 : a.parents.size(), {});
  if (a.is_chain) return;
  for (auto c = static_cast<std::uint32_t>(a.parents.size()); c-- > 0;) {
    if (a.parents[c] < 0) continue;
    Children& of_parent = a.children[static_cast<std::size_t>(a.parents[c])];
    a.children[c].sibling = of_parent.first, of_parent.first = c;
  }
}

/// Packs the anchors that are not roots.
void pack_pins(Builder& b, const std::vector<Anchorage>& anchorages, const Planting& all,
               Island& a) {
  for (const Anchorage& g : anchorages) {
    if (std::find(all.anchors.begin(), all.anchors.end(), &g) != all.anchors.end()) continue;
    PackedPin h;
    PANTIN_ASSERT(b.column[g.body] != kNoSlot);
    h.column = b.column[g.body], h.anchor = g.anchor, h.priority = g.priority;
    h.held_body = g.held_body, h.held_pin = g.held_pin, h.held_anchor = g.held_anchor;
    h.held_link = g.link;
    h.compliance = g.compliance, h.damping = g.damping;
    while (h.tree + 1 < a.trees.size() && a.trees[h.tree + 1].first <= h.column) ++h.tree;
    if (a.parents[a.trees[h.tree].first] == kHeld) measure_reach(a, h);
    a.pins.push_back(h);
  }
}

/// Packs one island, the next of those that are made.
Island pack(Builder& b, const IslandPlan& plan, std::uint32_t index) {
  World& world = b.world;
  Island a;
  PANTIN_ASSERT(plan.solver == kArticulated && !plan.slots.empty());
  a.settings = plan.settings;
  const std::vector<Anchorage> anchorages = anchorages_of(b, plan.slots);
  const Planting all = plant_trees(b, plan.slots, anchorages, a);
  for (const Visit& v : all.visits) b.island[v.slot] = index;
  pack_bodies(world, all, a);
  pack_pins(b, anchorages, all, a);
  // Padding repeats the last body, so that padding lanes stay finite.
  while (a.slots.size() % kLanes != 0) {
    set_constants(a, a.slots.size(), world.bodies.values()[a.slots.back()]);
    a.slots.push_back(a.slots.back());
    a.parents.push_back(kFree);
  }
  a.size = longest_way(a);
  pack_joints(world, a);
  watch_rest(world, a);
  return a;
}

void tie_loops(Builder& b, IslandVector& made) {
  for (const Loop& loop : b.loops) {
    Island& a = made[b.island[loop.body]];
    PANTIN_ASSERT(b.island[loop.body] == b.island[loop.partner] &&
                  b.column[loop.body] != b.column[loop.partner]);
    PackedPin h;
    h.column = b.column[loop.body], h.partner = b.column[loop.partner];
    h.anchor = loop.anchor, h.held_anchor = loop.partner_anchor;
    h.held_link = loop.link, h.held_pin = loop.pin;
    h.priority = loop.priority, h.compliance = loop.compliance, h.damping = loop.damping;
    while (h.tree + 1 < a.trees.size() && a.trees[h.tree + 1].first <= h.column) ++h.tree;
    a.pins.push_back(h);
  }
}

void add_cables(Builder& b, IslandVector& made) {
  World& world = b.world;
  for (const std::uint32_t i : b.scope.cables) {
    const Cable& s = world.cables.values()[i];
    if (!s.guides.empty()) continue;
    PackedCable cord;
    cord.cable = i;
    cord.slot_a = world.bodies.slot(s.a), cord.slot_b = world.bodies.slot(s.b);
    if (cord.slot_a == kNoSlot || cord.slot_b == kNoSlot || cord.slot_a == cord.slot_b) continue;
    cord.column_a = b.column[cord.slot_a], cord.column_b = b.column[cord.slot_b];
    const std::uint32_t owner = cord.column_a != kNoSlot ? cord.slot_a : cord.slot_b;
    if (b.column[owner] == kNoSlot) continue;  // between two kinematic bodies
    PANTIN_ASSERT(cord.column_a == kNoSlot || cord.column_b == kNoSlot ||
                  b.island[cord.slot_a] == b.island[cord.slot_b]);
    made[b.island[owner]].cables.push_back(cord);
  }
}

}  // namespace

IslandVector pack_islands(World& world, const Scope& scope, std::span<const IslandPlan> plans) {
  Builder b(world, scope);
  read_links(b);
  read_pins(b);
  check_strings(b);
  IslandVector made;
  made.reserve(plans.size());
  for (std::size_t i = 0; i < plans.size(); ++i)
    made.push_back(pack(b, plans[i], static_cast<std::uint32_t>(i)));
  add_cables(b, made);
  tie_loops(b, made);
  for (const Island& a : made)
    for (std::uint32_t c = 0; c < a.count(); ++c) b.partition.set_column(a.slots[c], c);
  for (std::size_t i = 0; i < made.size(); ++i) made[i].unfit = plans[i].unfit;
  return made;
}

}  // namespace pantin::detail::articulated
