#pragma once
/// Sweeps over the trees of an island, on the final poses: each body moves to its joint by the
/// least displacement, then rotates about it to within its limits. [Lee 2000, sec. 3.2]
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

/// One body at its final pose.
struct FinalBody {
  LaneTable& work;
  std::size_t column;

  Quat rotation() const { return work.quat(kFinalRotation, column); }
  Vec3 position() const { return work.vec(kFinalPosition, column); }
  Vec3 point(Vec3 anchor) const { return position() + rotation() * anchor; }
};

/// A point of a packed body, in its frame, and its goal, world.
struct Pull {
  std::size_t column = 0;
  Vec3 anchor{0}, goal{0};
};

/// Moves the parent of a body to their joint, as if the body were fixed.
void lead_parent(Island& a, std::size_t c);

/// A sweep from a pulled body: along its parents to the root, then all other bodies outwards.
void sweep_from(const World& world, Island& a, const Tree& tree, const Pull& from);

/// The closing sweep: the root to its target, then all other bodies outwards.
void sweep_from_root(const World& world, Island& a, const Tree& tree);

}  // namespace pantin::detail::articulated
