#pragma once
/// Axes of a contact: its normal, from b to a, and two tangents.
#include <cmath>

#include "engine/base/math.hpp"

namespace pantin::detail::contact {

inline void set_axes(Vec3 (&axes)[3], Vec3 normal) {
  axes[0] = normal;
  const Vec3 aside = std::abs(normal.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  axes[1] = glm::normalize(glm::cross(normal, aside));
  axes[2] = glm::cross(normal, axes[1]);
}

/// Components of a world vector along the axes.
inline Vec3 along_axes(const Vec3 (&axes)[3], Vec3 v) {
  return {glm::dot(v, axes[0]), glm::dot(v, axes[1]), glm::dot(v, axes[2])};
}

/// The world vector with given components along the axes.
inline Vec3 in_world(const Vec3 (&axes)[3], Vec3 v) {
  return v.x * axes[0] + v.y * axes[1] + v.z * axes[2];
}

}  // namespace pantin::detail::contact
