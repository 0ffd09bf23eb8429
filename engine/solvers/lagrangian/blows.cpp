// Which limits and cables take part in an impact: a complementarity problem whose solution is the
// admissible motion of least kinetic energy, with joints closed. Unilateral impulses never pull.
#include <algorithm>

#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Fraction of the fastest rate: slower rows with no impulse rest against their bounds.
constexpr Real kAtRest = 1e-9;

void set_motion(Island& m, std::span<const Vec3> twists) {
  for (std::size_t b = 0; b < m.count(); ++b) {
    BodyState& at = m.scratch.body_states[b];
    at.velocity = m.scratch.state.v[b] = twists[2 * b];
    at.angular_velocity = m.scratch.state.w[b] = twists[2 * b + 1];
  }
}

/// Opening rate of candidate row i, m/s or rad/s.
Real rate_of_row(const Island& m, std::size_t i) {
  const BlowScratch& s = m.scratch.blow;
  PANTIN_ASSERT(i < s.blocks.size() && s.first_vector.size() == s.blocks.size());
  const Block& b = m.blocks[s.blocks[i]];
  Real rate = 0;
  for (std::size_t k = 0; k < b.count; ++k) {
    const RowVectors j = row_of(b, &s.jacobian[s.first_vector[i]], 0, k);
    const BodyState& at = m.scratch.body_states[b.body[k]];
    rate += glm::dot(j.v, at.velocity) + glm::dot(j.w, at.angular_velocity);
  }
  return rate;
}

/// Applies an impulse at candidate row i, without joints. Returns the response of its own rate,
/// 1/kg.
Real push(Island& m, std::size_t i, Real impulse) {
  const BlowScratch& s = m.scratch.blow;
  PANTIN_ASSERT(i < s.blocks.size() && s.first_vector.size() == s.blocks.size());
  const Block& b = m.blocks[s.blocks[i]];
  Real own = 0;
  for (std::size_t k = 0; k < b.count; ++k) {
    const std::uint32_t body = b.body[k];
    if (body >= m.count()) continue;
    const RowVectors j = row_of(b, &s.jacobian[s.first_vector[i]], 0, k);
    BodyState& at = m.scratch.body_states[body];
    const Vec3 v = j.v / m.mass[body], w = m.scratch.inverse_inertia[body] * j.w;
    at.velocity = m.scratch.state.v[body] += impulse * v;
    at.angular_velocity = m.scratch.state.w[body] += impulse * w;
    own += glm::dot(j.v, v) + glm::dot(j.w, w);
  }
  return own;
}

/// Stores the Jacobians of the candidate rows and deactivates them until the impact is solved.
void set_aside(const World& world, Island& m) {
  BlowScratch& s = m.scratch.blow;
  s.jacobian.clear(), s.first_vector.clear();
  for (const std::uint32_t i : s.blocks) {
    PANTIN_ASSERT(is_one_sided(m, i));
    const Vec3* j = jacobian_of(m, m.blocks[i]);
    s.first_vector.push_back(s.jacobian.size());
    s.jacobian.insert(s.jacobian.end(), j, j + vectors_of(m.blocks[i]));
    m.memory[i].active = false;
  }
  write_all_rows(world, m, {true, false});
}

}  // namespace

void allocate_blows(Island& m) {
  BlowScratch& s = m.scratch.blow;
  std::size_t n = 0;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) n += is_one_sided(m, i);
  s.blocks.reserve(n), s.matrix.reserve(n * n), s.bias.reserve(n), s.bounds.reserve(n);
  s.impulses.reserve(n), s.jacobian.reserve(m.vectors), s.first_vector.reserve(n);
  s.scale.reserve(n), s.resting.reserve(n), s.passed.reserve(n), s.early.reserve(n);
  s.at_start.assign(m.rows, 0), s.was_active.assign(m.blocks.size(), 0);
  s.gap_before.assign(m.blocks.size(), 0), s.gap = s.rate = s.gap_before;
  s.is_near = s.was_active, s.hits.assign(m.blocks.size(), 0), s.touches = s.hits;
  reserve(s.complementarity, n);
  s.twists.assign(2 * m.count(), Vec3(0)), s.twists_closed = s.twists;
}

void choose_hit(const World& world, Island& m, std::span<const Real> bias) {
  StepScratch& scratch = m.scratch;
  BlowScratch& s = scratch.blow;
  PANTIN_ASSERT(bias.size() == m.rows && s.twists.size() == 2 * m.count());
  s.blocks.clear(), s.resting.clear();
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i)
    if (is_one_sided(m, i) && m.memory[i].active) s.blocks.push_back(i);
  const std::size_t n = s.blocks.size();
  if (n < 2) return;
  for (std::size_t b = 0; b < m.count(); ++b)
    s.twists[2 * b] = scratch.state.v[b], s.twists[2 * b + 1] = scratch.state.w[b];
  set_aside(world, m);
  factor(m);
  project_twists(m, {});
  for (std::size_t b = 0; b < m.count(); ++b)
    s.twists_closed[2 * b] = scratch.state.v[b], s.twists_closed[2 * b + 1] = scratch.state.w[b];
  s.bias.clear(), s.scale.clear();
  Real fastest = 0;
  const auto after = [&](std::size_t i) { return bias[m.blocks[s.blocks[i]].first_row]; };
  for (std::size_t i = 0; i < n; ++i) {
    s.bias.push_back(rate_of_row(m, i) - after(i));
    fastest = std::max(fastest, std::abs(s.bias.back()));
  }
  if (fastest > 0) {
    s.matrix.assign(n * n, 0), s.bounds.assign(n, {}), s.impulses.assign(n, 0);
    for (std::size_t j = 0; j < n; ++j) {
      set_motion(m, s.twists_closed);
      const Real own = push(m, j, 0);
      s.scale.push_back(own > 0 ? fastest / own : 0);
      push(m, j, s.scale[j]);
      project_twists(m, {});
      for (std::size_t i = 0; i < n; ++i)
        s.matrix[i * n + j] = rate_of_row(m, i) - s.bias[i] - after(i);
    }
    // Scaled to impulses that change each row's own rate by `fastest`: symmetric but for rounding.
    for (std::size_t i = 0; i < n; ++i) {
      s.bias[i] *= s.scale[i];
      for (std::size_t j = 0; j < n; ++j) s.matrix[i * n + j] *= s.scale[i];
    }
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < i; ++j)
        s.matrix[i * n + j] = s.matrix[j * n + i] =
            0.5 * (s.matrix[i * n + j] + s.matrix[j * n + i]);
    solve_complementarity({s.matrix, s.bias, s.bounds}, s.impulses, s.complementarity);
  }
  for (std::size_t i = 0; i < n; ++i) {
    Real rate = s.bias[i];
    for (std::size_t j = 0; fastest > 0 && j < n; ++j) rate += s.matrix[i * n + j] * s.impulses[j];
    m.memory[s.blocks[i]].active = fastest > 0 && s.impulses[i] > 0;
    if (rate <= kAtRest * fastest * (fastest > 0 ? s.scale[i] : 0))
      s.resting.push_back(s.blocks[i]);
  }
  set_motion(m, s.twists);
}

}  // namespace pantin::detail::lagrangian
