// Back onto the joints, by the least mass-weighted motion. [Ascher, Chin, Petzold & Reich 1995]
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::lagrangian {
namespace {

constexpr int kRounds = 40;
/// Residuals of so many times the bound may be all that rounding leaves.
constexpr Real kFine = 1e3;
/// Weights on rows where a plain correction leads astray, parts of their diagonal.
constexpr Real kSoftest = 1e-12, kSoftestLoop = 1e-6, kSofter = 100, kStiffer = 0.3, kStiffest = 1;
/// Joints of a rescued step may stay open by this part of the longest arm.
constexpr Real kLoose = 0.02;

void move_bodies(Island& m, std::span<const Vec3> way) {
  Motions& s = m.room.state;
  for (std::size_t b = 0; b < m.count(); ++b) {
    s.x[b] += way[2 * b];
    s.q[b] = glm::normalize(turn_by(way[2 * b + 1]) * s.q[b]);
  }
}

/// Solves for a correction, whose size is that of rounding in the end: what it lacks, part of that,
/// says nothing about the joints.
void correct(Island& m, Real enough = 1e-6) {
  StepScratch& room = m.room;
  const Real lack = room.worst_lack;
  const std::uint32_t block = room.worst_lack_block;
  solve(m, {}, room.right, room.correction, room.lambda, enough);
  room.worst_lack = lack, room.worst_lack_block = block;
}

}  // namespace

Real rate_of(const Island& m, const Block& b, std::size_t row) {
  Real rate = 0;
  for (std::size_t k = 0; k < b.count; ++k) {
    const RowVectors j = row_of(b, jacobian_of(m, b), row, k);
    const Placed& at = m.room.placed[b.body[k]];
    rate += glm::dot(j.v, at.velocity) + glm::dot(j.w, at.spin);
  }
  return rate;
}

void take_known(Island& m, std::span<Real> right, bool accelerations) {
  for (const std::uint32_t i : m.room.pattern.framed) {
    const Block& b = m.blocks[i];
    for (std::size_t k = 0; k < b.count; ++k) {
      const std::uint32_t n = b.body[k];
      if (n < m.count()) continue;
      const Vec3 v = accelerations ? m.room.motion[2 * n] : m.room.placed[n].velocity;
      const Vec3 w = accelerations ? m.room.motion[2 * n + 1] : m.room.placed[n].spin;
      if (v == Vec3(0) && w == Vec3(0)) continue;
      add_rates(b, jacobian_of(m, b), k, -v, -w, &right[b.first_row]);
    }
  }
}

void project_twists(Island& m, std::span<const Real> wanted) {
  StepScratch& room = m.room;
  if (wanted.empty()) std::fill(room.right.begin(), room.right.end(), 0.0);
  else std::copy(wanted.begin(), wanted.end(), room.right.begin());
  for (const Block& b : m.blocks)
    for (std::size_t k = 0; k < b.count; ++k) {
      const Placed& at = room.placed[b.body[k]];
      add_rates(b, jacobian_of(m, b), k, -at.velocity, -at.spin,
                &room.right[b.first_row]);
    }
  correct(m);
  for (std::size_t b = 0; b < m.count(); ++b) {
    room.state.v[b] += room.correction[2 * b], room.state.w[b] += room.correction[2 * b + 1];
    room.placed[b].velocity = room.state.v[b], room.placed[b].spin = room.state.w[b];
  }
}

bool project(const World& world, Island& m, Real part, Real whole) {
  constexpr Real kAny = std::numeric_limits<Real>::infinity();
  StepScratch& room = m.room;
  const Real enough = tolerance_of(m);
  place_frames(world, m, part, whole);
  const auto look = [&] {
    place(m);
    write_all_rows(world, m, {true, false});
    m.residual = worst_residual(m);
  };
  look();
  room.opened = m.residual;
  if (!std::isfinite(m.residual)) return false;
  factor(m, true);
  const Real softest = m.loops ? kSoftestLoop : kSoftest;
  Real before = kAny, weight = 0;
  bool fresh = true;  // the factor, at the last correction
  for (int round = 0; m.residual > enough && round < kRounds; ++round) {
    const bool better = m.residual < (weight > 0 ? 1 : 0.5) * before;
    if (better) {
      room.from.x = room.state.x, room.from.q = room.state.q;
      weight *= kStiffer;
    } else {
      if (m.residual <= kFine * enough) break;
      room.state.x = room.from.x, room.state.q = room.from.q;
      look();
      // The way was too long for a line: again, shorter, along what gives way easily.
      // [Levenberg 1944]
      if (fresh) weight = std::max(softest, kSofter * weight);
      if (weight > kStiffest) break;
    }
    // A factor serves as long as it brings the residual down; rows are always the newest.
    const bool serves = round == 0 || (better && weight == 0 && m.residual <= 0.1 * before);
    if (weight > 0) factor_soft(m, weight);
    else if (!serves) factor(m, false);
    fresh = round == 0 || !serves;
    before = m.residual;
    for (std::size_t r = 0; r < m.rows; ++r) room.right[r] = -room.c[r];
    correct(m, weight > 0 ? kAny : 1e-6);
    move_bodies(m, room.correction);
    look();
  }
  if (weight > 0) factor(m, false);
  project_twists(m, {});
  for (std::size_t r = 0; r < m.rows; ++r) room.impulses[r] += room.lambda[r];
  const Real loose = m.rescues > 0 ? kLoose * m.reach : 0;
  return m.residual <= std::max(1e-7 * std::max(Real(1), m.size), loose);
}

}  // namespace pantin::lagrangian
