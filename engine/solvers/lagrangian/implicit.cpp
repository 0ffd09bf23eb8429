// Generalised alpha on positions, twists and multipliers. Stiff joint forces are unknowns,
// evaluated at the end of the step. [Chung & Hulbert 1993; Bruels & Cardona 2010]
#include <algorithm>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr int kMaxIterations = 40;
/// Newton iterations with tangents; later ones use secants, which cannot cycle.
constexpr int kNewton = 6;

/// If a moment of inertia is smaller than mass times squared arm by this factor, torque residuals
/// are weighted by it.
constexpr Real kLight = 1e3;

struct Scheme {
  Real h = 0, am = 0, af = 0, gamma = 0, beta = 0;
  Real by_way = 0, by_speed = 0;  // of coordinates and rates, by the unknown accelerations
};

Scheme scheme_of(Real rho, Real h) {
  Scheme k;
  k.h = h;
  k.am = (2 * rho - 1) / (rho + 1), k.af = rho / (rho + 1);
  k.gamma = 0.5 + k.af - k.am;
  k.beta = 0.25 * (k.gamma + 0.5) * (k.gamma + 0.5);
  k.by_way = h * h * k.beta * (1 - k.af) / (1 - k.am);
  k.by_speed = h * k.gamma * (1 - k.af) / (1 - k.am);
  return k;
}

/// N, N m: the weight of a body and the forces and torques applied to it, which may jump from step
/// to step.
Vec3 known_force(const World& world, const Island& m, std::size_t i) {
  const Vec3 applied = m.scratch.applied[i];
  return i % 2 == 0 ? applied + m.mass[i / 2] * m.gravity_scale[i / 2] * world.gravity : applied;
}

/// Before the first step: accelerations of the initial state, where springs act as plain forces.
void find_initial_accelerations(const World& world, Island& m, const Span& span) {
  StepScratch& scratch = m.scratch;
  update_kinematics(m), update_frames(world, m, span.fraction(0), span.whole);
  write_all_rows(world, m, {true, true});
  write_joint_force_rows(world, m, m.mean_lambda, {0, 0, Slope::tangent});
  std::fill(scratch.weights.begin(), scratch.weights.end(), 0.0);
  scratch.springs_active = false;
  for (SurfaceMemory& touch : m.touches) touch.projected = 0;
  accelerate(world, m, span.fraction(0), span.whole);
  scratch.springs_active = true;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (m.blocks[i].kind != BlockKind::spring)
      for (std::size_t r = 0; r < m.blocks[i].rows; ++r)
        m.mean_lambda[m.blocks[i].first_row + r] = scratch.lambda[m.blocks[i].first_row + r];
  const auto own = std::span(scratch.motion).first(2 * m.count());
  std::copy(own.begin(), own.end(), m.accelerations.begin());
  m.lagged = m.accelerations;
  for (std::size_t i = 0; i < 2 * m.count(); ++i) m.known_forces[i] = known_force(world, m, i);
}

/// A jump of known forces between two steps is one of accelerations, too: without it the filter
/// would pass on a part of a push, or of a change of gravity, over later steps only.
void follow_jumps(const World& world, Island& m, const Span& span) {
  StepScratch& scratch = m.scratch;
  PANTIN_ASSERT(m.known_forces.size() == 2 * m.count());
  bool jumps = false;
  for (std::size_t i = 0; i < 2 * m.count(); ++i) {
    const Vec3 now = known_force(world, m, i);
    scratch.force_residuals[i] = now - std::exchange(m.known_forces[i], now);
    jumps = jumps || scratch.force_residuals[i] != Vec3(0);
  }
  if (!jumps) return;
  update_kinematics(m), update_frames(world, m, span.fraction(0), span.whole);
  write_all_rows(world, m, {true, true});
  std::fill(scratch.weights.begin(), scratch.weights.end(), 0.0);
  scratch.springs_active = false;
  factor(m);
  std::fill(scratch.right.begin(), scratch.right.end(), 0.0);
  solve(m, {scratch.force_residuals, scratch.right}, {scratch.solution, scratch.lambda});
  scratch.springs_active = true;
  for (std::size_t i = 0; i < 2 * m.count(); ++i)
    m.accelerations[i] += scratch.solution[i], m.lagged[i] += scratch.solution[i];
}

/// The filtered acceleration of the step, by which positions and twists are advanced.
Vec3 filtered_acceleration(const Island& m, const Scheme& k, std::size_t i) {
  return ((1 - k.af) * m.scratch.end_accelerations[i] + k.af * m.accelerations[i] -
          k.am * m.lagged[i]) /
         (1 - k.am);
}

/// The state at the end of the step that follows from its accelerations there.
void advance_state(Island& m, const Scheme& k) {
  Motions& s = m.scratch.state;
  const Motions& from = m.scratch.from;
  PANTIN_ASSERT(m.lagged.size() == 2 * m.count() && m.accelerations.size() == m.lagged.size());
  for (std::size_t b = 0; b < m.count(); ++b) {
    Vec3 way[2], twist[2];
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 a0 = m.lagged[2 * b + i];
      const Vec3 a = filtered_acceleration(m, k, 2 * b + i);
      const Vec3 v0 = i == 0 ? from.v[b] : from.w[b];
      way[i] = k.h * (v0 + k.h * ((0.5 - k.beta) * a0 + k.beta * a));
      twist[i] = v0 + k.h * ((1 - k.gamma) * a0 + k.gamma * a);
    }
    s.x[b] = from.x[b] + way[0];
    s.q[b] = glm::normalize(from_rotation_vector(way[1]) * from.q[b]);
    s.v[b] = twist[0], s.w[b] = twist[1];
  }
}

/// Largest residuals: of rows, in m or rad; of forces, and the size of the forces.
struct Residuals {
  Real row = 0, force = 0, force_scale = 1e-300;
  bool light = false;  // a moment of inertia is tiny
};

/// Adds constraint forces to the force residuals of the bodies; the right-hand side becomes the
/// residual of the rows.
void add_row_residuals(Island& m, const Scheme& k, Residuals& worst) {
  StepScratch& scratch = m.scratch;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    PANTIN_ASSERT(k.by_way > 0 && k.by_speed > 0);
    const bool on = is_active(m, i);
    for (std::size_t e = 0; e < b.count && on; ++e)
      if (b.body[e] < m.count())
        add_constraint_force({b, jacobian_of(m, b), e}, &scratch.sum_lambda[b.first_row],
                             &scratch.force_residuals[2 * b.body[e]]);
    for (std::size_t r = 0; r < b.rows; ++r) {
      const std::size_t row = b.first_row + r;
      const Real block_lambda = on ? scratch.sum_lambda[row] : 0;
      if (b.kind == BlockKind::spring) {
        const Real row_residual = scratch.right[row] - block_lambda;
        worst.force_scale = std::max(worst.force_scale, std::abs(block_lambda));
        worst.force = std::max(worst.force, std::abs(row_residual));
        scratch.right[row] = row_residual * scratch.weights[row];
      } else if (binds_no_poses(b)) {
        const Real rate = on ? rate_of(m, b, r) : 0;
        worst.row = std::max(worst.row, k.h * std::abs(rate));
        scratch.right[row] = -rate / k.by_speed;
      } else {
        worst.row = on ? std::max(worst.row, std::abs(scratch.c[row])) : worst.row;
        scratch.right[row] = on ? -scratch.c[row] / k.by_way : 0;
      }
    }
  }
}

/// Normal forces of friction. With positions on the constraints, multipliers are off by the order
/// of the step; the projection of the last step corrects them.
void set_own_grips(Island& m) {
  StepScratch& scratch = m.scratch;
  scratch.step_lambda = scratch.sum_lambda;
  for (const Block& b : m.blocks)
    if (b.kind == BlockKind::surface)
      scratch.step_lambda[b.first_row] += m.touches[b.first_place].projected;
  set_grips(m, scratch.step_lambda);
  for (const Block& b : m.blocks)
    if (b.carrier != UINT32_MAX && m.blocks[b.carrier].kind == BlockKind::joint)
      scratch.touching[b.first_place].grip =
          std::abs(load_of(m, b, scratch.sum_lambda) + m.touches[b.first_place].projected);
}

/// Residuals of the equations at the end of the step, into scratch.force_residuals and
/// scratch.right.
Residuals find_residuals(const World& world, Island& m, const Scheme& k, Slope slope) {
  StepScratch& scratch = m.scratch;
  update_kinematics(m);
  write_all_rows(world, m, {true, false});
  set_own_grips(m);
  add_forces(world, m, Torques::with_gyroscopic);
  std::fill(scratch.right.begin(), scratch.right.end(), 0.0);
  write_joint_force_rows(world, m, scratch.right, {k.by_way, k.by_speed, slope});
  Residuals worst;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const BodyState& at = scratch.body_states[b];
    const Vec3* a = &scratch.end_accelerations[2 * b];
    const Vec3 rotation = at.rotation_matrix * (m.inertia[b] * (a[1] * at.rotation_matrix));
    const Vec3 ma[2] = {m.mass[b] * a[0], rotation};
    for (std::size_t i = 0; i < 2; ++i) {
      worst.force_scale =
          std::max({worst.force_scale, glm::length(ma[i]), glm::length(scratch.force[2 * b + i])});
      scratch.force_residuals[2 * b + i] = scratch.force[2 * b + i] - ma[i];
    }
  }
  add_row_residuals(m, k, worst);
  // A tiny moment of inertia responds to torques that are negligible beside the forces. (For
  // surface joints the reach is no arm.)
  const Real reach = m.touches.empty() ? m.reach : 0;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Vec3 inertia = m.inertia[b];
    const Real most = std::max({inertia.x, inertia.y, inertia.z});
    const bool is_light = m.mass[b] * reach * reach > kLight * most;
    worst.light = worst.light || is_light;
    worst.force =
        std::max({worst.force, glm::length(scratch.force_residuals[2 * b]),
                  (is_light ? kLight : 1) * glm::length(scratch.force_residuals[2 * b + 1])});
  }
  return worst;
}

void correct(Island& m) {
  StepScratch& scratch = m.scratch;
  // The residual of a correction is meaningless once the correction is of the size of rounding.
  const Real row_residual = scratch.worst_relative_residual;
  solve(m, {scratch.force_residuals, scratch.right}, {scratch.solution, scratch.lambda});
  scratch.worst_relative_residual = row_residual;
  for (std::size_t i = 0; i < 2 * m.count(); ++i)
    scratch.end_accelerations[i] += scratch.solution[i];
  for (std::size_t r = 0; r < m.rows; ++r) scratch.sum_lambda[r] += scratch.lambda[r];
}

/// Newton iterations for the accelerations and multipliers at the end of the step.
bool solve_equations(const World& world, Island& m, const Scheme& k) {
  Real before = std::numeric_limits<Real>::infinity(), force_before = before;
  for (int n = 0; n < kMaxIterations; ++n) {
    advance_state(m, k);
    const Residuals now =
        find_residuals(world, m, k, n >= kNewton ? Slope::secant : Slope::tangent);
    ++m.iterations;
    const Real worst =
        std::max(now.row / std::max(Real(1), m.size), 1e-3 * now.force / now.force_scale);
    if (!std::isfinite(worst)) return false;
    if (n > 0 && (worst <= 1e-13 || (worst <= 1e-10 && worst > 0.5 * before))) return true;
    if (n == 0 || worst > 0.25 * before || (now.light && now.force > 0.25 * force_before))
      factor(m);
    if (n > 12 && worst > 1e3 * before) return false;
    before = worst, force_before = now.force;
    correct(m);
  }
  return false;
}

bool step_implicit(const World& world, Island& m, const Span& span) {
  StepScratch& scratch = m.scratch;
  PANTIN_ASSERT(span.h > 0);
  const Scheme k = scheme_of(m.settings.damping_ratio, span.h);
  scratch.springs_active = true;
  m.fresh ? find_initial_accelerations(world, m, span) : follow_jumps(world, m, span);
  scratch.from = scratch.state;
  scratch.end_accelerations = m.accelerations;  // initial guess from the last step
  std::copy(m.mean_lambda.begin(), m.mean_lambda.end(), scratch.sum_lambda.begin());
  update_frames(world, m, span.fraction(1), span.whole);
  const bool solved = solve_equations(world, m, k);
  scratch.springs_active = false;
  if (!solved) return false;
  for (std::size_t i = 0; i < 2 * m.count(); ++i) {
    m.lagged[i] = filtered_acceleration(m, k, i);
    m.accelerations[i] = scratch.end_accelerations[i];
  }
  std::copy(scratch.sum_lambda.begin(), scratch.sum_lambda.end(), m.mean_lambda.begin());
  std::fill(scratch.weights.begin(), scratch.weights.end(), 0.0);
  return all_within_bounds(m);
}

}  // namespace

const IntegratorRow integrators::implicit{.step = step_implicit,
                                          .projection_presses = true,
                                          .keeps_energy_to = 5e-4,
                                          .turns_far = true,
                                          .keeps_accelerations = true,
                                          .takes_means = true};

}  // namespace pantin::detail::lagrangian
