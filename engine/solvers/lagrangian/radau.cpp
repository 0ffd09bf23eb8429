// Radau IIA with three stages, order 5: solves for the accelerations of all stages together, by
// Newton iterations with the slopes of stiff forces. [Hairer & Wanner II, sec. IV.8]
#include "engine/solvers/lagrangian/radau.hpp"

#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr Real kRoot6 = 2.449489742783178;
constexpr Real kC[3] = {(4 - kRoot6) / 10, (4 + kRoot6) / 10, 1};
constexpr Real kA[3][3] = {
    {(88 - 7 * kRoot6) / 360, (296 - 169 * kRoot6) / 1800, (-2 + 3 * kRoot6) / 225},
    {(296 + 169 * kRoot6) / 1800, (88 + 7 * kRoot6) / 360, (-2 - 3 * kRoot6) / 225},
    {(16 - kRoot6) / 36, (16 + kRoot6) / 36, 1.0 / 9}};
/// Brings the inverse of kA to one real eigenvalue and a complex pair, and back.
constexpr Real kTo[3][3] = {
    {4.3255798900631553510, 0.33919925181580986954, 0.54177053993587487119},
    {-4.1787185915519047273, -0.32768282076106238708, 0.47662355450055045196},
    {-0.50287263494578687595, 2.5719269498556054292, -0.59603920482822492497}};
constexpr Real kFrom[3][3] = {
    {9.1232394870892942792e-02, -0.14125529502095420843, -3.0029194105147424492e-02},
    {0.24171793270710701896, 0.20412935229379993199, 0.38294211275726193779},
    {0.96604818261509293619, 1, 0}};
/// Weights of the stages in the estimate of the error.
constexpr Real kEstimate[3] = {-(13 + 7 * kRoot6) / 3, (-13 + 7 * kRoot6) / 3, -1.0 / 3};

constexpr int kMostIterations = 12, kMostWithoutTolerance = 40;
/// Convergence: fraction of the tolerance; without one, fraction of the largest number.
constexpr Real kLeft = 0.02, kRounding = 1e-14;
/// If corrections stop shrinking below this fraction of the largest number, rounding is reached.
constexpr Real kRoundingOfSolves = 1e-11;
/// Corrections below this fraction may grow again where rounding is large (thin bodies that spin
/// about their axes) or rates off the joints are (loops that lose rank): then the previous stages
/// are kept.
constexpr Real kSmallCorrection = 1e-7;
/// Longest step, as a multiple of the last one, over which accelerations are extrapolated.
constexpr Real kLongestExtrapolation = 4;

using Stages = std::vector<Vec3>;

/// A step and the tolerance of its solution.
struct Attempt {
  const World& world;
  Island& m;
  const Span& span;
  Real tolerance = 0;  // 0: to rounding
};

/// The rate of a rotation vector `turn` for the angular velocity `w`.
Vec3 rotation_rate(Vec3 turn, Vec3 w) {
  const Real angle2 = glm::dot(turn, turn);
  const Vec3 once = glm::cross(turn, w);
  const Real half = 0.5 * std::sqrt(angle2);
  const Real second = angle2 < 1e-4 ? 1.0 / 12 + angle2 / 720 + angle2 * angle2 / 30240
                                    : (1 - half * std::cos(half) / std::sin(half)) / angle2;
  return w - 0.5 * once + second * glm::cross(turn, once);
}

/// scratch.state from `change` since the start of the step, four vectors a body.
void set_state(Island& m, const Stages& change) {
  PANTIN_ASSERT(change.size() == kStageVectors * m.count());
  Motions& s = m.scratch.state;
  const Motions& from = m.scratch.from;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Vec3* z = &change[kStageVectors * b];
    s.x[b] = from.x[b] + z[0], s.q[b] = glm::normalize(from_rotation_vector(z[1]) * from.q[b]);
    s.v[b] = from.v[b] + z[2], s.w[b] = from.w[b] + z[3];
  }
}

/// Rates of `change` at the fraction `c` of the step.
void find_rates(const Attempt& a, const Stages& change, Real c, Stages& rates) {
  StepScratch& scratch = a.m.scratch;
  set_state(a.m, change);
  accelerate(a.world, a.m, a.span.fraction(c), a.span.whole);
  for (std::size_t b = 0; b < a.m.count(); ++b) {
    Vec3* rate = &rates[kStageVectors * b];
    rate[0] = scratch.state.v[b];
    rate[1] = rotation_rate(change[kStageVectors * b + 1], scratch.state.w[b]);
    rate[2] = scratch.motion[2 * b], rate[3] = scratch.motion[2 * b + 1];
  }
}

/// Value at `s` of the parabola through those at the stages' times, as weights of these.
std::array<Real, 3> weights_at(Real s) {
  std::array<Real, 3> w{1, 1, 1};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      if (k != i) w[i] *= (s - kC[k]) / (kC[i] - kC[k]);
  return w;
}

/// Initial guess of the stages: extrapolates the accelerations of the last step; or none.
void guess_stages(Island& m, Real h) {
  PANTIN_ASSERT(m.stage_accelerations.size() == 6 * m.count());
  CollocationScratch& s = m.scratch.collocation;
  const bool known = !m.fresh && m.stage_step > 0 && h <= kLongestExtrapolation * m.stage_step;
  std::array<Real, 3> w[3];
  for (int i = 0; i < 3; ++i) w[i] = weights_at(1 + kC[i] * h / m.stage_step);
  for (std::size_t b = 0; b < m.count(); ++b)
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t at = kStageVectors * b + k;
      Vec3 a[3] = {Vec3(0), Vec3(0), Vec3(0)}, v[3];
      for (std::size_t i = 0; i < 3 && known; ++i)
        for (std::size_t n = 0; n < 3; ++n)
          a[i] += w[i][n] * m.stage_accelerations[2 * (n * m.count() + b) + k];
      const Vec3 start = k == 0 ? m.scratch.from.v[b] : m.scratch.from.w[b];
      for (int i = 0; i < 3; ++i) {
        v[i] = h * (kA[i][0] * a[0] + kA[i][1] * a[1] + kA[i][2] * a[2]);
        s.stage[i][at + 2] = v[i];
      }
      for (int i = 0; i < 3; ++i)
        s.stage[i][at] = h * (kC[i] * start + kA[i][0] * v[0] + kA[i][1] * v[1] + kA[i][2] * v[2]);
    }
}

void keep_accelerations(Island& m, Real h) {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t b = 0; b < m.count(); ++b)
      for (std::size_t k = 0; k < 2; ++k)
        m.stage_accelerations[2 * (i * m.count() + b) + k] =
            m.scratch.collocation.rate[i][kStageVectors * b + 2 + k];
  PANTIN_ASSERT(h > 0);
  m.stage_step = h;
}

/// Largest number of a stage's change, each in its own unit.
Real largest(const Stages& change) {
  Real most = 0;
  for (const Vec3& part : change) {
    const Real size = glm::dot(part, part);
    if (!(size <= most)) most = size;  // NaN is kept, too
  }
  return std::sqrt(most);
}

/// One Newton iteration: its correction, into scratch.collocation.part. Returns the largest of any
/// body.
Real find_correction(const Attempt& a) {
  Island& m = a.m;
  CollocationScratch& s = m.scratch.collocation;
  const Real h = a.span.h;
  std::fill(m.mean_lambda.begin(), m.mean_lambda.end(), 0.0);
  for (int i = 0; i < 3; ++i) {
    find_rates(a, s.stage[i], kC[i], s.rate[i]);
    for (std::size_t r = 0; r < m.rows; ++r) m.mean_lambda[r] += kA[2][i] * m.scratch.lambda[r];
  }
  const Complex g = Complex(h) / kComplexEigenvalue;
  for (std::size_t n = 0; n < s.part[0].size(); ++n) {
    Vec3 change[3] = {}, rate[3] = {};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        change[i] += kTo[i][k] * s.stage[k][n], rate[i] += kTo[i][k] * s.rate[k][n];
    s.part[0][n] = h / kRealEigenvalue * rate[0] - change[0];
    s.part[1][n] = g.re * rate[1] - g.im * rate[2] - change[1];
    s.part[2][n] = g.re * rate[2] + g.im * rate[1] - change[2];
  }
  solve_real_system(m, s.part[0]);
  solve_complex_system(m, s.part[1], s.part[2]);
  Real most = 0;
  for (std::size_t n = 0; n < s.part[0].size(); ++n)
    for (int i = 0; i < 3; ++i) {
      const Vec3 by =
          kFrom[i][0] * s.part[0][n] + kFrom[i][1] * s.part[1][n] + kFrom[i][2] * s.part[2][n];
      const Real size = glm::dot(by, by);
      if (!(size <= most)) most = size;
    }
  return std::sqrt(most);
}

void correct_stages(CollocationScratch& s) {
  for (std::size_t n = 0; n < s.part[0].size(); ++n)
    for (int i = 0; i < 3; ++i)
      s.stage[i][n] +=
          kFrom[i][0] * s.part[0][n] + kFrom[i][1] * s.part[1][n] + kFrom[i][2] * s.part[2][n];
}

/// Solves for the stages. False: the iterations do not converge.
bool solve_stages(const Attempt& a) {
  CollocationScratch& s = a.m.scratch.collocation;
  const bool to_rounding = !(a.tolerance > 0);
  const int most = to_rounding ? kMostWithoutTolerance : kMostIterations;
  Real before = std::numeric_limits<Real>::infinity();
  const Real row_residual = a.m.scratch.worst_relative_residual;
  for (int n = 0; n < most; ++n) {
    // Counts in the last iteration only: stages before convergence may violate redundant rows.
    a.m.scratch.worst_relative_residual = row_residual;
    const Real size = find_correction(a);
    ++a.m.iterations;
    if (!std::isfinite(size)) return false;
    const Real scale = std::max(Real(1), largest(s.stage[2])), ratio = size / before;
    if (to_rounding && ratio >= 1 && before <= kSmallCorrection * scale) return true;
    correct_stages(s);
    const Real goal = std::max(kLeft * a.tolerance, kRounding * scale);
    if (size <= goal || (n > 0 && ratio < 1 && size * ratio <= goal * (1 - ratio))) return true;
    if (ratio > 0.5 && size <= kRoundingOfSolves * scale) return true;
    if (n > 1 && ratio >= 1) return size <= a.tolerance;
    // Converges too slowly.
    if (n > 1 && size * std::pow(ratio, most - n) > goal && !to_rounding) return false;
    before = size;
  }
  return false;
}

void start_step(const Attempt& a) {
  Island& m = a.m;
  m.scratch.from = m.scratch.state;
  update_kinematics(m), update_frames(a.world, m, a.span.fraction(0), a.span.whole);
  prepare_stage_systems(a.world, m, a.span.h);
  guess_stages(m, a.span.h);
}

/// Error estimate from the rates `rate` at the start and the stages. [sec. IV.8, eq. 8.19]
Real estimate(Island& m, const Stages& rate, Real h) {
  CollocationScratch& s = m.scratch.collocation;
  PANTIN_ASSERT(s.error.size() == rate.size());
  for (std::size_t n = 0; n < s.error.size(); ++n)
    s.error[n] = (h * rate[n] + kEstimate[0] * s.stage[0][n] + kEstimate[1] * s.stage[1][n] +
                  kEstimate[2] * s.stage[2][n]) /
                 kRealEigenvalue;
  solve_real_system(m, s.error);
  return largest(s.error);
}

bool step_radau(const World& world, Island& m, const Span& span) {
  const Attempt a{world, m, span};
  start_step(a);
  if (!solve_stages(a)) return false;
  keep_accelerations(m, span.h);
  set_state(m, m.scratch.collocation.stage[2]);
  return all_within_bounds(m);
}

bool step_estimated(const World& world, Island& m, const Span& span, Real& error) {
  CollocationScratch& s = m.scratch.collocation;
  const Attempt a{world, m, span, m.settings.step_tolerance};
  start_step(a);
  std::fill(s.error.begin(), s.error.end(), Vec3(0));
  find_rates(a, s.error, 0, s.rate_at_start);
  if (!solve_stages(a)) return false;
  error = estimate(m, s.rate_at_start, span.h);
  if (error > a.tolerance && std::isfinite(error)) {
    // With stiff forces the rates at the start mislead: repeats the estimate with filtered ones.
    find_rates(a, s.error, 0, s.rate_at_start);
    error = estimate(m, s.rate_at_start, span.h);
  }
  if (error <= a.tolerance) keep_accelerations(m, span.h);
  set_state(m, s.stage[2]);
  return std::isfinite(error) && all_within_bounds(m);
}

}  // namespace

const IntegratorRow integrators::radau{.step = step_radau,
                                       .step_estimated = step_estimated,
                                       .estimate_order = 4,
                                       .after_failure = 0.5,
                                       .may_open_joints = true,
                                       .keeps_energy_to = 1e-4,
                                       .collocates = true};

}  // namespace pantin::detail::lagrangian
