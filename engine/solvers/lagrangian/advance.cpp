// As far as asked by the integrator chosen: in halves where the step is too long for it, by steps
// within a tolerance, by Euler where nothing else helps.
#include <algorithm>

#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::lagrangian {
namespace {

constexpr int kMostHalvings = 6, kMostSteps = 200000;
/// More steps of the integrator than this make no step: it is given up and told.
constexpr int kMostParts = 1000;
/// Residual that a step of Runge-Kutta may leave to the projection, part of the way of bodies.
constexpr Real kMostOpened = 0.05;
/// Steps that Euler takes before the integrator is tried again, and how often it is halved then.
constexpr int kPatience = 8, kRetries = 3;
/// Bodies that turn farther in a step, rad, have it halved; not by the implicit integrator.
constexpr Real kMostTurn = 0.5;
/// Steps squared times springs, and twice steps times dampers, over what they move.
constexpr Real kStiff = 4;

/// Whether joints were opened by little beside the way that bodies went. A step of high order that
/// opens more passes a place where rows nearly depend on one another: it may end on another branch.
bool keeps_joints(const Island& m, Real h) {
  Real speed = 0;
  for (std::size_t b = 0; b < m.count(); ++b)
    speed = std::max(speed,
                     glm::length(m.room.state.v[b]) + m.reach * glm::length(m.room.state.w[b]));
  return m.room.opened <= std::max(kMostOpened * h * speed, 1e-9 * m.size);
}

void add_loads(Island& m, Real h) {
  for (std::size_t r = 0; r < m.rows; ++r) m.room.impulses[r] += h * m.loads[r];
}

/// One step of the integrator, projected. False: not taken.
bool integrate(const World& world, Island& m, const Span& span, const IntegratorRow& by) {
  const bool done = by.step(world, m, span);
  ++m.parts;
  if (!done || !all_within_bounds(m)) return false;
  m.fresh = false;
  add_loads(m, span.h);
  // Ends on its joints by itself, or so near that rounding keeps it off.
  if (by.ends_on_joints && m.residual <= tolerance_of(m)) return true;
  if (m.settings.stabilisation == Stabilisation::projection)
    return project(world, m, span.part(1), span.whole) && all_within_bounds(m) &&
           (!by.may_open_joints || keeps_joints(m, span.h));
  place(m), place_frames(world, m, span.part(1), span.whole);
  write_all_rows(world, m, {true, false});
  m.residual = worst_residual(m);
  return all_within_bounds(m);
}

/// Steps that tell their error, each within the tolerance. False: they became too small.
bool integrate_adaptively(const World& world, Island& m, const Span& span,
                          const IntegratorRow& by) {
  const Real goal = m.settings.step_tolerance;
  Real done = 0, h = m.try_step > 0 ? m.try_step : span.h / 16;
  for (int n = 0; done < span.h * (1 - 1e-14); ++n) {
    if (n > kMostSteps || h < 1e-12 * span.h) return false;
    const bool last = done + h > span.h * (1 - 1e-12);
    const Real now = last ? span.h - done : h;
    m.room.start = m.room.state;
    const Real lack = m.room.worst_lack;
    Real error = 0;
    const Span part{span.from + done, now, span.whole};
    bool good = by.step_estimated(world, m, part, error);
    ++m.parts;
    const Real factor_of = good ? 0.9 * std::pow(goal / std::max(error, 1e-300), 0.2) : 0.1;
    good = good && error <= goal;
    if (good && m.settings.stabilisation == Stabilisation::projection)
      good = project(world, m, part.part(1), span.whole);
    if (good) {
      add_loads(m, now);
      done += now, m.fresh = false;
      if (!last || factor_of < 1) h = now * std::clamp(factor_of, 0.2, 5.0);
    } else {
      m.room.state = m.room.start, m.room.worst_lack = lack;
      h = now * std::clamp(factor_of, 0.1, 0.7);
    }
  }
  m.try_step = h;
  return true;
}

Real fastest_spin(const Island& m) {
  Real most = 0;
  for (const Vec3& w : m.room.state.w) most = std::max(most, glm::dot(w, w));
  return std::sqrt(most);
}

/// By one integrator, in halves where the step is too long for it: at most so many times halved.
bool go_by(const World& world, Island& m, const Span& span, const IntegratorRow& by,
           int most_halvings, int most_parts) {
  const bool bound = !by.turns_far;
  const Real fastest = bound ? fastest_spin(m) : 0;
  int parts = 1;
  while (parts < 64 && fastest * span.h > kMostTurn * parts) parts *= 2;
  if (!m.efforts.empty() && by.efforts_are_forces) {
    place(m), place_frames(world, m, span.part(0), span.whole);
    const Stiffness stiff = stiffness_of(world, m);
    const auto is_long = [&](Real h) {
      return h * h * stiff.spring + 2 * h * stiff.damper > kStiff;
    };
    while (parts < 64 && is_long(span.h / parts)) parts *= 2;
    if (is_long(span.h / parts)) return false;
  }
  for (int halvings = 0;; parts *= 2) {
    bool good = true;
    for (int i = 0; i < parts && good; ++i)
      good = integrate(world, m, {span.from + i * span.h / parts, span.h / parts, span.whole},
                       by) &&
             (!bound || parts >= 64 || fastest_spin(m) * span.h <= 2 * kMostTurn * parts);
    if (good) return true;
    m.room.state = m.room.start, m.room.impulses = m.room.impulses_at_start;
    std::fill(m.loads.begin(), m.loads.end(), 0.0);
    m.fresh = true;
    if (++halvings > most_halvings || m.parts > most_parts) return false;
  }
}

/// The last resort: joints that stay open a little, what turns too fast for any step slowed down;
/// and if that does not help, from rest.
bool go_loosely(const World& world, Island& m, const Span& span) {
  Motions& s = m.room.state;
  for (Vec3& w : s.w)
    if (const Real turn = glm::length(w) * span.h; turn > 1) w /= turn;
  if (integrate(world, m, span, integrators::euler)) return true;
  s = m.room.start, m.room.impulses = m.room.impulses_at_start;
  std::fill(s.v.begin(), s.v.end(), Vec3(0)), std::fill(s.w.begin(), s.w.end(), Vec3(0));
  return integrate(world, m, span, integrators::euler);
}

}  // namespace

bool advance(const World& world, Island& m, const Span& span) {
  const IntegratorRow& asked = row_of(m.settings.integrator);
  const IntegratorRow& chosen =
      asked.carries_interfaces || m.interfaces.empty() ? asked : integrators::euler;
  if (chosen.step_estimated && m.settings.step_tolerance > 0)
    return integrate_adaptively(world, m, span, chosen);
  m.room.start = m.room.state, m.room.impulses_at_start = m.room.impulses;
  const int before = m.rescues;
  m.rescues = 0;
  // After a rescue there is less hope in halves, and none at once.
  if (before % kPatience == 0 &&
      go_by(world, m, span, chosen, before > 0 ? kRetries : kMostHalvings, kMostParts))
    return true;
  const bool by_halves = &chosen != &integrators::euler &&
                         go_by(world, m, span, integrators::euler, kMostHalvings, 2 * kMostParts);
  m.rescues = before + 1;
  if (!by_halves && !go_loosely(world, m, span)) return m.rescues = 0, false;
  m.fresh = chosen.keeps_accelerations;
  return true;
}

}  // namespace pantin::lagrangian
