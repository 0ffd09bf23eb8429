// Forces in a step of RATTLE: weights, springs, dampers, motors, limits, and belts that slip.
#include <algorithm>
#include <cmath>

#include "engine/solvers/planar/rattle.hpp"

namespace pantin::detail::planar {
namespace {

/// Of h^2 k / m and h d / m: stiffer elements act implicitly.
constexpr Real kStiffest = 0.25;
constexpr Real kImmobile = 1e-12;  // a coordinate with less mobility is locked

void push(Motions& m, const Row& row, Real impulse) {
  for (int i = 0; i < row.count; ++i)
    m.velocity[row.body[i]] += m.inverse_mass[row.body[i]] * (impulse * row.j[i]);
}

}  // namespace

void Rattle::find_springs() {
  bool any_stiff = false;
  springs_.clear();
  each_joint([&](const PlaneJoint& j) {
    const PlaneSpring& along = j.along;
    if (along.stiffness == 0 && along.damping == 0 && along.load == 0) return;
    const Row start = sprung_row(j, m_);
    Real light = 0;
    for (int i = 0; i < start.count; ++i)
      light += glm::dot(start.j[i] * m_.inverse_mass[start.body[i]], start.j[i]);
    RattleSpring& made = springs_.emplace_back(RattleSpring{&j});
    const bool is_soft = h_ * h_ * along.stiffness * light < kStiffest;
    made.is_soft = is_soft && h_ * along.damping * light < kStiffest;
    made.damping = along.damping + (is_soft ? 0 : h_ * along.stiffness);
    any_stiff = any_stiff || !made.is_soft;
  });
  for (RattleSpring& spring : springs_)
    spring.is_soft = spring.is_soft && !(any_stiff && spring.damping > 0);
}

/// Applies forces at one end of the substep, for half of its length.
void Rattle::kick(End at) {
  const Real half = 0.5 * h_;
  bool is_stiff = false;
  for (RattleSpring& spring : springs_) {
    const PlaneSpring& along = spring.joint->along;
    spring.row = sprung_row(*spring.joint, m_);
    spring.load = along.load - along.stiffness * spring.row.c;
    if (at == End::start && spring.is_soft)
      spring.load -= spring.damping * rate_of(spring.row, m_.velocity);
    is_stiff = is_stiff || (!spring.is_soft && spring.damping > 0);
  }
  std::vector<Real>& impulses = at == End::start ? first_ : impulse_;
  const RattleRows& rows = at == End::start ? start_ : now_;
  impulses.assign(rows.rows.size(), 0);
  if (!is_stiff) press(half, at);
  if (is_stiff || at == End::end) project(rows.rows, impulses);
  if (is_stiff) damp(at, impulses);
}

/// Applies forces of positions for a time; at the start those of soft dampers, too.
void Rattle::press(Real time, End at) {
  for (const std::uint32_t b : of_.bodies) {
    const PlaneBody& body = s_.plane.bodies[b];
    const Vec3 force = body.force + body.gravity_scale * body.mass * s_.plane.gravity;
    m_.velocity[b] += time * m_.inverse_mass[b] * Vec3(force.x, force.y, body.torque);
  }
  for (const RattleSpring& spring : springs_)
    if (spring.is_soft && (at == End::start || spring.damping == 0))
      push(m_, spring.row, time * spring.load);
  for (const std::uint32_t at_span : of_.spans) {
    const FlatSpan& span = all_.spans[at_span];
    if (span.slips != 0) push(m_, span_pull(world_, all_, span), time * grip(span));
  }
  for (const std::uint32_t drive : of_.drives)
    if (const FlatDrive& d = all_.drives[drive]; d.lag.yields)
      push(m_, drive_pull(world_, all_, d), time * d.lag.force);
}

/// N, the friction force of a slipping span.
Real Rattle::grip(const FlatSpan& span) const {
  return span.slips * grip_of(world_.belts.values()[span.belt]);
}

/// Solves for velocities along rows, the last of which are compliant, and adds the impulses.
void Rattle::solve_rates(const Factor& factor, std::span<const Row> rows,
                         std::vector<Real>& impulses) {
  const std::size_t hard = rows.size() - work_.wanted.size();
  std::vector<Real>& borne = work_.stage;
  borne.assign(rows.size(), 0);
  for (int n = 0; n < 2; ++n) {
    step_.resize(rows.size());
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const bool gives = r >= hard;
      step_[r] = lack_of(rows[r], m_.velocity);
      if (gives) step_[r] += work_.wanted[r - hard] - rows[r].soft * borne[r];
    }
    factor.solve(step_);
    for (std::size_t r = 0; r < rows.size(); ++r) borne[r] += step_[r], push(m_, rows[r], step_[r]);
  }
  for (std::size_t r = 0; r < hard; ++r) impulses[r] += borne[r];
}

/// The rows of one end, and the compliant rows of springs that act for `time`.
std::vector<Row>& Rattle::damped_rows(std::span<const Row> rows, Real time, Which which) {
  std::vector<Row>& all = work_.damped_rows;
  all.assign(rows.begin(), rows.end()), soften(all, kGives);
  work_.damped.clear(), work_.wanted.clear();
  for (const RattleSpring& spring : springs_) {
    if (!(spring.damping > 0) || spring.is_soft != (which == Which::soft)) continue;
    work_.damped.push_back(static_cast<std::uint32_t>(spring.joint - s_.plane.joints.data()));
    all.push_back(sprung_row(*spring.joint, m_));
    all.back().soft = 1 / (time * spring.damping);
    work_.wanted.push_back(spring.load / spring.damping);
  }
  return all;
}

void Rattle::prepare(DampedFactor& factor, std::span<const Row> rows) const {
  if (!factor.fits(rows.size()) || factor.damped != work_.damped)
    factor.analyse(rows, m_.inverse_mass), factor.damped = work_.damped;
  factor.compute(rows, m_.inverse_mass);
}

/// Projects velocities onto the rows of one end; at the end of the step with soft dampers.
void Rattle::project(std::span<const Row> hard, std::vector<Real>& impulses) {
  const std::vector<Row>& rows = damped_rows(hard, 0.5 * h_, Which::soft);
  prepare(of_.velocities, rows);
  solve_rates(of_.velocities, rows, impulses);
}

/// Applies forces and stiff elements together for half of the substep, from velocities that satisfy
/// the rows: implicitly, in two stages, of order 2 and L-stable. [Alexander 1977]
void Rattle::damp(End at, std::vector<Real>& impulses) {
  constexpr Real kStage = 1 - 0.70710678118654752440, kOn = (1 - kStage) / kStage - 1;
  const std::vector<Row>& hard = at == End::start ? start_.rows : now_.rows;
  const Real time = 0.5 * h_;
  const std::vector<Row>& rows = damped_rows(hard, kStage * time, Which::stiff);
  prepare(of_.damping, rows);
  if (rows.size() == hard.size() + 1) return relax(at, impulses);
  note_velocities(free_velocity_);
  press(kStage * time, at);
  solve_rates(of_.damping, rows, impulses);
  for (std::size_t i = 0; i < of_.bodies.size(); ++i) {
    Vec3& velocity = m_.velocity[of_.bodies[i]];
    velocity += kOn * (velocity - free_velocity_[i]);
  }
  for (std::size_t r = 0; r < hard.size(); ++r) impulses[r] += kOn * work_.stage[r];
  press(kStage * time, at);
  solve_rates(of_.damping, rows, impulses);
}

/// A single damper by its closed form: the rate of its row approaches the equilibrium of forces and
/// damper like exp(-t d / m).
void Rattle::relax(End at, std::vector<Real>& impulses) {
  const Real time = 0.5 * h_;
  const Row row = work_.damped_rows.back();
  const Real asked = work_.wanted[0];
  const std::size_t last = impulses.size();
  const RattleSpring& spring = *std::ranges::find_if(
      springs_, [](const RattleSpring& s) { return !s.is_soft && s.damping > 0; });
  step_.assign(last + 1, 0), step_[last] = 1;
  of_.damping.solve(step_);
  work_.answer = step_;
  const Real gained = 1 - row.soft * step_[last];  // by its rate
  const Real before = rate_of(row, m_.velocity);
  press(time, at);
  project(at == End::start ? start_.rows : now_.rows, impulses);
  if (!(gained > kImmobile)) return;
  const Real way = time * spring.damping * gained / work_.answer[last];
  const Real rate = rate_of(row, m_.velocity), end = asked + (rate - before) / way;
  const Real part = (end + (before - end) * std::exp(-way) - rate) / gained;
  const std::vector<Row>& hard = at == End::start ? start_.rows : now_.rows;
  for (std::size_t r = 0; r < last; ++r)
    push(m_, hard[r], part * work_.answer[r]), impulses[r] += part * work_.answer[r];
  push(m_, row, part * work_.answer[last]);
}

/// Finds the joint limits that are reached at the start of the substep.
void Rattle::find_limits() {
  limits_.clear();
  const Real near = kAccepted * size_;
  each_joint([&](const PlaneJoint& j) {
    if (!j.limited) return;
    const Real x = sprung_row(j, m_).c;
    limits_.push_back({&j, x <= j.low + near ? -1 : x >= j.high - near ? 1 : 0});
  });
}

void Rattle::append_limit_rows(std::vector<Row>& rows) const {
  for (const RattleLimit& limit : limits_) {
    Row row = sprung_row(*limit.joint, m_);
    if (limit.side == 0) row.j = {}, row.c = 0;
    if (limit.side < 0) row.c -= limit.joint->low;
    if (limit.side > 0) {
      for (Vec3& j : row.j) j = -j;
      row.c = limit.joint->high - row.c;
    }
    rows.push_back(row);
  }
}

/// Whether a limit was reached in an iteration, or released.
bool Rattle::switch_limits(int looks) {
  bool changed = false;
  for (std::size_t i = 0; i < limits_.size(); ++i) {
    RattleLimit& limit = limits_[i];
    const Row& row = now_.rows[now_.first_limit + i];
    const bool met = limit.side != 0;
    const std::size_t at = now_.first_limit + i;
    if (met && lambda_[at] + h_ * first_[at] < 0 && std::abs(row.c) < kAccepted * size_)
      limit.side = 0, changed = true;
    if (met || looks < 0) continue;
    const Real x = sprung_row(*limit.joint, m_).c;
    limit.side = x < limit.joint->low - kClosed * size_    ? -1
                 : x > limit.joint->high + kClosed * size_ ? 1
                                                           : 0;
    changed = changed || limit.side != 0;
  }
  return changed;
}

/// Lets drives yield whose force would exceed their maximum. Whether any does from now on.
bool Rattle::yield_drives(StepOutcome outcome) {
  return yield_any(outcome, [&](auto&& look) {
    for (const std::uint32_t at : of_.drives) {
      FlatDrive& d = all_.drives[at];
      const DriveNeed need{d.impulse / whole_, 0, outcome == StepOutcome::failed};
      look(world_.joint_drives.values()[d.drive], need, d.lag);
    }
  });
}

/// Lets spans slip whose force would exceed their belts' friction. Whether any did.
bool Rattle::overloads() {
  bool any = false;
  for (std::size_t i = 0; i < of_.spans.size(); ++i) {
    FlatSpan& span = all_.spans[of_.spans[i]];
    const Belt& belt = world_.belts.values()[span.belt];
    const Real impulse = of_.span_loads[i].impulse;
    if (!(belt.friction > 0) || !(std::abs(impulse) > grip_of(belt) * whole_)) continue;
    span.slips = impulse < 0 ? -1 : 1, any = true;
  }
  return any;
}

}  // namespace pantin::detail::planar
