#pragma once
/// Numbers, vectors, rotations and poses. The only file that includes glm.
///
/// SI units, +Y up, right-handed. Quaternions rotate body axes into world axes. In memory glm keeps
/// them as (x, y, z, w), which is also the order of scene files; the constructor takes w first.
#include <cmath>
#include <cstddef>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <numbers>

namespace pantin {

using Real = double;
using Vec3 = glm::dvec3;
using Quat = glm::dquat;
using Mat3 = glm::dmat3;

// glm can be configured by macros. The library and its users must agree on those that change the
// meaning or the layout of numbers; the others are free.
static_assert(offsetof(Quat, x) == 0 && offsetof(Quat, w) == 3 * sizeof(Real),
              "pantin needs quaternions in memory as x, y, z, w: without GLM_FORCE_QUAT_DATA_WXYZ");
static_assert(sizeof(Vec3) == 3 * sizeof(Real) && alignof(Vec3) == alignof(Real) &&
                  sizeof(Quat) == 4 * sizeof(Real) && alignof(Quat) == alignof(Real) &&
                  sizeof(Mat3) == 9 * sizeof(Real),
              "pantin needs packed vectors: without GLM_FORCE_DEFAULT_ALIGNED_GENTYPES");
#ifdef GLM_FORCE_QUAT_CTOR_XYZW
static_assert(sizeof(Quat) == 0,
              "pantin constructs quaternions w first: without GLM_FORCE_QUAT_CTOR_XYZW");
#endif

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
