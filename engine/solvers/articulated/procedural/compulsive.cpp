#include "engine/solvers/articulated/procedural/compulsive.hpp"

#include "engine/base/rotation.hpp"

namespace pantin::detail::articulated {

CompulsiveMotion least_displacement(Vec3 arm, Vec3 gap, const Inertia& of, Real stiffness) {
  const Vec3 a = glm::cross(arm, gap);
  const Real a2 = glm::dot(a, a);
  // A gap along the arm, or no arm, defines no axis of rotation.
  if (!(a2 > 1e-100)) return {kIdentity, gap};
  // Scaled by |r x s|^2: only the quotient matters, so no division is needed.
  const Vec3 s = of.mass * a2 * a;
  const Real c = stiffness * glm::dot(a, of.tensor * a) + of.mass * a2 * glm::dot(arm, arm + gap);
  const Real s2 = glm::dot(s, s);
  const Real z = std::sqrt(c * c + s2);
  const Quat rotation = glm::normalize(Quat(c >= 0 ? z + c : s2 / (z - c), s));
  return {rotation, arm + gap - rotation * arm};
}

CompulsiveMotion literal_rule(Vec3 arm, Vec3 gap, Real reluctance) {
  const Vec3 a = glm::cross(arm, gap);
  const Real sine = glm::length(a), lengths = glm::length(arm) * glm::length(gap);
  if (!(sine > 1e-14 * lengths) || lengths == 0) return {kIdentity, gap};
  const Real phi = std::atan2(sine, glm::dot(arm, gap));
  const Quat rotation = from_rotation_vector(phi * std::exp(-reluctance / lengths) / sine * a);
  return {rotation, arm + gap - rotation * arm};
}

Real inertia_about_turn(Vec3 arm, Vec3 gap, const Mat3& inertia) {
  const Vec3 a = glm::cross(arm, gap);
  const Real a2 = glm::dot(a, a);
  return a2 < 1e-300 ? inertia[0][0] : glm::dot(a, inertia * a) / a2;
}

Quat verlet_rotation(Quat before, Quat now, Real keep) {
  return glm::normalize(fraction_of(now * glm::conjugate(before), keep) * now);
}

}  // namespace pantin::detail::articulated
