#pragma once
/// Joints that constrain rotations or exert torques in a step by the energy-momentum method: see
/// conserving_joints.cpp, and conserving_torques.cpp for what they exert.
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

/// A part of a step of an island with such joints.
struct StiffStep {
  const World& world;
  Island& a;
  Real h;  // s, of the part
  StepPart part;
  bool knows_yields = true;  // of actuated joints: see ConservingNode::yield
};

/// The rotations of both bodies of a joint at the start of the part and at the iterate.
struct JointEnds {
  Quat own0, own1, parent0, parent1;
};
JointEnds ends_of(const StiffStep& s, std::size_t c);

/// The hooks of the kernels; `step` has to outlive them.
ConservingJoints stiff_joints(StiffStep& step);
/// The same without a fresh start.
ConservingJoints hooks_of(StiffStep& step);

/// Whether a joint has a drive, soft zones, a spring, friction or a motor; what these exert on the
/// own body, and how that depends on its turn relative to its parent at the iterate, into its node.
bool exerts_torque(const PackedJoint& joint);
void find_torque(const StiffStep& s, std::size_t c, const JointEnds& ends);
/// Cayley's vector of the relative turn over the part: the work of a torque is its product with it.
Vec3 turned_by(const StiffStep& s, std::size_t c, const JointEnds& ends);

/// Directions fixed in both bodies of a joint, at the start, and at the iterate.
struct Directions {
  Mat3 a0, a1, b0, b1;
};

/// The rows of a joint: how the torques of their multipliers act on the own body, how they change
/// with the relative turn of the own body at the end, by how much they are off.
struct JointRows {
  std::size_t count = 0;
  Vec3 torque[3], gradient[3];
  Real off[3];
  ConservingLimit* limit[3] = {nullptr, nullptr, nullptr};  // none: of the kind
};

JointRows find_rows(const PackedJoint& joint, const Directions& d, Unknown unknown);
Directions directions_of(const PackedJoint& joint, const JointEnds& ends);
/// Directions in which the rows leave the body free: perpendicular to all of these.
std::size_t find_free(const Vec3 (&rows)[3], std::size_t count, Vec3 (&free)[3]);
/// The pseudo-inverse of rows: x = sum of columns * b solves row . x = b with the least x.
void invert_rows(const Vec3 (&rows)[3], std::size_t count, Vec3 (&columns)[3]);
/// free (to^T m free)^-1 to^T for the first `count` directions.
Mat3 reduced_inverse(const Mat3& m, const Vec3 (&free)[3], const Vec3 (&to)[3], std::size_t count);
/// How the torque of the rows' multipliers turns with the own body and with its parent.
struct RowTurn {
  Mat3 own{0}, parent{0};
};

RowTurn turn_of_rows(const PackedJoint& joint, const Directions& d, const Real (&multipliers)[3]);

/// Limits (conserving_limits.cpp). Where they are at the iterate, rounding apart; whether they keep
/// the body's rotation from being the one that the kind alone allows.
void look_at_limits(const StiffStep& s, std::size_t c, const JointEnds& ends);
bool is_clamped(const Island& a, std::size_t c);
inline bool has_limits(const Island& a, std::size_t c) {
  return a.parents[c] != kFree && a.joints[c].stiff && a.joints[c].joint.limits.any();
}
bool any_limit(const Island& a);
/// Whether a limit has to change, which it then does: one that would pull opens, one that would be
/// exceeded is held.
bool change_limits(const StiffStep& s, std::size_t c);
/// Adds those that are held, or act on the velocities, to the rows of a joint.
void add_limit_rows(const StiffStep& s, std::size_t c, Unknown unknown, JointRows& rows);
/// After the iterations: whether the part of the step has to end where a limit is hit.
/// TiedPart::shorter tells where.
bool limits_end_early(const StiffStep& s, TiedPart& with);
bool any_limit_hit(const Island& a);

/// The blow of limits that were hit at the end of the part, with those that are held. Its start:
/// impulses are those of the velocities found; rad/s, of the fastest.
Real begin_blow(const StiffStep& s);
/// The velocities with the rows that act; whether one of these pulls, which then no longer acts;
/// whether one that does not is passed faster than `rate`, which then acts.
void respond_to_blow(StiffStep& s);
bool release_limit(const StiffStep& s, Real rate);
bool catch_limit(const StiffStep& s, Real rate);
void end_blow(Island& a);

/// Mobility of a joint about an axis, 1/(kg m^2): of its two bodies alone.
Real mobility_about(const StiffStep& s, std::size_t c, Vec3 axis);

}  // namespace pantin::detail::articulated
