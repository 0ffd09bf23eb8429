#pragma once
/// Equations of a joint, and bodies to write them for.
#include <array>

#include "engine/joints/rows.hpp"

namespace pantin::test {

using namespace detail;

/// A block of at most six rows: of a joint, or one of a coordinate.
struct Equations {
  std::array<Real, 6> c{}, gamma{};
  std::array<Vec3, 24> j{};
  RowsOut out() { return {c.data(), j.data(), gamma.data()}; }
  Real rate(int row, const BodyState& a, const BodyState& b) const {
    const Vec3* k = &j[std::size_t(4 * row)];
    return glm::dot(k[0], a.velocity) + glm::dot(k[1], a.angular_velocity) +
           glm::dot(k[2], b.velocity) + glm::dot(k[3], b.angular_velocity);
  }
};

inline BodyState placed(Vec3 position, Quat rotation, Vec3 velocity = Vec3(0),
                        Vec3 angular_velocity = Vec3(0)) {
  return {position, rotation, glm::mat3_cast(rotation), velocity, angular_velocity};
}

}  // namespace pantin::test
