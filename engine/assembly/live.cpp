#include "engine/assembly/live.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"

namespace pantin::detail::assembly {

using lagrangian::Block;
using lagrangian::BlockKind;
using lagrangian::Island;

namespace {

/// Compliance of rows of targets, relative to their diagonal: its bounds, and how it changes when
/// targets at rest are approached or left.
constexpr Real kSoftest = 1e6, kStiffest = 1e-7, kSoften = 4, kHarden = 0.5, kSame = 1e-9;
/// Joint error, relative to the size, above which the step is corrected with the same factor, and
/// the number of corrections.
constexpr Real kJointError = 1e-7;
constexpr int kCorrections = 4;
/// Steps that one factor serves, and the fraction of kJointError beyond which it is made anew.
/// Its error grows with the steps.
constexpr int kStepsOfFactor = 32;
constexpr Real kStale = 0.25;
/// Fraction of kJointError below which targets are met up to rounding.
constexpr Real kRounding = 1e-5;
/// The largest multiple of the step before that is taken again.
constexpr Real kMostAgain = 2;
/// Changes of the active set within an iteration.
constexpr int kActiveSets = 4;
/// rad: the largest rotation of an iteration.
constexpr Real kMostTurn = 0.25;
/// Compliance of laws, only so that dependent rows have pivots; of rows that a target leaves free.
constexpr Real kHard = 1e-12, kFree = 1e15;
constexpr Real kStep = 1e-3;  // s; frames are at rest
constexpr std::size_t kNoPart = SIZE_MAX;

/// Of a row of a target. Rows 0 and 1 of an aim would keep the line parallel to x of the frame,
/// which it need not be.
Real weight_of(const LiveTarget& t, std::size_t row) {
  if (t.goal == Goal::aim && row < 2) return 0;
  return t.goal == Goal::pose && row >= 3 ? t.turn_weight : t.weight;
}

/// The joint error that needs no correction, m or rad.
Real bound_of(const Island& m) {
  return kJointError * std::max({m.size, m.reach, std::sqrt(m.inertia[0].x)});
}

/// Whether one-sided rows have become active, or inactive, since the multipliers were solved for.
/// Those that became active press until they are.
bool takes_active_set(Part& part, std::span<const Real> pressing) {
  Island& m = part.m;
  bool changed = false;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if (!lagrangian::is_one_sided(m, i)) continue;
    const std::uint32_t row = m.blocks[i].first_row;
    const bool was = pressing[row] != 0;
    changed = changed || m.memory[i].active != was;
    if (m.memory[i].active && !was) m.scratch.lambda[row] = 1;
  }
  return changed;
}

/// Copies what a step changes.
void copy_poses(const lagrangian::Motions& from, lagrangian::Motions& to) {
  to.x = from.x, to.q = from.q, to.touches = from.touches;
}

/// The largest vector, m or rad.
Real largest(std::span<const Vec3> all) {
  Real most = 0;
  for (const Vec3& v : all) most = std::max(most, glm::dot(v, v));
  return std::sqrt(most);
}

}  // namespace

Live::Live(const World& world, std::vector<Entity> held) : model_(world), held_(std::move(held)) {}

std::size_t Live::add(const LiveTarget& target) {
  targets_.push_back(target), used_.push_back(true), compiled_ = false;
  return targets_.size() - 1;
}

void Live::remove(std::size_t target) {
  if (has(target)) used_[target] = false, compiled_ = false;
}

void Live::hold(Entity body) {
  let_go(body);
  held_.push_back(body);
}

void Live::let_go(Entity body) {
  std::erase(held_, body);
  compiled_ = false;
}

void Live::move(std::size_t number, const Pose& target) {
  targets_[number].target = target;
  if (!compiled_) return;
  for (const Followed& f : followed_)
    if (f.target == number) place(f);
}

void Live::set_weight(std::size_t number, Real weight, Real turn_weight) {
  targets_[number].weight = weight, targets_[number].turn_weight = turn_weight;
  for (PartState& state : states_) state.factor.stands = false;
}

void Live::place(const Followed& f) {
  const LiveTarget& t = targets_[f.target];
  if (t.goal == Goal::point)
    problem_.world.pins[f.entity].target = t.target.position;
  else
    problem_.world.bodies[f.entity].pose = t.target;
  states_[f.part].moved = true;
}

/// Targets are pins and joints to frames, in a copy of the model.
void Live::compile() {
  if (!problem_.parts.empty()) write_to(model_);
  World w = model_;
  followed_.clear();
  std::vector<Entity> laws;
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    const LiveTarget& t = targets_[i];
    if (!used_[i] || !w.bodies.find(t.body)) continue;
    if (t.goal == Goal::point) {
      const Entity pin =
          w.add_pin({.body = t.body, .anchor = t.own.position, .target = t.target.position});
      followed_.push_back({i, kNoPart, 0, pin}), laws.push_back(pin);
      continue;
    }
    Body frame;
    frame.motion = Motion::fixed, frame.pose = t.target;
    const Entity at = w.add_body(frame);
    Joint joint;
    joint.kind = t.goal == Goal::pose ? JointKind::fixed : JointKind::cylindrical;
    joint.anchor_a = t.own.position, joint.frames.set(t.own.rotation, kIdentity);
    followed_.push_back({i, kNoPart, 0, at}), laws.push_back(add_link(w, {t.body, at, joint}));
  }
  problem_ = make_problem(w, held_);
  states_.assign(problem_.parts.size(), {});
  for (std::size_t p = 0; p < states_.size(); ++p) {
    const Island& m = problem_.parts[p].m;
    states_[p].pressing.assign(m.rows, 0), states_[p].response.assign(m.rows, 0);
    states_[p].way.assign(2 * m.count(), Vec3(0));
  }
  is_target_.clear();
  for (std::size_t p = 0; p < problem_.parts.size(); ++p) {
    const Island& m = problem_.parts[p].m;
    is_target_.emplace_back(m.blocks.size(), 0);
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      for (std::size_t k = 0; k < laws.size(); ++k)
        if (!lagrangian::is_compliant(m.blocks[i].kind) &&
            joint_of(problem_.world, m.blocks[i]) == laws[k])
          followed_[k].part = p, followed_[k].block = i, is_target_[p][i] = 1;
  }
  // Targets of bodies that are held, or cannot be solved for, have no rows.
  std::erase_if(followed_, [](const Followed& f) { return f.part == kNoPart; });
  compiled_ = true;
}

/// Compliances and right-hand sides.
void Live::set_weights(Part& part, std::size_t number) {
  Island& m = part.m;
  lagrangian::StepScratch& scratch = m.scratch;
  set_equations(part, kHard);
  for (const Followed& f : followed_) {
    if (f.part != number) continue;
    const LiveTarget& t = targets_[f.target];
    const Block& b = m.blocks[f.block];
    for (std::size_t r = 0; r < b.rows; ++r) {
      const std::size_t row = b.first_row + r;
      const Real weight = weight_of(t, r);
      scratch.weights[row] =
          (weight > 0 ? states_[number].softness / weight : kFree) * part.units[row];
      if (!(weight > 0)) scratch.right[row] = 0;
    }
  }
}

/// Rows of all blocks at the present poses.
void Live::evaluate(std::size_t number, Known rows) {
  Part& part = problem_.parts[number];
  if (rows == Known::all)
    look(problem_.world, part);
  else
    look_at_residuals(problem_.world, part);
  states_[number].known = rows;
}

/// Rows of the targets alone. All others are known.
void Live::look_at_targets(std::size_t number) {
  Island& m = problem_.parts[number].m;
  lagrangian::update_frames(problem_.world, m, 0, kStep);
  for (const Followed& f : followed_)
    if (f.part == number)
      lagrangian::write_block(problem_.world, m, f.block, {.c = true, .gamma = false});
}

/// Whether the factor serves the next step, too.
bool Live::serves(std::size_t number) const {
  const PartState& state = states_[number];
  const Island& m = problem_.parts[number].m;
  return state.factor.stands && state.factor.steps < kStepsOfFactor && m.touches.empty() &&
         state.factor.softness == state.softness && state.misfit <= kStale * bound_of(m);
}

/// A step with the factor of an earlier one, from the response to the step before.
void Live::solve_by_response(std::size_t number) {
  Part& part = problem_.parts[number];
  lagrangian::StepScratch& scratch = part.m.scratch;
  PartState& state = states_[number];
  Real along = 0, square = 0;
  for (std::size_t r = 0; r < part.m.rows; ++r) {
    const Real y = state.response[r] / part.units[r];
    along += scratch.right[r] * y, square += state.response[r] * y;
  }
  const Real again = square > 0 ? std::clamp(along / square, -kMostAgain, kMostAgain) : 0;
  for (std::size_t r = 0; r < part.m.rows; ++r) {
    const Real y = std::exchange(state.response[r], scratch.right[r]);
    scratch.right[r] -= again * y;
  }
  solve_again(part);
  for (std::size_t i = 0; i < state.way.size(); ++i) scratch.solution[i] += again * state.way[i];
  for (std::size_t r = 0; r < part.m.rows; ++r) scratch.lambda[r] += again * state.pressing[r];
}

/// After a step: what it did, beside what its model foresaw.
void Live::note_response(std::size_t number, Real opened) {
  const Part& part = problem_.parts[number];
  const lagrangian::StepScratch& scratch = part.m.scratch;
  PartState& state = states_[number];
  std::copy_n(scratch.solution.begin(), state.way.size(), state.way.begin());
  for (std::size_t r = 0; r < part.m.rows; ++r)
    if (state.response[r] != 0) state.response[r] += scratch.c[r];
  state.misfit = opened;
  for (const Followed& f : followed_) {
    if (f.part != number) continue;
    const Block& b = part.m.blocks[f.block];
    for (std::size_t r = 0; r < b.rows; ++r)
      if (const std::size_t row = b.first_row + r; weight_of(targets_[f.target], r) > 0)
        state.misfit =
            worse_of(state.misfit, scratch.c[row] + scratch.weights[row] * state.pressing[row]);
  }
}

void Live::solve(std::size_t number) {
  Part& part = problem_.parts[number];
  PartState& state = states_[number];
  const bool again = serves(number);
  if (!again && state.known != Known::all) evaluate(number, Known::all);
  set_weights(part, number);
  if (again) {
    solve_by_response(number);
  } else {
    std::copy_n(part.m.scratch.right.begin(), part.m.rows, state.response.begin());
    solve_equations(part);
    state.factor = {state.softness, 0, true};
  }
  ++state.factor.steps;
}

Real Live::joint_error(std::size_t number) const {
  const Part& part = problem_.parts[number];
  Real worst = 0;
  for (std::size_t i = 0; i < part.m.blocks.size(); ++i) {
    if (is_target_[number][i] || !counts(part, i)) continue;
    const Block& b = part.m.blocks[i];
    for (std::size_t r = b.first_row; r < b.first_row + b.rows; ++r)
      worst = worse_of(worst, part.m.scratch.c[r]);
  }
  return worst;
}

/// The weighted sum of squares of the targets of a part, and the largest error.
Real Live::target_merit(std::size_t number, Real& worst) const {
  Real sum = 0;
  for (const Followed& f : followed_) {
    if (f.part != number) continue;
    const Part& part = problem_.parts[number];
    const Block& b = part.m.blocks[f.block];
    for (std::size_t r = 0; r < b.rows; ++r) {
      const Real weight = weight_of(targets_[f.target], r), c = part.m.scratch.c[b.first_row + r];
      if (!(weight > 0)) continue;
      sum += weight * c * c / part.units[b.first_row + r];
      worst = worse_of(worst, c);
    }
  }
  return sum;
}

/// A step towards the targets. If limits that it passes become active, or others inactive, it is
/// solved again from where it began.
void Live::step(std::size_t number) {
  Part& part = problem_.parts[number];
  Island& m = part.m;
  std::vector<Real>& pressing = states_[number].pressing;
  copy_poses(m.scratch.state, m.scratch.from);
  for (int n = 0;; ++n) {
    solve(number);
    std::copy(m.scratch.lambda.begin(), m.scratch.lambda.end(), pressing.begin());
    const Real turn = turn_of(part);
    assembly::move(part, turn > kMostTurn ? kMostTurn / turn : 1);
    if (turn > kMostTurn) states_[number].factor.stands = false;
    evaluate(number, serves(number) ? Known::residuals : Known::all);
    if (!m.unilateral) return;
    const bool is_last = n == kActiveSets;
    if (!is_last && !takes_active_set(part, pressing)) return;
    states_[number].factor.stands = false;
    if (is_last) return;
    copy_poses(m.scratch.from, m.scratch.state);
    evaluate(number, Known::all);
  }
}

/// Closes laws after a long step, also limits that it has passed, without targets: the least
/// displacement that does. Limits that the targets press against stay active.
Real Live::correct(std::size_t number, Real error) {
  Part& part = problem_.parts[number];
  Island& m = part.m;
  const std::vector<Real>& pressing = states_[number].pressing;
  const Real bound = bound_of(m);
  for (int n = 0; n < kCorrections && error > bound; ++n) {
    if (states_[number].known != Known::all) evaluate(number, Known::all);
    set_weights(part, number);
    for (const Followed& f : followed_) {
      if (f.part != number) continue;
      const Block& b = m.blocks[f.block];
      for (std::size_t r = b.first_row; r < b.first_row + b.rows; ++r)
        m.scratch.weights[r] = kFree * part.units[r], m.scratch.right[r] = 0;
    }
    solve_equations(part);
    states_[number].factor.stands = false;
    for (std::size_t r = 0; r < pressing.size(); ++r)
      if (pressing[r] != 0) m.scratch.lambda[r] = pressing[r];
    assembly::move(part, 1);
    evaluate(number, Known::all);
    error = joint_error(number);
  }
  return error;
}

void Live::iterate_part(std::size_t number, LiveReport& report) {
  Part& part = problem_.parts[number];
  PartState& state = states_[number];
  Island& m = part.m;
  const World& w = problem_.world;
  Real unused = 0;
  if (state.known == Known::nothing)
    lagrangian::update_frames(w, m, 0, kStep), evaluate(number, Known::all), state.moved = true;
  if (std::exchange(state.moved, false))
    look_at_targets(number), state.merit = target_merit(number, unused), state.closed = false;
  step(number);
  last_step_ = std::max(last_step_, largest(m.scratch.solution));
  count(w, part);
  Real error = joint_error(number);
  note_response(number, error);
  error = correct(number, error);
  Real merit = target_merit(number, unused);
  const Real rounding = kRounding * bound_of(m);
  const bool worse = merit > (1 + kSame) * state.merit + rounding * rounding;
  if (worse)
    state.softness = std::min(kSoften * state.softness, kSoftest);
  else if (merit < (1 - kSame) * state.merit)
    state.softness = std::max(kHarden * state.softness, kStiffest);
  // Targets are at rest, and it was not laws that moved the bodies: the step was too long.
  if (worse && state.closed && !(error < 0.5 * state.error)) {
    copy_poses(m.scratch.from, m.scratch.state);
    evaluate(number, Known::all), count(w, part), state.factor.stands = false;
    error = joint_error(number), merit = state.merit;
  }
  target_merit(number, report.target_error);
  state.merit = merit, state.error = error, state.closed = error <= bound_of(m);
  report.joint_error = worse_of(report.joint_error, error);
}

LiveReport Live::iterate() {
  if (!compiled_) compile();
  LiveReport report;
  last_step_ = 0;
  for (std::size_t p = 0; p < problem_.parts.size(); ++p) iterate_part(p, report);
  return report;
}

void Live::write_to(World& world) const {
  for (const Part& part : problem_.parts) write_poses(part, world);
}

}  // namespace pantin::detail::assembly
