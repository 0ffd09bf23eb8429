#pragma once
/// Rolling and spinning friction: a contact over a patch resists rotation about the contact.
///
/// A torque across the normal, of at most a length times the normal force, opposes rolling; one
/// along the normal opposes spinning. All points of two bodies share one torque, since the torques
/// of single points would be indeterminate. Both are implicit, like Coulomb's cone: they may stop a
/// rotation but never reverse it.
#include <algorithm>
#include <cmath>

#include "engine/contact/contact.hpp"

namespace pantin::detail::contact {

/// Largest torque per normal force of a contact point, m.
struct RollingLengths {
  Real spinning = 0, rolling = 0;
  bool any() const { return spinning > 0 || rolling > 0; }
};

inline RollingLengths rolling_lengths(const Contact& c) { return {c.spinning, c.rolling}; }

/// Largest torque along the normal and across it, N m; for impulses, N m s.
struct RollingBounds {
  Real spinning = 0, rolling = 0;

  void add(const RollingLengths& of, Real normal) {
    spinning += of.spinning * normal, rolling += of.rolling * normal;
  }
  Vec3 bounded(Vec3 torque) const {
    torque.x = std::clamp(torque.x, -spinning, spinning);
    const Real held = std::sqrt(torque.y * torque.y + torque.z * torque.z);
    if (held > rolling) torque.y *= rolling / held, torque.z *= rolling / held;
    return torque;
  }
};

/// The mean of normals, given their sum; the first one where they cancel.
inline Vec3 shared_normal(Vec3 sum, Vec3 first) {
  return glm::length(sum) > 0.1 ? glm::normalize(sum) : first;
}

}  // namespace pantin::detail::contact
