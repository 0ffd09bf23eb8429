// Generalised alpha on positions, twists and multipliers. Stiff joint forces are unknowns,
// evaluated at the end of the step. [Chung & Hulbert 1993; Bruels & Cardona 2010]
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr int kMaxIterations = 40;
/// Newton iterations with tangents; later ones use secants, which cannot cycle.
constexpr int kNewton = 6;

struct Weights {
  Real am, af, gamma, beta;
};

Weights weights_of(Real rho) {
  Weights w{};
  w.am = (2 * rho - 1) / (rho + 1), w.af = rho / (rho + 1);
  w.gamma = 0.5 + w.af - w.am;
  w.beta = 0.25 * (w.gamma + 0.5) * (w.gamma + 0.5);
  return w;
}

bool step_implicit(const World& world, Island& m, const Span& span) {
  StepScratch& scratch = m.scratch;
  Motions& s = scratch.state;
  const Real h = span.h;
  const Weights k = weights_of(m.settings.damping_ratio);
  const auto own = std::span(scratch.motion).first(2 * m.count());
  scratch.springs_active = true;
  if (m.fresh) {
    // For the initial accelerations springs act as plain forces.
    update_kinematics(m), update_frames(world, m, span.fraction(0), span.whole);
    write_all_rows(world, m, {true, true});
    write_joint_force_rows(world, m, m.mean_lambda, 0, 0, false);
    std::fill(scratch.weights.begin(), scratch.weights.end(), 0.0);
    scratch.springs_active = false;
    accelerate(world, m, span.fraction(0), span.whole);
    scratch.springs_active = true;
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      if (m.blocks[i].kind != BlockKind::spring)
        for (std::size_t r = 0; r < m.blocks[i].rows; ++r)
          m.mean_lambda[m.blocks[i].first_row + r] = scratch.lambda[m.blocks[i].first_row + r];
    std::copy(own.begin(), own.end(), m.accelerations.begin());
    m.lagged = m.accelerations;
  }
  scratch.from = s;
  scratch.residuals = m.accelerations;  // unknown accelerations, initialised from the last step
  std::copy(m.mean_lambda.begin(), m.mean_lambda.end(), scratch.sum_lambda.begin());
  const Real by_way = h * h * k.beta * (1 - k.af) / (1 - k.am);
  const Real by_speed = h * k.gamma * (1 - k.af) / (1 - k.am);
  update_frames(world, m, span.fraction(1), span.whole);
  Real before = std::numeric_limits<Real>::infinity();
  bool closed = false;
  for (int n = 0; n < kMaxIterations && !closed; ++n) {
    for (std::size_t b = 0; b < m.count(); ++b) {
      Vec3 way[2], twist[2];
      for (std::size_t i = 0; i < 2; ++i) {
        const Vec3 a0 = m.lagged[2 * b + i];
        const Vec3 a = ((1 - k.af) * scratch.residuals[2 * b + i] +
                        k.af * m.accelerations[2 * b + i] - k.am * a0) /
                       (1 - k.am);
        const Vec3 v0 = i == 0 ? scratch.from.v[b] : scratch.from.w[b];
        way[i] = h * (v0 + h * ((0.5 - k.beta) * a0 + k.beta * a));
        twist[i] = v0 + h * ((1 - k.gamma) * a0 + k.gamma * a);
      }
      s.x[b] = scratch.from.x[b] + way[0];
      s.q[b] = glm::normalize(from_rotation_vector(way[1]) * scratch.from.q[b]);
      s.v[b] = twist[0], s.w[b] = twist[1];
    }
    update_kinematics(m);
    write_all_rows(world, m, {true, false});
    add_forces(world, m, true);
    std::fill(scratch.right.begin(), scratch.right.end(), 0.0);
    write_joint_force_rows(world, m, scratch.right, by_way, by_speed, n >= kNewton);
    // Residual of the equations of motion, as a force.
    Real missing = 0, scale = 1e-300, open = 0;
    for (std::size_t b = 0; b < m.count(); ++b) {
      const BodyState& at = scratch.body_states[b];
      const Vec3 rotation =
          at.rotation_matrix * (m.inertia[b] * (scratch.residuals[2 * b + 1] * at.rotation_matrix));
      const Vec3 ma[2] = {m.mass[b] * scratch.residuals[2 * b], rotation};
      for (std::size_t i = 0; i < 2; ++i) {
        scale = std::max({scale, glm::length(ma[i]), glm::length(scratch.force[2 * b + i])});
        scratch.momenta[2 * b + i] = scratch.force[2 * b + i] - ma[i];
      }
    }
    for (std::size_t i = 0; i < m.blocks.size(); ++i) {
      const Block& b = m.blocks[i];
      const bool on = is_active(m, i);
      for (std::size_t e = 0; e < b.count && on; ++e)
        if (b.body[e] < m.count())
          add_constraint_force(b, jacobian_of(m, b), e, &scratch.sum_lambda[b.first_row],
                               &scratch.momenta[2 * b.body[e]]);
      for (std::size_t r = 0; r < b.rows; ++r) {
        const std::size_t row = b.first_row + r;
        const Real block_lambda = on ? scratch.sum_lambda[row] : 0;
        if (b.kind == BlockKind::spring) {
          const Real row_residual = scratch.right[row] - block_lambda;
          scale = std::max(scale, std::abs(block_lambda));
          missing = std::max(missing, std::abs(row_residual));
          scratch.right[row] = row_residual * scratch.weights[row];
        } else {
          open = on ? std::max(open, std::abs(scratch.c[row])) : open;
          scratch.right[row] = on ? -scratch.c[row] / by_way : 0;
        }
      }
    }
    for (const Vec3& f : scratch.momenta) missing = std::max(missing, glm::length(f));
    ++m.iterations;
    const Real worst = std::max(open / std::max(Real(1), m.size), 1e-3 * missing / scale);
    if (!std::isfinite(worst)) return false;
    closed = n > 0 && (worst <= 1e-13 || (worst <= 1e-10 && worst > 0.5 * before));
    if (closed) break;
    if (n == 0 || worst > 0.25 * before) factor(m, false);
    if (n > 12 && worst > 1e3 * before) return false;
    before = worst;
    // The residual of a correction is meaningless once the correction is of the size of rounding.
    const Real row_residual = scratch.worst_relative_residual;
    solve(m, scratch.momenta, scratch.right, scratch.correction, scratch.lambda);
    scratch.worst_relative_residual = row_residual;
    for (std::size_t i = 0; i < 2 * m.count(); ++i) scratch.residuals[i] += scratch.correction[i];
    for (std::size_t r = 0; r < m.rows; ++r) scratch.sum_lambda[r] += scratch.lambda[r];
  }
  scratch.springs_active = false;
  if (!closed) return false;
  for (std::size_t i = 0; i < 2 * m.count(); ++i) {
    const Vec3 a =
        ((1 - k.af) * scratch.residuals[i] + k.af * m.accelerations[i] - k.am * m.lagged[i]) /
        (1 - k.am);
    m.lagged[i] = a, m.accelerations[i] = scratch.residuals[i];
  }
  std::copy(scratch.sum_lambda.begin(), scratch.sum_lambda.end(), m.mean_lambda.begin());
  std::fill(scratch.weights.begin(), scratch.weights.end(), 0.0);
  return all_within_bounds(m);
}

}  // namespace

// Its twists are not the sums of what acts: what hangs there would not be met.
const IntegratorRow integrators::implicit{.step = step_implicit,
                                          .turns_far = true,
                                          .carries_interfaces = false,
                                          .keeps_accelerations = true};

}  // namespace pantin::detail::lagrangian
