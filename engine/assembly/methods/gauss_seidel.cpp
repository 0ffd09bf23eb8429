// Gauss-Seidel: one law after the other is closed by the least step of its bodies.
#include <algorithm>
#include <cmath>

#include "engine/assembly/methods/comparison.hpp"
#include "engine/base/dense_blocks.hpp"
#include "engine/base/rotation.hpp"

namespace pantin::detail::assembly {

using lagrangian::add_constraint_force;
using lagrangian::Block;
using lagrangian::Island;
using lagrangian::jacobian_of;
using lagrangian::RowVectors;

namespace {

constexpr Real kRegularisation = 1e-9;
constexpr Real kMostTurn = 0.5;  // rad

/// lambda of (J W J^T) lambda = -C of one block, in place of C.
void solve_block(const Part& part, const Block& b, Real* lambda) {
  const Island& m = part.m;
  Real a[36] = {}, scales[6];
  const std::size_t n = b.rows;
  for (std::size_t k = 0; k < b.count; ++k) {
    if (b.body[k] >= m.count()) continue;
    const Real per_inertia = 1 / m.inertia[b.body[k]].x;
    for (std::size_t r = 0; r < n; ++r) {
      const RowVectors x = row_of(b, jacobian_of(m, b), r, k);
      for (std::size_t s = 0; s <= r; ++s) {
        const RowVectors y = row_of(b, jacobian_of(m, b), s, k);
        a[r * n + s] += glm::dot(x.v, y.v) + per_inertia * glm::dot(x.w, y.w);
      }
    }
  }
  for (std::size_t r = 0; r < n; ++r)
    scales[r] = a[r * n + r], a[r * n + r] += kRegularisation * (scales[r] + 1e-12);
  decompose<0>(a, n, {.scales = scales});
  for (std::size_t r = 0; r < n; ++r) {
    lambda[r] = -lambda[r];
    for (std::size_t k = 0; k < r; ++k) lambda[r] -= a[r * n + k] * lambda[k];
  }
  for (std::size_t r = 0; r < n; ++r) lambda[r] *= a[r * n + r];
  for (std::size_t r = n; r-- > 0;)
    for (std::size_t k = r + 1; k < n; ++k) lambda[r] -= a[k * n + r] * lambda[k];
}

void move_body(Island& m, std::uint32_t body, const Vec3* pull) {
  lagrangian::Motions& s = m.scratch.state;
  Vec3 turn = pull[1] / m.inertia[body];
  if (const Real angle = glm::length(turn); angle > kMostTurn) turn *= kMostTurn / angle;
  s.x[body] += pull[0];
  s.q[body] = glm::normalize(from_rotation_vector(turn) * s.q[body]);
  BodyState& at = m.scratch.body_states[body];
  at.position = s.x[body], at.rotation = s.q[body];
  at.rotation_matrix = glm::mat3_cast(s.q[body]);
}

}  // namespace

Ending descend_gauss_seidel(Descent& d) {
  Island& m = d.part.m;
  return iterate(d, [&] {
    for (std::size_t i = 0; i < m.blocks.size(); ++i) {
      const Block& b = m.blocks[i];
      if (!counts(d.part, i) || binds_no_poses(b)) continue;
      lagrangian::write_block(d.world, m, i, {true, false});
      Real lambda[6];
      std::copy_n(&m.scratch.c[b.first_row], b.rows, lambda);
      solve_block(d.part, b, lambda);
      for (std::size_t k = 0; k < b.count; ++k) {
        if (b.body[k] >= m.count()) continue;
        Vec3 pull[2] = {Vec3(0), Vec3(0)};
        add_constraint_force({b, jacobian_of(m, b), k}, lambda, pull);
        move_body(m, b.body[k], pull);
      }
    }
    look(d.world, d.part), count(d.world, d.part);
  });
}

}  // namespace pantin::detail::assembly
