#pragma once
/// Joints that constrain rotations or exert torques in a step by the energy-momentum method: see
/// conserving_joints.cpp and conserving_torques.cpp.
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {

/// A substep of an island with such joints.
struct StiffStep {
  const World& world;
  Island& a;
  Real h;  // s, of the substep
  StepPart part;
  bool knows_yields = true;  // of actuated joints: see ConservingNode::yield
};

/// The rotations of both bodies of a joint at the start of the substep and at the iterate.
struct JointEnds {
  Quat own0, own1, parent0, parent1;
};
JointEnds ends_of(const StiffStep& s, std::size_t c);
/// rad: a joint that is this far from its limits keeps clear of them for certain.
inline constexpr Real kFarFromLimits = 1e-3;

/// The hooks of the kernels; `step` has to outlive them.
ConservingJoints stiff_joints(StiffStep& step);
/// The same without resetting the nodes.
ConservingJoints hooks_of(StiffStep& step);

/// Whether a joint has a drive, soft zones, a spring, friction or a motor. find_torque() writes
/// their torque on the own body, and its derivative by the relative rotation, to the joint's node.
bool exerts_torque(const PackedJoint& joint);
void find_torque(const StiffStep& s, std::size_t c, const JointEnds& ends);
/// Cayley vector of the relative rotation over the substep: a torque's work is its product with it.
Vec3 turned_by(const StiffStep& s, std::size_t c, const JointEnds& ends);

/// Axes fixed in the joint's bodies a and b, at the start (0) and at the iterate (1).
struct Directions {
  Mat3 a0, a1, b0, b1;
};

/// The constraint rows of a joint: torque on the own body per multiplier, gradient by the relative
/// rotation at the end, residual.
struct JointRows {
  std::size_t count = 0;
  Vec3 torque[3], gradient[3];
  Real off[3];
  ConservingLimit* limit[3] = {nullptr, nullptr, nullptr};  // null: a row of the joint's kind
};

JointRows find_rows(const PackedJoint& joint, const Directions& d, Unknown unknown);
Directions directions_of(const PackedJoint& joint, const JointEnds& ends);
/// Free directions of the body: perpendicular to all rows.
std::size_t find_free(const Vec3 (&rows)[3], std::size_t count, Vec3 (&free)[3]);
/// The pseudo-inverse of rows: x = sum of columns * b solves row . x = b with the least x.
void invert_rows(const Vec3 (&rows)[3], std::size_t count, Vec3 (&columns)[3]);
/// free (to^T m free)^-1 to^T for the first `count` directions.
Mat3 reduced_inverse(const Mat3& m, const Vec3 (&free)[3], const Vec3 (&to)[3], std::size_t count);
/// Derivatives of the rows' torque by the rotations of the own body and of its parent.
struct RowTurn {
  Mat3 own{0}, parent{0};
};

RowTurn turn_of_rows(const PackedJoint& joint, const Directions& d, const Real (&multipliers)[3]);

/// Limits (conserving_limits.cpp). Updates clearances and directions at the iterate. is_clamped():
/// whether a limit is exceeded by rounding only, so that the rotation is clamped to it.
void look_at_limits(const StiffStep& s, std::size_t c, const JointEnds& ends);
bool is_clamped(const Island& a, std::size_t c);
inline bool has_limits(const Island& a, std::size_t c) {
  return a.parents[c] != kFree && a.joints[c].stiff && a.joints[c].joint.limits.any();
}
bool any_limit(const Island& a);
/// Updates the active set: a limit whose torque would pull is released, an exceeded one becomes
/// active. Returns whether anything changed.
bool change_limits(const StiffStep& s, std::size_t c);
/// Adds active limits to the rows of a joint; for velocities, those that act at the end.
void add_limit_rows(const StiffStep& s, std::size_t c, Unknown unknown, JointRows& rows);
/// After the iterations: whether the substep has to end earlier, where a limit is hit;
/// TiedPart::shorter is then its new length.
bool limits_end_early(const StiffStep& s, TiedPart& with);
bool any_limit_hit(const Island& a);

/// Starts the impact of limits that were hit at the end of the substep, with the active ones: sets
/// the impulses of the computed velocities. Returns the fastest rate of a limit, rad/s.
Real begin_blow(const StiffStep& s);
/// Solves velocities with the active rows. release_limit() releases the active limit that pulls
/// hardest; catch_limit() activates the one passed fastest, above `rate`. Both return whether any.
void respond_to_blow(StiffStep& s);
bool release_limit(const StiffStep& s, Real rate);
bool catch_limit(const StiffStep& s, Real rate);
void end_blow(Island& a);

/// Mobility of a joint about an axis, 1/(kg m^2), from its two bodies alone.
Real mobility_about(const StiffStep& s, std::size_t c, Vec3 axis);

}  // namespace pantin::detail::articulated
