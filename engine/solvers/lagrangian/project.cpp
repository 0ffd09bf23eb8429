// Mass-orthogonal projection onto the constraints. [Ascher, Chin, Petzold & Reich 1995]
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr int kMaxCorrections = 40;
/// Residuals below this multiple of the bound may be due to rounding.
constexpr Real kRoundingFactor = 1e3;
/// Levenberg weights where a plain Newton correction diverges, relative to the diagonal.
constexpr Real kSoftest = 1e-12, kSoftestLoop = 1e-6, kSofter = 100, kStiffer = 0.3, kStiffest = 1;
/// Tolerance of joints in a rescued step, relative to the longest arm.
constexpr Real kRescueTolerance = 0.02;
/// The mass-weighted least correction may rotate thin bodies far about their axes and diverge. Then
/// moments of inertia count as at least this fraction of the body's largest.
constexpr Real kThick = 0.1;
/// rad: longer corrections are no motion and leave angular velocities unrotated.
constexpr Real kMostTurned = 0.1;

/// Change of an angular velocity `w`, body axes, by a rotation `way` that is not part of it: the
/// gyroscopic torque of the two.
Vec3 gyroscopic_change(Vec3 w, Vec3 way, Vec3 inertia) {
  if (glm::dot(way, way) > kMostTurned * kMostTurned) return Vec3(0);
  return (glm::cross(inertia * w, way) + glm::cross(inertia * way, w)) / inertia;
}

/// Displaces the bodies. Returns the work of the forces.
Real move_bodies(Island& m, std::span<const Vec3> way) {
  PANTIN_ASSERT(way.size() == 2 * m.count());
  Motions& s = m.scratch.state;
  Real work = 0;
  for (std::size_t b = 0; b < m.count(); ++b) {
    work += glm::dot(m.scratch.force[2 * b], way[2 * b]) +
            glm::dot(m.scratch.force[2 * b + 1], way[2 * b + 1]);
    s.x[b] += way[2 * b];
    const Quat before = glm::conjugate(s.q[b]);
    s.q[b] = glm::normalize(from_rotation_vector(way[2 * b + 1]) * s.q[b]);
    if (!m.scratch.projection_moves) continue;
    const Vec3 w = before * s.w[b];
    s.w[b] = s.q[b] * (w + gyroscopic_change(w, before * way[2 * b + 1], m.inertia[b]));
  }
  return work;
}

/// Solves for a correction. Its residual is not recorded, since near convergence it is rounding.
void correct(Island& m, Real tolerance = 1e-6) {
  StepScratch& scratch = m.scratch;
  const Real row_residual = scratch.worst_relative_residual;
  const std::uint32_t block = scratch.worst_relative_block;
  solve(m, {{}, scratch.right}, {scratch.solution, scratch.lambda}, tolerance);
  scratch.worst_relative_residual = row_residual, scratch.worst_relative_block = block;
}

}  // namespace

Real rate_of(const Island& m, const Block& b, std::size_t row) {
  Real rate = 0;
  for (std::size_t k = 0; k < b.count; ++k) {
    const RowVectors j = row_of(b, jacobian_of(m, b), row, k);
    const BodyState& at = m.scratch.body_states[b.body[k]];
    rate += glm::dot(j.v, at.velocity) + glm::dot(j.w, at.angular_velocity);
  }
  return rate;
}

namespace {

/// Calls `subtract` with the part of every block that belongs to a frame, and the frame's number.
template <class Subtract>
void for_each_framed(const Island& m, const Subtract& subtract) {
  for (const std::uint32_t i : m.scratch.pattern.framed) {
    const Block& b = m.blocks[i];
    for (std::size_t k = 0; k < b.count; ++k) {
      const std::uint32_t n = b.body[k];
      PANTIN_ASSERT(n < m.scratch.body_states.size());
      if (n >= m.count()) subtract(BodyPart{b, jacobian_of(m, b), k}, n);
    }
  }
}

void subtract_motion(const BodyPart& part, Vec3 v, Vec3 w, std::span<Real> right) {
  if (v == Vec3(0) && w == Vec3(0)) return;
  add_rates(part, -v, -w, &right[part.block.first_row]);
}

}  // namespace

void subtract_frame_twists(Island& m, std::span<Real> right) {
  for_each_framed(m, [&](const BodyPart& part, std::uint32_t n) {
    const BodyState& at = m.scratch.body_states[n];
    subtract_motion(part, at.velocity, at.angular_velocity, right);
  });
}

void subtract_frame_accelerations(Island& m, std::span<Real> right) {
  for_each_framed(m, [&](const BodyPart& part, std::uint32_t n) {
    subtract_motion(part, m.scratch.motion[2 * n], m.scratch.motion[2 * n + 1], right);
  });
}

void project_twists(Island& m, std::span<const Real> bias) {
  StepScratch& scratch = m.scratch;
  PANTIN_ASSERT(bias.empty() || bias.size() == scratch.right.size());
  if (bias.empty())
    std::fill(scratch.right.begin(), scratch.right.end(), 0.0);
  else
    std::copy(bias.begin(), bias.end(), scratch.right.begin());
  for (const Block& b : m.blocks)
    for (std::size_t k = 0; k < b.count; ++k) {
      const BodyState& at = scratch.body_states[b.body[k]];
      add_rates({b, jacobian_of(m, b), k}, -at.velocity, -at.angular_velocity,
                &scratch.right[b.first_row]);
    }
  correct(m);
  for (std::size_t b = 0; b < m.count(); ++b) {
    scratch.state.v[b] += scratch.solution[2 * b],
        scratch.state.w[b] += scratch.solution[2 * b + 1];
    scratch.body_states[b].velocity = scratch.state.v[b],
    scratch.body_states[b].angular_velocity = scratch.state.w[b];
  }
}

namespace {

/// Inertia by which a correction of poses is minimal.
enum class Metric : std::uint8_t { of_masses, thick };

void look(const World& world, Island& m, Metric metric) {
  update_kinematics(m);
  if (metric == Metric::thick) regularise_inertia(m, kThick);
  write_all_rows(world, m, {true, false});
  m.residual = worst_residual(m);
}

/// The gap row of a surface joint if no other row constrains poses; else null.
const Block* only_gap(const Island& m) {
  const Block* gap = nullptr;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    if (binds_no_poses(b) || !is_active(m, i)) continue;
    if (gap || b.kind != BlockKind::surface) return nullptr;
    gap = &b;
  }
  return gap;
}

/// Solves the one row without a factor.
void correct_gap(Island& m, const Block& gap) {
  StepScratch& scratch = m.scratch;
  PANTIN_ASSERT(gap.rows == 1);
  const Vec3* j = jacobian_of(m, gap);
  std::fill(scratch.solution.begin(), scratch.solution.end(), Vec3(0));
  Real gives = 0;
  for (std::size_t k = 0; k < gap.count; ++k, j += 2) {
    const std::uint32_t b = gap.body[k];
    if (b >= m.count()) continue;
    scratch.solution[2 * b] = 1 / m.mass[b] * j[0];
    scratch.solution[2 * b + 1] = scratch.inverse_inertia[b] * j[1];
    gives += glm::dot(j[0], scratch.solution[2 * b]) + glm::dot(j[1], scratch.solution[2 * b + 1]);
  }
  const Real part = -scratch.c[gap.first_row] / gives;
  for (Vec3& way : scratch.solution) way *= part;
}

/// Closes the only pose row. Restores the poses if it does not converge.
void close_gap(const World& world, Island& m, const Block& gap) {
  StepScratch& scratch = m.scratch;
  const Real tolerance = tolerance_of(m);
  scratch.from = scratch.state;
  for (int n = 0; m.residual > tolerance; ++n) {
    const Real before = m.residual;
    correct_gap(m, gap);
    scratch.projection_work += move_bodies(m, scratch.solution);
    look(world, m, Metric::of_masses);
    if (n < kMaxCorrections && m.residual < 0.5 * before) continue;
    if (m.residual <= kRoundingFactor * tolerance) return;
    scratch.state = scratch.from, scratch.projection_work = 0;
    look(world, m, Metric::of_masses);
    return;
  }
}

/// Newton's method on the pose rows, with Levenberg's where it diverges. Returns whether the last
/// factor is regularised and so does not match the rows.
bool close_poses(const World& world, Island& m, Metric metric) {
  constexpr Real kInfinite = std::numeric_limits<Real>::infinity();
  StepScratch& scratch = m.scratch;
  const Real tolerance = tolerance_of(m), softest = m.loops ? kSoftestLoop : kSoftest;
  Real before = kInfinite, weight = 0, work_before = 0;
  bool fresh = true;  // the factor, at the last correction
  for (int round = 0; m.residual > tolerance && round < kMaxCorrections; ++round) {
    const bool better = m.residual < (weight > 0 ? 1 : 0.5) * before;
    if (better) {
      scratch.from = scratch.state, work_before = scratch.projection_work;
      weight *= kStiffer;
    } else {
      if (m.residual <= kRoundingFactor * tolerance) break;
      scratch.state = scratch.from, scratch.projection_work = work_before;
      look(world, m, metric);
      // The Newton step was too long: retries a shorter, regularised one. [Levenberg 1944]
      if (fresh) weight = std::max(softest, kSofter * weight);
      if (weight > kStiffest) break;
    }
    // The factor is reused while the residual decreases; rows are always current.
    const bool serves = round == 0 || (better && weight == 0 && m.residual <= 0.1 * before);
    if (weight > 0)
      factor_soft(m, weight);
    else if (!serves)
      factor(m);
    fresh = round == 0 || !serves;
    before = m.residual;
    for (std::size_t r = 0; r < m.rows; ++r) scratch.right[r] = -scratch.c[r];
    correct(m, weight > 0 ? kInfinite : 1e-6);
    scratch.projection_work += move_bodies(m, scratch.solution);
    look(world, m, metric);
  }
  return weight > 0;
}

}  // namespace

bool project(const World& world, Island& m, Real part, Real whole) {
  StepScratch& scratch = m.scratch;
  PANTIN_ASSERT(!scratch.poses_only);
  update_frames(world, m, part, whole);
  look(world, m, Metric::of_masses);
  scratch.opened = m.residual;
  if (!std::isfinite(m.residual)) return false;
  scratch.projection_work = 0;
  const Block* gap = m.rolls && m.residual > tolerance_of(m) ? only_gap(m) : nullptr;
  if (gap) close_gap(world, m, *gap);
  // Rows that constrain velocities only are left out for poses.
  const bool splits = m.rolls && m.residual > tolerance_of(m);
  if (splits)
    scratch.poses_only = true, clear_rolling(m), factor(m);
  else
    factor_and_report(m);
  bool softened = close_poses(world, m, Metric::of_masses);
  const Real enough = 1e-7 * std::max(Real(1), m.size);
  if (m.rescues > 0 && m.residual > enough) {
    look(world, m, Metric::thick), factor(m);
    close_poses(world, m, Metric::thick);
    look(world, m, Metric::of_masses), softened = true;
  }
  scratch.poses_only = false;
  if (splits)
    look(world, m, Metric::of_masses), factor_and_report(m);
  else if (softened)
    factor(m);
  project_twists(m, {});
  for (std::size_t r = 0; r < m.rows; ++r) scratch.impulses[r] += scratch.lambda[r];
  const Real loose = m.rescues > 0 ? kRescueTolerance * m.reach : 0;
  return m.residual <= std::max(enough, loose);
}

}  // namespace pantin::detail::lagrangian
