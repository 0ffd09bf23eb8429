// Gradient descent on |C|^2 / 2, and with momentum.
#include <algorithm>
#include <cmath>

#include "engine/assembly/methods/comparison.hpp"
#include "engine/base/rotation.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::assembly {

using lagrangian::add_constraint_force;
using lagrangian::Block;
using lagrangian::Island;
using lagrangian::jacobian_of;
using lagrangian::KktPattern;
using lagrangian::RowVectors;

namespace {

constexpr Real kGain = 0.1, kMomentum = 0.85;
/// |dQ|^2 of a rotation by 2 |dQ|: the square of a rotation counts a quarter in quaternions.
constexpr Real kQuarter = 4;

/// q -= k C_q^T C. In quaternions C_q^T C = 2 (0, t) Q, t the torque J_w^T C; the length is then
/// restored.
void descend_by(Descent& d, Real gain) {
  lagrangian::Motions& s = d.part.m.scratch.state;
  for (std::size_t b = 0; b < d.part.m.count(); ++b) {
    s.x[b] -= gain * d.part.m.scratch.force[2 * b];
    const Quat change = Quat(0, 2 * gain * d.part.m.scratch.force[2 * b + 1]) * s.q[b];
    s.q[b] = glm::normalize(s.q[b] - change);
  }
}

/// Of every row of C_q C_q^T the sum of sizes is below this. [Gershgorin 1931]
Real largest_eigenvalue(const Part& part) {
  const Island& m = part.m;
  const auto length = [&](const Block& b, std::size_t row, std::size_t k) {
    const RowVectors j = row_of(b, jacobian_of(m, b), row, k);
    return std::sqrt(glm::dot(j.v, j.v) + kQuarter * glm::dot(j.w, j.w));
  };
  std::vector<Real> at_body(m.count(), 0);
  const auto each = [&](const auto& take) {
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      for (std::size_t r = 0; r < m.blocks[i].rows && counts(part, i); ++r) take(m.blocks[i], r);
  };
  each([&](const Block& b, std::size_t r) {
    for (std::size_t k = 0; k < b.count; ++k)
      if (b.body[k] < m.count()) at_body[b.body[k]] += length(b, r, k);
  });
  Real most = 1e-12;
  each([&](const Block& b, std::size_t r) {
    Real sum = 0;
    for (std::size_t k = 0; k < b.count; ++k)
      if (b.body[k] < m.count()) sum += length(b, r, k) * at_body[b.body[k]];
    most = std::max(most, sum);
  });
  return most;
}

}  // namespace

void find_gradient(Descent& d) {
  Island& m = d.part.m;
  const KktPattern& p = m.scratch.pattern;
  for_each_island(m.count(), {.threads = {d.effort.threads}}, [&](std::size_t body) {
    Vec3* sum = &m.scratch.force[2 * body];
    sum[0] = sum[1] = Vec3(0);
    for (std::uint32_t i = p.first_incident[body]; i < p.first_incident[body + 1]; ++i) {
      const std::uint32_t block = p.incidents[i].block;
      if (!counts(d.part, block)) continue;
      const Block& b = m.blocks[block];
      add_constraint_force({b, jacobian_of(m, b), p.incidents[i].at}, &m.scratch.c[b.first_row],
                           sum);
    }
  });
}

void look_in_parallel(Descent& d) {
  Island& m = d.part.m;
  // Surfaces, and laws that may be inactive, are evaluated with what is beside them.
  if (d.effort.threads == 1 || m.unilateral || m.rolls || !m.touches.empty())
    return look(d.world, d.part);
  lagrangian::update_kinematics(m);
  for_each_island(m.blocks.size(), {.threads = {d.effort.threads}}, [&](std::size_t block) {
    lagrangian::write_block(d.world, m, block, {true, false});
  });
}

Ending descend_gradient(Descent& d) {
  return iterate(d, [&] {
    find_gradient(d), descend_by(d, kGain);
    look_in_parallel(d), count(d.world, d.part);
  });
}

Ending descend_gradient_safely(Descent& d) {
  return iterate(d, [&] {
    find_gradient(d), descend_by(d, 1 / largest_eigenvalue(d.part));
    look_in_parallel(d), count(d.world, d.part);
  });
}

Ending descend_momentum(Descent& d) {
  std::vector<Vec3>& way = d.part.m.scratch.solution;
  std::fill(way.begin(), way.end(), Vec3(0));
  return iterate(d, [&] {
    find_gradient(d);
    for (std::size_t i = 0; i < way.size(); ++i)
      way[i] = kMomentum * way[i] - (i % 2 ? kQuarter : 1) * kGain * d.part.m.scratch.force[i];
    move(d.part, 1);
    look_in_parallel(d), count(d.world, d.part);
  });
}

}  // namespace pantin::detail::assembly
