// Limits and cables that are beyond their bounds before a substep, or cross them twice within it.
#include <algorithm>

#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Residuals below this multiple of the tolerance are rounding.
constexpr Real kRoundingFactor = 1e3;
/// Bisection steps for the zero of a cubic.
constexpr int kHalvings = 30;

/// Limits and cables. Surface joints track their gaps themselves.
bool has_bound(const Island& m, std::size_t i) {
  return is_one_sided(m, i) && m.blocks[i].kind != BlockKind::surface;
}

bool is_passed(const Island& m, std::size_t i) {
  return has_bound(m, i) && !m.memory[i].active &&
         m.scratch.c[m.blocks[i].first_row] < -kLimitTolerance;
}

bool any_passed(const Island& m) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (is_passed(m, i)) return true;
  return false;
}

/// Projects poses back to the bounds that are violated but opening.
void close_passed(const World& world, Island& m, const Span& at) {
  StepScratch& scratch = m.scratch;
  std::vector<std::uint32_t>& passed = scratch.blow.passed;
  passed.clear();
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i)
    if (is_passed(m, i)) passed.push_back(i);
  if (passed.empty()) return;
  for (const std::uint32_t i : passed) m.memory[i].active = true;
  scratch.start = scratch.state, scratch.impulses_before = scratch.impulses;
  const bool closed = project(world, m, at.fraction(0), at.whole);
  if (!closed) scratch.state = scratch.start;
  scratch.state.v = scratch.start.v, scratch.state.w = scratch.start.w;
  scratch.impulses = scratch.impulses_before;
  for (const std::uint32_t i : passed) m.memory[i].active = false;
}

/// A bound on the speed of anything in the island, m/s or rad/s.
Real fastest_of(const Island& m) {
  Real most = 0;
  for (std::size_t n = 0; n < m.scratch.body_states.size(); ++n) {
    const BodyState& at = m.scratch.body_states[n];
    const Real spin = glm::length(at.angular_velocity);
    most = std::max(most, glm::length(at.velocity) + (1 + m.size) * spin);
  }
  return most;
}

/// Cubic Hermite interpolant of a limit's gap over a substep, with time scaled to 0..1.
struct Course {
  Real from = 0, to = 0, rate_from = 0, rate_to = 0;

  Real cube() const { return 2 * (from - to) + rate_from + rate_to; }
  Real square() const { return 3 * (to - from) - 2 * rate_from - rate_to; }
  Real at(Real t) const { return from + t * (rate_from + t * (square() + t * cube())); }

  /// 0, the extrema between, 1. Returns how many.
  int turns(Real times[4]) const {
    int n = 0;
    times[n++] = 0;
    const Real a = 3 * cube(), b = 2 * square(), root = std::sqrt(b * b - 4 * a * rate_from);
    const Real q = -0.5 * (b + std::copysign(root, b));
    Real first = q / a, second = rate_from / q;
    if (!(first <= second)) std::swap(first, second);
    for (const Real t : {first, second})
      if (t > 0 && t < 1) times[n++] = t;
    times[n++] = 1;
    return n;
  }
  /// The first crossing below the bound.
  Passing find_passing() const {
    Real times[4];
    const int n = turns(times);
    for (int k = 0; k + 1 < n; ++k) {
      if (!(at(times[k]) >= -kLimitTolerance) || !(at(times[k + 1]) < -kLimitTolerance)) continue;
      Real low = times[k], high = times[k + 1];  // high is the guess: never 0
      for (int i = 0; i < kHalvings; ++i) {
        const Real middle = 0.5 * (low + high);
        (at(middle) >= 0 ? low : high) = middle;
      }
      return {times[k], times[k + 1], high, std::max(at(times[k]), kLimitTolerance)};
    }
    return {};
  }
};

}  // namespace

bool begin_on_bounds(const World& world, Island& m, const Span& at) {
  const bool passed = any_passed(m), by_poses = row_of(m.settings.integrator).ends_on_joints;
  if (!passed && !(by_poses && worst_residual(m) > kRoundingFactor * tolerance_of(m))) return true;
  if (passed) hit(world, m), close_passed(world, m, at);
  return project(world, m, at.fraction(0), at.whole);
}

void note_bounds(const World& world, Island& m, Real h) {
  BlowScratch& s = m.scratch.blow;
  const Real near = m.touches.empty() ? 2 * h * fastest_of(m) : 0;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    s.gap[i] = m.scratch.c[m.blocks[i].first_row];
    s.is_near[i] = has_bound(m, i) && !m.memory[i].active && s.gap[i] < near;
    if (s.is_near[i]) s.rate[i] = opening_rate(world, m, i);
  }
}

Passing find_passing(const World& world, Island& m, Real h) {
  const BlowScratch& s = m.scratch.blow;
  Passing first;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (!s.is_near[i] || m.memory[i].active) continue;
    const Real end = m.scratch.c[m.blocks[i].first_row];
    const bool comes_back = s.rate[i] < 0;  // otherwise the gap at the end shows the crossing
    if (!comes_back && end >= -kLimitTolerance) continue;
    const Passing one =
        Course{std::max(Real(0), s.gap[i]), end, h * s.rate[i], h * opening_rate(world, m, i)}
            .find_passing();
    if (one.guess < first.guess) first = one;
  }
  return first;
}

}  // namespace pantin::detail::lagrangian
