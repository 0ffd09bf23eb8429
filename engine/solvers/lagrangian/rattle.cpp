// RATTLE: symplectic and reversible.
#include <limits>

#include "engine/solvers/lagrangian/momenta.hpp"

namespace pantin::lagrangian {
namespace {

constexpr int kMostIterations = 40;

/// Free rotation over `h`: turns about the body's axes one after the other and back, symplectic and
/// reversible. `l` in body axes. [McLachlan 1993; Reich 1994]
void rotate_freely(Quat& q, Vec3& l, Vec3 inertia, Real h) {
  constexpr int kAxis[] = {2, 1, 0, 1, 2};
  constexpr Real kPart[] = {0.5, 0.5, 1, 0.5, 0.5};
  for (int i = 0; i < 5; ++i) {
    const int axis = kAxis[i], next = (axis + 1) % 3, last = (axis + 2) % 3;
    const Real half = 0.5 * kPart[i] * h * l[axis] / inertia[axis];
    const Real ch = std::cos(half), sh = std::sin(half);
    const Real c = 1 - 2 * sh * sh, s = 2 * sh * ch;
    const Real a = l[next], b = l[last];
    l[next] = c * a + s * b, l[last] = c * b - s * a;
    Vec3 way(0);
    way[axis] = sh;
    q = q * Quat(ch, way);
  }
  q = glm::normalize(q);
}

bool step_rattle(const World& world, Island& m, const Span& span) {
  StepScratch& room = m.room;
  Motions& s = room.state;
  const Real h = span.h, enough = tolerance_of(m);
  place(m), place_frames(world, m, span.part(0), span.whole);
  write_all_rows(world, m, {false, false});
  add_forces(world, m, false);
  factor(m, false);
  kick(m, h / 2);
  room.jacobian_before = room.jacobian;
  room.residuals = room.momenta;
  room.from = s;
  place_frames(world, m, span.part(1), span.whole);
  std::copy(m.loads.begin(), m.loads.end(), room.sum_lambda.begin());
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (!bears(m, i)) room.sum_lambda[m.blocks[i].first_row] = 0;
  Real before = std::numeric_limits<Real>::infinity();
  bool closed = false;
  for (int n = 0; n < kMostIterations && !closed; ++n) {
    room.momenta = room.residuals;
    push(m, room.jacobian_before, room.sum_lambda, h / 2);
    for (std::size_t b = 0; b < m.count(); ++b) {
      s.x[b] = room.from.x[b] + h / m.mass[b] * room.momenta[2 * b];
      s.q[b] = room.from.q[b];
      Vec3 l = glm::conjugate(s.q[b]) * room.momenta[2 * b + 1];
      rotate_freely(s.q[b], l, m.inertia[b], h);
      room.momenta[2 * b + 1] = s.q[b] * l;
      s.v[b] = room.momenta[2 * b] / m.mass[b], s.w[b] = s.q[b] * (l / m.inertia[b]);
    }
    place(m);
    write_all_rows(world, m, {true, false});
    const Real worst = worst_residual(m);
    ++m.iterations;
    if (!std::isfinite(worst)) return false;
    closed = worst <= enough || (worst <= 1e3 * enough && worst > 0.5 * before);
    const Real last = before;
    before = worst;
    if (closed) break;
    if (n > 0 && worst > 0.25 * last) factor(m, false);
    if (n > 12 && worst > 1e3 * last) return false;
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      for (std::size_t r = 0; r < m.blocks[i].rows; ++r) {
        const std::size_t row = m.blocks[i].first_row + r;
        room.right[row] = bears(m, i) ? -2 / (h * h) * room.c[row] : 0;
      }
    loads_for(m, room.right, room.step_lambda);
    for (std::size_t r = 0; r < m.rows; ++r) room.sum_lambda[r] += room.step_lambda[r];
  }
  if (!closed) return false;
  m.residual = before;
  factor(m, true);
  room.residuals = room.momenta;
  // Forces that depend on the motion need the motion they make: once more with it.
  for (int n = 0; n < (m.damped ? 3 : 1); ++n) {
    add_forces(world, m, false);
    for (std::size_t i = 0; i < room.momenta.size(); ++i)
      room.momenta[i] = room.residuals[i] + h / 2 * room.force[i];
    right_of_rates(m);
    solve(m, room.momenta, room.right, room.correction, room.lambda);
    for (std::size_t b = 0; b < m.count(); ++b) {
      room.placed[b].velocity = s.v[b] = room.correction[2 * b];
      room.placed[b].spin = s.w[b] = room.correction[2 * b + 1];
    }
  }
  for (std::size_t r = 0; r < m.rows; ++r)
    m.loads[r] = 0.5 * room.sum_lambda[r] + room.lambda[r] / h;
  return true;
}

}  // namespace

const IntegratorRow integrators::rattle{
    .step = step_rattle, .ends_on_joints = true, .efforts_are_forces = true};

}  // namespace pantin::lagrangian
