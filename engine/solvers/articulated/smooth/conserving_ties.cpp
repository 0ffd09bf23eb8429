// Loops, pins and elastic cables in the energy-momentum method: forces between two points of the
// bodies or of the world. As at joints, a force acts at the mean of the arms before and after the
// step; its work is then exactly its product with the change of the distance d between the points.
//
// The unknown of a tie is the impulse mu over half the step. A rigid tie makes d vanish, but for a
// tiny compliance. The force of an elastic tie depends on d before and after, and its work is the
// change of the stored energy (discrete gradient): energy is conserved exactly. [Gonzalez 1996]
//
// A taut inextensible cable keeps the length of d, a quadratic constraint: its force is along the
// mean of d before and after, and does no work. A cable that would push becomes slack. One that
// reaches its length ends the substep there, with an impact (strike).
//
// The elimination of the tree gives the motion for the current mu; tie_response.cpp gives its
// response to further impulses at the ties.
#include "engine/solvers/articulated/smooth/conserving_ties.hpp"

#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/smooth/conserving_joints.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr std::uint32_t kNobody = UINT32_MAX;
/// Arms of a point of a body, from the body's own joint.
struct TieArms {
  const Vec3& start;
  Vec3 &mean, &end;
};

/// Rate tolerance of an impact, as a fraction of the fastest rate: a slower cable does not stretch.
constexpr Real kStill = 1e-9;

/// Updates arms and d at the iterate.
void look_at(const TiedStep& s, ConservingTie& t) {
  const LaneTable& work = s.a.scratch.work;
  // The displacement of the point over the substep.
  const auto moved = [&](std::uint32_t c, Vec3 anchor, const TieArms& arms) {
    arms.end = work.quat(kEndRotation, c) * anchor;
    arms.mean = 0.5 * (arms.start + arms.end);
    return work.vec(kJointWay, c) + (arms.end - arms.start);
  };
  const Vec3 of_a =
      t.a != kNobody ? moved(t.a, t.anchor_a, {t.start_a, t.mean_a, t.end_a}) : Vec3(0);
  t.now = t.before + (moved(t.b, t.anchor_b, {t.start_b, t.mean_b, t.end_b}) - of_a - t.way);
}

/// Impulse and derivative of a spring with a damper.
void load_spring(ConservingTie& t, Real h) {
  const Real along = 0.5 * t.stiffness + t.damping / h;
  t.mu = 0.5 * h * (along * t.now + (0.5 * t.stiffness - t.damping / h) * t.before);
  t.derivative = Mat3(0.5 * h * along);
}

CableLoad<Vec3, Real> load_of(const ConservingTie& t, Real h) {
  return load_of_cable(CableSpan<Vec3>{t.before, t.now}, t.length, t.stiffness, h);
}
void load_cable(ConservingTie& t, Real h) {
  const CableLoad<Vec3, Real> load = load_of(t, h);
  t.mu = load.mu, t.across = load.across;
  t.derivative = Mat3(load.derivative[0], load.derivative[1], load.derivative[2]);
}

void load_taut(ConservingTie& t) {
  PANTIN_ASSERT(t.kind == TieKind::taut);
  const auto load = load_of_taut(CableSpan<Vec3>{t.before, t.now}, t.mu);
  t.mu = load.mu, t.across = load.across;
  if (!t.grounded) return;
  Vec3 columns[3];
  turn_taut(t.across, columns);
  t.derivative = Mat3(columns[0], columns[1], columns[2]);
}

/// Adds the impulse of a tie to the block of one of its bodies, like that of a massless child.
void add_to_block(Real* block, Vec3 impulse, Vec3 mean, Vec3 end) {
  const Vec3 f = 0.5 * impulse, torque = glm::cross(mean, impulse);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) block[3 * i + j] += end[i] * f[j];
    block[4 * i] -= glm::dot(f, end);
    block[9 + i] += impulse[i], block[12 + i] += torque[i];
  }
}
/// Adds the derivative of the impulse of a grounded tie to its body's block.
void add_grounded(const ConservingTie& t, Real* block) {
  const Vec3 columns[3] = {t.derivative[0], t.derivative[1], t.derivative[2]};
  const GroundedBlock<Vec3> own = grounded_block(columns, t.mean_b, t.end_b);
  const auto add = [&](std::size_t at, const Vec3(&rows)[3]) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) block[at + static_cast<std::size_t>(3 * i + j)] += rows[i][j];
  };
  add(kTieTurn, own.tt), add(kTieTurnMove, own.ty);
  add(kTieMoveTurn, own.yt), add(kTieMoveMove, own.yy);
}

void load(void* context) {
  const TiedStep& s = *static_cast<const TiedStep*>(context);
  StepScratch& r = s.a.scratch;
  PANTIN_ASSERT(r.tie_blocks.size() == kTieBlock * s.a.count() && r.stiff == (s.stiff != nullptr));
  std::fill(r.tie_blocks.begin(), r.tie_blocks.end(), 0.0);
  bool may_change = true;
  s.with.tautened = false;
  ++s.with.iterations;
  for (std::size_t c = 0; s.stiff && c < s.a.joints.size(); ++c) {
    if (!has_limits(s.a, c)) continue;
    look_at_limits(*s.stiff, c, ends_of(*s.stiff, c));
    if (may_change && change_limits(*s.stiff, c)) may_change = s.with.iterations <= kChangeAtOnce;
  }
  for (ConservingTie& t : r.ties) {
    look_at(s, t);
    if (may_change && has_to_change(s, t)) {
      change(t), may_change = s.with.iterations <= kChangeAtOnce;
      s.with.tautened = s.with.tautened || t.kind == TieKind::taut;
    }
    if (t.kind == TieKind::spring) load_spring(t, s.h);
    if (t.kind == TieKind::cable) load_cable(t, s.h);
    if (t.kind == TieKind::taut) load_taut(t);
    if (t.kind == TieKind::slack) t.derivative = Mat3(0);
    Real* const block = &r.tie_blocks[kTieBlock * t.b];
    add_to_block(block, t.mu, t.mean_b, t.end_b);
    if (t.grounded) add_grounded(t, block);
    if (t.a != kNobody) add_to_block(&r.tie_blocks[kTieBlock * t.a], -t.mu, t.mean_a, t.end_a);
  }
}

/// Change of d of a tie by the unknowns of the bodies.
Vec3 change_of(const Island& a, const ConservingTie& t) {
  const auto at = [&](std::uint32_t c, Vec3 arm) {
    return a.memory.vec(kMove, c) + glm::cross(a.memory.vec(kTurnBy, c), arm);
  };
  return at(t.b, t.end_b) - (t.a != kNobody ? at(t.a, t.end_a) : Vec3(0));
}

/// A row for the change of d along `by`, for an impulse along `direction`.
TieRows one_row(Vec3 by, Vec3 direction, Real right, Real own) {
  TieRows rows{1, Mat3(0), {right, 0, 0}, Mat3(own), Mat3(0)};
  rows.by[0] = by, rows.directions[0] = direction;
  return rows;
}

/// Adds the ties' own diagonal blocks and right-hand sides; sets their compliance if unset: at
/// least that of a tie to the whole island, since the points of a rigid part have no response but
/// rounding.
template <class RowsOf>
void add_own_rows(const TiedStep& s, Arms arms, std::size_t n, const RowsOf& rows_of) {
  StepScratch& r = s.a.scratch;
  const Real least = (arms == Arms::mean ? s.h : Real(1)) / s.a.mass;
  std::size_t row = 0;
  for (ConservingTie& t : r.ties) {
    TieRows& rows = rows_at(r, t);
    PANTIN_ASSERT(rows.count == 0 || rows.count == 1 || rows.count == 3);
    const auto count = static_cast<std::size_t>(rows.count);
    if (count == 0) continue;
    Real response = 0;
    for (std::size_t i = 0; i < count; ++i)
      response += std::abs(r.tie_matrix[(row + i) * (n + 1)]) / static_cast<Real>(count);
    if (count == 1) t.response = response;
    const Real floor = t.kind == TieKind::rigid ? least : kRigidPart * least;
    if (t.softness == 0) t.softness = r.tie_yield * std::max(response, floor);
    // The matrix has the rows that were counted: a tie keeps its number of rows.
    if (const TieRows now = rows_of(t); now.count == rows.count) rows = now;
    const Vec3 right = rows.right - change_of(s.a, t) * rows.by;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j)
        r.tie_matrix[(row + i) * n + row + j] -= rows.own[static_cast<int>(j)][static_cast<int>(i)];
      r.tie_solution[row + i] = right[static_cast<int>(i)];
    }
    row += count;
  }
}

/// Solves for the impulses of all ties for which `rows_of` has equations, and adds their motion to
/// the bodies: by (d + W mu) - own mu = right, W being the response.
template <class RowsOf, class Take>
bool solve_ties(const TiedStep& s, Arms arms, const RowsOf& rows_of, const Take& take) {
  Island& a = s.a;
  StepScratch& r = a.scratch;
  std::size_t n = 0;
  for (ConservingTie& t : r.ties) n += static_cast<std::size_t>((rows_at(r, t) = rows_of(t)).count);
  if (n == 0) return true;
  fill_tie_matrix(a, arms, n);
  add_own_rows(s, arms, n, rows_of);
  if (!solve_tie_equations(r, n)) return false;
  clear_tie_impulses(r);
  std::size_t row = 0;
  for (ConservingTie& t : r.ties) {
    const TieRows& rows = rows_at(r, t);
    if (rows.count == 0) continue;
    Vec3 mu(0);
    for (int i = 0; i < rows.count; ++i) mu += r.tie_solution[row++] * rows.directions[i];
    add_tie_impulse(r, t, mu, arms);
    take(t, mu);
  }
  PANTIN_ASSERT(row == n);
  respond_to_ties(a, arms);
  for (std::size_t c = 0; c < a.count(); ++c) {
    a.memory.set(kMove, c, a.memory.vec(kMove, c) + r.tie_impulses[c]);
    a.memory.set(kTurnBy, c, a.memory.vec(kTurnBy, c) + r.tie_torques[c]);
  }
  return true;
}

/// Adds the response to the ties' impulses to the impulses at the joints.
void add_joint_impulses(Island& a, Real share) {
  for (std::size_t c = 0; c < a.count(); ++c)
    a.memory.set(kLambda, c, a.memory.vec(kLambda, c) + share * a.scratch.tie_joints[c]);
}

bool turns_slightly(const ConservingTie& t) {
  return t.grounded || 0.5 * t.across * t.response < kSlight;
}

TieRows one_row(const CableEquation<Vec3, Real>& e) {
  return one_row(e.by, e.direction, e.right, e.own);
}
/// One row along the mean of d for the length; two across it that keep the impulse along the mean.
TieRows taut_rows(const TiedStep& s, const ConservingTie& t) {
  const CableEquation<Vec3, Real> e =
      equation_of_taut(CableSpan<Vec3>{t.before, t.now}, t.mu, t.length, t.softness);
  if (turns_slightly(t)) return one_row(e);
  const Mat3 along = glm::outerProduct(e.direction, e.direction),
             across = s.h / s.a.mass * (Mat3(1) - along);
  return {3, glm::transpose(glm::outerProduct(e.direction, e.by) + 0.5 * t.across * across),
          e.right * e.direction, across + t.softness * along};
}
/// Rows of an elastic cable: the impulse linearised in d.
TieRows elastic_rows(const ConservingTie& t) {
  if (t.derivative == Mat3(0)) return {0};
  if (!turns_slightly(t)) return {3, glm::transpose(t.derivative), Vec3(0), Mat3(1)};
  const Vec3 columns[3] = {t.derivative[0], t.derivative[1], t.derivative[2]};
  return one_row(equation_of_elastic(CableSpan<Vec3>{t.before, t.now}, columns));
}
/// Rows of velocities: along d at the end.
TieRows taut_speeds(const ConservingTie& t) {
  const Vec3 n = glm::normalize(t.now);
  return one_row(n, n, glm::dot(n, t.velocity) + t.rate, t.softness);
}
TieRows rigid_speeds(const ConservingTie& t) {
  return {t.kind == TieKind::rigid ? 3 : 0, Mat3(1), t.velocity, Mat3(t.softness)};
}

bool has_tie_rows(const StepScratch& r) {
  return std::any_of(r.tie_sets.begin(), r.tie_sets.end(),
                     [](const TieRows& rows) { return rows.count > 0; });
}

bool correct(void* context) {
  const TiedStep& s = *static_cast<const TiedStep*>(context);
  const auto rows_of = [&](const ConservingTie& t) {
    if (t.kind == TieKind::taut) return taut_rows(s, t);
    if (t.kind == TieKind::slack || t.grounded) return TieRows{0};
    if (t.kind == TieKind::cable) return elastic_rows(t);
    return t.kind == TieKind::rigid
               ? TieRows{3, Mat3(1), t.softness * t.mu - t.now, Mat3(t.softness)}
               : TieRows{3, glm::transpose(t.derivative), Vec3(0), Mat3(1)};
  };
  if (!solve_ties(s, Arms::mean, rows_of, [](ConservingTie& t, Vec3 mu) { t.mu += mu; }))
    return false;
  for (ConservingTie& t : s.a.scratch.ties)
    if (t.grounded) t.mu += t.derivative * change_of(s.a, t);
  if (s.with.tautened && is_hit_early(s)) return false;
  if (has_tie_rows(s.a.scratch)) add_joint_impulses(s.a, 1);
  return true;
}

/// m/s: rate at which a taut cable would stretch.
Real rate_of(const Island& a, const ConservingTie& t) {
  return glm::dot(change_of(a, t) - t.velocity, glm::normalize(t.now)) - t.rate;
}

/// Work on the bodies by what moves a tie's ends in the world, or reels a cable, while an impulse
/// acts along it at the end.
Real work_of(const ConservingTie& t, Vec3 mu) {
  Real work = -glm::dot(mu, t.velocity);
  if (t.rate != 0) work -= t.rate * glm::dot(mu, glm::normalize(t.now));
  return work;
}

/// Impact of cables that reached their lengths at the end, and of limits that were hit. Finds the
/// velocities of least kinetic energy at which no taut cable stretches and no limit is exceeded.
/// Cables only pull, limits only push. The active set changes one at a time: the one with the most
/// infeasible impulse is released, then the one with the fastest violation is activated.
bool strike(const TiedStep& s) {
  Island& a = s.a;
  StepScratch& r = a.scratch;
  const bool limits = s.stiff && any_limit(a);
  PANTIN_ASSERT(limits || r.velocities_before.size() == 2 * a.count());
  Real fastest = limits ? begin_blow(*s.stiff) : 0;
  const Real still_turn = kStill * fastest;
  for (std::size_t c = 0; !limits && c < a.count(); ++c)
    r.velocities_before[2 * c] = a.memory.vec(kMove, c),
                            r.velocities_before[2 * c + 1] = a.memory.vec(kTurnBy, c);
  fastest = 0;
  for (ConservingTie& t : r.ties)
    if (t.kind == TieKind::taut) fastest = std::max(fastest, rate_of(a, t)), t.strikes = true;
  const auto rows_of = [&](const ConservingTie& t) {
    return t.strikes ? taut_speeds(t) : rigid_speeds(t);
  };
  const std::size_t most_rounds = 4 * r.ties.size() + (limits ? 8 * a.count() : 0) + 4;
  for (std::size_t round = 0; round < most_rounds; ++round) {
    if (limits) respond_to_blow(*s.stiff);
    for (std::size_t c = 0; !limits && c < a.count(); ++c)
      a.memory.set(kMove, c, r.velocities_before[2 * c]),
          a.memory.set(kTurnBy, c, r.velocities_before[2 * c + 1]);
    ConservingTie* out = nullptr;
    Real most = 0;
    const auto take = [&](ConservingTie& t, Vec3 mu) {
      const Real push = t.strikes ? -glm::dot(mu, t.now) : 0;
      if (push > most) most = push, out = &t;
      s.with.struck_work += work_of(t, mu);
    };
    s.with.struck_work = 0;
    if (!solve_ties(s, Arms::end, rows_of, take)) return false;
    if (out) {
      out->strikes = false;
      continue;
    }
    if (limits && release_limit(*s.stiff, still_turn)) continue;
    if (limits && catch_limit(*s.stiff, still_turn)) continue;
    most = kStill * fastest;
    for (ConservingTie& t : r.ties)
      if (t.kind == TieKind::taut && !t.strikes && rate_of(a, t) > most)
        most = rate_of(a, t), out = &t;
    if (!out) break;
    out->strikes = true;
  }
  for (ConservingTie& t : r.ties)
    if (t.kind == TieKind::taut && !t.strikes) t.kind = TieKind::slack;
  if (limits) end_blow(a);
  if (has_tie_rows(r)) add_joint_impulses(a, 0.5);
  return true;
}

}  // namespace

bool project_ties(const TiedStep& s) {
  const auto rows_of = [&](const ConservingTie& t) {
    return t.kind == TieKind::taut && !t.strikes ? taut_speeds(t) : rigid_speeds(t);
  };
  std::vector<ConservingTie>& ties = s.a.scratch.ties;
  for (ConservingTie& t : ties) t.softness = 0;
  // Half of the projection's impulses counts in the mean over the step.
  Real& work = s.with.place_work;
  const auto take = [&](const ConservingTie& t, Vec3 mu) { work += work_of(t, mu); };
  if (!solve_ties(s, Arms::end, rows_of, take)) return false;
  if (has_tie_rows(s.a.scratch)) add_joint_impulses(s.a, 0.5);
  const bool strikes = std::any_of(ties.begin(), ties.end(), [](auto& t) { return t.strikes; });
  if (!strikes && !(s.stiff && any_limit_hit(s.a))) return true;
  if (!strike(s)) return false;
  work += s.with.struck_work;
  return true;
}

namespace {

bool project(void* context) { return project_ties(*static_cast<const TiedStep*>(context)); }

/// Whether the impulse of an elastic cable has converged to that of its length at the iterate.
bool is_followed(const TiedStep& s, const ConservingTie& t) {
  const CableLoad<Vec3, Real> now = load_of(t, s.h);
  const Real response = t.response > 0 ? t.response : s.h / s.a.mass;
  const Vec3 direction = direction_of(CableSpan<Vec3>{t.before, t.now});
  const Real stiffness = glm::length(times_columns(direction, now.derivative));
  return response * glm::length(now.mu - t.mu) <= kFollowed * s.a.size * (1 + response * stiffness);
}

bool settled(void* context) {
  const TiedStep& s = *static_cast<const TiedStep*>(context);
  for (ConservingTie& t : s.a.scratch.ties) {
    look_at(s, t);
    if (t.kind == TieKind::cable && !is_followed(s, t)) return false;
    if (!has_to_change(s, t)) continue;
    change(t);
    return false;
  }
  for (std::size_t c = 0; s.stiff && c < s.a.joints.size(); ++c) {
    if (!has_limits(s.a, c)) continue;
    look_at_limits(*s.stiff, c, ends_of(*s.stiff, c));
    if (change_limits(*s.stiff, c)) return false;
  }
  return true;
}

bool accept(void* context, Real& released) {
  const TiedStep& s = *static_cast<const TiedStep*>(context);
  Real most = 0;
  s.with.place_work = 0;
  for (ConservingTie& t : s.a.scratch.ties) {
    look_at(s, t);
    released += 2 / s.h * glm::dot(t.mu, t.before - t.now);
    s.with.place_work -= 2 / s.h * glm::dot(t.mu, t.way);
    if (t.kind == TieKind::rigid) most = std::max(most, glm::length(t.now));
    if (t.kind == TieKind::taut) most = std::max(most, std::abs(over(t)));
  }
  const bool yields = s.a.scratch.tie_yield > kTieSoftness;
  if (!(most <= (yields ? kNearTie : kAccepted) * s.a.size)) return false;
  if (has_to_end_early(s) || (s.stiff && limits_end_early(*s.stiff, s.with))) return false;
  s.with.inner = ties_are_inner(s.a);
  return true;
}

}  // namespace

bool conserve_tied(World& world, Island& a, ConservingInput in, TiedPart& with) {
  StepScratch& r = a.scratch;
  const StepPart& part = with.part;
  TiedStep step{world, a, in.h, with};
  const ConservingTies ties{&step,
                            r.tie_blocks.data(),
                            r.tie_grounded.data(),
                            r.tie_factors.data(),
                            load,
                            correct,
                            settled,
                            accept,
                            project,
                            &with.inner,
                            &with.struck,
                            &with.place_work};
  in.ties = &ties;
  if (!r.stiff) return kernels().conserve(view_of(world, a), in);
  StiffStep stiff{world, a, in.h, part};
  step.stiff = &stiff;
  const ConservingJoints joints = stiff_joints(stiff);
  in.joints = &joints;
  return kernels().conserve(view_of(world, a), in);
}

}  // namespace pantin::detail::articulated
