// Generalised alpha on positions, twists and multipliers; stiff efforts along freedoms are unknowns
// of their own, met at the end of the step. [Chung & Hulbert 1993; Bruels & Cardona 2010]
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::lagrangian {
namespace {

constexpr int kMostIterations = 40;
/// Iterations by tangents; what has not converged then goes on by secants, which cannot cycle.
constexpr int kNewton = 6;

struct Weights {
  Real am, af, gamma, beta;
};

Weights weights_of(Real rho) {
  Weights w{};
  w.am = (2 * rho - 1) / (rho + 1), w.af = rho / (rho + 1);
  w.gamma = 0.5 + w.af - w.am;
  w.beta = 0.25 * (w.gamma + 0.5) * (w.gamma + 0.5);
  return w;
}

bool step_implicit(const World& world, Island& m, const Span& span) {
  StepScratch& room = m.room;
  Motions& s = room.state;
  const Real h = span.h;
  const Weights k = weights_of(m.settings.damping_ratio);
  const auto own = std::span(room.motion).first(2 * m.count());
  room.springs_bear = true;
  if (m.fresh) {
    // Springs act as forces for the start: their rows have no say in accelerations.
    place(m), place_frames(world, m, span.part(0), span.whole);
    write_all_rows(world, m, {true, true});
    meet_efforts(world, m, m.loads, 0, 0, false);
    std::fill(room.weights.begin(), room.weights.end(), 0.0);
    room.springs_bear = false;
    accelerate(world, m, span.part(0), span.whole);
    room.springs_bear = true;
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      if (m.blocks[i].kind != BlockKind::spring)
        for (std::size_t r = 0; r < m.blocks[i].rows; ++r)
          m.loads[m.blocks[i].first_row + r] = room.lambda[m.blocks[i].first_row + r];
    std::copy(own.begin(), own.end(), m.accelerations.begin());
    m.lagged = m.accelerations;
  }
  room.from = s;
  room.residuals = m.accelerations;  // the unknown accelerations, from those of the last step
  std::copy(m.loads.begin(), m.loads.end(), room.sum_lambda.begin());
  const Real by_way = h * h * k.beta * (1 - k.af) / (1 - k.am);
  const Real by_speed = h * k.gamma * (1 - k.af) / (1 - k.am);
  place_frames(world, m, span.part(1), span.whole);
  Real before = std::numeric_limits<Real>::infinity();
  bool closed = false;
  for (int n = 0; n < kMostIterations && !closed; ++n) {
    for (std::size_t b = 0; b < m.count(); ++b) {
      Vec3 way[2], twist[2];
      for (std::size_t i = 0; i < 2; ++i) {
        const Vec3 a0 = m.lagged[2 * b + i];
        const Vec3 a = ((1 - k.af) * room.residuals[2 * b + i] +
                        k.af * m.accelerations[2 * b + i] - k.am * a0) / (1 - k.am);
        const Vec3 v0 = i == 0 ? room.from.v[b] : room.from.w[b];
        way[i] = h * (v0 + h * ((0.5 - k.beta) * a0 + k.beta * a));
        twist[i] = v0 + h * ((1 - k.gamma) * a0 + k.gamma * a);
      }
      s.x[b] = room.from.x[b] + way[0];
      s.q[b] = glm::normalize(turn_by(way[1]) * room.from.q[b]);
      s.v[b] = twist[0], s.w[b] = twist[1];
    }
    place(m);
    write_all_rows(world, m, {true, false});
    add_forces(world, m, true);
    std::fill(room.right.begin(), room.right.end(), 0.0);
    meet_efforts(world, m, room.right, by_way, by_speed, n >= kNewton);
    // M a - J^T lambda - f, as a force that is missing.
    Real missing = 0, scale = 1e-300, open = 0;
    for (std::size_t b = 0; b < m.count(); ++b) {
      const Placed& at = room.placed[b];
      const Vec3 turn = at.turn * (m.inertia[b] * (room.residuals[2 * b + 1] * at.turn));
      const Vec3 ma[2] = {m.mass[b] * room.residuals[2 * b], turn};
      for (std::size_t i = 0; i < 2; ++i) {
        scale = std::max({scale, glm::length(ma[i]), glm::length(room.force[2 * b + i])});
        room.momenta[2 * b + i] = room.force[2 * b + i] - ma[i];
      }
    }
    for (std::size_t i = 0; i < m.blocks.size(); ++i) {
      const Block& b = m.blocks[i];
      const bool on = bears(m, i);
      for (std::size_t e = 0; e < b.count && on; ++e)
        if (b.body[e] < m.count())
          add_pull(b, jacobian_of(m, b), e, &room.sum_lambda[b.first_row],
                   &room.momenta[2 * b.body[e]]);
      for (std::size_t r = 0; r < b.rows; ++r) {
        const std::size_t row = b.first_row + r;
        const Real load = on ? room.sum_lambda[row] : 0;
        if (b.kind == BlockKind::spring) {
          const Real lack = room.right[row] - load;
          scale = std::max(scale, std::abs(load));
          missing = std::max(missing, std::abs(lack));
          room.right[row] = lack * room.weights[row];
        } else {
          open = on ? std::max(open, std::abs(room.c[row])) : open;
          room.right[row] = on ? -room.c[row] / by_way : 0;
        }
      }
    }
    for (const Vec3& f : room.momenta) missing = std::max(missing, glm::length(f));
    ++m.iterations;
    const Real worst = std::max(open / std::max(Real(1), m.size), 1e-3 * missing / scale);
    if (!std::isfinite(worst)) return false;
    closed = n > 0 && (worst <= 1e-13 || (worst <= 1e-10 && worst > 0.5 * before));
    if (closed) break;
    if (n == 0 || worst > 0.25 * before) factor(m, false);
    if (n > 12 && worst > 1e3 * before) return false;
    before = worst;
    // A correction is of the size of rounding in the end: what it lacks, part of that, says nothing.
    const Real lack = room.worst_lack;
    solve(m, room.momenta, room.right, room.correction, room.lambda);
    room.worst_lack = lack;
    for (std::size_t i = 0; i < 2 * m.count(); ++i) room.residuals[i] += room.correction[i];
    for (std::size_t r = 0; r < m.rows; ++r) room.sum_lambda[r] += room.lambda[r];
  }
  room.springs_bear = false;
  if (!closed) return false;
  for (std::size_t i = 0; i < 2 * m.count(); ++i) {
    const Vec3 a = ((1 - k.af) * room.residuals[i] + k.af * m.accelerations[i] -
                    k.am * m.lagged[i]) / (1 - k.am);
    m.lagged[i] = a, m.accelerations[i] = room.residuals[i];
  }
  std::copy(room.sum_lambda.begin(), room.sum_lambda.end(), m.loads.begin());
  std::fill(room.weights.begin(), room.weights.end(), 0.0);
  return all_within_bounds(m);
}

}  // namespace

// Its twists are not the sums of what acts: what hangs there would not be met.
const IntegratorRow integrators::implicit{.step = step_implicit,
                                          .turns_far = true,
                                          .carries_interfaces = false,
                                          .keeps_accelerations = true};

}  // namespace pantin::lagrangian
