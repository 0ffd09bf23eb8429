// Euler in momenta, semi-implicit.
#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/momenta.hpp"

namespace pantin::lagrangian {
namespace {

/// Drag as it will be at the end of the step in place of that at its start.
void brake(Island& m, Real h) {
  for (std::size_t b = 0; b < m.count(); ++b) {
    if (m.drag[b] == 0) continue;
    const Placed& at = m.room.placed[b];
    const Real part = 1 / (1 + h * m.drag[b]);
    Vec3* p = &m.room.momenta[2 * b];
    p[0] = part * (p[0] + h * m.drag[b] * m.mass[b] * at.velocity);
    p[1] = part * (p[1] + h * m.drag[b] * spin_momentum(at, m.inertia[b]));
  }
}

/// The mean spin of a free body of angular momentum `l` over `h` seconds: w = I(q at h/2)^-1 l.
Vec3 mean_spin(Quat q, Vec3 inertia, Vec3 l, Real h) {
  Vec3 w = q * ((glm::conjugate(q) * l) / inertia);
  for (int i = 0; i < 8; ++i) {
    const Quat half = turn_by(0.5 * h * w) * q;
    const Vec3 next = half * ((glm::conjugate(half) * l) / inertia);
    const Real change = glm::length(next - w);
    w = next;
    if (change <= 1e-14 * glm::length(w)) break;
  }
  return w;
}

void keep_loads(Island& m, std::span<const Real> lambda, Real factor_of) {
  for (std::size_t r = 0; r < m.rows; ++r) m.loads[r] = factor_of * lambda[r];
}

bool step_euler(const World& world, Island& m, const Span& span) {
  StepScratch& room = m.room;
  const bool draws = m.settings.stabilisation == Stabilisation::baumgarte;
  place(m);
  // Joints to frames are met where these will be: the step is implicit in what moves them.
  place_frames(world, m, span.part(1), span.whole);
  for (std::size_t n = m.count(); n < room.placed.size(); ++n) {
    // ... by their mean motion over the step.
    room.placed[n].position -= span.h * room.placed[n].velocity;
    room.placed[n].turn =
        glm::mat3_cast(turn_by(-span.h * room.placed[n].spin) * room.placed[n].rotation);
  }
  room.springs_bear = true;
  write_all_rows(world, m, {draws || !m.efforts.empty(), false});
  add_forces(world, m, false);
  right_of_rates(m);
  if (draws)
    for (const Block& b : m.blocks)
      for (std::size_t r = b.first_row; r < b.first_row + b.rows && b.kind != BlockKind::spring; ++r)
        room.right[r] -= rate_or_default(m, 0.2) / span.h * room.c[r];
  meet_efforts_at_end(world, m, room.right, span.h);
  factor(m, false);
  kick(m, span.h);
  brake(m, span.h);
  room.residuals = room.momenta;  // with the free motion's spin in place of its momentum
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Vec3 w = mean_spin(room.state.q[b], m.inertia[b], room.momenta[2 * b + 1], span.h);
    const Placed at{{}, {}, room.placed[b].turn, {}, w};
    room.residuals[2 * b + 1] = spin_momentum(at, m.inertia[b]);
  }
  solve(m, room.residuals, room.right, room.correction, room.lambda);
  push(m, room.jacobian, room.lambda, 1);
  room.springs_bear = false;
  if (!m.efforts.empty()) std::fill(room.weights.begin(), room.weights.end(), 0.0);
  keep_loads(m, room.lambda, 1 / span.h);
  Motions& s = room.state;
  for (std::size_t b = 0; b < m.count(); ++b) {
    s.v[b] = room.correction[2 * b];
    s.x[b] += span.h * s.v[b];
    s.q[b] = glm::normalize(turn_by(span.h * room.correction[2 * b + 1]) * s.q[b]);
    s.w[b] = s.q[b] * ((glm::conjugate(s.q[b]) * room.momenta[2 * b + 1]) / m.inertia[b]);
  }
  return true;
}

}  // namespace

const IntegratorRow integrators::euler{.step = step_euler};

}  // namespace pantin::lagrangian
