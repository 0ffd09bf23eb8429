#pragma once
/// Whether an awake island may meet one that sleeps: it may pass or roll on beside it. Parts of a
/// group fall asleep by the same measures, with twice the margin (group_sleep.cpp).
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

/// Islands meet if their gap is less than this many times touching_gap() plus their way in a step;
/// they stay awake together up to the second.
inline constexpr Real kWakes = 2, kStaysAwake = 4;

/// m: fraction of the larger island's size.
inline Real touching_gap(const Island& a, const Island& b) {
  return 1e-3 * std::max(a.size, b.size);
}

/// Whether an island may speed up by itself in the step: by applied forces, drives, springs and
/// motors, cables, pins and moved anchors.
bool has_power(const World& world, const Island& a);
/// m/s: a bound on the speed of its surface.
Real speed_bound(const World& world, const Island& a);
/// m/s: what weight adds to its speed in a step of h seconds where nothing bears it.
Real fall_of(const World& world, const Island& a, Real h);

/// Joins islands that touch, and sleeping ones to those that are awake and may meet them in the
/// step.
void join_islands(const World& world, GroupScratch& r, Real h);
/// Joins the islands of both bodies of each of these contacts.
void join_touching(const World& world, std::span<const Contact> contacts, DisjointSets& sets);
/// Whether one of the bodies of a contact sleeps, and the other one does not meet it in the step.
bool is_idle(const World& world, const Contact& c);
/// Whether this solver can step an island in a group.
bool can_join(const Island& a);

}  // namespace pantin::detail::articulated
