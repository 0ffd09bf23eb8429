#include "engine/assembly/live.hpp"

#include <algorithm>
#include <cmath>

#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"

namespace pantin::detail::assembly {

using lagrangian::Block;
using lagrangian::BlockKind;
using lagrangian::Island;

namespace {

/// Compliance of rows of targets, relative to their diagonal: its bounds, and how it changes.
constexpr Real kSoftest = 1, kStiffest = 1e-7, kSoften = 4, kHarden = 0.5;
/// Joint error after an iteration, relative to the size, above which targets pull more softly.
constexpr Real kJointError = 1e-7;
/// Fractions of the size, and rad, by which a target may pull in one iteration.
constexpr Real kMostPull = 0.05, kMostTurn = 0.3;
/// Compliance of laws, only so that dependent rows have pivots; of rows that a target leaves free.
constexpr Real kHard = 1e-12, kFree = 1e12;
/// A limit that is beyond its bound by more, after a step, is met: the step is solved again.
constexpr Real kMet = 1e-9;
constexpr int kMostRetries = 4;
constexpr Real kStep = 1e-3;  // s; frames are at rest

}  // namespace

Live::Live(const World& world, std::vector<Entity> held) : model_(world), held_(std::move(held)) {}

std::size_t Live::add(const LiveTarget& target) {
  targets_.push_back(target), used_.push_back(true), compiled_ = false;
  return targets_.size() - 1;
}

void Live::remove(std::size_t target) {
  if (has(target)) used_[target] = false, compiled_ = false;
}

void Live::hold(Entity body, bool is_held) {
  std::erase(held_, body);
  if (is_held) held_.push_back(body);
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
}

void Live::place(const Followed& f) {
  const LiveTarget& t = targets_[f.target];
  if (t.goal == Goal::point)
    problem_.world.pins[f.entity].target = t.target.position;
  else
    problem_.world.bodies[f.entity].pose = t.target;
  states_[f.part].known = false;
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
      const Entity pin = w.add_pin({.body = t.body, .anchor = t.own.position,
                                    .target = t.target.position});
      followed_.push_back({i, 0, 0, pin}), laws.push_back(pin);
      continue;
    }
    Body frame;
    frame.motion = Motion::fixed, frame.pose = t.target;
    const Entity at = w.add_body(frame);
    Joint joint;
    joint.kind = t.goal == Goal::pose ? JointKind::fixed : JointKind::cylindrical;
    joint.anchor_a = t.own.position, joint.frames.set(t.own.rotation, kIdentity);
    followed_.push_back({i, 0, 0, at}), laws.push_back(add_link(w, {t.body, at, joint}));
  }
  problem_ = make_problem(w, held_);
  states_.assign(problem_.parts.size(), {});
  is_target_.clear();
  std::size_t most_blocks = 0;
  for (std::size_t p = 0; p < problem_.parts.size(); ++p) {
    const Island& m = problem_.parts[p].m;
    is_target_.emplace_back(m.blocks.size(), 0);
    most_blocks = std::max(most_blocks, m.blocks.size());
    for (std::size_t i = 0; i < m.blocks.size(); ++i)
      for (std::size_t k = 0; k < laws.size(); ++k)
        if (!lagrangian::is_compliant(m.blocks[i].kind) &&
            joint_of(problem_.world, m.blocks[i]) == laws[k])
          followed_[k].part = p, followed_[k].block = i, is_target_[p][i] = 1;
  }
  memory_.reserve(most_blocks);
  std::erase_if(followed_, [&](const Followed& f) {  // of held bodies
    return f.part >= is_target_.size() || f.block >= is_target_[f.part].size() ||
           !is_target_[f.part][f.block];
  });
  compiled_ = true;
}

/// Compliances and right-hand sides; pulls of targets are bounded.
void Live::set_weights(Part& part, std::size_t number) {
  Island& m = part.m;
  lagrangian::StepScratch& scratch = m.scratch;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    const bool on = !lagrangian::is_compliant(b.kind) && lagrangian::is_active(m, i);
    for (std::size_t r = b.first_row; r < b.first_row + b.rows; ++r) {
      scratch.weights[r] = on ? kHard * part.units[r] : 0;
      scratch.right[r] = on ? -scratch.c[r] : 0;
    }
  }
  const Real softness = states_[number].softness;
  for (const Followed& f : followed_) {
    if (f.part != number) continue;
    const LiveTarget& t = targets_[f.target];
    const Block& b = m.blocks[f.block];
    // Rows 0 and 1 of an aim only keep the line parallel to the frame, which it need not be.
    const std::size_t free = t.goal == Goal::aim ? 2 : 0;
    Real pull = 0, turn = 0;
    for (std::size_t r = 0; r < b.rows; ++r) {
      const std::size_t row = b.first_row + r;
      const bool turns = t.goal == Goal::pose && r >= 3;
      const Real weight = turns ? t.turn_weight : t.weight;
      const bool is_free = r < free || !(weight > 0);
      scratch.weights[row] = is_free ? kFree : softness / weight * part.units[row];
      if (is_free) scratch.right[row] = 0;
      (turns ? turn : pull) += scratch.right[row] * scratch.right[row];
    }
    const Real most = kMostPull * std::max(m.size, m.reach);
    const Real cut = pull > most * most ? most / std::sqrt(pull) : 1,
               cut_turn = turn > kMostTurn * kMostTurn ? kMostTurn / std::sqrt(turn) : 1;
    for (std::size_t r = 0; r < b.rows; ++r)
      scratch.right[b.first_row + r] *= t.goal == Goal::pose && r >= 3 ? cut_turn : cut;
  }
}

void Live::solve(Part& part, std::size_t number) {
  Island& m = part.m;
  set_weights(part, number);
  constexpr Real kRegularisation = 1e-11;
  lagrangian::factor_soft(m, m.loops ? kRegularisation : 0);
  constexpr Real kUnrefined = std::numeric_limits<Real>::infinity();
  lagrangian::solve(m, {{}, m.scratch.right}, {m.scratch.solution, m.scratch.lambda}, kUnrefined);
}

Real Live::error_of(const Part& part, std::size_t number, bool of_targets) const {
  Real worst = 0;
  const Island& m = part.m;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    if ((is_target_[number][i] != 0) != of_targets || !counts(part, i)) continue;
    const Block& b = m.blocks[i];
    const bool is_aim = of_targets && b.rows == 4;
    for (std::size_t r = is_aim ? 2 : 0; r < b.rows; ++r)
      worst = std::max(worst, std::abs(m.scratch.c[b.first_row + r]));
  }
  return worst;
}

void Live::iterate_part(std::size_t number, LiveReport& report) {
  Part& part = problem_.parts[number];
  PartState& state = states_[number];
  Island& m = part.m;
  const World& w = problem_.world;
  if (!state.known) {
    lagrangian::update_frames(w, m, 0, kStep);
    look(w, part);
    state.known = true;
  }
  for (int n = 0;; ++n) {
    solve(part, number);
    if (m.unilateral) memory_ = m.memory;
    m.scratch.from = m.scratch.state;
    assembly::move(part, 1);
    look(w, part);
    if (!m.unilateral || n == kMostRetries) break;
    bool met = false;
    for (std::size_t i = 0; i < m.blocks.size(); ++i) {
      const bool is_new = lagrangian::is_one_sided(m, i) && !memory_[i].active &&
                          m.scratch.c[m.blocks[i].first_row] < -kMet;
      memory_[i].active = memory_[i].active || is_new;
      met = met || is_new;
    }
    if (!met) break;
    ++report.retries;
    m.scratch.state = m.scratch.from, m.memory = memory_;
    lagrangian::update_kinematics(m);
    lagrangian::write_all_rows(w, m, {true, false});
    lagrangian::clear_rolling(m);
  }
  count(w, part);
  const Real error = error_of(part, number, false);
  const Real bound = kJointError * std::max(m.size, m.reach);
  state.softness = std::clamp(state.softness * (error > bound ? kSoften : kHarden), kStiffest,
                              kSoftest);
  report.joint_error = std::max(report.joint_error, error);
  report.target_error = std::max(report.target_error, error_of(part, number, true));
}

LiveReport Live::iterate() {
  if (!compiled_) compile();
  LiveReport report;
  for (std::size_t p = 0; p < problem_.parts.size(); ++p) iterate_part(p, report);
  return report;
}

Real Live::last_step() const {
  Real most = 0;
  for (const Part& part : problem_.parts)
    for (const Vec3& way : part.m.scratch.solution) most = std::max(most, glm::dot(way, way));
  return std::sqrt(most);
}

void Live::write_to(World& world) const {
  for (const Part& part : problem_.parts) write_poses(part, world);
}

}  // namespace pantin::detail::assembly
