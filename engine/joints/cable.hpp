#pragma once
/// A cable between two bodies: it pulls, never pushes.
///
///   C = |p_b - p_a| - length <= 0       one unilateral row, metres
///
/// Internal (pantin::detail); installed because World::cables holds it.
#include <algorithm>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin::detail {

/// Reference for the wrap angle of a first pose, rad: allows angles from -90 to 270 degrees.
inline constexpr Real kFirstWrap = kPi / 2;

struct CableParameters {
  Vec3 anchor_a{0};     // in body a's mass-centre frame
  Vec3 anchor_b{0};     // in body b's mass-centre frame
  Real length = 1;      // m, taut and without tension
  Real compliance = 0;  // m/N; 0: inextensible
  Real rate = 0;        // m/s, by which a winch changes the length now

  static void fields(auto& self, auto&& field) {
    field("anchor_a", self.anchor_a);
    field("anchor_b", self.anchor_b);
    field("length", self.length);
    field("compliance", self.compliance);
    field("rate", self.rate);
  }
};

/// Elongation of the cable, never negative, m.
inline Real stretch(const CableParameters& joint, const Pose& a, const Pose& b) {
  const Real span = glm::length(to_world(b, joint.anchor_b) - to_world(a, joint.anchor_a));
  return std::max(Real(0), span - joint.length);
}

/// For an elastic cable, compliance > 0, stretched by `over` >= 0, m: tension, N, its derivative,
/// N/m, and stored energy, J.
inline Real tension_of(const CableParameters& joint, Real over) { return over / joint.compliance; }
inline Real stiffness_of(const CableParameters& joint) { return 1 / joint.compliance; }
inline Real energy_of(const CableParameters& joint, Real over) {
  return 0.5 * over * over / joint.compliance;
}

}  // namespace pantin::detail
