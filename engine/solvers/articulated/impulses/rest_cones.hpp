#pragma once
/// Impulses of the contacts of a group that is solved as a whole (group_rest.cpp), and their
/// derivatives.
#include <cmath>

#include "engine/solvers/articulated/impulses/contact_groups.hpp"

namespace pantin::detail::articulated {

/// An impulse slides if it is longer across than this fraction of its bound.
inline constexpr Real kOnCone = 1 - 1e-9;

/// Whether a contact bore and did not slide in the last step.
inline bool holds(const GroupContact& c) {
  const Real most = kOnCone * c.friction * c.impulse.x;
  return c.impulse.y * c.impulse.y + c.impulse.z * c.impulse.z < most * most;
}

/// The impulse of a contact: (goal - speed) / R, projected to the cone.
inline ConeImpulse cone_of(const RestContact& r, Real friction, Vec3 speed) {
  const Vec3 y = (r.goal - speed) / r.compliance;
  const Real aside = std::sqrt(y.y * y.y + y.z * y.z);
  if (y.x > 0 && aside <= friction * y.x) return {y, ConeImpulse::At::inside};
  if (friction * aside <= -y.x) return {};
  const Real normal = (y.x + friction * aside) / (1 + friction * friction);
  const Vec3 across = Vec3(0, y.y, y.z) / aside;
  return {normal * (Vec3(1, 0, 0) + friction * across), ConeImpulse::At::surface, normal, aside,
          across};
}

/// The same if the contact holds, slides or does not act as with this impulse.
inline ConeImpulse cone_as_with(const RestContact& r, Real friction, Vec3 known) {
  const Vec3 y = (r.goal - r.speed) / r.compliance;
  if (!(known.x > 0)) return {};
  const Real aside = std::sqrt(known.y * known.y + known.z * known.z);
  if (aside < kOnCone * friction * known.x) return {y, ConeImpulse::At::inside};
  const Vec3 across = aside > 0 ? Vec3(0, known.y, known.z) / aside : Vec3(0);
  const Vec3 along = Vec3(1, 0, 0) + friction * across;
  return {glm::dot(along, y) / glm::dot(along, along) * along, ConeImpulse::At::surface, 0, 1,
          across};
}

/// Minus the derivative of that impulse by the speed.
inline Mat3 stiffness_of(const RestContact& r, Real friction) {
  const ConeImpulse& cone = r.cone;
  if (cone.at == ConeImpulse::At::inside) return Mat3(1 / r.compliance);
  if (cone.at == ConeImpulse::At::apex) return Mat3(0);
  const Real whole = 1 + friction * friction;
  const Vec3 along = Vec3(1, 0, 0) + friction * cone.across;
  const Mat3 turning =
      Mat3(0, 0, 0, 0, 1, 0, 0, 0, 1) - glm::outerProduct(cone.across, cone.across);
  return glm::outerProduct(along, along / whole) / r.compliance +
         friction * cone.normal / (cone.aside * r.compliance) * turning;
}

}  // namespace pantin::detail::articulated
