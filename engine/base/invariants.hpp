#pragma once
/// Conditions for PANTIN_ASSERT on vectors, rotations, ranges and indices. NaN passes: it comes
/// from the state, and is reported with its body in every build.
#include <cstddef>
#include <cstdint>

#include "engine/base/check.hpp"
#include "engine/base/math.hpp"

namespace pantin::detail {

/// Far above the rounding error of a unit vector in a step.
inline constexpr Real kUnitTolerance = 1e-6;

inline bool is_unit(Vec3 v) { return !(std::abs(glm::dot(v, v) - 1) > kUnitTolerance); }
inline bool is_unit(Quat q) { return !(std::abs(glm::dot(q, q) - 1) > kUnitTolerance); }
inline bool is_unit(const Pose& p) { return is_unit(p.rotation); }

/// A mass that a step can divide by; files are checked for it in every build.
inline bool is_mass(Real x) { return x > 0 && std::isfinite(x) && std::isfinite(1 / x); }
inline bool is_mass(Vec3 v) { return is_mass(v.x) && is_mass(v.y) && is_mass(v.z); }
inline bool is_positive(Real x) { return !(x <= 0); }
inline bool is_positive(Vec3 v) { return is_positive(v.x) && is_positive(v.y) && is_positive(v.z); }

/// The lower bound is not above the upper one.
inline bool is_range(Real low, Real high) { return !(low > high); }
inline bool is_range(Vec3 low, Vec3 high) {
  return is_range(low.x, high.x) && is_range(low.y, high.y) && is_range(low.z, high.z);
}

/// Whether elements [first, first + count) are within an array of `size`.
inline bool is_part(std::size_t first, std::size_t count, std::size_t size) {
  return first <= size && count <= size - first;
}
/// Whether an index is UINT32_MAX (none), or below `size`.
inline bool is_index_or_none(std::uint32_t i, std::size_t size) {
  return i < size || i == UINT32_MAX;
}

}  // namespace pantin::detail
