#pragma once
/// Placement of trees in contact: bodies rotate by their spins, then joints place them.
#include "engine/solvers/articulated/impulses/contact_groups.hpp"

namespace pantin::detail::articulated {

/// rad: largest rotation in one correction.
inline constexpr Real kFarthestTurn = 0.1;

/// A tree without an anchor.
inline bool is_free(const Group& g, const GroupTree& t) { return g.nodes[t.first].free_root; }

/// m/s: velocity of the mass centre of a tree's body.
inline Vec3 own_velocity(const GroupBody& b, const GroupNode& n) { return speed_at(b, n.arm); }

/// The anchor of a tree at one time: rotation of the anchor body, position of the anchor.
struct Moved {
  Quat held{1, 0, 0, 0};
  Vec3 anchor{0};
};
Moved place_of(const GroupTree& t, Real fraction);

/// Forward kinematics: rotates each body to n.turned as far as its joint allows, then places it.
void place_by_joints(const Group& g, const GroupTree& t, const Moved& to);

/// Replaces impulses in `passing` by the changes they make. Returns the largest rotation, rad.
Real respond_to_impulses(const Group& g, const GroupTree& t);
/// Sets n.turned to the pose rotated by this fraction of the changes in `passing`.
void turn_by(const Group& g, const GroupTree& t, Real part);
/// Restores the poses before respond_to_impulses().
void turn_back(const Group& g, const GroupTree& t);

/// Moves a tree over a part of the step, its joints closed. Sets n.goal.
void place_tree(const Group& g, GroupTree& t, const GroupPart& part);
/// Afterwards: pushes trees out of contacts that closing joints pushed them into.
void hold_contacts(const Group& g, const GroupPart& part);

}  // namespace pantin::detail::articulated
