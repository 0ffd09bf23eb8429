#pragma once
/// Common code of solids of revolution about y.
#include "engine/geometry/kinds.hpp"
#include "engine/geometry/patch.hpp"

namespace pantin::detail::shape_kinds {

/// A direction across y, and the distance along it.
struct Polar {
  Real x = 1, z = 0;  // unit
  Real radius = 0;
};

inline Polar polar_of(Vec3 p) {
  const Real radius = std::sqrt(p.x * p.x + p.z * p.z);
  return radius > 0 ? Polar{p.x / radius, p.z / radius, radius} : Polar{};
}

inline Vec3 from_polar(const Polar& at, Real radius, Real y) {
  return {radius * at.x, y, radius * at.z};
}

/// Numbers of the points of patches: from these on the points of a rim, and the ends of a side.
/// Where the shape leans, the lowest point of the rim is added; more points would spread the load
/// over many rows.
inline constexpr std::uint32_t kRimPoints = 4;
inline constexpr std::uint32_t kBottomRim = 0, kTopRim = kRimPoints;
inline constexpr std::uint32_t kBottomPoint = 2 * kRimPoints, kTopPoint = kBottomPoint + 1;

/// Points of a rim that are fixed to the shape, so that contacts persist.
void add_rim(Real radius, Real y, std::uint32_t first, Patch& to);

/// Radius of curvature, a rim included, in the rolling direction: for rolling about the axis the
/// distance to it along the normal, for rolling over a rim 0.
Real rounding_of_turned(const Shape& shape, const Rolling& at);

}  // namespace pantin::detail::shape_kinds
