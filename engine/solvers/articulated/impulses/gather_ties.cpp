// Gathers pins, loops and cables of each group for a step (group_loops.cpp, group_ties.cpp).
#include <algorithm>
#include <tuple>

#include "engine/contact/detect.hpp"
#include "engine/joints/reel.hpp"
#include "engine/solvers/articulated/impulses/gather.hpp"
#include "engine/solvers/articulated/impulses/graph_order.hpp"

namespace pantin::detail::articulated {
namespace {

/// Loop gap, as a fraction of the island's size, that is closed gradually over the steps.
constexpr Real kOpen = 1e-5;

/// The index of a fixed or kinematic body, which is added to the group once.
std::uint32_t gather_place(const World& world, GroupScratch& r, const GroupScratch::Range& range,
                           const PlacedAt& at) {
  PANTIN_ASSERT(at.slot < r.index.size());
  const std::size_t first = range.first_body;
  const std::uint32_t known = r.index[at.slot];
  if (known < r.bodies.size() - first && r.bodies[first + known].slot == at.slot &&
      r.bodies[first + known].island == UINT32_MAX)
    return known;
  r.index[at.slot] = static_cast<std::uint32_t>(r.bodies.size() - first);
  r.bodies.push_back(gather_pose(world, at.slot, at.h));
  return r.index[at.slot];
}

/// A pin's target in the world, as a kinematic body that moves to the target of the step.
std::uint32_t gather_target(GroupScratch& r, const GroupScratch::Range& range, const PackedPin& pin,
                            Real h) {
  GroupBody place;
  PANTIN_ASSERT(pin.held_pin != kNone);
  place.slot = UINT32_MAX;
  place.pose.position = pin.target_before;
  place.velocity = (pin.target - pin.target_before) / h;
  r.bodies.push_back(place);
  return static_cast<std::uint32_t>(r.bodies.size() - 1 - range.first_body);
}

void add_tie(GroupScratch& r, const GroupScratch::Range& range, GroupTie t) {
  if (are_coupled(r, range, {t.a, t.b})) {
    t.cross = static_cast<std::uint32_t>(r.crosses.size() - range.first_cross);
    r.crosses.emplace_back();
  }
  r.ties.push_back(t);
}

/// A pin or a joint that closes a loop, of an island whose bodies are in the group.
struct PinOf {
  const PackedPin& pin;
  const IslandStep& of;
};
GroupTie gather_pin(const World& world, GroupScratch& r, const GroupScratch::Range& range,
                    const PinOf& gathered) {
  const auto& [pin, of] = gathered;
  const Island& a = islands_of(world)[of.number];
  GroupTie t;
  t.kind = is_rigid(pin) ? GroupTie::Kind::rigid : GroupTie::Kind::spring;
  if (!is_rigid(pin)) t.stiffness = 1 / pin.compliance, t.damping = pin.damping;
  t.island = of.number, t.number = static_cast<std::uint32_t>(&pin - a.pins.data());
  t.b = r.index[a.slots[pin.column]], t.anchor_b = pin.anchor;
  t.impulse = force_of_multiplier(a) * pin.lambda;
  if (pin.partner != UINT32_MAX)
    t.a = r.index[a.slots[pin.partner]], t.anchor_a = pin.held_anchor;
  else if (pin.held_body != UINT32_MAX)
    t.a = gather_place(world, r, range, {pin.held_body, of.h}), t.anchor_a = pin.held_anchor;
  else
    t.a = gather_target(r, range, pin, of.h);
  return t;
}

std::uint32_t joints_to_root(const GroupScratch& r, const GroupScratch::Range& range,
                             std::uint32_t body) {
  const std::uint32_t node = r.bodies[range.first_body + body].node;
  return node == kNoNode ? 0 : r.nodes[range.first_node + node].depth + 1;
}

/// The rigid ties of an island, which are the last ones so far, and workspace for their equations.
void gather_loops(GroupScratch& r, const GroupScratch::Range& range, GroupLoops l) {
  const auto number = static_cast<std::uint32_t>(r.loops.size() - range.first_loops);
  const auto trees = std::span(r.trees).subspan(range.first_tree + l.first_tree, l.trees);
  std::uint32_t deepest = 0;
  for (GroupTree& t : trees) {
    PANTIN_ASSERT(t.island == trees.front().island);
    t.loops = number;
    for (std::uint32_t i = t.first; i < t.first + t.count; ++i)
      deepest = std::max(deepest, r.nodes[range.first_node + i].depth + 1);
  }
  const auto ties = std::span(r.ties).subspan(range.first_tie + l.first_tie, l.ties);
  for (std::uint32_t i = 0; i < l.ties; ++i) {
    GroupTie& t = ties[i];
    t.first = i;
    GroupTree *const first = tree_of(r, range, t.a), *const second = tree_of(r, range, t.b);
    for (GroupTree* tree : {first, second}) {
      if (!tree) continue;
      tree->is_tied_outside = tree->is_tied_outside || first != second;
      tree->first_tie = std::min(tree->first_tie, i);
      t.first = std::min(t.first, tree->first_tie);
    }
    t.first_step = static_cast<std::uint32_t>(r.path_steps.size() - range.first_step);
    r.path_steps.resize(r.path_steps.size() + joints_to_root(r, range, t.a) +
                        joints_to_root(r, range, t.b));
  }
  l.first_step = static_cast<std::uint32_t>(r.path_steps.size() - range.first_step);
  r.path_steps.resize(r.path_steps.size() + deepest);
  const auto take = [&](std::size_t numbers) {
    r.numbers += numbers;
    return r.numbers - numbers - range.first_number;
  };
  for (std::uint32_t i = 0; i < l.ties; ++i)
    ties[i].row = take((i - ties[i].first + 1) * kBlockNumbers);
  l.row = take(l.ties * kBlockNumbers), l.left = take(3 * l.ties);
  r.loops.push_back(l);
}

/// Adds the cut joints of an island as ties. Returns their number.
std::uint32_t gather_cuts(GroupScratch& r, const GroupScratch::Range& range, const IslandStep& of,
                          const Island& a) {
  std::uint32_t count = 0;
  for (std::uint32_t c = 0; c < a.count(); ++c) {
    GroupTie t;
    t.b = r.index[a.slots[c]];
    if (a.parents[c] < 0 ||
        !r.nodes[range.first_node + r.bodies[range.first_body + t.b].node].free_root)
      continue;
    PANTIN_ASSERT(r.bodies[range.first_body + t.b].node != kNoNode);
    t.a = r.index[a.slots[static_cast<std::size_t>(a.parents[c])]];
    t.anchor_a = a.constants.vec(kParentAnchor, c), t.anchor_b = a.constants.vec(kOwnAnchor, c);
    t.island = of.number, t.number = c, t.is_joint = true;
    t.impulse = force_of_multiplier(a) * a.memory.vec(kLambda, c);
    r.ties.push_back(t);
    ++count;
  }
  return count;
}

/// Sorts the ties of an island so that those of the same or neighbouring trees are close together.
void sort_ties(GroupScratch& r, const GroupScratch::Range& range, const GroupLoops& l) {
  const auto ties = std::span(r.ties).subspan(range.first_tie + l.first_tie, l.ties);
  const auto tree = [&](std::uint32_t body) {
    const std::uint32_t node = r.bodies[range.first_body + body].node;
    return node == kNoNode ? kNone : r.nodes[range.first_node + node].tree - l.first_tree;
  };
  const auto sort_by = [&](auto&& place) {
    const auto key = [&](const GroupTie& t) {
      const std::uint32_t a = tree(t.a), b = tree(t.b);
      const std::uint32_t first = a == kNone ? place(b) : place(a),
                          second = b == kNone ? first : place(b);
      return std::tuple(std::min(first, second), std::max(first, second), t.is_joint, t.number);
    };
    std::sort(ties.begin(), ties.end(),
              [&](const GroupTie& x, const GroupTie& y) { return key(x) < key(y); });
  };
  sort_by([](std::uint32_t number) { return number; });
  if (l.trees < 3) return;
  find_links(r, l.trees, [&](auto&& visit) {
    std::uint32_t a = kNone, b = kNone;
    for (const GroupTie& t : ties) {
      const std::uint32_t first = tree(t.a), second = tree(t.b);
      if (first == kNone || second == kNone || first == second) continue;
      if (std::minmax(first, second) == std::minmax(a, b)) continue;
      visit(a = first, b = second);
    }
  });
  find_order(r, l.trees);
  sort_by([&](std::uint32_t number) { return l.trees - 1 - r.numbered[number]; });
}

/// Lists a body on which a contact or tie acts, if its island has loops.
void add_looped(GroupScratch& r, const GroupScratch::Range& range, std::uint32_t body) {
  const GroupTree* tree = tree_of(r, range, body);
  GroupBody& b = r.bodies[range.first_body + body];
  if (!tree || tree->loops == kNoNode || b.looped != kNoNode) return;
  LoopedBody looped;
  PANTIN_ASSERT(b.node != kNoNode);
  looped.loops = tree->loops, looped.node = b.node;
  looped.rows = r.numbers - range.first_number;
  b.looped = static_cast<std::uint32_t>(r.looped.size() - range.first_looped);
  r.numbers += 2 * r.loops[range.first_loops + tree->loops].ties * kBlockNumbers;
  r.looped.push_back(looped);
}

}  // namespace

void gather_ties(const World& world, GroupScratch& r, const GroupScratch::Range& range,
                 const IslandStep& of) {
  const Island& a = islands_of(world)[of.number];
  GroupLoops loops;
  loops.first_tie = static_cast<std::uint32_t>(r.ties.size() - range.first_tie);
  for (const PackedPin& pin : a.pins)
    if (is_rigid(pin)) r.ties.push_back(gather_pin(world, r, range, {pin, of})), ++loops.ties;
  if (loops.ties > 0) {
    const std::uint32_t node = r.bodies[range.first_body + r.index[a.slots[0]]].node;
    loops.first_tree = r.nodes[range.first_node + node].tree;
    for (std::size_t i = range.first_tree + loops.first_tree;
         i < r.trees.size() && r.trees[i].island == of.number; ++i)
      ++loops.trees;
    loops.ties += gather_cuts(r, range, of, a);
    sort_ties(r, range, loops);
    loops.open = kOpen * a.size;
    gather_loops(r, range, loops);
  }
  for (const PackedPin& pin : a.pins)
    if (!is_rigid(pin)) add_tie(r, range, gather_pin(world, r, range, {pin, of}));
  for (std::uint32_t i = 0; i < a.cables.size(); ++i) {
    const PackedCable& cable = a.cables[i];
    const CableParameters& own = world.cables.values()[cable.cable].joint;
    GroupTie t;
    t.kind = GroupTie::Kind::cable, t.length = own.length;
    t.is_reeled = is_reeled(cable.before(), own);
    t.stiffness = own.compliance > 0 ? stiffness_of(own) : 0;
    t.island = of.number, t.number = i;
    t.anchor_a = own.anchor_a, t.anchor_b = own.anchor_b;
    t.impulse.x = force_of_multiplier(a) * cable.lambda;
    const auto body = [&](std::uint32_t column, std::uint32_t slot) {
      return column != UINT32_MAX ? r.index[a.slots[column]]
                                  : gather_place(world, r, range, {slot, of.h});
    };
    t.a = body(cable.column_a, cable.slot_a), t.b = body(cable.column_b, cable.slot_b);
    add_tie(r, range, t);
  }
}

void add_looped(GroupScratch& r, const GroupScratch::Range& range) {
  for (std::size_t i = range.first_contact; i < r.contacts.size(); ++i)
    add_looped(r, range, r.contacts[i].a), add_looped(r, range, r.contacts[i].b);
  for (std::size_t i = range.first_tie; i < r.ties.size(); ++i)
    if (r.ties[i].kind != GroupTie::Kind::rigid)
      add_looped(r, range, r.ties[i].a), add_looped(r, range, r.ties[i].b);
}

}  // namespace pantin::detail::articulated
