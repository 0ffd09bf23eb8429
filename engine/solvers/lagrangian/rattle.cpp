// RATTLE: symplectic and reversible.
#include <limits>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/momenta.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr int kMaxIterations = 40;
/// rad: initial multipliers that rotate a body by more are rejected.
constexpr Real kPoorTurn = 0.5;
/// Residuals that fall by less than kFalls in an iteration cause a new factorisation; kFallsSlowly
/// for tiny moments of inertia. Up to kRoundingFactor times the tolerance they may be rounding.
constexpr Real kFalls = 0.25, kFallsSlowly = 0.6, kRoundingFactor = 1e3;
/// Evaluations of forces that depend on the velocity at the end of a step. They must contract by
/// kContracts, unless the last change is below kSlowChange of the speeds.
constexpr int kRateIterations = 3;
constexpr Real kContracts = 0.5, kSlowChange = 1e-3;
/// Change of a row's dependence within a step, as a factor, that marks a nearby singular
/// configuration.
constexpr Real kNears = 9;
/// Relative residual of the friction.
constexpr Real kGripTolerance = 1e-11;
/// Relative change between iterations at which friction does not converge.
constexpr Real kGrows = 0.1;

/// Rotates by `angle` about a body axis; `l` in body axes stays in space.
void rotate_about(Quat& q, Vec3& l, int axis, Real angle) {
  PANTIN_ASSERT(axis >= 0 && axis < 3);
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  const Real ch = std::cos(0.5 * angle), sh = std::sin(0.5 * angle);
  const Real c = 1 - 2 * sh * sh, s = 2 * sh * ch, a = l[next], b = l[last];
  l[next] = c * a + s * b, l[last] = c * b - s * a;
  Vec3 way(0);
  way[axis] = sh;
  q = q * Quat(ch, way);
}

/// Free rotation over `h` by a symmetric splitting. The symmetric top, whose two most similar
/// moments are equal, rotates exactly. Before and after it, half of the remaining term rotates
/// about its axis. Symplectic and reversible. A thin body is such a top, so its spin about its axis
/// is exact; rotations about all three axes would disturb it. `l` in body axes. [McLachlan 1993;
/// Touma & Wisdom 1994]
void rotate_freely(Quat& q, Vec3& l, Vec3 inertia, Real h) {
  const Vec3 mobile = 1.0 / inertia;
  int axis = 0;  // of the top
  const auto apart = [&](int k) { return std::abs(mobile[(k + 1) % 3] - mobile[(k + 2) % 3]); };
  for (const int k : {1, 2})
    if (apart(k) < apart(axis)) axis = k;
  const int other = (axis + 1) % 3;
  const Real across = mobile[(axis + 2) % 3], more = mobile[other] - across;
  if (more != 0) rotate_about(q, l, other, 0.5 * h * more * l[other]);
  q = q * from_rotation_vector(h * across * l);
  rotate_about(q, l, axis, h * (mobile[axis] - across) * l[axis]);
  if (more != 0) rotate_about(q, l, other, 0.5 * h * more * l[other]);
  q = glm::normalize(q);
}

/// A correction of the multipliers for the residuals in scratch.right, into scratch.step_lambda.
/// Keeps only the part that moves bodies, by the Jacobian that was factored.
enum class FactorOf : std::uint8_t { start, end };
void find_correction(Island& m, FactorOf of) {
  StepScratch& scratch = m.scratch;
  solve_lambda(m, scratch.right, scratch.step_lambda);
  if (of == FactorOf::start) std::swap(scratch.jacobian, scratch.jacobian_before);
  keep_moving_part(m, scratch.step_lambda);
  if (of == FactorOf::start) std::swap(scratch.jacobian, scratch.jacobian_before);
}

/// m: arm that converts a body's rotation to displacement; not 0 for a joint at the mass centre.
Real arm_of(const Island& m, std::size_t b) {
  return m.reach + radius_of_gyration(m.inertia[b], m.mass[b]);
}

/// m: bound on the displacement of a body's points in `time`, at the initial speeds.
Real way_of_step(const Island& m, Real time) {
  Real most = 0;
  for (std::size_t b = 0; b < m.count(); ++b)
    most = std::max(most, time * (glm::length(m.scratch.from.v[b]) +
                                  arm_of(m, b) * glm::length(m.scratch.from.w[b])));
  return most;
}

/// Whether the multipliers of the last step are a poor initial guess: they rotate a body with a
/// tiny moment of inertia too far.
bool is_poor_guess(const Island& m, Real h) {
  Real most = 0;
  for (std::size_t b = 0; b < m.count(); ++b)
    most = std::max(most, glm::length(m.scratch.state.w[b] - m.scratch.from.w[b]));
  return h * most > kPoorTurn;
}

/// m: displacement by rounding errors of the multipliers in a step; large where moments are tiny.
Real rounding_of(const Island& m, std::span<const Real> lambda, Real h) {
  Real most = 0, mobile = 0;
  for (std::size_t r = 0; r < m.rows; ++r)
    most = std::max(most, std::abs(lambda[r])), mobile = std::max(mobile, m.scratch.scales[r]);
  return std::numeric_limits<Real>::epsilon() * most * mobile * h * h / 2;
}

/// Constraint forces at the start of the step, into scratch.lambda. Rows that constrain velocities
/// only act in the first half with these: poses at its end do not determine them.
void find_forces_now(const World& world, Island& m) {
  StepScratch& scratch = m.scratch;
  add_forces(world, m, Torques::with_gyroscopic);
  std::copy(scratch.gamma.begin(), scratch.gamma.end(), scratch.right.begin());
  subtract_frame_accelerations(m, scratch.right);
  solve(m, {scratch.force, scratch.right},
        {std::span(scratch.motion).first(2 * m.count()), scratch.lambda});
}

/// Whether the step starts or ends near a singular configuration: nearer than a third of the
/// rotation in the step. There, the velocities along nearly dependent rows consist of errors of the
/// poses. If one redundant row replaces another as the dependent one, the product of changes stays
/// constant.
bool is_beside_singular(Island& m, Real h) {
  StepScratch& scratch = m.scratch;
  if (!scratch.shuns_singular) return false;
  const std::span<Real> at_end = scratch.step_lambda;
  PANTIN_ASSERT(at_end.size() == m.rows && scratch.dependence.size() == m.rows);
  note_dependence(m, at_end);
  Real turn = 0, most = 1, nearest = 0, product = 1;
  for (const Vec3& w : scratch.from.w) turn = std::max(turn, h * glm::length(w));
  for (std::size_t r = 0; r < m.rows; ++r) {
    const Real from = scratch.dependence[r], to = at_end[r];
    if (!(from > 0 && to > 0)) continue;
    most = std::max({most, to / from, from / to}), product *= to / from;
    nearest = std::max({nearest, from, to});
  }
  return scratch.beside_singular = most > kNears && std::max(product, 1 / product) > kNears &&
                                   nearest * turn * turn > kNears;
}

/// The second half of the step. Evaluates velocity-dependent forces again with the new velocity.
/// False: they oscillate.
bool end_velocities(const World& world, Island& m, Real h) {
  StepScratch& scratch = m.scratch;
  Motions& s = scratch.state;
  scratch.momenta_before = scratch.momenta;
  const int most = m.damped ? kRateIterations : 1;
  Real moved = 0, moved_before = 0;  // m/s, in an iteration
  for (int n = 0; n < most; ++n) {
    add_forces(world, m, Torques::applied);
    moved_before = std::exchange(moved, 0);
    for (std::size_t i = 0; i < scratch.momenta.size(); ++i)
      scratch.momenta[i] = scratch.momenta_before[i] + h / 2 * scratch.force[i];
    right_of_rates(m);
    solve(m, {scratch.momenta, scratch.right}, {scratch.solution, scratch.lambda});
    for (std::size_t b = 0; b < m.count(); ++b) {
      const Vec3 v = scratch.solution[2 * b], w = scratch.solution[2 * b + 1];
      moved = std::max(moved, glm::length(v - s.v[b]) + arm_of(m, b) * glm::length(w - s.w[b]));
      scratch.body_states[b].velocity = s.v[b] = v;
      scratch.body_states[b].angular_velocity = s.w[b] = w;
    }
  }
  // Dry friction that reverses with every iteration would go on to oscillate.
  return !m.damped || moved <= kContracts * moved_before ||
         moved <= kSlowChange * way_of_step(m, 1);
}

bool step_once(const World& world, Island& m, const Span& span) {
  StepScratch& scratch = m.scratch;
  Motions& s = scratch.state;
  PANTIN_ASSERT(scratch.momenta.size() == 2 * m.count());
  const Real h = span.h, tolerance = tolerance_of(m);
  update_kinematics(m), update_frames(world, m, span.fraction(0), span.whole);
  write_all_rows(world, m, {false, m.rolls});
  factor(m);
  if (scratch.shuns_singular) note_dependence(m, scratch.dependence);
  if (m.rolls) find_forces_now(world, m);
  add_forces(world, m, Torques::applied);
  kick(m, h / 2);
  scratch.jacobian_before = scratch.jacobian;
  scratch.momenta_before = scratch.momenta;
  scratch.from = s;
  update_frames(world, m, span.fraction(1), span.whole);
  std::copy(m.mean_lambda.begin(), m.mean_lambda.end(), scratch.sum_lambda.begin());
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    for (std::size_t r = b.first_row; r < b.first_row + b.rows; ++r)
      if (!is_active(m, i))
        scratch.sum_lambda[r] = 0;
      else if (binds_no_poses(b))
        scratch.sum_lambda[r] = scratch.lambda[r];
  }
  keep_moving_part(m, scratch.sum_lambda);
  FactorOf factor_of = FactorOf::start;
  Real before = std::numeric_limits<Real>::infinity();
  bool closed = false;
  Real falls = kFalls;
  for (int n = 0; n < kMaxIterations && !closed; ++n) {
    scratch.momenta = scratch.momenta_before;
    push(m, scratch.jacobian_before, scratch.sum_lambda, h / 2);
    for (std::size_t b = 0; b < m.count(); ++b) {
      s.x[b] = scratch.from.x[b] + h / m.mass[b] * scratch.momenta[2 * b];
      s.q[b] = scratch.from.q[b];
      Vec3 l = glm::conjugate(s.q[b]) * scratch.momenta[2 * b + 1];
      rotate_freely(s.q[b], l, m.inertia[b], h);
      scratch.momenta[2 * b + 1] = s.q[b] * l;
      s.v[b] = scratch.momenta[2 * b] / m.mass[b], s.w[b] = s.q[b] * (l / m.inertia[b]);
    }
    update_kinematics(m);
    write_all_rows(world, m, {true, false});
    const Real worst = worst_residual(m);
    ++m.iterations;
    if (!std::isfinite(worst)) return false;
    // A residual that falls no faster is rounding.
    closed = worst <= tolerance || (worst <= kRoundingFactor * tolerance && worst > 0.5 * before) ||
             (worst <= rounding_of(m, scratch.sum_lambda, h) && worst > kFalls * before);
    const Real last = before;
    before = worst;
    if (closed) break;
    // Near singular loops or surfaces the factor has to follow the state instead.
    if (n == 0 && !m.loops && m.touches.empty() && is_poor_guess(m, h)) {
      std::fill(scratch.sum_lambda.begin(), scratch.sum_lambda.end(), 0.0);
      falls = kFallsSlowly;
      continue;
    }
    if (n > 0 && worst > falls * last) factor(m), factor_of = FactorOf::end;
    if (n > 12 && worst > 1e3 * last) return false;
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      for (std::size_t r = 0; r < m.blocks[i].rows; ++r) {
        const std::size_t row = m.blocks[i].first_row + r;
        scratch.right[row] = is_active(m, i) ? -2 / (h * h) * scratch.c[row] : 0;
      }
    find_correction(m, factor_of);
    for (std::size_t r = 0; r < m.rows; ++r) scratch.sum_lambda[r] += scratch.step_lambda[r];
  }
  if (!closed) return false;
  m.residual = before;
  factor_and_report(m);
  if (is_beside_singular(m, h)) return false;
  if (!end_velocities(world, m, h)) return false;
  for (std::size_t r = 0; r < m.rows; ++r)
    m.mean_lambda[r] = 0.5 * scratch.sum_lambda[r] + scratch.lambda[r] / h;
  return true;
}

/// Iterates until friction agrees with the mean normal force.
bool step_rattle(const World& world, Island& m, const Span& span) {
  bool jammed = false;
  for (int n = 0;; ++n) {
    if (!step_once(world, m, span)) return false;
    const Real change = set_grips(m, m.mean_lambda);
    if (n == kMostGrips || jammed || !(change > kGripTolerance)) return true;
    jammed = n > kSureGrips && change > kGrows;
    if (jammed) jam_slips(m, 0, {});
    m.scratch.state = m.scratch.from;
  }
}

}  // namespace

const IntegratorRow integrators::rattle{.step = step_rattle,
                                        .ends_on_joints = true,
                                        .efforts_are_forces = true,
                                        .keeps_energy_to = 1e-3,
                                        .returns_energy = true,
                                        .takes_means = true};

}  // namespace pantin::detail::lagrangian
