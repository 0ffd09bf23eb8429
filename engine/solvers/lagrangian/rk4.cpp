// Runge-Kutta: the classic method of order 4; within a tolerance the 5(4) pair.
#include <algorithm>

#include "engine/base/butcher_tableau.hpp"
#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Stability limit of Runge-Kutta (rate times step), and changes of speed that are negligible
/// (squared, relative).
constexpr Real kMaxRate = 1.9, kNegligible = 1e-6, kTurning = 2.5e-3;

/// state = from + h sum of weight_i rates_i.
void combine(Island& m, const Real* weights, int count, Real h) {
  StepScratch& scratch = m.scratch;
  for (std::size_t b = 0; b < m.count(); ++b) {
    Vec3 x(0), v(0), w(0);
    Quat q(0, 0, 0, 0);
    for (int i = 0; i < count; ++i) {
      if (weights[i] == 0) continue;
      const Vec3* rate = &scratch.rates[i][3 * b];
      x += weights[i] * rate[0], v += weights[i] * rate[1], w += weights[i] * rate[2];
      q += weights[i] * scratch.quat_rates[i][b];
    }
    scratch.state.x[b] = scratch.from.x[b] + h * x;
    scratch.state.v[b] = scratch.from.v[b] + h * v;
    scratch.state.w[b] = scratch.from.w[b] + h * w;
    scratch.state.q[b] = glm::normalize(scratch.from.q[b] + h * q);
  }
}

bool runge_kutta(const World& world, Island& m, const Span& span, const ButcherTableau& t) {
  StepScratch& scratch = m.scratch;
  scratch.from = scratch.state;
  std::fill(m.mean_lambda.begin(), m.mean_lambda.end(), 0.0);
  for (int i = 0; i < t.stages; ++i) {
    if (i > 0) combine(m, t.a[i], i, span.h);
    accelerate(world, m, span.fraction(t.c[i]), span.whole);
    for (std::size_t b = 0; b < m.count(); ++b) {
      scratch.rates[i][3 * b] = scratch.state.v[b];
      scratch.rates[i][3 * b + 1] = scratch.motion[2 * b];
      scratch.rates[i][3 * b + 2] = scratch.motion[2 * b + 1];
      scratch.quat_rates[i][b] = Quat(0, 0.5 * scratch.state.w[b]) * scratch.state.q[b];
    }
    for (std::size_t r = 0; r < m.rows; ++r) m.mean_lambda[r] += t.b[i] * scratch.lambda[r];
  }
  combine(m, t.b, t.stages, span.h);
  return all_within_bounds(m);
}

/// Stability test of the step just taken. The fastest rate is about 2 |k3 - k2| / (h |k2 - k1|)
/// [Hairer & Wanner II, sec. IV.2]; the method is unstable beyond 2.8 / h. All bodies count alike,
/// since light ones move fastest. At turning points k2 equals k1, so a fraction of k1 bounds the
/// difference from below.
bool is_unstable(const World& world, const Island& m, Real h) {
  const StepScratch& scratch = m.scratch;
  const Real fall = glm::dot(world.gravity, world.gravity) * static_cast<Real>(m.count());
  Real start = 0, first = 0, second = 0, moving = 0;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Real arm2 = (m.inertia[b].x + m.inertia[b].y + m.inertia[b].z) / (3 * m.mass[b]);
    const auto size = [&](Vec3 v, Vec3 w) { return glm::dot(v, v) + arm2 * glm::dot(w, w); };
    const Vec3* k[3] = {&scratch.rates[0][3 * b], &scratch.rates[1][3 * b],
                        &scratch.rates[2][3 * b]};
    start += size(k[0][1], k[0][2]);
    first += size(k[1][1] - k[0][1], k[1][2] - k[0][2]);
    second += size(k[2][1] - k[1][1], k[2][2] - k[1][2]);
    moving += size(scratch.state.v[b], scratch.state.w[b]);
  }
  return 4 * second > kMaxRate * kMaxRate * (first + kTurning * start) &&
         h * h * second > kNegligible * (moving + h * h * (start + fall));
}

bool step_rk4(const World& world, Island& m, const Span& span) {
  return runge_kutta(world, m, span, kClassicRungeKutta) && !is_unstable(world, m, span.h);
}

bool step_estimated(const World& world, Island& m, const Span& span, Real& error) {
  StepScratch& scratch = m.scratch;
  if (!runge_kutta(world, m, span, kDormandPrince)) return false;
  error = 0;
  for (std::size_t b = 0; b < m.count(); ++b) {
    Vec3 x(0), v(0), w(0);
    Quat q(0, 0, 0, 0);
    for (int i = 0; i < kDormandPrince.stages; ++i) {
      const Real e = span.h * (kDormandPrince.b[i] - kDormandPrince.lower[i]);
      const Vec3* rate = &scratch.rates[i][3 * b];
      x += e * rate[0], v += e * rate[1], w += e * rate[2];
      q += e * scratch.quat_rates[i][b];
    }
    for (const Real part : {glm::length(x), glm::length(v), glm::length(w), 2 * glm::length(q)})
      error = std::max(error, part);
  }
  return std::isfinite(error);
}

}  // namespace

const IntegratorRow integrators::rk4{.step = step_rk4,
                                     .step_estimated = step_estimated,
                                     .stages = kClassicRungeKutta.stages,
                                     .stages_estimated = kDormandPrince.stages,
                                     .may_open_joints = true,
                                     .efforts_are_forces = true,
                                     .keeps_energy_to = 1e-4};

}  // namespace pantin::detail::lagrangian
