// Joints that constrain rotations, in the energy-momentum method: hinges, universals, fixed joints,
// and the torques of drives, springs, friction and motors (conserving_torques.cpp).
//
// Joint kinds that restrict rotation keep axes of both bodies perpendicular: p . s = 0, p fixed in
// the joint's body a and s in b. Such a row is bilinear in the axes. So the torque along its
// gradient at the mean of the poses, mean(s) x mean(p), does no work and conserves angular
// momentum. [Betsch & Steinmann 2001]
//
// The unknowns of a body are its rotation t and the displacement y of its own joint point; t_p is
// the rotation of its parent. Elimination from the leaves to the roots gives
//   t = turn + turn_y y + turn_p t_p                 with the joint's rows satisfied
//   impulse at the joint = force_y y + force_p t_p - force
//   torque from the parent = torque + torque_y y + torque_p t_p
// The rows are eliminated first: t is the prescribed rotation plus one in the free directions. So
// the inertia in the constrained directions does not affect the conditioning.
#include "engine/solvers/articulated/smooth/conserving_joints.hpp"

#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/contact/detect.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/world/joint_drive.hpp"

namespace pantin::detail::articulated {
namespace {

Mat3 rows_of(const Real* m, std::size_t row_stride, std::size_t stride) {
  Mat3 out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[j][i] =
          m[static_cast<std::size_t>(i) * row_stride + static_cast<std::size_t>(j) * stride];
  return out;
}

/// A body in an elimination: the sum over itself and its children, and the resulting node.
struct Elimination {
  const StiffStep& step;
  std::size_t c;
  Unknown unknown;
  ConservingSum& sum;
  ConservingNode& node;
  bool moves() const { return unknown == Unknown::displacement; }
};

/// Adds the body's own equations.
void add_own(const Elimination& e) {
  const Island& a = e.step.a;
  const std::size_t c = e.c;
  ConservingSum& s = e.sum;
  const LaneTable& work = a.scratch.work;
  const bool moves = e.moves();
  const Real m = a.constants.at(kMass, c) * (moves ? 1 / e.step.h : 1);
  const Vec3 end = m * work.vec(kEndArm, c), arm = moves ? m * work.vec(kMeanArm, c) : end;
  const Vec3 torque = work.vec(kTorqueImpulse, c), impulse = work.vec(kImpulse, c);
  for (int i = 0; i < 3; ++i) {
    const Vec3 row = work.vec(kTurn + 3 * static_cast<std::size_t>(i), c);
    for (int j = 0; j < 3; ++j) s.tt[j][i] += row[j];
  }
  s.ty += cross_matrix(arm), s.yt -= cross_matrix(end), s.yy += Mat3(m);
  s.by_torque -= torque, s.by_force += moves ? -impulse : impulse;
  if (moves) s.torque += torque, s.impulse += impulse;
}

void add_ties(const Island& a, std::size_t c, ConservingSum& s) {
  const Real* const t = &a.scratch.tie_blocks[kTieBlock * c];
  s.tt += rows_of(t + kTieTurn, 3, 1);
  if (a.scratch.tie_grounded[c])
    s.ty += rows_of(t + kTieTurnMove, 3, 1), s.yt += rows_of(t + kTieMoveTurn, 3, 1),
        s.yy += rows_of(t + kTieMoveMove, 3, 1);
  const auto vec = [&](std::size_t i) { return Vec3(t[i], t[i + 1], t[i + 2]); };
  const Vec3 impulse = vec(kTieImpulse), torque = vec(kTieTorque);
  s.by_torque -= torque, s.by_force -= impulse, s.torque += torque, s.impulse += impulse;
}

/// Correction for equations written in axes that rotate with the body: see the kernels' turn_axes.
Mat3 turning_axes(Vec3 torque, Vec3 turned) {
  const Vec3 n = 0.5 * torque, d = -0.5 * turned;
  return glm::outerProduct(n, d) - Mat3(glm::dot(n, d)) + cross_matrix(n);
}

/// The rotation of a root's anchor body at a fraction of the whole step.
Quat parent_at(const StiffStep& s, std::size_t c, Real fraction) {
  const std::uint32_t held = held_body_of(s.a, c);
  if (held == UINT32_MAX) return kIdentity;
  const Body& b = s.world.bodies.values()[held];
  if (b.teleport || fraction == 1) return b.pose.rotation;
  return glm::normalize(from_rotation_vector((fraction - 1) * s.part.whole * b.angular_velocity) *
                        b.pose.rotation);
}

/// Completes a node whose joint restricts no rotation and exerts no torque.
void eliminate_free(const ConservingSum& s, ConservingNode& n) {
  n.compliance = glm::inverse(n.turning);
  n.turn = n.compliance * s.by_torque, n.turn_y = -(n.compliance * s.ty), n.turn_p = Mat3(0);
  n.torque = Vec3(0), n.torque_y = n.torque_p = Mat3(0);
  n.passes_torque = false;
}

/// The same with rows and torques. Returns the torque impulse at the iterate.
Vec3 eliminate_stiff(const Elimination& e) {
  const auto& [step, c, unknown, s, n] = e;
  PANTIN_ASSERT(step.a.joints[c].stiff && step.a.parents[c] != kFree);
  const PackedJoint& j = step.a.joints[c];
  const JointEnds ends = ends_of(step, c);
  const Directions d = directions_of(j, ends);
  JointRows rows = find_rows(j, d, unknown);
  if (j.joint.limits.any()) add_limit_rows(step, c, unknown, rows);
  Vec3 along[3], free[3], to[3], columns[3];
  const std::size_t count = find_free(rows.gradient, rows.count, free);
  find_free(rows.torque, rows.count, to);
  invert_rows(rows.gradient, rows.count, along);
  Vec3 current(0);  // torque impulse on the own body
  RowTurn turn;
  if (unknown == Unknown::displacement) {
    find_torque(step, c, ends);
    const Real half = 0.5 * step.h;
    // Multipliers that balance the remaining torque, by the pseudo-inverse.
    invert_rows(rows.torque, rows.count, columns);
    Real multipliers[3] = {0, 0, 0};
    current = half * n.exerted;
    const Vec3 rest = s.torque - current;
    for (std::size_t k = 0; k < rows.count; ++k) {
      multipliers[k] = glm::dot(columns[k], rest);
      current += multipliers[k] * rows.torque[k];
    }
    turn = turn_of_rows(j, d, multipliers);
    turn.own -= half * n.stiffness, turn.parent += half * n.stiffness;
    n.turning += turning_axes(s.torque - current, step.a.memory.vec(kTurned, c));
  } else {
    if (rows.count > 0 && rows.limit[rows.count - 1]) invert_rows(rows.torque, rows.count, columns);
    current = n.damped, turn.own = -n.damping, turn.parent = n.damping;
  }
  for (std::size_t k = 0; k < rows.count; ++k)
    if (rows.limit[k]) rows.limit[k]->column = columns[k];
  const Mat3 system = n.turning - turn.own;
  n.compliance = reduced_inverse(system, free, to, count);
  Mat3 prescribed(0);  // rotation per rotation of the parent
  Vec3 back(0);
  for (std::size_t k = 0; k < rows.count; ++k) {
    prescribed += glm::outerProduct(along[k], rows.gradient[k]);
    back -= rows.off[k] * along[k];
  }
  if (unknown == Unknown::displacement && n.yield == 0 && is_actuated(j)) {
    // The response of the rotation to a torque, without the stiffness of the law itself.
    const Real half = 0.5 * step.h, whole = half * glm::dot(n.axis, n.compliance * n.axis);
    n.yield = whole / (1 - std::min(whole * n.slope, Real(1 - 1e-9)));
  }
  const Vec3 right = s.by_torque + current;
  n.turn = back + n.compliance * (right - system * back);
  n.turn_y = -(n.compliance * s.ty);
  n.turn_p = prescribed + n.compliance * (turn.parent - system * prescribed);
  n.torque = n.turning * n.turn - s.by_torque;
  n.torque_y = s.ty + n.turning * n.turn_y, n.torque_p = n.turning * n.turn_p;
  n.passes_torque = true;
  return current;
}

/// Adds an eliminated body to its parent.
void give_parent(const Elimination& e, Vec3 current, ConservingSum& p) {
  const ConservingNode& n = e.node;
  const ConservingSum& child = e.sum;
  const LaneTable& work = e.step.a.scratch.work;
  const Vec3 end = work.vec(kEndReach, e.c), reach = e.moves() ? work.vec(kMeanReach, e.c) : end;
  const Mat3 back = cross_matrix(end), out = cross_matrix(reach);
  const Mat3 by_turn = (n.passes_torque ? n.force_p : Mat3(0)) - n.force_y * back;
  p.yy += n.force_y, p.yt += by_turn, p.by_force += n.force;
  const Mat3 across = out * n.force_y;
  p.ty += across, p.tt += out * by_turn, p.by_torque += glm::cross(reach, n.force);
  if (n.passes_torque) {
    p.ty += n.torque_y, p.tt += n.torque_p - n.torque_y * back;
    p.by_torque -= n.torque;
  }
  if (!e.moves()) return;
  const Vec3 half = 0.5 * child.impulse;
  p.tt += glm::outerProduct(end, half) - Mat3(glm::dot(end, half));
  p.impulse += child.impulse, p.torque += glm::cross(reach, child.impulse) + current;
}

void eliminate_all(const StiffStep& step, Unknown unknown) {
  Island& a = step.a;
  StepScratch& r = a.scratch;
  PANTIN_ASSERT(r.conserving_sums.size() == a.count() && r.conserving_nodes.size() == a.count());
  std::fill(r.conserving_sums.begin(), r.conserving_sums.end(), ConservingSum{});
  for (std::size_t c = a.count(); c-- > 0;) {
    ConservingSum& s = r.conserving_sums[c];
    ConservingNode& n = r.conserving_nodes[c];
    const Elimination e{step, c, unknown, s, n};
    add_own(e);
    const bool moves = e.moves();
    if (moves && !r.ties.empty()) add_ties(a, c, s);
    n.turning = s.tt, n.crossing = s.yt;
    Vec3 current(0);
    const bool is_free = a.parents[c] == kFree || !a.joints[c].stiff;
    if (is_free) {
      if (moves) n.turning += turning_axes(s.torque, a.memory.vec(kTurned, c));
      eliminate_free(s, n);
    } else {
      current = eliminate_stiff(e);
    }
    n.force = s.by_force - s.yt * n.turn;
    n.force_y = s.yy + s.yt * n.turn_y;
    if (n.passes_torque) n.force_p = s.yt * n.turn_p;
    if (a.parents[c] < 0) continue;
    give_parent(e, current, r.conserving_sums[static_cast<std::size_t>(a.parents[c])]);
  }
}

void inward(void* context, Unknown unknown) {
  StiffStep& step = *static_cast<StiffStep*>(context);
  // The laws of springs and motors depend on `yield`, which a first elimination finds.
  if (!step.knows_yields) eliminate_all(step, unknown);
  step.knows_yields = true;
  eliminate_all(step, unknown);
}

/// The motion of a root's joint and the rotation of its anchor body.
struct Held {
  Vec3 move{0}, turn{0};
};

Held held_at(const StiffStep& step, std::size_t c, std::size_t tree, Unknown unknown) {
  PANTIN_ASSERT(step.a.parents[c] < 0 && tree < step.a.trees.size());
  Held held;
  if (step.a.parents[c] == kFree) {
    const ConservingNode& n = step.a.scratch.conserving_nodes[c];
    held.move = glm::inverse(n.force_y) * n.force;
    return held;
  }
  if (unknown == Unknown::displacement) return held;
  PANTIN_ASSERT(3 * tree + 3 <= step.a.scratch.anchor_velocities.size());
  const Real* v = &step.a.scratch.anchor_velocities[3 * tree];
  held.move = {v[0], v[1], v[2]};
  const std::uint32_t body = held_body_of(step.a, c);
  if (body != UINT32_MAX) held.turn = step.world.bodies.values()[body].angular_velocity;
  return held;
}

/// The changes at a joint in an iteration.
struct JointChange {
  Vec3 move, turn, turn_of_parent;
};

/// Predicts the torques through a joint after an iteration.
void expect(ConservingNode& n, const JointChange& by) {
  const Vec3 relative = by.turn - by.turn_of_parent;
  n.passed = n.torque + n.torque_y * by.move + n.torque_p * by.turn_of_parent;
  n.expected -= n.slope * glm::dot(n.axis, relative);
  n.exerted -= n.stiffness * relative;
}

void outward(void* context, Unknown unknown) {
  const StiffStep& step = *static_cast<const StiffStep*>(context);
  Island& a = step.a;
  std::size_t tree = 0;
  for (std::size_t c = 0; c < a.count(); ++c) {
    ConservingNode& n = a.scratch.conserving_nodes[c];
    Vec3 y, turn_p;
    if (a.parents[c] < 0) {
      const Held held = held_at(step, c, tree++, unknown);
      y = held.move, turn_p = held.turn;
    } else {
      const auto p = static_cast<std::size_t>(a.parents[c]);
      turn_p = a.memory.vec(kTurnBy, p);
      y = a.memory.vec(kMove, p) + glm::cross(turn_p, a.scratch.work.vec(kEndReach, c));
    }
    Vec3 t = n.turn + n.turn_y * y;
    Vec3 impulse = n.force_y * y - n.force;
    if (n.passes_torque) {
      t += n.turn_p * turn_p, impulse += n.force_p * turn_p;
      if (unknown == Unknown::displacement) expect(n, {y, t, turn_p});
      if (unknown == Unknown::velocity)
        n.passed += 0.5 * (n.torque + n.torque_y * y + n.torque_p * turn_p - n.damped +
                           n.damping * (t - turn_p));
    }
    a.memory.set(kMove, c, y), a.memory.set(kTurnBy, c, t);
    a.memory.set(
        kLambda, c,
        unknown == Unknown::displacement ? impulse : a.memory.vec(kLambda, c) + 0.5 * impulse);
  }
}

void align(void* context) {
  const StiffStep& step = *static_cast<const StiffStep*>(context);
  Island& a = step.a;
  for (std::size_t c = 0; c < a.count(); ++c) {
    const PackedJoint& j = a.joints[c];
    if (a.parents[c] == kFree || !j.stiff) continue;
    const JointEnds ends = ends_of(step, c);
    look_at_limits(step, c, ends);
    const bool clamped = is_clamped(a, c);
    if (turns_of(j.joint.kind) == Turns::freely && !clamped) continue;
    const Quat rotation = joint_rotation(j, ends.own1, ends.parent1);
    a.scratch.work.set(kEndRotation, c,
                       own_rotation(j, ends.parent1,
                                    clamped ? allowed_rotation(j.joint, rotation)
                                            : allowed_by_kind(j.joint.kind, rotation)));
  }
}

/// Whether a joint has a drive or a motor, or is held by a body that moves.
bool moves_by_itself(const StiffStep& s, std::size_t c) {
  if (s.a.joints[c].drive != UINT32_MAX) return true;
  if (is_actuated(s.a.joints[c]) && dof_of(s.world, s.a, c).motor.kind != MotorKind::none)
    return true;
  const std::uint32_t holder = s.a.parents[c] < 0 ? held_body_of(s.a, c) : UINT32_MAX;
  return holder != UINT32_MAX && contact::moves(s.world.bodies.values()[holder]);
}

AtEnd add_work(void* context, double& released) {
  const StiffStep& step = *static_cast<const StiffStep*>(context);
  const Island& a = step.a;
  AtEnd at_end = AtEnd::keeps;
  for (std::size_t c = 0; c < a.count(); ++c) {
    if (!a.joints[c].stiff || !exerts_torque(a.joints[c]) || a.parents[c] == kFree) continue;
    const ConservingNode& n = a.scratch.conserving_nodes[c];
    released += glm::dot(n.exerted, turned_by(step, c, ends_of(step, c)));
    if (n.damping == Mat3(0)) continue;
    const bool drives = moves_by_itself(step, c);
    at_end = std::max(at_end, drives ? AtEnd::drives : AtEnd::damps);
  }
  return at_end;
}

}  // namespace

JointEnds ends_of(const StiffStep& s, std::size_t c) {
  const LaneTable& work = s.a.scratch.work;
  JointEnds ends;
  ends.own0 = s.world.bodies.values()[s.a.slots[c]].pose.rotation;
  ends.own1 = work.quat(kEndRotation, c);
  if (s.a.parents[c] >= 0) {
    const auto p = static_cast<std::size_t>(s.a.parents[c]);
    ends.parent0 = s.world.bodies.values()[s.a.slots[p]].pose.rotation;
    ends.parent1 = work.quat(kEndRotation, p);
  } else {
    ends.parent0 = parent_at(s, c, s.part.begin), ends.parent1 = parent_at(s, c, s.part.end);
  }
  return ends;
}

void begin_joints(World& world, Island& a) {
  a.drives_capped = a.stops_hit = 0;
  begin_limits(a);
  for (JointMemory& memory : a.joint_memory) memory.torque = Vec3(0), memory.actuation = 0;
  for (const PackedJoint& j : a.joints)
    if (j.drive != UINT32_MAX) world.joint_drives.values()[j.drive].torque = 0;
}

void store_joints(World& world, Island& a, const StepPart& part) {
  PANTIN_ASSERT(part.begin < part.end);
  const Real share = part.end - part.begin, per = 2 / (share * part.whole);
  for (std::size_t c = 0; c < a.count(); ++c) {
    const PackedJoint& j = a.joints[c];
    if (!j.stiff || a.parents[c] == kFree) continue;
    const ConservingNode& n = a.scratch.conserving_nodes[c];
    a.joint_memory[c].torque += share * (per * n.passed - n.exerted);
    if (is_actuated(j)) a.joint_memory[c].actuation += share * per * glm::dot(n.passed, n.axis);
    store_limits(a, c, part);
    if (j.drive == UINT32_MAX) continue;
    JointDrive& drive = world.joint_drives.values()[j.drive];
    a.joint_memory[c].torque_fraction = n.drive_share;
    drive.torque += share * n.driven, drive.capped = n.drive_share < 1;
    if (part.end == 1) a.drives_capped += drive.capped;
  }
}

ConservingJoints stiff_joints(StiffStep& step) {
  step.knows_yields = std::none_of(step.a.joints.begin(), step.a.joints.end(),
                                   [](const PackedJoint& j) { return is_actuated(j); });
  for (ConservingNode& n : step.a.scratch.conserving_nodes)
    n.expected = n.yield = n.slope = 0, n.exerted = n.damped = Vec3(0),
    n.stiffness = n.damping = Mat3(0);
  return hooks_of(step);
}

ConservingJoints hooks_of(StiffStep& step) { return {&step, inward, outward, align, add_work}; }

}  // namespace pantin::detail::articulated
