// Limits of joints in the energy-momentum method.
//
// Hitting a limit is an impact at its time, where the substep ends: see strike() in
// conserving_ties.cpp. An active limit is a row of its joint, eliminated with those of the kind,
// until its torque would pull. The torque is along the mean of the limit's gradients before and
// after, minus the component that would do work. [Gonzalez 1996]
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/smooth/conserving_joints.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr Real kAtLimit = 1e-10;  // rad: tolerance of a limit
constexpr Real kHit = 1e-6;       // rad: clearance within which it is hit at the end of a substep
/// rad: residual of an active limit after the iterations.
constexpr Real kAngleRounding = 1e-8;
/// rad per step: slower impacts are not resolved in time.
constexpr Real kSlow = 1e-4;
/// Fraction of a step: limits hit within this time of one another are hit simultaneously. Their
/// order would depend on the error of the step, and would break the symmetry of a mechanism.
constexpr Real kTogether = 0.1;
/// rad^2/s: times the step, the largest square of the angle by which a cone's gradient rotates in a
/// substep. A body sliding along a cone goes round it, thin rods in milliseconds. The error of the
/// mid-point rule grows with that square, so it falls with the step.
constexpr Real kBend = 0.3;
/// In the shortest units of time: the shortest substep for that reason.
constexpr Real kShortestBend = 4;
/// In the shortest units of time: the earliest end of a substep.
constexpr Real kSoonest = 1e-3;
/// Least multiplier of an active limit, as a fraction of the island's mass times its size squared.
constexpr Real kLeast = 1e-30;

template <class Do>
void for_each_limit(Island& a, const Do& act) {
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    if (has_limits(a, c))
      for (ConservingLimit& l : a.scratch.conserving_nodes[c].limits) act(l, c);
}

Vec3 spin_of_parent(const World& world, const Island& a, std::size_t c) {
  const std::uint32_t slot =
      a.parents[c] >= 0 ? a.slots[static_cast<std::size_t>(a.parents[c])] : held_body_of(a, c);
  return slot == UINT32_MAX ? Vec3(0) : world.bodies.values()[slot].angular_velocity;
}

/// rad/s: approach to a limit, by the computed velocities.
Real rate_of(const StiffStep& s, std::size_t c, const ConservingLimit& l) {
  const Vec3 of_parent = s.a.parents[c] >= 0
                             ? s.a.memory.vec(kTurnBy, static_cast<std::size_t>(s.a.parents[c]))
                             : spin_of_parent(s.world, s.a, c);
  return glm::dot(l.along, s.a.memory.vec(kTurnBy, c) - of_parent);
}

/// Time at which a limit is hit, as a fraction of the substep.
Real time_of_blow(const ConservingLimit& l, Real h) {
  const Real from = std::max(Real(0), l.clearance_before - 0.5 * kHit), way = l.rate * h;
  const Real bend = l.clearance_before - way - l.clearance;
  return 2 * from / (way + std::sqrt(std::max(Real(0), way * way + 4 * bend * from)));
}

/// rad: largest rotation of an active cone's gradient over the substep, relative to the parent.
Real bend_of(const StiffStep& s) {
  constexpr std::size_t kSwing = 2;  // index, after the two limits of the twist
  Real bend = 0;
  for (std::size_t c = 0; c < s.a.joints.size(); ++c) {
    if (!has_limits(s.a, c) || turns_of(s.a.joints[c].joint.kind) != Turns::freely) continue;
    const ConservingLimit& l = s.a.scratch.conserving_nodes[c].limits[kSwing];
    if (!l.watched || !l.acts) continue;
    const JointEnds ends = ends_of(s, c);
    const Vec3 carried = ends.parent1 * (glm::conjugate(ends.parent0) * l.along_before);
    bend = std::max(bend, glm::distance(glm::normalize(l.along), glm::normalize(carried)));
  }
  return bend;
}

/// Whether the substep has to be repeated shorter, since a cone's gradient rotates too far in it.
bool cones_bend(const StiffStep& s, TiedPart& with) {
  const Real bend = bend_of(s), most = std::sqrt(kBend * s.part.whole);
  if (!with.may_divide || bend <= kAngleRounding) return false;
  with.longest =
      std::max(kShortestBend, 0.8 * most / bend * with.units);  // it may rotate faster then
  if (bend <= most || with.longest >= with.units) return false;
  with.shorter = with.longest;
  return true;
}

/// Half the impulse of an active limit over the substep; negative if it pulls.
Real push_of(const StiffStep& s, std::size_t c, const ConservingLimit& l) {
  PANTIN_ASSERT(l.state == LimitState::held);
  const ConservingNode& n = s.a.scratch.conserving_nodes[c];
  return -glm::dot(l.column, n.passed - 0.5 * s.h * n.exerted);
}

}  // namespace

bool can_limit(const World& world, const Island& a) {
  for (std::size_t c = 0; c < a.joints.size(); ++c) {
    const PackedJoint& j = a.joints[c];
    if (!has_limits(a, c)) continue;
    const std::uint32_t held = held_body_of(a, c);
    const Quat parent =
        a.parents[c] >= 0
            ? world.bodies.values()[a.slots[static_cast<std::size_t>(a.parents[c])]].pose.rotation
        : held == UINT32_MAX ? kIdentity
                             : world.bodies.values()[held].pose.rotation;
    const Quat own = world.bodies.values()[a.slots[c]].pose.rotation;
    if (is_far_from_limits(j, own, parent, kFarFromLimits)) continue;
    JointLimit limits[4];
    find_limits(j, own, parent, limits);
    for (const JointLimit& l : limits)
      if (l.watched && l.clearance < -2 * kHit) return false;
  }
  return true;
}

void begin_limits(Island& a) {
  for_each_limit(a, [&](ConservingLimit& l, std::size_t c) {
    Real& lambda = a.joint_memory[c].lambdas[&l - a.scratch.conserving_nodes[c].limits];
    l.at_start = lambda != 0 ? LimitState::held : LimitState::open;
    lambda = 0;
  });
}

void begin_limits(const World& world, Island& a, const StepPart& part, Blows blows) {
  const StiffStep s{world, a, (part.end - part.begin) * part.whole, part};
  JointLimit found[4];
  for_each_limit(a, [&](ConservingLimit& l, std::size_t c) {
    const std::ptrdiff_t k = &l - a.scratch.conserving_nodes[c].limits;
    const JointEnds ends = ends_of(s, c);
    if (k == 0) find_limits(a.joints[c], ends.own0, ends.parent0, found);
    const LimitState at_start = l.at_start;
    l = {};
    l.at_start = at_start;
    l.watched = found[k].watched, l.both_ways = found[k].both_ways;
    l.along = l.along_before = found[k].along;
    l.clearance = l.clearance_before = found[k].clearance;
    if (!l.watched) return;
    const Body& own = world.bodies.values()[a.slots[c]];
    l.rate = glm::dot(l.along, own.angular_velocity - spin_of_parent(world, a, c));
    if (l.both_ways || (at_start == LimitState::held && l.clearance <= kHit))
      l.state = LimitState::held;
    else if (blows == Blows::followed && l.rate * part.whole > kSlow)
      l.state = LimitState::followed;
  });
}

void look_at_limits(const StiffStep& s, std::size_t c, const JointEnds& ends) {
  if (!s.a.joints[c].joint.limits.any()) return;
  JointLimit found[4];
  find_limits(s.a.joints[c], ends.own1, ends.parent1, found);
  for (int k = 0; k < 4; ++k) {
    ConservingLimit& l = s.a.scratch.conserving_nodes[c].limits[k];
    l.watched = found[k].watched, l.clearance = found[k].clearance;
    if (l.watched) l.along = found[k].along;
  }
}

bool is_clamped(const Island& a, std::size_t c) {
  if (!a.joints[c].joint.limits.any()) return false;
  Real least = 0;
  for (const ConservingLimit& l : a.scratch.conserving_nodes[c].limits)
    if (l.watched) least = std::min(least, l.clearance);
  return least < 0 && least >= -kAngleRounding;
}

bool change_limits(const StiffStep& s, std::size_t c) {
  bool changes = false;
  for (ConservingLimit& l : s.a.scratch.conserving_nodes[c].limits) {
    if (!l.watched || l.both_ways) continue;
    if (l.state == LimitState::open && l.clearance < -kAtLimit) {
      l.state = LimitState::held, changes = true;
    } else if (l.state == LimitState::held && l.column != Vec3(0) &&
               push_of(s, c, l) * s.h * mobility_about(s, c, l.along) < -kAtLimit) {
      l.state = LimitState::open, l.column = Vec3(0), changes = true;
    }
  }
  return changes;
}

void add_limit_rows(const StiffStep& s, std::size_t c, Unknown unknown, JointRows& rows) {
  for (ConservingLimit& l : s.a.scratch.conserving_nodes[c].limits) {
    l.column = Vec3(0);
    const bool moves = unknown == Unknown::displacement;
    if (!(moves ? l.state == LimitState::held : l.acts) || rows.count == 3) continue;
    PANTIN_ASSERT(rows.count < 3);
    const std::size_t n = rows.count++;
    rows.limit[n] = &l;
    rows.gradient[n] = rows.torque[n] = l.along;
    rows.off[n] = moves ? -l.clearance : 0;
    if (!moves) continue;
    const Vec3 mean = 0.5 * (l.along_before + l.along), turned = turned_by(s, c, ends_of(s, c));
    const Real turned2 = glm::dot(turned, turned);
    const Real works = glm::dot(mean, turned) - (l.clearance_before - l.clearance);
    rows.torque[n] = turned2 > 1e-16 ? mean - works / turned2 * turned : mean;
  }
}

bool limits_end_early(const StiffStep& s, TiedPart& with) {
  Real first = 1;
  bool hit = false;
  for_each_limit(s.a, [&](ConservingLimit& l, std::size_t) {
    l.acts = l.state == LimitState::held;
    hit = hit || (l.acts && l.clearance_before > kHit);
    if (l.state != LimitState::followed || !l.watched || l.clearance > kHit) return;
    if (l.clearance < -kAtLimit && with.units > kSoonest)
      first = std::min(first, time_of_blow(l, s.h));
    l.state = LimitState::hit, hit = true;
  });
  if (first < 1) {
    PANTIN_ASSERT(is_range(0, first));
    with.shorter = std::max(first * with.units, kSoonest);
    return true;
  }
  if (cones_bend(s, with)) return true;
  with.struck = with.struck || hit;
  return false;
}

bool any_limit(const Island& a) {
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    if (has_limits(a, c)) return true;
  return false;
}

bool any_limit_hit(const Island& a) {
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    for (const ConservingLimit& l : a.scratch.conserving_nodes[c].limits)
      if (has_limits(a, c) && l.state == LimitState::hit) return true;
  return false;
}

Real begin_blow(const StiffStep& s) {
  Island& a = s.a;
  PANTIN_ASSERT(a.scratch.conserving_nodes.size() == a.count());
  StepScratch& r = a.scratch;
  for (std::size_t c = 0; c < a.count(); ++c) {
    r.conserving_nodes[c].end_joint = r.work.vec(kEndJoint, c);
    const Vec3 turn = a.memory.vec(kTurnBy, c), arm = r.work.vec(kEndArm, c);
    const Vec3 impulse =
        a.constants.at(kMass, c) * (a.memory.vec(kMove, c) + glm::cross(turn, arm));
    const Mat3 inertia = world_inertia(r.work.quat(kEndRotation, c), a.constants.vec(kInertia, c));
    r.work.set(kImpulse, c, impulse);
    r.work.set(kTorqueImpulse, c, -(inertia * turn) - glm::cross(arm, impulse));
    ConservingNode& n = r.conserving_nodes[c];
    n.impulse_before = a.memory.vec(kLambda, c), n.passed_before = n.passed;
    n.damped = Vec3(0), n.damping = Mat3(0);
  }
  Real fastest = 0;
  for_each_limit(a, [&](ConservingLimit& l, std::size_t c) {
    if (!l.watched) return;
    const Real rate = rate_of(s, c, l);
    if (l.clearance > std::max(kHit, kTogether * s.part.whole * rate) && !l.both_ways) return;
    l.state = LimitState::hit, l.acts = true;
    fastest = std::max(fastest, std::abs(rate));
  });
  return fastest;
}

void respond_to_blow(StiffStep& s) {
  Island& a = s.a;
  for (std::size_t c = 0; c < a.count(); ++c) {
    ConservingNode& n = a.scratch.conserving_nodes[c];
    n.passed = n.passed_before, a.memory.set(kLambda, c, n.impulse_before);
    n.tie_passed = a.scratch.tie_impulses[c] = a.scratch.tie_torques[c] = Vec3(0);
  }
  const ConservingJoints joints = hooks_of(s);
  joints.inward(joints.context, Unknown::velocity);
  joints.outward(joints.context, Unknown::velocity);
}

bool release_limit(const StiffStep& s, Real rate) {
  const StepScratch& r = s.a.scratch;
  ConservingLimit* out = nullptr;
  Real most = rate;
  for_each_limit(s.a, [&](ConservingLimit& l, std::size_t c) {
    if (!l.acts || l.both_ways) return;
    const ConservingNode& n = r.conserving_nodes[c];
    Vec3 torque =
        2.0 * (n.passed - n.passed_before) + n.tie_passed + n.torque_y * r.tie_impulses[c];
    if (s.a.parents[c] >= 0)
      torque += n.torque_p * r.tie_torques[static_cast<std::size_t>(s.a.parents[c])];
    const Real pull = glm::dot(l.column, torque) * mobility_about(s, c, l.along);
    if (pull > most) most = pull, out = &l;
  });
  if (out) out->acts = false;
  return out != nullptr;
}

bool catch_limit(const StiffStep& s, Real rate) {
  ConservingLimit* in = nullptr;
  Real most = rate;
  for_each_limit(s.a, [&](ConservingLimit& l, std::size_t c) {
    if (l.state != LimitState::hit || l.acts) return;
    if (const Real of = rate_of(s, c, l); of > most) most = of, in = &l;
  });
  if (in) in->acts = true;
  return in != nullptr;
}

void end_blow(Island& a) {
  for (std::size_t c = 0; c < a.count(); ++c)
    a.scratch.work.set(kEndJoint, c, a.scratch.conserving_nodes[c].end_joint);
  for_each_limit(a, [](ConservingLimit& l, std::size_t) {
    if (l.state == LimitState::hit) l.state = l.acts ? LimitState::held : LimitState::open;
  });
}

void store_limits(Island& a, std::size_t c, const StepPart& part) {
  if (!a.joints[c].joint.limits.any()) return;
  const ConservingNode& n = a.scratch.conserving_nodes[c];
  const Real h = (part.end - part.begin) * part.whole;
  bool holds = false;
  for (std::size_t k = 0; k < 4; ++k) {
    ConservingLimit& l = a.scratch.conserving_nodes[c].limits[k];
    Real& lambda = a.joint_memory[c].lambdas[k];
    l.at_start = l.state;
    if (l.state != LimitState::held) {
      if (part.end == 1) lambda = 0;
      continue;
    }
    const Real push = -2 * part.whole * glm::dot(l.column, n.passed - 0.5 * h * n.exerted);
    lambda += push;
    if (!l.both_ways) lambda = std::max(lambda, kLeast * a.mass * a.size * a.size);
    holds = holds || !l.both_ways;
  }
  if (part.end == 1) a.stops_hit += holds;
}

}  // namespace pantin::detail::articulated
