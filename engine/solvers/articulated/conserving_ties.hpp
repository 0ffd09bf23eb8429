#pragma once
/// Ties of a step by the energy-momentum method: what its files share.
#include "engine/solvers/articulated/conserving_joints.hpp"

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

}  // namespace pantin::detail::articulated
