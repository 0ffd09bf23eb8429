#pragma once
/// Numbers, vectors, rotations and poses. The only file that includes glm.
///
/// SI units, +Y up, right-handed. Quaternions rotate body axes into world axes. In memory glm keeps
/// them as (x, y, z, w), which is also the order of scene files; the constructor takes w first.
#include <cmath>
#include <numbers>

#define GLM_ENABLE_EXPERIMENTAL
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace pantin {

using Real = double;
using Vec3 = glm::dvec3;
using Quat = glm::dquat;
using Mat3 = glm::dmat3;

inline constexpr Real kPi = std::numbers::pi_v<Real>;
inline const Quat kIdentity{1, 0, 0, 0};

/// A rigid frame: `position` of its origin and `rotation` of its axes, in the outer frame.
struct Pose {
  Vec3 position{0};
  Quat rotation{1, 0, 0, 0};
};

inline Vec3 to_world(const Pose& at, Vec3 local) { return at.position + at.rotation * local; }
inline Vec3 to_local(const Pose& at, Vec3 world) {
  return glm::conjugate(at.rotation) * (world - at.position);
}

/// The pose of `inner` (given in the frame of `outer`) in the frame that `outer` is given in.
inline Pose compose(const Pose& outer, const Pose& inner) {
  return {to_world(outer, inner.position), glm::normalize(outer.rotation * inner.rotation)};
}

inline Pose inverse(const Pose& p) {
  const Quat back = glm::conjugate(p.rotation);
  return {back * -p.position, back};
}

inline bool is_finite(Vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool is_finite(Quat q) {
  return std::isfinite(q.w) && std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z);
}
inline bool is_finite(const Pose& p) { return is_finite(p.position) && is_finite(p.rotation); }

}  // namespace pantin
