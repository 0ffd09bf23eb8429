#pragma once
/// Contacts of shapes that meet within the step.
#include "engine/contact/search.hpp"
#include "engine/geometry/kinds.hpp"

namespace pantin::detail::contact {

/// A search that follows bodies through a step.
struct SweptSearch : Finder {
  Real h = 0;                         // s, of the step; 0: bodies stay where they are
  std::span<const Real> struck = {};  // by slot, see DetectScratch

  /// m, reach of a body that may be struck: the striker may push it through an obstacle.
  Real reach_if_struck(std::uint32_t slot) const {
    const Real own = reach_of(slot);
    return slot < struck.size() && own > 0 ? std::max(own, struck[slot]) : own;
  }
  /// m: by how much two bodies may approach each other, `a` with that reach unless they fly
  /// together.
  Real reach_between(const Search& search, std::uint32_t a, std::uint32_t b,
                     Real reach_of_a) const {
    if (search.flights.share_one(a, b)) return search.flights.reach_between(a, b);
    return reach_of_a + reach_of(b);
  }
};

/// A search, and what it has listed.
struct Swept {
  const SweptSearch& s;
  const Search& search;
};

/// For two convex shapes that would meet within the step, given their points at its start: replaces
/// PointSearch::points by those of where they meet or pass, mapped back to the start. Otherwise
/// balls that collide off-centre would be deflected along the normal of the step before.
void advance_to_impact(const Swept& with, PointSearch& at, const ColliderShape& a,
                       const ColliderShape& b);

/// Rounding radius of a shape at a contact, m: the contact point keeps that distance along the
/// normal from a body point while the body rotates. 0: the contact point is a body point itself.
Real rounding_of(const Shape& shape, const Rolling& at);

}  // namespace pantin::detail::contact
