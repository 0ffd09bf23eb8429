// Events of surface joints besides impacts: when a contact opens, and when rolling begins to slip.
// Also corrects steps that end in penetration although the surfaces did not approach.
#include <algorithm>

#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// m/s: closing-speed tolerance. Surfaces that separate no slower than this do not count as
/// closing.
constexpr Real kClosingSpeed = 1e-3;
/// m: tolerance of penetration, as of limits.
constexpr Real kPenetration = 1e-9;
/// Fraction of the largest force; smaller forces are rounding.
constexpr Real kForceRounding = 1e-9;

bool may_lift(const Island& m, std::size_t block) {
  return m.blocks[block].kind == BlockKind::surface && !m.blocks[block].lock;
}
bool is_within(const Island& m, std::size_t block) {
  return may_lift(m, block) && !m.memory[block].active &&
         m.scratch.c[m.blocks[block].first_row] < -kPenetration;
}

/// N: stands for "no limit here".
constexpr Real kNothing = 1e300;
/// Force left before a unilateral row becomes tensile, or before its friction slips, N or N m.
Real left_of(const Island& m, std::size_t block, std::span<const Real> lambda) {
  if (is_one_sided(m, block) && is_active(m, block)) return lambda[m.blocks[block].first_row];
  return grip_left(m, block, lambda);
}

Real largest(std::span<const Real> forces) {
  Real most = 0;
  for (const Real force : forces) most = std::max(most, std::abs(force));
  return most;
}

/// Opening speed of the two bodies at a pair, m/s, with the current rows.
Real opening_speed(const Island& m, const Block& b) {
  const SurfaceFound& found = m.scratch.touching[b.first_place];
  const auto velocity = [&](std::size_t k, Vec3 point) {
    const BodyState& at = m.scratch.body_states[b.body[k]];
    return at.velocity + glm::cross(at.angular_velocity, point - at.position);
  };
  const Vec3 on_a = found.on_b + found.gap * found.normal;
  return glm::dot(found.normal, velocity(0, on_a) - velocity(1, found.on_b));
}

}  // namespace

void note_pulls(Island& m, const Span& span) {
  if (!m.unilateral || m.scratch.pulled_at < 1e300) return;
  const Real rounding = kForceRounding * largest(m.mean_lambda);
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (left_of(m, i, m.mean_lambda) < -rounding) m.scratch.pulled_at = span.from + span.h;
}

void note_ends(Island& m, Real end) {
  if (!m.unilateral || m.scratch.pulled_at <= end) return;
  const std::span<const Real> before = m.scratch.lambda_before;
  const Real rounding = kForceRounding * largest(before);
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    // The force at the end of a step is extrapolated from the means of the last two steps.
    const Real left = left_of(m, i, m.mean_lambda);
    if (left < kNothing && left < left_of(m, i, before) - left - rounding)
      m.scratch.pulled_at = end;
  }
}

Real least_left(const World& world, Island& m, Real part, Real whole) {
  accelerate(world, m, part, whole);
  Real least = kNothing;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    least = std::min(least, left_of(m, i, m.scratch.lambda));
  return least;
}

void let_go(const World& world, Island& m, Real part, Real whole) {
  const Real least = std::max(least_left(world, m, part, whole), Real(0));
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (left_of(m, i, m.scratch.lambda) > least) continue;
    if (may_lift(m, i) || may_slip(m.blocks[i]))
      m.scratch.touching[m.blocks[i].first_place].has_let_go = true;
    if (may_slip(m.blocks[i]))
      release_sticking(m, i, m.scratch.lambda);
    else
      m.memory[i].active = false;
  }
  write_all_rows(world, m, {true, false});
}

bool activate_penetrating(Island& m) {
  bool any = false;
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    if (is_within(m, i)) m.memory[i].active = any = true;
  return any;
}

void note_openings(Island& m) {
  for (const Block& b : m.blocks)
    if (b.kind == BlockKind::surface)
      m.scratch.touching[b.first_place].opened = opening_speed(m, b),
      m.scratch.touching[b.first_place].has_let_go = false;
}

bool project_penetrations(const World& world, Island& m, const Span& span) {
  StepScratch& scratch = m.scratch;
  if (!row_of(m.settings.integrator).projection_moves) return true;
  bool any = false;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    SurfaceFound* found = may_lift(m, i) ? &scratch.touching[m.blocks[i].first_place] : nullptr;
    if (!found) continue;
    found->is_set_back = is_within(m, i) && found->opened >= -kClosingSpeed &&
                         opening_speed(m, m.blocks[i]) >= -kClosingSpeed;
    any = any || found->is_set_back;
  }
  if (!any) return true;
  enum class Bears : bool { no, yes };
  const auto set = [&](Bears to) {
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      if (may_lift(m, i) && scratch.touching[m.blocks[i].first_place].is_set_back)
        m.memory[i].active = to == Bears::yes;
  };
  const Real kinetic = kinetic_energy(m, scratch.state);
  for (std::size_t b = 0; b < m.count(); ++b)
    scratch.momenta[2 * b] = scratch.state.v[b], scratch.momenta[2 * b + 1] = scratch.state.w[b];
  scratch.impulses_at_start = scratch.impulses;
  const Real part = span.fraction(1);
  set(Bears::yes);
  const bool closed = project(world, m, part, span.whole);
  set(Bears::no);
  for (std::size_t b = 0; b < m.count(); ++b)
    scratch.state.v[b] = scratch.momenta[2 * b], scratch.state.w[b] = scratch.momenta[2 * b + 1];
  scratch.impulses = scratch.impulses_at_start;
  update_kinematics(m), write_all_rows(world, m, {true, false});
  factor(m), project_twists(m, {});
  return closed && remove_projection_energy(m, kinetic);
}

}  // namespace pantin::detail::lagrangian
