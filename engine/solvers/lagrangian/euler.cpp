// Euler, semi-implicit: a step by itself adds no energy.
#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/momenta.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr int kRotationIterations = 8;
/// Square of the residual of an angular velocity that ends the iterations, relative.
constexpr Real kRotationTolerance = 1e-30;
/// Bound of the rotation in half a step at which the gyroscopic torque is evaluated, rad.
constexpr Real kMostTurned = 1;
/// (rate times step)^2 up to this needs no geometric stiffness; the limit of stability is 4.
constexpr Real kSlowEnough = 1;

/// Replaces explicit drag by drag at the end of the step.
void brake(Island& m, Real h) {
  for (std::size_t b = 0; b < m.count(); ++b) {
    if (m.drag[b] == 0) continue;
    const BodyState& at = m.scratch.body_states[b];
    const Real part = 1 / (1 + h * m.drag[b]);
    Vec3* p = &m.scratch.momenta[2 * b];
    p[0] = part * (p[0] + h * m.drag[b] * m.mass[b] * at.velocity);
    p[1] = part * (p[1] + h * m.drag[b] * angular_momentum(at, m.inertia[b]));
  }
}

/// Advances the angular velocity `w` of a free body, in body axes, by the implicit mid-point rule
///
///   I (w1 - w0) = h (I wm) x wm,   wm = (w0 + w1) / 2
///
/// and returns the rotation about wm that conserves the angular momentum in space. The rule
/// conserves energy, too. In body axes no term is large where a moment of inertia is small.
Vec3 turn_freely(Vec3& w, Vec3 inertia, Real h) {
  const Vec3 start = w;
  const Real fast = glm::length(w), turned = std::min(h * fast, kMostTurned);
  if (!(turned > 0)) return Vec3(0);
  // The rule rotates by 2 atan(h |wm| / 2); this `half` makes it h |wm| about a fixed axis.
  const Real half = std::tan(0.5 * turned) / fast;
  for (int i = 0; i < kRotationIterations; ++i) {
    const Vec3 l = inertia * w;
    const Vec3 residual = start - w + half * glm::cross(l, w) / inertia;
    if (!(glm::dot(residual, residual) > kRotationTolerance * fast * fast)) break;
    Mat3 slope(1);
    for (int k = 0; k < 3; ++k) {
      Vec3 axis(0);
      axis[k] = 1;
      slope[k] -= half * (glm::cross(inertia * axis, w) + glm::cross(l, axis)) / inertia;
    }
    w += glm::inverse(slope) * residual;
  }
  const Real mean = glm::length(w);
  const Vec3 way = 2 * std::atan(half * mean) / mean * w;
  w = 2.0 * w - start;
  // Keeps the iteration error from adding energy.
  const Real before = glm::dot(start, inertia * start), after = glm::dot(w, inertia * w);
  if (after > before) w *= std::sqrt(before / after);
  return way;
}

/// Rotates all bodies freely over the first half of the step. The second half follows the impulses
/// of the step, so impulses and rows see its mean velocity. Stores in scratch.from.w by how much
/// the first rotation exceeds that of the mean velocity.
void turn_first_half(Island& m, Real h) {
  Motions& s = m.scratch.state;
  for (std::size_t b = 0; b < m.count(); ++b) {
    Vec3 w = glm::conjugate(s.q[b]) * s.w[b];
    const Vec3 way = turn_freely(w, m.inertia[b], 0.5 * h);
    m.scratch.from.w[b] = way - 0.5 * h * w;
    s.w[b] = s.q[b] * w;
  }
}

/// Bodies in tension between joints oscillate faster than explicit constraint forces allow. Adds to
/// their inertia as much of the geometric stiffness as stability needs, with the forces of the last
/// step. It resists every rotation and would change the angular momentum of free islands, which go
/// without; nothing lifts their bodies. [Andrews, Teichmann & Kry 2017]
void add_geometric_stiffness(Island& m, Real h) {
  const KktPattern& p = m.scratch.pattern;
  PANTIN_ASSERT(p.first_incident.size() == m.count() + 1);
  if (p.framed.empty()) return;
  for (std::size_t body = 0; body < m.count(); ++body) {
    Mat3 sum(0);
    Real trace = 0;
    for (std::uint32_t i = p.first_incident[body]; i < p.first_incident[body + 1]; ++i) {
      const Block& b = m.blocks[p.incidents[i].block];
      if (!b.point) continue;
      const std::size_t at = p.incidents[i].at;
      const Real* lambda = &m.mean_lambda[b.first_row];
      const Vec3 arm = jacobian_of(m, b)[at];
      const Real pull = (at == 0 ? 1 : -1) * glm::dot(arm, Vec3(lambda[0], lambda[1], lambda[2]));
      if (!(pull > 0)) continue;
      sum += pull * (Mat3(1) - glm::outerProduct(arm, arm) / glm::dot(arm, arm));
      trace += 2 * pull;
    }
    const Vec3 inertia = m.inertia[body];
    // (Step times fastest rate)^2, approximately.
    const Real fast = h * h * trace / (inertia.x + inertia.y + inertia.z);
    if (!(fast > kSlowEnough)) continue;
    const Mat3& r = m.scratch.body_states[body].rotation_matrix;
    const Mat3 own(inertia.x, 0, 0, 0, inertia.y, 0, 0, 0, inertia.z);
    const Mat3 stiff = glm::transpose(r) * sum * r;
    m.scratch.inverse_inertia[body] =
        r * glm::inverse(own + (1 - kSlowEnough / fast) * h * h * stiff) * glm::transpose(r);
  }
}

void store_lambda(Island& m, std::span<const Real> lambda, Real factor_of) {
  PANTIN_ASSERT(lambda.size() == m.rows && m.mean_lambda.size() == m.rows);
  for (std::size_t r = 0; r < m.rows; ++r) m.mean_lambda[r] = factor_of * lambda[r];
}

/// Whether no constraint forces are known yet, or the last step failed.
bool are_unknown(std::span<const Real> lambda) {
  return std::all_of(lambda.begin(), lambda.end(), [](Real x) { return x == 0; });
}

/// Kinematics at the start of the step, with the twists of frames at its end: implicit in their
/// motion.
void place(const World& world, Island& m, const Span& span) {
  StepScratch& scratch = m.scratch;
  update_kinematics(m);
  update_frames(world, m, span.fraction(1), span.whole);
  for (std::size_t n = m.count(); n < scratch.body_states.size(); ++n) {
    // Extrapolates back to their poses at the start of the step.
    scratch.body_states[n].position -= span.h * scratch.body_states[n].velocity;
    scratch.body_states[n].rotation_matrix =
        glm::mat3_cast(from_rotation_vector(-span.h * scratch.body_states[n].angular_velocity) *
                       scratch.body_states[n].rotation);
  }
}

/// Whether the body is free of joints, pins and cables.
bool is_loose(const Island& m) {
  return m.blocks.empty() && m.elastic_pins.empty() && m.elastic_cables.empty() &&
         m.elastic_paths.empty();
}

/// Poses at the end of the step, and the second half of the free rotation.
void finish(Island& m, Real h) {
  StepScratch& scratch = m.scratch;
  Motions& s = scratch.state;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Vec3 before = s.v[b];
    s.v[b] = scratch.solution[2 * b];
    // A loose body falls with the mean velocity, which conserves energy.
    s.x[b] += is_loose(m) && !scratch.in_parts ? 0.5 * h * (before + s.v[b]) : h * s.v[b];
    Vec3 w = glm::conjugate(s.q[b]) * scratch.solution[2 * b + 1];
    const Vec3 first = scratch.from.w[b] + 0.5 * h * w;
    const Vec3 second = turn_freely(w, m.inertia[b], 0.5 * h);
    s.q[b] = glm::normalize(s.q[b] * from_rotation_vector(first) * from_rotation_vector(second));
    s.w[b] = s.q[b] * w;
  }
}

bool step_euler(const World& world, Island& m, const Span& span) {
  StepScratch& scratch = m.scratch;
  const bool draws = m.settings.stabilisation == Stabilisation::baumgarte;
  turn_first_half(m, span.h);
  place(world, m, span);
  scratch.springs_active = true;
  // Contact points of surface joints are those at the start.
  const Real ends = scratch.time;
  scratch.time -= span.h;
  write_all_rows(world, m, {draws || !m.joint_forces.empty(), false});
  scratch.time = ends;
  scratch.forces_over = span.h;
  add_forces(world, m, Torques::applied);
  scratch.forces_over = 0;
  right_of_rates(m);
  if (draws)
    for (const Block& b : m.blocks)
      for (std::size_t r = b.first_row; r < b.first_row + b.rows && b.kind != BlockKind::spring;
           ++r)
        scratch.right[r] -= rate_or_default(m, 0.2) / span.h * scratch.c[r];
  write_joint_force_rows_at_end(world, m, scratch.right, span.h);
  kick(m, span.h);
  brake(m, span.h);
  if (!scratch.pattern.framed.empty() && are_unknown(m.mean_lambda)) {
    factor(m);
    solve(m, {scratch.momenta, scratch.right}, {scratch.solution, scratch.lambda});
    store_lambda(m, scratch.lambda, 1 / span.h);
  }
  add_geometric_stiffness(m, span.h);
  factor(m);
  const auto solve_now = [&] {
    solve(m, {scratch.momenta, scratch.right}, {scratch.solution, scratch.lambda});
  };
  solve_now();
  settle_grips(m, span.h, scratch.momenta, solve_now);
  scratch.springs_active = false;
  if (!m.joint_forces.empty() && !scratch.in_parts)
    std::fill(scratch.weights.begin(), scratch.weights.end(), 0.0);
  store_lambda(m, scratch.lambda, 1 / span.h);
  finish(m, span.h);
  return true;
}

}  // namespace

const IntegratorRow integrators::euler{.step = step_euler, .projection_moves = true};

}  // namespace pantin::detail::lagrangian
