#pragma once
/// Storage of a block's Jacobian. Joints that constrain a point (Block::point) store both arms,
/// then the directions of rows 3 and up, world axes:
///
///   rows 0 to 2:  v_a + w_a x arm_a - (v_b + w_b x arm_b)
///   row 3 + i:    k_i . (w_a - w_b)
///
/// Other blocks store 2 * count vectors a row: for velocity and angular velocity of each body.
#include "engine/solvers/lagrangian/island.hpp"

namespace pantin::detail::lagrangian {

/// Number of vectors stored for a block.
inline std::uint32_t vectors_of(const Block& b) {
  return b.point ? b.rows - 1u : 2u * b.rows * b.count;
}

/// One row for one body: coefficients of its velocity and angular velocity.
struct RowVectors {
  Vec3 v, w;
};
inline RowVectors row_of(const Block& b, const Vec3* j, std::size_t row, std::size_t at) {
  if (!b.point) return {j[2 * (row * b.count + at)], j[2 * (row * b.count + at) + 1]};
  PANTIN_ASSERT(at < 2 && row < b.rows);
  const Real sign = at == 0 ? 1 : -1;
  if (row >= 3) return {Vec3(0), sign * j[row - 1]};
  Vec3 unit(0);
  unit[static_cast<int>(row)] = sign;
  return {unit, glm::cross(j[at], unit)};
}

/// The part of a block's Jacobian that belongs to its body number `at`.
struct BodyPart {
  const Block& block;
  const Vec3* jacobian;  // of the block
  std::size_t at;
};

/// Adds J times the twist (v, w) of the body to `to`, one number a row.
inline void add_rates(const BodyPart& part, Vec3 v, Vec3 w, Real* to) {
  const auto& [b, j, at] = part;
  if (!b.point) {
    for (std::size_t r = 0; r < b.rows; ++r) {
      const Vec3* row = j + 2 * (r * b.count + at);
      to[r] += glm::dot(row[0], v) + glm::dot(row[1], w);
    }
    return;
  }
  const Real sign = at == 0 ? 1 : -1;
  const Vec3 rate = sign * (v + glm::cross(w, j[at]));
  to[0] += rate.x, to[1] += rate.y, to[2] += rate.z;
  for (std::size_t r = 3; r < b.rows; ++r) to[r] += sign * glm::dot(j[r - 1], w);
}

/// Adds J^T lambda to the body's force and torque.
inline void add_constraint_force(const BodyPart& part, const Real* block_lambda, Vec3* to) {
  const auto& [b, j, at] = part;
  if (!b.point) {
    for (std::size_t r = 0; r < b.rows; ++r) {
      const Vec3* row = j + 2 * (r * b.count + at);
      to[0] += block_lambda[r] * row[0], to[1] += block_lambda[r] * row[1];
    }
    return;
  }
  const Real sign = at == 0 ? 1 : -1;
  const Vec3 force = sign * Vec3(block_lambda[0], block_lambda[1], block_lambda[2]);
  Vec3 torque = glm::cross(j[at], force);
  for (std::size_t r = 3; r < b.rows; ++r) torque += sign * block_lambda[r] * j[r - 1];
  to[0] += force, to[1] += torque;
}

}  // namespace pantin::detail::lagrangian
