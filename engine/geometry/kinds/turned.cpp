#include "engine/geometry/kinds/turned.hpp"

namespace pantin::detail::shape_kinds {

void add_rim(Real radius, Real y, std::uint32_t first, Patch& to) {
  to.rim = radius;
  for (std::uint32_t i = 0; i < kRimPoints; ++i) {
    const Real angle = 2 * kPi * i / kRimPoints;
    to.add({radius * std::cos(angle), y, radius * std::sin(angle)}, first + i);
  }
}

Real rounding_of_turned(const Shape&, const Rolling& at) {
  const Polar out = polar_of(at.outward);
  // Near upright a rim is a corner, in whichever direction it rolls.
  constexpr Real kUpright = 0.5;
  const Real lean = out.radius / glm::max(out.radius * out.radius, kUpright * kUpright);
  const Vec3 way = glm::cross(at.spin, at.outward);
  const Real speed = glm::length(way);
  const Real around = speed > 0 ? glm::dot(way, Vec3(-out.z, 0, out.x)) / speed : 1;
  return std::hypot(at.point.x, at.point.z) * lean * around * around;
}

}  // namespace pantin::detail::shape_kinds
