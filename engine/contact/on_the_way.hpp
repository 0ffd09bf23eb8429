#pragma once
/// Shapes that meet within the step.
#include "engine/contact/search.hpp"
#include "engine/geometry/kinds.hpp"

namespace pantin::detail::contact {

/// A search that follows bodies through a step.
struct WayFinder : Finder {
  Real h = 0;                         // s, of the step; 0: bodies stay where they are
  std::span<const Real> struck = {};  // by slot, see DetectScratch

  /// m: what strikes a body within the step may take it along, and press it through an obstacle.
  Real reach_if_struck(std::uint32_t slot) const {
    const Real own = reach_of(slot);
    return slot < struck.size() && own > 0 ? std::max(own, struck[slot]) : own;
  }
};

/// Of two convex shapes that would meet within the step, given their points at its start: makes
/// Search::points those of where they meet or pass, seen from the start. Balls that strike
/// off-centre would else be turned away by where they were a step before.
void follow_way(const WayFinder& finder, Search& search, const ColliderShape& a,
                const ColliderShape& b);

/// The radius by which a shape is round where it is touched, m: the place is that far from a point
/// of it along the normal, while it turns. 0: it is touched with its own points.
Real rounding_of(const Shape& shape, const Rolling& at);

}  // namespace pantin::detail::contact
