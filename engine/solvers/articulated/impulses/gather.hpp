#pragma once
/// Gathers groups: bodies and trees (gather_groups.cpp), then ties (gather_ties.cpp).
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

inline constexpr std::uint32_t kNone = UINT32_MAX;

/// An island and the length of the step, s.
struct IslandStep {
  std::uint32_t number;
  Real h;
};
/// A fixed or kinematic body.
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

/// Factor from a multiplier of the last step to the mean force, 1/s^2; 0 without a last step.
inline Real force_of_multiplier(const Island& a) {
  return a.last_step > 0 && !a.fresh ? 1 / (a.last_step * a.last_step) : 0;
}

/// A body at the start of the step; kinematic ones at their pose before it.
GroupBody gather_pose(const World& world, std::uint32_t slot, Real h);
inline GroupTree* tree_of(GroupScratch& r, const GroupScratch::Range& range, std::uint32_t body) {
  PANTIN_ASSERT(range.first_body + body < r.bodies.size());
  const std::uint32_t node = r.bodies[range.first_body + body].node;
  if (node == kNoNode) return nullptr;
  return &r.trees[range.first_tree + r.nodes[range.first_node + node].tree];
}

/// Whether an impulse on one body moves the other: both in one tree, or in one island with loops.
inline bool are_coupled(GroupScratch& r, const GroupScratch::Range& range, const TwoBodies& c) {
  const GroupTree *a = tree_of(r, range, c.a), *b = tree_of(r, range, c.b);
  return a && b && (a == b || (a->has_loops && a->island == b->island));
}

/// Pins, loops and cables of an island whose bodies are in the group.
void gather_ties(const World& world, GroupScratch& r, const GroupScratch::Range& range,
                 const IslandStep& of);
/// Prepares the factor of a group that may be at rest (gather_rest.cpp).
void gather_resting(GroupScratch& r, GroupScratch::Range& range, Real h);
/// Lists the pairs that are solved in lanes; after all pairs (group_lanes.cpp).
void gather_laned(GroupScratch& r, GroupScratch::Range& range);
/// Lists bodies of islands with loops on which contacts or ties act; after these are gathered.
void add_looped(GroupScratch& r, const GroupScratch::Range& range);

}  // namespace pantin::detail::articulated
