#pragma once
/// Rotations as quaternions and as rotation vectors (axis times angle, radians).
#include <algorithm>

#include "engine/base/math.hpp"

namespace pantin {

/// The quaternion of a rotation vector (exponential map); any angle is allowed.
inline Quat from_rotation_vector(Vec3 rotation_vector) {
  const Real angle2 = glm::dot(rotation_vector, rotation_vector);
  if (angle2 < 1e-6) {  // series: sin(t/2)/t loses digits near zero
    const Real scale = 0.5 - angle2 / 48 + angle2 * angle2 / 3840;
    const Real w = 1 - angle2 / 8 + angle2 * angle2 / 384;
    return glm::normalize(Quat(w, scale * rotation_vector));
  }
  const Real angle = std::sqrt(angle2);
  return Quat(std::cos(angle / 2), std::sin(angle / 2) / angle * rotation_vector);
}

/// The shortest rotation vector of a unit quaternion; its length lies in [0, pi].
inline Vec3 rotation_vector(Quat q) {
  if (q.w < 0) q = -q;
  const Vec3 v{q.x, q.y, q.z};
  const Real n2 = glm::dot(v, v);
  if (n2 < 1e-12) return v * (2 + n2 / 3);
  const Real n = std::sqrt(n2);
  return v * (2 * std::atan2(n, q.w) / n);
}

/// The rotation of `d` by Cayley's map: angle 2 atan(|d|/2), always below pi, without trigonometry.
inline Quat cayley(Vec3 d) { return glm::normalize(Quat(1, 0.5 * d)); }

/// The fraction `k` of a rotation, along the shortest path.
inline Quat fraction_of(Quat rotation, Real k) {
  return from_rotation_vector(k * rotation_vector(rotation));
}

/// Angular velocity that carries `from` to `to` in `h` seconds at a constant rate, world axes,
/// rad/s.
inline Vec3 angular_velocity_between(Quat from, Quat to, Real h) {
  return rotation_vector(to * glm::conjugate(from)) / h;
}

/// Largest radius of gyration, m, from principal moments.
inline Real radius_of_gyration(Vec3 inertia, Real mass) {
  return std::sqrt(std::max({inertia.x, inertia.y, inertia.z}) / mass);
}

/// The world inertia of principal moments `inertia` (body axes) at `rotation`.
inline Mat3 world_inertia(Quat rotation, Vec3 inertia) {
  const Mat3 r = glm::mat3_cast(rotation);
  return Mat3(r[0] * inertia.x, r[1] * inertia.y, r[2] * inertia.z) * glm::transpose(r);
}

}  // namespace pantin
