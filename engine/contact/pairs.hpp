#pragma once
/// Pairs of bodies that may come into contact within a step (broad phase).
#include "engine/contact/on_the_way.hpp"
#include "engine/contact/search.hpp"

namespace pantin::detail::contact {

/// Margin in addition to the reach, as a fraction of a shape's extent, so that rounding loses no
/// contact.
inline constexpr Real kContactSlop = 1e-4;

/// Whether two bodies have different solvers. The solver that adjusts later treats the other's body
/// as a moving obstacle.
bool have_two_solvers(const SweptSearch& s, std::uint32_t a, std::uint32_t b);
/// Of two bodies that solvers move, whether `a` owns the contact.
bool is_first(const SweptSearch& s, std::uint32_t a, std::uint32_t b);
/// Index of a body's island over all solvers; UINT64_MAX: none.
std::uint64_t island_of(const SweptSearch& s, std::uint32_t slot);
/// False for bodies of different contact solvers: they join one solver once they come near each
/// other.
bool may_collide(const SweptSearch& s, const Search& search, std::uint32_t a, std::uint32_t b);
/// Whether two bodies that solvers move request contacts with each other.
bool asked_for(const SweptSearch& s, std::uint32_t slot_a, std::uint32_t slot_b);

/// Lists pairs of colliders with overlapping bounds, the owner of the contact first.
void list_pairs(const SweptSearch& s, Search& search);

/// Finds bodies that fly together, and removes the pairs that are too far apart for their relative
/// motion.
///
/// Motion and contacts of bodies are the same in every inertial frame, until something at rest
/// disturbs them. A body is disturbed when it may first reach a fixed or a resting body, or a body
/// that was disturbed earlier: the time that two bodies need at least is their distance over the
/// sum of their reaches. Joints disturb bodies, too. Bodies that are not disturbed within the step,
/// and kinematic ones between them, are in flight: they approach one another only by their relative
/// motion.
void find_flights(const SweptSearch& s, Search& search, std::span<const Displacement> displacement);

}  // namespace pantin::detail::contact
