// Explicit steps: Euler in momenta, RATTLE, Runge-Kutta.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::lagrangian {
namespace {

constexpr int kMostIterations = 40;
/// Rates times the step that Runge-Kutta is let meet, and changes of speed too small to matter:
/// squares, part of all.
constexpr Real kFastest = 2, kUnfelt = 1e-6, kTurning = 2.5e-3;

/// L = R I R^T w.
Vec3 spin_momentum(const Placed& at, Vec3 inertia) {
  return at.turn * (inertia * (at.spin * at.turn));
}

/// Momenta of all bodies as placed, plus `h` times the forces.
void kick(Island& m, Real h) {
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Placed& at = m.room.placed[b];
    m.room.momenta[2 * b] = m.mass[b] * at.velocity + h * m.room.force[2 * b];
    m.room.momenta[2 * b + 1] =
        spin_momentum(at, m.inertia[b]) + h * m.room.force[2 * b + 1];
  }
}

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

void keep_loads(Island& m, std::span<const Real> lambda, Real factor_of) {
  for (std::size_t r = 0; r < m.rows; ++r) m.loads[r] = factor_of * lambda[r];
}

/// Adds J^T (scale lambda) of the given Jacobian to the momenta.
void push(Island& m, const std::vector<Vec3>& jacobian, std::span<const Real> lambda,
          Real scale) {
  for (const Block& b : m.blocks) {
    Real load[6];
    for (std::size_t r = 0; r < b.rows; ++r) load[r] = scale * lambda[b.first_row + r];
    for (std::size_t k = 0; k < b.count; ++k)
      if (b.body[k] < m.count())
        add_pull(b, &jacobian[b.first_vector], k, load, &m.room.momenta[2 * b.body[k]]);
  }
}

Real rate_or_default(const Island& m, Real standard) {
  return m.settings.baumgarte > 0 ? m.settings.baumgarte : standard;
}

void right_of_rates(Island& m) {
  std::fill(m.room.right.begin(), m.room.right.end(), 0.0);
  take_known(m, m.room.right, false);
}

}  // namespace

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

void accelerate(const World& world, Island& m, Real part, Real whole) {
  StepScratch& room = m.room;
  const bool draws = m.settings.stabilisation == Stabilisation::baumgarte;
  place(m), place_frames(world, m, part, whole);
  write_all_rows(world, m, {draws, true});
  add_forces(world, m, true);
  factor(m, false);
  std::copy(room.gamma.begin(), room.gamma.end(), room.right.begin());
  take_known(m, room.right, true);
  if (draws) {
    const Real rate = rate_or_default(m, 5);
    for (const Block& b : m.blocks)
      for (std::size_t r = 0; r < b.rows; ++r)
        room.right[b.first_row + r] -=
            2 * rate * rate_of(m, b, r) + rate * rate * room.c[b.first_row + r];
  }
  solve(m, room.force, room.right, std::span(room.motion).first(2 * m.count()), room.lambda);
}

namespace {

/// A table of an explicit Runge-Kutta method.
struct Table7 {
  int stages;
  Real c[7], a[7][6], b[7], lower[7];
};

constexpr Table7 kClassic{4,
                          {0, 0.5, 0.5, 1},
                          {{}, {0.5}, {0, 0.5}, {0, 0, 1}},
                          {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6},
                          {}};
/// [Dormand & Prince 1980]
constexpr Table7 kPair{
    7,
    {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1},
    {{},
     {1.0 / 5},
     {3.0 / 40, 9.0 / 40},
     {44.0 / 45, -56.0 / 15, 32.0 / 9},
     {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
     {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
     {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}},
    {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84, 0},
    {5179.0 / 57600, 0, 7571.0 / 16695, 393.0 / 640, -92097.0 / 339200, 187.0 / 2100, 1.0 / 40}};

/// state = from + h sum of weight_i rates_i.
void combine(Island& m, const Real* weights, int count, Real h) {
  StepScratch& room = m.room;
  for (std::size_t b = 0; b < m.count(); ++b) {
    Vec3 x(0), v(0), w(0);
    Quat q(0, 0, 0, 0);
    for (int i = 0; i < count; ++i) {
      if (weights[i] == 0) continue;
      const Vec3* rate = &room.rates[i][3 * b];
      x += weights[i] * rate[0], v += weights[i] * rate[1], w += weights[i] * rate[2];
      q += weights[i] * room.quat_rates[i][b];
    }
    room.state.x[b] = room.from.x[b] + h * x;
    room.state.v[b] = room.from.v[b] + h * v;
    room.state.w[b] = room.from.w[b] + h * w;
    room.state.q[b] = glm::normalize(room.from.q[b] + h * q);
  }
}

bool runge_kutta(const World& world, Island& m, const Span& span, const Table7& t) {
  StepScratch& room = m.room;
  room.from = room.state;
  std::fill(m.loads.begin(), m.loads.end(), 0.0);
  for (int i = 0; i < t.stages; ++i) {
    if (i > 0) combine(m, t.a[i], i, span.h);
    accelerate(world, m, span.part(t.c[i]), span.whole);
    for (std::size_t b = 0; b < m.count(); ++b) {
      room.rates[i][3 * b] = room.state.v[b];
      room.rates[i][3 * b + 1] = room.motion[2 * b];
      room.rates[i][3 * b + 2] = room.motion[2 * b + 1];
      room.quat_rates[i][b] = Quat(0, 0.5 * room.state.w[b]) * room.state.q[b];
    }
    for (std::size_t r = 0; r < m.rows; ++r) m.loads[r] += t.b[i] * room.lambda[r];
  }
  combine(m, t.b, t.stages, span.h);
  return all_within_bounds(m);
}

/// Whether the step just taken is too long for the fastest motion there is: its rate is about
/// 2 |k3 - k2| / (h |k2 - k1|) [Hairer & Wanner II, sec. IV.2], and the method grows beyond 2.8 / h.
/// All bodies count alike: what is light moves fastest. Where motion turns back k2 is k1; a part of
/// k1 itself stands in for the difference.
bool is_unstable(const World& world, const Island& m, Real h) {
  const StepScratch& room = m.room;
  const Real fall = glm::dot(world.gravity, world.gravity) * static_cast<Real>(m.count());
  Real start = 0, first = 0, second = 0, moving = 0;
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Real arm2 = (m.inertia[b].x + m.inertia[b].y + m.inertia[b].z) / (3 * m.mass[b]);
    const auto size = [&](Vec3 v, Vec3 w) { return glm::dot(v, v) + arm2 * glm::dot(w, w); };
    const Vec3* k[3] = {&room.rates[0][3 * b], &room.rates[1][3 * b], &room.rates[2][3 * b]};
    start += size(k[0][1], k[0][2]);
    first += size(k[1][1] - k[0][1], k[1][2] - k[0][2]);
    second += size(k[2][1] - k[1][1], k[2][2] - k[1][2]);
    moving += size(room.state.v[b], room.state.w[b]);
  }
  return 4 * second > kFastest * kFastest * (first + kTurning * start) &&
         h * h * second > kUnfelt * (moving + h * h * (start + fall));
}

}  // namespace

bool step_rk4(const World& world, Island& m, const Span& span) {
  return runge_kutta(world, m, span, kClassic) && !is_unstable(world, m, span.h);
}

bool step_rk54(const World& world, Island& m, const Span& span, Real& error) {
  StepScratch& room = m.room;
  if (!runge_kutta(world, m, span, kPair)) return false;
  error = 0;
  for (std::size_t b = 0; b < m.count(); ++b) {
    Vec3 x(0), v(0), w(0);
    Quat q(0, 0, 0, 0);
    for (int i = 0; i < kPair.stages; ++i) {
      const Real e = span.h * (kPair.b[i] - kPair.lower[i]);
      const Vec3* rate = &room.rates[i][3 * b];
      x += e * rate[0], v += e * rate[1], w += e * rate[2];
      q += e * room.quat_rates[i][b];
    }
    for (const Real part : {glm::length(x), glm::length(v), glm::length(w), 2 * glm::length(q)})
      error = std::max(error, part);
  }
  return std::isfinite(error);
}

}  // namespace pantin::lagrangian
