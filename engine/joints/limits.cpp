#include "engine/joints/limits.hpp"

#include <algorithm>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"

namespace pantin::detail {
namespace {

/// The angle unwrapped to within half a revolution of `near`.
Real unwound(Real angle, Real near) {
  return angle - 2 * kPi * std::round((angle - near) / (2 * kPi));
}

Quat about_x(Real angle) { return Quat(std::cos(angle / 2), std::sin(angle / 2), 0, 0); }
Quat about_y(Real angle) { return Quat(std::cos(angle / 2), 0, std::sin(angle / 2), 0); }
Quat about_z(Real angle) { return Quat(std::cos(angle / 2), 0, 0, std::sin(angle / 2)); }

}  // namespace

SwingTwist swing_twist(Quat q) {
  if (!is_unit(q)) q = glm::normalize(q);  // of a pose that a user wrote
  if (q.w < 0 || (q.w == 0 && q.x < 0)) q = -q;
  // A swing of half a revolution leaves the twist undefined.
  const Real n2 = q.w * q.w + q.x * q.x;
  Quat twist(1, 0, 0, 0);
  if (n2 > 1e-24) {
    const Real n = std::sqrt(n2);
    twist = Quat(q.w / n, q.x / n, 0, 0);
  }
  Vec3 swing = rotation_vector(q * glm::conjugate(twist));
  swing.x = 0;
  return {2 * std::atan2(twist.x, twist.w), swing};
}

Quat rotation_of(const SwingTwist& parts) {
  return glm::normalize(from_rotation_vector(parts.swing) * about_x(parts.twist));
}

UniversalAngles universal_angles(Quat q) {
  if (!is_unit(q)) q = glm::normalize(q);
  // Q = turn_y(first) turn_x(e) turn_z(second) for some e; dropping e is the nearest such joint.
  const Vec3 z = q * Vec3(0, 0, 1), y = glm::conjugate(q) * Vec3(0, 1, 0);
  return {std::atan2(z.x, z.z), std::atan2(y.x, y.y)};
}

Quat rotation_of(const UniversalAngles& a) {
  return glm::normalize(about_y(a.first) * about_z(a.second));
}

bool is_within(const AngleLimit& limit, Real x, Real w) {
  if (!limit.on) return true;
  const Real side = x < 0 ? -limit.low : limit.high, half = 0.5 * side, u = half * half;
  // tan(half) is larger than the first terms of its series, which are all positive.
  const Real tangent = half * (1 + u * (1.0 / 3 + u * (2.0 / 15 + u * (17.0 / 315))));
  return w > 0 && limit.low <= 0 && limit.high >= 0 && side < kPi && std::abs(x) <= w * tangent;
}

bool is_within(const JointLimits& limits, Quat q) {
  if (q.w < 0) q = -q;
  if (!is_within(limits.angle, q.x, q.w)) return false;
  if (!limits.swing.on) return true;
  const Real n2 = q.w * q.w + q.x * q.x, sine2 = q.y * q.y + q.z * q.z;
  if (!(limits.swing.y > 0 && limits.swing.z > 0) || !(n2 > sine2)) return false;
  // The swing is q without the twist, (w, x) / n. asin(s) / s is convex in s s: up to a quarter of
  // a revolution it lies below this chord.
  const Real longer = 2 * (1 + 0.22145 * sine2);
  const Real y = (q.w * q.y - q.x * q.z) / limits.swing.y;
  const Real z = (q.w * q.z + q.x * q.y) / limits.swing.z;
  return longer * longer * (y * y + z * z) <= (1 - 1e-12) * n2;
}

Real clamped(const AngleLimit& limit, Real angle) {
  if (!limit.on || !is_range(limit.low, limit.high)) return angle;
  const Real middle = 0.5 * (limit.low + limit.high);
  return std::clamp(unwound(angle, middle), limit.low, limit.high);
}

Vec3 clamped(const SwingLimit& limit, Vec3 swing) {
  if (!limit.on) return swing;
  // A cone locked in one direction is an arc: the other component remains.
  if (limit.y <= 0) swing.y = 0;
  if (limit.z <= 0) swing.z = 0;
  const Real y = limit.y > 0 ? swing.y / limit.y : 0, z = limit.z > 0 ? swing.z / limit.z : 0;
  const Real beyond2 = y * y + z * z;
  return beyond2 > 1 ? swing / std::sqrt(beyond2) : swing;
}

}  // namespace pantin::detail
