#pragma once
/// Springs and cables of a group (group_ties.cpp).
#include <algorithm>

#include "engine/solvers/articulated/impulses/contact_groups.hpp"

namespace pantin::detail::articulated {

/// Whether it is an inextensible cable; whether one pulls in the substep.
inline bool is_inextensible(const GroupTie& t) {
  return t.kind == GroupTie::Kind::cable && t.stiffness == 0;
}
inline bool is_taut(const GroupTie& t) { return is_inextensible(t) && t.impulse.x > 0; }

/// Whether any does not stretch.
inline bool has_cables(const Group& g) {
  return std::any_of(g.ties.begin(), g.ties.end(), is_inextensible);
}
/// Updates the arms and the gap of a tie.
void place_tie(const Group& g, GroupTie& t);
void prepare_tie(const Group& g, GroupTie& t, Real h);
void push_tie(const Group& g, const GroupTie& t);
/// Marks the bodies of a group with inextensible cables that move by their end velocities. Before
/// impulses: free bodies that contacts or cables will strike; also sets GroupTie::parting. After
/// sweeps: free bodies that contacts have struck, bodies of trees that contacts or taut cables act
/// on.
void begin_cables(const Group& g, Real h);
void touch_by_impulses(const Group& g);
/// Places cables between free bodies where these have moved to, with half of their impulses.
void follow_cables(const Group& g);
/// Solves one tie, closing the fraction `part` of its gap in the substep. Returns the change of
/// speed, m/s.
Real solve_tie(const Group& g, GroupTie& t, Real h, Real part);

}  // namespace pantin::detail::articulated
