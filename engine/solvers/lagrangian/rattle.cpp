// RATTLE: symplectic and reversible.
#include <limits>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/momenta.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr int kMaxIterations = 40;
/// What may be missing of friction, relative.
constexpr Real kGripTolerance = 1e-11;
/// Friction that changes by as much from one solution to the next, relative, does not end.
constexpr Real kGrows = 0.1;

/// Rotates by `angle` about a body axis; `l` in body axes stays in space.
void rotate_about(Quat& q, Vec3& l, int axis, Real angle) {
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  const Real ch = std::cos(0.5 * angle), sh = std::sin(0.5 * angle);
  const Real c = 1 - 2 * sh * sh, s = 2 * sh * ch, a = l[next], b = l[last];
  l[next] = c * a + s * b, l[last] = c * b - s * a;
  Vec3 way(0);
  way[axis] = sh;
  q = q * Quat(ch, way);
}

/// Free rotation over `h` by a symmetric splitting: a top, of which the two moments that are most
/// alike are one, turns as it does exactly; before and after, half of what the other moment adds, a
/// rotation about its axis. Symplectic and reversible; a thin body, whose spin about its axis
/// rotations about all three would disturb, is such a top. `l` in body axes. [McLachlan 1993; Touma
/// & Wisdom 1994]
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

/// A correction of the multipliers for the residuals in scratch.right, into scratch.step_lambda, of
/// which only what moves bodies is kept: by the Jacobian that the factor is of.
enum class FactorOf : std::uint8_t { start, end };
void find_correction(Island& m, FactorOf of) {
  StepScratch& scratch = m.scratch;
  solve_lambda(m, scratch.right, scratch.step_lambda);
  if (of == FactorOf::start) std::swap(scratch.jacobian, scratch.jacobian_before);
  keep_moving_part(m, scratch.step_lambda);
  if (of == FactorOf::start) std::swap(scratch.jacobian, scratch.jacobian_before);
}

/// Forces of constraint at the start of the step, into scratch.lambda. Rows that bind velocities
/// only say nothing of poses at its end; they act in the first half as they do now.
void find_forces_now(const World& world, Island& m) {
  StepScratch& scratch = m.scratch;
  add_forces(world, m, Torques::with_gyroscopic);
  std::copy(scratch.gamma.begin(), scratch.gamma.end(), scratch.right.begin());
  subtract_frame_accelerations(m, scratch.right);
  solve(m, {scratch.force, scratch.right},
        {std::span(scratch.motion).first(2 * m.count()), scratch.lambda});
}

bool step_once(const World& world, Island& m, const Span& span) {
  StepScratch& scratch = m.scratch;
  Motions& s = scratch.state;
  const Real h = span.h, tolerance = tolerance_of(m);
  update_kinematics(m), update_frames(world, m, span.fraction(0), span.whole);
  write_all_rows(world, m, {false, m.rolls});
  factor(m);
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
    closed = worst <= tolerance || (worst <= 1e3 * tolerance && worst > 0.5 * before);
    const Real last = before;
    before = worst;
    if (closed) break;
    if (n > 0 && worst > 0.25 * last) factor(m), factor_of = FactorOf::end;
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
  scratch.momenta_before = scratch.momenta;
  // Forces that depend on velocity are evaluated again with the new velocity.
  for (int n = 0; n < (m.damped ? 3 : 1); ++n) {
    add_forces(world, m, Torques::applied);
    for (std::size_t i = 0; i < scratch.momenta.size(); ++i)
      scratch.momenta[i] = scratch.momenta_before[i] + h / 2 * scratch.force[i];
    right_of_rates(m);
    solve(m, {scratch.momenta, scratch.right}, {scratch.solution, scratch.lambda});
    for (std::size_t b = 0; b < m.count(); ++b) {
      scratch.body_states[b].velocity = s.v[b] = scratch.solution[2 * b];
      scratch.body_states[b].angular_velocity = s.w[b] = scratch.solution[2 * b + 1];
    }
  }
  for (std::size_t r = 0; r < m.rows; ++r)
    m.mean_lambda[r] = 0.5 * scratch.sum_lambda[r] + scratch.lambda[r] / h;
  return true;
}

/// Friction acts with the mean force that presses surfaces together.
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
                                        .returns_energy = true};

}  // namespace pantin::detail::lagrangian
