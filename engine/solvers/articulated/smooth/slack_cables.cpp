// Inextensible cables in a step by the energy-momentum method: when they become taut or slack.
#include "engine/solvers/articulated/smooth/conserving_ties.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::uint32_t kNobody = UINT32_MAX;
/// Fraction of the island's kinetic energy: an impact that dissipates more is resolved in time.
constexpr Real kMuch = 0.01;

/// At the start of the substep: rate of stretch of a cable, m/s; kinetic energy of the island, J.
Real rate_before(const TiedStep& s, const ConservingTie& t) {
  const auto at = [&](std::uint32_t c, Vec3 anchor) {
    const Body& b = s.body(c);
    return b.velocity + glm::cross(b.angular_velocity,
                                   b.pose.rotation * (anchor + s.a.constants.vec(kOwnAnchor, c)));
  };
  const Vec3 of_a = t.a != kNobody ? at(t.a, t.anchor_a) : t.velocity;
  return glm::dot(at(t.b, t.anchor_b) - of_a, glm::normalize(t.before));
}
Real kinetic_energy(const TiedStep& s) {
  Real energy = 0;
  for (std::uint32_t c = 0; c < s.a.count(); ++c) {
    const Body& b = s.body(c);
    const Vec3 w = glm::conjugate(b.pose.rotation) * b.angular_velocity;
    energy += 0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(w, b.inertia * w));
  }
  return energy;
}

/// Impulse of a taut cable; negative if it would push.
Real pull_of(const ConservingTie& t) {
  return t.kind == TieKind::taut ? glm::dot(t.mu, direction_of(CableSpan<Vec3>{t.before, t.now}))
                                 : 0;
}

/// Whether the substep has to end at this fraction of it; sets TiedPart::shorter then.
bool ends_at(const TiedStep& s, Real fraction) {
  const Real units = fraction * s.with.units;
  if (!(fraction < 1) || !(s.with.units - units > 1)) return false;
  s.with.shorter = std::ceil(std::max(units, Real(1)));
  return true;
}

}  // namespace

bool has_to_change(const TiedStep& s, const ConservingTie& t) {
  const Real near = kAtLength * s.a.size;
  if (t.kind == TieKind::taut) return pull_of(t) * t.softness < -s.a.scratch.tie_yield * near;
  return t.kind == TieKind::slack && !t.followed && over(t) > near;
}
void change(ConservingTie& t) {
  PANTIN_ASSERT(t.kind == TieKind::taut || t.kind == TieKind::slack);
  t.kind = t.kind == TieKind::taut ? TieKind::slack : TieKind::taut;
  t.mu = Vec3(0), t.softness = 0;
}

bool is_hit_early(const TiedStep& s) {
  StepScratch& r = s.a.scratch;
  const Real near = kAtLength * s.a.size;
  Real kinetic = 0, first = 1;
  for (ConservingTie& t : r.ties) {
    const Real before = glm::length(t.before) - t.length;
    if (t.kind != TieKind::taut || t.was_taut) continue;
    s.with.struck = true;
    if (!(before < -near) || s.with.units <= 1 || !s.with.may_end_early) continue;
    if (kinetic == 0) kinetic = kinetic_energy(s);
    const Real rate = rate_before(s, t), mass = s.h * r.tie_yield / t.softness;
    if (!(0.5 * mass * rate * rate > kMuch * kinetic)) continue;
    PANTIN_ASSERT(t.cable < r.cable_rows.size());
    r.cable_rows[t.cable] = CableRow::followed;
    first = std::min(first, -before / (rate * s.h));
  }
  return ends_at(s, first);
}

bool has_to_end_early(const TiedStep& s) {
  if (is_hit_early(s)) return true;
  StepScratch& r = s.a.scratch;
  const Real near = kAtLength * s.a.size;
  Real first = 1;
  for (const ConservingTie& t : r.ties) {
    if (!t.followed || !(over(t) > near)) continue;
    const Real before = glm::length(t.before) - t.length;
    first = std::min(first, before / (before - over(t)));
  }
  if (ends_at(s, first)) return true;
  for (ConservingTie& t : r.ties)
    if (t.followed && over(t) > near) t.kind = TieKind::taut, t.strikes = s.with.struck = true;
  return false;
}

}  // namespace pantin::detail::articulated
