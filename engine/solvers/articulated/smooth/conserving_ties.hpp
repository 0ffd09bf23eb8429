#pragma once
/// Ties of a step by the energy-momentum method: what its files share.
#include <cmath>

#include "engine/solvers/articulated/smooth/conserving_joints.hpp"

namespace pantin::detail::articulated {
namespace {

// What the law of a cable needs of one.
inline Real root(Real x) { return std::sqrt(x); }
template <class Mask, class T>
T choose(Mask yes, T first, T second) {
  return yes ? first : second;
}

}  // namespace
}  // namespace pantin::detail::articulated

#include "engine/solvers/articulated/smooth/cable_law.hpp"

namespace pantin::detail::articulated {

/// One step, as the hooks of the kernel see it.
struct TiedStep {
  const World& world;
  Island& a;
  Real h;
  TiedPart& with;
  StiffStep* stiff = nullptr;  // where joints constrain rotations

  const Body& body(std::uint32_t c) const { return world.bodies.values()[a.slots[c]]; }
};

/// The part of a tie of the island in the equations that couple ties.
inline TieRows& rows_at(StepScratch& r, const ConservingTie& t) {
  PANTIN_ASSERT(r.tie_sets.size() == r.ties.size());
  return r.tie_sets[static_cast<std::size_t>(&t - r.ties.data())];
}

/// Arms of impulses: at the means of the poses, or at the end.
enum class Arms : std::uint8_t { mean, end };
/// The response of the island to impulses of ties, by the last elimination (tie_response.cpp): the
/// n x n matrix of the ties' rows into `tie_matrix`; displacements of the own joints and turns by
/// all impulses that were added, into `tie_impulses` and `tie_torques`, which held these, and
/// impulses at the joints into `tie_joints`.
void fill_tie_matrix(Island& a, Arms arms, std::size_t n);
void clear_tie_impulses(StepScratch& r);
void add_tie_impulse(StepScratch& r, const ConservingTie& t, Vec3 mu, Arms arms);
void respond_to_ties(Island& a, Arms arms);

/// How much too long a cable is at the iterate, m.
inline Real over(const ConservingTie& t) { return glm::length(t.now) - t.length; }
/// Whether an inextensible cable has to change: one that would push goes slack, one that would be
/// too long becomes taut. [Hintermueller, Ito & Kunisch 2002: primal-dual active sets]
bool has_to_change(const TiedStep& s, const ConservingTie& t);
void change(ConservingTie& t);
/// Whether cables that become taut on the way take so much energy that the part of the step has to
/// end where the first of them comes to its length: TiedPart::shorter tells where. At the end of
/// such a part they strike.
bool has_to_end_early(const TiedStep& s);
/// The same of those that took up their load in this iteration: the rest of it would be in vain.
bool is_hit_early(const TiedStep& s);

/// Velocities at the end as ties allow them, blows included: see ConservingTies::project.
bool project_ties(const TiedStep& s);

}  // namespace pantin::detail::articulated
