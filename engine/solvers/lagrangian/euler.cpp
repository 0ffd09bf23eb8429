// Euler in momenta, semi-implicit.
#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/momenta.hpp"

namespace pantin::detail::lagrangian {
namespace {

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

/// Mean angular velocity of a free body with angular momentum `l` over `h` seconds: w = I(q at
/// h/2)^-1 l.
Vec3 mean_angular_velocity(Quat q, Vec3 inertia, Vec3 l, Real h) {
  Vec3 w = q * ((glm::conjugate(q) * l) / inertia);
  for (int i = 0; i < 8; ++i) {
    const Quat half = from_rotation_vector(0.5 * h * w) * q;
    const Vec3 next = half * ((glm::conjugate(half) * l) / inertia);
    const Real change = glm::length(next - w);
    w = next;
    if (change <= 1e-14 * glm::length(w)) break;
  }
  return w;
}

void store_lambda(Island& m, std::span<const Real> lambda, Real factor_of) {
  for (std::size_t r = 0; r < m.rows; ++r) m.mean_lambda[r] = factor_of * lambda[r];
}

bool step_euler(const World& world, Island& m, const Span& span) {
  StepScratch& scratch = m.scratch;
  const bool draws = m.settings.stabilisation == Stabilisation::baumgarte;
  update_kinematics(m);
  // Frames are evaluated at the end of the step: implicit in their motion.
  update_frames(world, m, span.fraction(1), span.whole);
  for (std::size_t n = m.count(); n < scratch.body_states.size(); ++n) {
    // Their poses at the start of the step, from the mean motion.
    scratch.body_states[n].position -= span.h * scratch.body_states[n].velocity;
    scratch.body_states[n].rotation_matrix =
        glm::mat3_cast(from_rotation_vector(-span.h * scratch.body_states[n].angular_velocity) *
                       scratch.body_states[n].rotation);
  }
  scratch.springs_active = true;
  write_all_rows(world, m, {draws || !m.joint_forces.empty(), false});
  add_forces(world, m, Torques::applied);
  right_of_rates(m);
  if (draws)
    for (const Block& b : m.blocks)
      for (std::size_t r = b.first_row; r < b.first_row + b.rows && b.kind != BlockKind::spring;
           ++r)
        scratch.right[r] -= rate_or_default(m, 0.2) / span.h * scratch.c[r];
  write_joint_force_rows_at_end(world, m, scratch.right, span.h);
  factor(m);
  kick(m, span.h);
  brake(m, span.h);
  // The rows see the mean angular velocity of the free motion: momenta that give it.
  scratch.momenta_before = scratch.momenta;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Vec3 w =
        mean_angular_velocity(scratch.state.q[b], m.inertia[b], scratch.momenta[2 * b + 1], span.h);
    const BodyState at{{}, {}, scratch.body_states[b].rotation_matrix, {}, w};
    scratch.momenta_before[2 * b + 1] = angular_momentum(at, m.inertia[b]);
  }
  solve(m, {scratch.momenta_before, scratch.right}, {scratch.solution, scratch.lambda});
  push(m, scratch.jacobian, scratch.lambda, 1);
  scratch.springs_active = false;
  if (!m.joint_forces.empty()) std::fill(scratch.weights.begin(), scratch.weights.end(), 0.0);
  store_lambda(m, scratch.lambda, 1 / span.h);
  Motions& s = scratch.state;
  for (std::size_t b = 0; b < m.count(); ++b) {
    s.v[b] = scratch.solution[2 * b];
    s.x[b] += span.h * s.v[b];
    s.q[b] = glm::normalize(from_rotation_vector(span.h * scratch.solution[2 * b + 1]) * s.q[b]);
    s.w[b] = s.q[b] * ((glm::conjugate(s.q[b]) * scratch.momenta[2 * b + 1]) / m.inertia[b]);
  }
  return true;
}

}  // namespace

const IntegratorRow integrators::euler{.step = step_euler};

}  // namespace pantin::detail::lagrangian
