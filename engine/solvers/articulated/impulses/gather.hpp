#pragma once
/// What gathers groups: bodies and trees (gather_groups.cpp), then ties (gather_ties.cpp).
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

inline constexpr std::uint32_t kNone = UINT32_MAX;

/// An island in a step.
struct IslandStep {
  std::uint32_t number;
  Real h;
};
/// A body that nothing moves here.
struct PlacedAt {
  std::uint32_t slot;
  Real h;
};

/// Two bodies of a group.
struct TwoBodies {
  std::uint32_t a, b;
};

inline bool is_rigid(const PackedPin& pin) { return !(pin.compliance > 0); }
inline bool has_rigid_ties(const Island& a) {
  return std::any_of(a.pins.begin(), a.pins.end(), is_rigid);
}

/// From a multiplier to the mean force.
inline Real force_of_multiplier(const Island& a) {
  return a.last_step > 0 && !a.fresh ? 1 / (a.last_step * a.last_step) : 0;
}

/// A body as it enters the step, fixed or kinematic ones as they were before it.
GroupBody gather_pose(const World& world, std::uint32_t slot, Real h);
inline GroupTree* tree_of(GroupScratch& r, const GroupScratch::Range& range, std::uint32_t body) {
  PANTIN_ASSERT(range.first_body + body < r.bodies.size());
  const std::uint32_t node = r.bodies[range.first_body + body].node;
  if (node == kNoNode) return nullptr;
  return &r.trees[range.first_tree + r.nodes[range.first_node + node].tree];
}

/// Whether an impulse on one moves the other: both of one tree, or of one island with loops.
inline bool are_coupled(GroupScratch& r, const GroupScratch::Range& range, const TwoBodies& c) {
  const GroupTree *a = tree_of(r, range, c.a), *b = tree_of(r, range, c.b);
  return a && b && (a == b || (a->has_loops && a->island == b->island));
}

/// Pins, loops and cables of an island whose bodies are in the group.
void gather_ties(const World& world, GroupScratch& r, const GroupScratch::Range& range,
                 const IslandStep& of);
/// What solves a group that hardly moves as a whole, if it may be one (gather_rest.cpp).
void gather_resting(GroupScratch& r, const GroupScratch::Range& range, Real h);
/// Bodies that something pushes, of islands with loops; after the contacts and ties of a group.
void add_looped(GroupScratch& r, const GroupScratch::Range& range);

}  // namespace pantin::detail::articulated
