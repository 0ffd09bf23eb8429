// Invariants of packed islands and of groups in contact, which all files of the solver rely on.
#include "engine/base/invariants.hpp"

#include <algorithm>

#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Bodies of a tree are consecutive, parents before children.
void assert_trees(const Island& a) {
  [[maybe_unused]] std::size_t next = 0;
  for (const Tree& t : a.trees) {
    PANTIN_ASSERT(t.first == next && t.count > 0);
    next += t.count;
    PANTIN_ASSERT(a.parents[t.first] == kHeld || a.parents[t.first] == kFree);
    PANTIN_ASSERT(a.parents[t.first] != kHeld || t.held_body != kNoSlot || t.held_pin != kNoSlot);
    for (std::size_t c = t.first + 1; c < t.first + t.count; ++c) {
      PANTIN_ASSERT(a.parents[c] >= static_cast<std::int32_t>(t.first));
      PANTIN_ASSERT(a.parents[c] < static_cast<std::int32_t>(c) && a.links[c] != kNoSlot);
    }
  }
  PANTIN_ASSERT(next == a.count());
}

void assert_joints(const Island& a) {
  PANTIN_ASSERT(a.joints.empty() || a.joints.size() == a.count());
  PANTIN_ASSERT(a.joint_memory.size() == a.joints.size());
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    PANTIN_ASSERT(!a.joints[c].stiff || (a.links[c] != kNoSlot && a.parents[c] != kFree));
}

void assert_ties(const Island& a) {
  for ([[maybe_unused]] const PackedPin& p : a.pins) {
    PANTIN_ASSERT(p.column < a.count() && is_index_or_none(p.partner, a.count()));
    PANTIN_ASSERT(p.tree < a.trees.size() &&
                  p.column - a.trees[p.tree].first < a.trees[p.tree].count);
    PANTIN_ASSERT(p.held_pin != kNoSlot || p.held_link != kNoSlot);
    PANTIN_ASSERT(p.partner != kNoSlot || p.held_body != kNoSlot || p.held_pin != kNoSlot);
  }
  for ([[maybe_unused]] const PackedCable& c : a.cables) {
    PANTIN_ASSERT(is_index_or_none(c.column_a, a.count()) &&
                  is_index_or_none(c.column_b, a.count()));
    PANTIN_ASSERT(c.column_a != kNoSlot || c.column_b != kNoSlot);
  }
}

}  // namespace

void assert_packed(const Island& a) {
  PANTIN_ASSERT(a.count() > 0 && a.links.size() == a.count());
  PANTIN_ASSERT(a.slots.size() % kLanes == 0 && a.slots.size() - a.count() < kLanes);
  PANTIN_ASSERT(a.parents.size() == a.slots.size());
  PANTIN_ASSERT(a.rests.empty() || a.rests.size() == a.count());
  PANTIN_ASSERT(!a.is_chain || a.trees.size() == 1);
  assert_trees(a), assert_joints(a), assert_ties(a);
}

namespace {

void assert_bodies(const Group& g) {
  PANTIN_ASSERT(!g.bodies.empty() && g.bodies.front().per_mass > 0);
  for ([[maybe_unused]] const GroupBody& b : g.bodies) {
    PANTIN_ASSERT(is_index_or_none(b.node, g.nodes.size()));
    PANTIN_ASSERT(is_index_or_none(b.looped, g.looped.size()));
    PANTIN_ASSERT(b.node == kNoNode || g.bodies.data() + g.nodes[b.node].body == &b);
    PANTIN_ASSERT(b.looped == kNoNode || g.looped[b.looped].node == b.node);
  }
  PANTIN_ASSERT(std::is_partitioned(g.bodies.begin(), g.bodies.end(), can_give_way));
}

/// Nodes of a tree are consecutive, parents before children.
void assert_nodes(const Group& g) {
  [[maybe_unused]] std::size_t next = 0;
  for (const GroupTree& t : g.trees) {
    PANTIN_ASSERT(t.first == next && t.count > 0 && g.nodes[t.first].parent == kNoNode);
    next += t.count;
    PANTIN_ASSERT(is_index_or_none(t.loops, g.loops.size()));
    for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
      [[maybe_unused]] const GroupNode& n = g.nodes[i];
      PANTIN_ASSERT(n.body < g.bodies.size() && &g.trees[n.tree] == &t);
      PANTIN_ASSERT(i == t.first || (n.parent >= t.first && n.parent < i));
      PANTIN_ASSERT(i == t.first || n.depth == g.nodes[n.parent].depth + 1);
      PANTIN_ASSERT(n.joint || (!n.is_limited && !n.has_spring && !n.drive && !n.actuator.dof));
    }
  }
  PANTIN_ASSERT(next == g.nodes.size());
}

void assert_points(const Group& g) {
  for ([[maybe_unused]] const GroupContact& c : g.contacts) {
    PANTIN_ASSERT(c.a < g.bodies.size() && c.b < g.bodies.size() && c.a != c.b);
    PANTIN_ASSERT(g.bodies[c.a].per_mass > 0 && is_unit(c.axes[0]));
    PANTIN_ASSERT(is_index_or_none(c.cross, g.crosses.size()));
    PANTIN_ASSERT(is_index_or_none(c.rolling, g.rollings.size()));
  }
  [[maybe_unused]] std::size_t next = 0;
  for (const GroupPair& p : g.pairs) {
    PANTIN_ASSERT(p.first == next && p.count > 0 && p.count <= kMostPoints);
    next += p.count;
    PANTIN_ASSERT(next <= g.contacts.size() &&
                  have_same_bodies(g.contacts[p.first], g.contacts[next - 1]));
  }
  PANTIN_ASSERT(next == g.contacts.size());
  for ([[maybe_unused]] const GroupRolling& r : g.rollings)
    PANTIN_ASSERT(r.count > 0 && is_part(r.first, r.count, g.contacts.size()));
  for ([[maybe_unused]] const GroupTie& t : g.ties) {
    PANTIN_ASSERT(t.a < g.bodies.size() && t.b < g.bodies.size());
    PANTIN_ASSERT(is_index_or_none(t.cross, g.crosses.size()));
  }
}

/// Rigid ties of an island are consecutive, as are its trees; their workspace is large enough.
void assert_loops(const Group& g) {
  for ([[maybe_unused]] const GroupLoops& l : g.loops) {
    PANTIN_ASSERT(l.ties > 0 && is_part(l.first_tie, l.ties, g.ties.size()));
    PANTIN_ASSERT(l.trees > 0 && is_part(l.first_tree, l.trees, g.trees.size()));
    PANTIN_ASSERT(is_part(l.row, l.ties * kBlockNumbers, g.numbers.size()));
    PANTIN_ASSERT(is_part(l.left, 3 * l.ties, g.numbers.size()));
    for (std::uint32_t i = 0; i < l.ties; ++i) {
      [[maybe_unused]] const GroupTie& t = g.ties[l.first_tie + i];
      PANTIN_ASSERT(t.kind == GroupTie::Kind::rigid && t.first <= i);
      PANTIN_ASSERT(t.first_step <= g.path_steps.size());
    }
  }
  for ([[maybe_unused]] const LoopedBody& b : g.looped) {
    PANTIN_ASSERT(b.loops < g.loops.size() && b.node < g.nodes.size());
    PANTIN_ASSERT(is_part(b.rows, 2 * g.loops[b.loops].ties * kBlockNumbers, g.numbers.size()));
  }
}

}  // namespace

void assert_gathered(const Group& g) {
  assert_bodies(g), assert_nodes(g), assert_points(g), assert_loops(g);
}

}  // namespace pantin::detail::articulated
