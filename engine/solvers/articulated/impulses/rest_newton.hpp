#pragma once
/// Newton's method on the convex problem of a group that is solved as a whole (group_rest.cpp).
#include "engine/solvers/articulated/impulses/group_resting.hpp"
#include "engine/solvers/articulated/impulses/rest_cones.hpp"

namespace pantin::detail::articulated {

using At = ConeImpulse::At;

/// How exactly a group is solved as a whole.
struct Exactness {
  Real compliance;  // R, as a fraction of the response of a point
  /// Tolerance of the residual, as a fraction of Search::fastest, and where rounding or the
  /// iterations stop progress.
  Real balanced, nearly;
  /// As fractions of Search::typical: the largest closing speed under load, and the error of
  /// lifts, likewise after the last correction.
  Real sinks, lifted, nearly_lifted;
  int liftings;  // corrections of lifts, at most
};

/// A search for the velocities of a group.
struct Search {
  const Exactness& exactness;
  Real typical = 0;       // m/s, of which errors are fractions
  Real fastest = 0;       // m/s, without contacts
  int left = 0;           // iterations
  bool is_exact = false;  // found with the compliance asked for
};

/// Iterations with corrected goals or compliances.
inline constexpr int kIterations = 20;

/// m/s: velocity of a's point relative to b's, along the axes.
Vec3 speed_of(const Group& g, const GroupContact& c, Wrench RestBody::*motion);
/// Computes the impulses, and the residuals of momentum with them. Returns the largest as a speed
/// of a body, m/s.
Real find_residuals(const Group& g, Acting acting = Acting::now);
/// Whether free bodies rest as in the last step: its impulses and velocities balance, and no
/// contact has to be opened. Takes these then; no factor is needed.
bool rests_as_before(const Group& g, const Search& s);
/// Newton's direction. False if the factorisation fails.
bool find_direction(const Group& g);
/// Moves on by a part of the direction.
void advance_search(const Group& g, Real part);
/// Starts from the velocities of the last step, with the predicted active set.
void start_search(const Group& g);
/// Moves on to the velocities at which every contact acts as in the last step. Whether there is one
/// that acted.
bool resume_search(const Group& g);
/// Newton's method, at most so many iterations. Whether it converged.
bool iterate(const Group& g, int most, Search& s);
/// Keeps the velocities, lifts and compliances; returns to them, and computes the impulses.
void keep_found(const Group& g);
void return_to_kept(const Group& g);
/// Continuation from far larger compliances, where the distribution of loads is found first.
/// Whether it converged.
bool iterate_softer(const Group& g, Search& s);
/// The same, but a solution with larger compliances than asked for is accepted.
bool iterate_yielding(const Group& g, Search& s);

}  // namespace pantin::detail::articulated
