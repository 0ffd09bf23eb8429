#pragma once
/// Ties of a step by the energy-momentum method: shared declarations.
#include <cmath>

#include "engine/solvers/articulated/smooth/conserving_joints.hpp"

namespace pantin::detail::articulated {
namespace {

// The scalar functions that cable_law.hpp requires.
inline Real root(Real x) { return std::sqrt(x); }
template <class Mask, class T>
T choose(Mask yes, T first, T second) {
  return yes ? first : second;
}

}  // namespace
}  // namespace pantin::detail::articulated

#include "engine/solvers/articulated/smooth/cable_law.hpp"

namespace pantin::detail::articulated {

/// One substep, as the hooks of the kernel see it.
struct TiedStep {
  const World& world;
  Island& a;
  Real h;
  TiedPart& with;
  StiffStep* stiff = nullptr;  // set if joints constrain rotations

  const Body& body(std::uint32_t c) const { return world.bodies.values()[a.slots[c]]; }
};

/// The rows of a tie in the equations that couple ties.
inline TieRows& rows_at(StepScratch& r, const ConservingTie& t) {
  PANTIN_ASSERT(r.tie_sets.size() == r.ties.size());
  return r.tie_sets[static_cast<std::size_t>(&t - r.ties.data())];
}

/// Arms of impulses: at the means of the poses, or at the end.
enum class Arms : std::uint8_t { mean, end };
/// The response of the island to impulses of ties, by the last elimination (tie_response.cpp).
/// fill_tie_matrix() writes the n x n matrix of the ties' rows to `tie_matrix`. respond_to_ties()
/// replaces the impulses in `tie_impulses` and `tie_torques` by displacements of the own joints and
/// by rotations, and writes the impulses at the joints to `tie_joints`.
void fill_tie_matrix(Island& a, Arms arms, std::size_t n);
void clear_tie_impulses(StepScratch& r);
void add_tie_impulse(StepScratch& r, const ConservingTie& t, Vec3 mu, Arms arms);
void respond_to_ties(Island& a, Arms arms);

/// m: stretch of a cable at the iterate, negative if slack.
inline Real over(const ConservingTie& t) { return glm::length(t.now) - t.length; }
/// Whether an inextensible cable has to change state: one that would push becomes slack, one that
/// is too long becomes taut. [Hintermueller, Ito & Kunisch 2002: primal-dual active sets]
bool has_to_change(const TiedStep& s, const ConservingTie& t);
void change(ConservingTie& t);
/// Whether cables that become taut within the substep dissipate so much energy that the substep has
/// to end where the first of them reaches its length: TiedPart::shorter is then its new length. At
/// the end of such a substep they act as impacts.
bool has_to_end_early(const TiedStep& s);
/// The same for those that became taut in this iteration, so that it can be abandoned early.
bool is_hit_early(const TiedStep& s);

/// Projects the end velocities to those that ties allow, with impacts: see ConservingTies::project.
bool project_ties(const TiedStep& s);

}  // namespace pantin::detail::articulated
