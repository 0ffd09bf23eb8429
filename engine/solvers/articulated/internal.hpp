#pragma once
/// Declarations shared by the files of the articulated solver.
#include "engine/contact/memory.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/articulated/kernels.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::articulated {

/// The island as seen by the kernels.
IslandView view_of(World& world, Island& a);

/// Asserts how an island is packed, and a group gathered; nothing where builds are not checked
/// (invariants.cpp).
void assert_packed(const Island& a);
void assert_gathered(const Group& g);

/// The end of compile(): the state of the previous islands is carried over to those made from the
/// same bodies. Islands that are built as they were go on as they were.
void carry_over(World& world, std::vector<Island>& before, std::vector<Island>& made);

inline Tension tension_of(const Island& a) {
  return a.settings.tension_stiffness ? Tension::stiffens : Tension::ignored;
}

/// Poses of the packed bodies: rows of the work table.
struct PoseRows {
  Work position, rotation;
};
inline constexpr PoseRows kPredictedPoses{kPosition, kRotation};
inline constexpr PoseRows kFinalPoses{kFinalPosition, kFinalRotation};

/// A pass of the general solve: the one of the step, from the predicted poses, or a correction,
/// which starts from closed poses and closes only what is open there.
struct Pass {
  PoseRows from;
  bool corrects;
};
inline constexpr Pass kStepPass{kPredictedPoses, false}, kCorrection{kFinalPoses, true};

/// A point of a packed body at the given poses, and one of a body of the World.
Vec3 point_at(const Island& a, std::size_t column, Vec3 anchor, PoseRows at);
Vec3 point_on(const World& world, std::uint32_t slot, Vec3 anchor);

/// The integration rule of this step.
Rule rule_of(const Island& a);
/// The free motion of the bodies over the step, into the work table (predict.cpp).
void predict_motion(World& world, Island& a, Real h);

/// Sleep (sleep.cpp). Whether something wakes a sleeping island, after its targets are known.
bool must_wake(const World& world, const Island& a);
/// The prediction of an island that does not move, for contact detection.
void predict_still(const World& world, Island& a);
/// Falls asleep after resting on fixed bodies long enough. Islands in contact with other dynamic
/// islands, or with joint drives or cables, stay awake.
void update_sleep(World& world, Island& a, Real h);
void fall_asleep(World& world, Island& a);
/// Whether an island has stayed where it is for a second, or creeps, though an arm of it may sway;
/// once a step.
bool has_rested(const World& world, Island& a, Real h);
inline constexpr Real kTimeToSleep = 0.5;  // s
/// rad/s of sleep speed per m/s.
inline constexpr Real kTurning = 10;
/// Awake, and as if it had moved just now.
void rouse(Island& a);

/// One group in contact over a step (step_group.cpp): bodies that are free or in trees first, then
/// the fixed and kinematic ones. Contacts hold mean forces before and after.
/// Contacts by group, bodies of each group with the fixed ones that it touches (gather_groups.cpp).
void gather_groups(const World& world, GroupScratch& r, Real h);
void step_group(const Group& g, Real h);
Mat3 inverse_inertia(const GroupBody& b, Quat rotation);

/// Allocates memory of the general solve when a step first needs it (scratch.cpp).
void reserve_general_solve(Island& a);

/// The active set (active_set.cpp).
bool has_rows(const Island& a);
bool has_active_contacts(const World& world, const Island& a);
/// Whether the island has only free ball joints in this step.
bool is_plain(const Island& a);
/// Inward half of the general solve at the predicted poses, with lambdas of cables, pins and loops.
void eliminate_once(World& world, Island& a, Real h);
/// Outward half: final poses and update of the active set. True if unchanged.
bool apply_once(World& world, Island& a, Real h);
/// Active-set iterations from the predicted poses. False without convergence.
enum class StepLength : std::uint8_t { whole, substep };
bool find_active_set(World& world, Island& a, Real h, StepLength length);

/// Closes the joints of the step by the method of the island, and updates the velocities
/// (close.cpp).
EndSums close_joints(World& world, Island& a, Real h);

/// Whether any tree has no anchor.
bool has_free_tree(const Island& a);

/// The energy-momentum method (conserving.cpp). Whether the island can be stepped by it: it has
/// no active limits, no contacts and no taut inextensible cables in this step.
bool conserves(const World& world, const Island& a);
/// The whole step. False if a body is lost, which `lost` then names.
bool step_conserving(World& world, Island& a, Real h, Entity& lost);
/// A part of a step of the length `whole`, s, by the fractions of it at which it begins and ends.
struct StepPart {
  Real begin, end, whole;
  bool yields = false;  // rigid ties give way
};
/// Loops, spring pins and elastic cables in that method (conserving_ties.cpp). Whether it can take
/// those of the island: cables are not far too long, no exact pin but the root's is there, since
/// those jump and may be out of reach, and loops are nearly closed.
bool can_tie(const World& world, const Island& a);
inline constexpr std::size_t kMostTies = 200;
/// Part of the island's size: wider open, a tie is closed by the sweeps of the other rules.
inline constexpr Real kNearTie = 0.1;
/// A rigid tie gives way by this part of the motion that its impulse makes in the step.
inline constexpr Real kTieSoftness = 1e-7;
std::size_t tie_count(const Island& a);
/// The ties for a part of the step; their multipliers after it.
void begin_ties(const World& world, Island& a, const StepPart& part);
void store_ties(Island& a, const StepPart& part);
/// Whether joints of the island close loops.
bool has_loops(const Island& a);
/// Whether no tie leads to a moving place; whether the energy of all of them is known: none is
/// open; whether each leads from a tree to itself.
bool ties_hold_still(const Island& a);
bool ties_are_closed(const Island& a);
bool ties_are_inner(const Island& a);
/// Whether no joint is beyond its limits, or has a cone too narrow to be held on one side.
bool can_limit(const World& world, const Island& a);
/// Kernels::conserve with ties and joints that constrain rotations, for a part of the step.
struct TiedPart {
  const StepPart& part;
  Real units = 1;  // its length, in the shortest units of time
  bool may_end_early = true;
  bool may_divide = true;  // where cones bend the way
  int iterations = 0;      // so far
  bool tautened = false;   // in the last one cables became taut
  Real shorter = 0;    // it has to be taken again in so many units: a cable is taut, or a limit hit
  Real longest = 1e9;  // units of the next one at most, as far as cones bend the way
  bool inner = true;   // no tie leads to the world or to another tree
  bool struck = false;  // cables pulled tight, or limits that were hit, took energy
  Real place_work = 0, struck_work = 0;  // J, by moving places at the ties; of that, by blows
};
bool conserve_tied(World& world, Island& a, ConservingInput in, TiedPart& with);
void reserve_ties(Island& a);
void reserve_tie_rows(Island& a);
/// Joints that constrain rotations or exert torques in that method (conserving_joints.cpp): before
/// the step; what passed through them in a part of it that was taken.
void begin_joints(World& world, Island& a);
/// Limits in that method (conserving_limits.cpp): those held in the last step; where they are at
/// the start of a part; their multipliers after it.
enum class Blows : std::uint8_t { followed, within_part };
void begin_limits(Island& a);
void begin_limits(const World& world, Island& a, const StepPart& part, Blows blows);
void store_limits(Island& a, std::size_t c, const StepPart& part);
void store_joints(World& world, Island& a, const StepPart& part);
/// Follows the angles of actuated joints after a step by any method.
void count_turns(const World& world, Island& a);
/// Whether a spring, friction or a motor acts along the coordinate of a joint; the coordinate, rad,
/// within a turn.
bool is_actuated(const PackedJoint& joint);
const Dof& dof_of(const World& world, const Island& a, std::size_t c);
/// Whether a joint has a drive, a motor or a spring: it may move without being pushed.
bool is_driven(const World& world, const Island& a, std::size_t c);
Real coordinate_of(const PackedJoint& joint, Quat own, Quat parent);
/// The same at the bodies' poses, turns counted.
Real angle_of(const World& world, const Island& a, std::size_t c);
/// The angle that differs from `near` by less than half a turn.
Real unwound(Real angle, Real near);
/// The body of a joint whose drive, motor or the like has a number that is none, or none.
Entity find_unsound(const World& world, const Island& a);
/// The axis of that coordinate in the joint's body a, by its rotation; the sign with which a torque
/// along it turns the own body.
Vec3 actuated_axis(const PackedJoint& joint, Quat own, Quat parent);
inline Real sign_of(const PackedJoint& joint) { return joint.own_is_a ? -1 : 1; }
/// Solves the n equations in tie_matrix for tie_solution, which holds the right-hand side, with
/// complete pivoting (tie_equations.cpp). Dependent rows get no impulse. False if a number is not
/// finite.
bool solve_tie_equations(StepScratch& r, std::size_t n);
/// The end of a step by any method (step.cpp): what the next step starts from.
void remember_step(World& world, Island& a, Real h);

/// The general articulated solve (tree.cpp). Blocks of the bodies alone; needs prepare().
void fill_base(Island& a, Tension tension);
/// Saves the joint gaps before the outward pass overwrites their row.
void keep_gaps(Island& a);
/// The matrix of the cross product v x.
inline Mat3 cross_matrix(Vec3 v) { return Mat3(0, v.z, -v.y, -v.z, 0, v.x, v.y, -v.x, 0); }
/// G = S (S^T K S)^-1 S^T for the first `count` directions S.
Mat3 compliance_of(const Mat3& stiffness, const Vec3 (&free)[3], std::size_t count);
/// Inward pass, leaf to root: scratch.joint_blocks (overwritten) to scratch.joint_nodes.
void inward_pass(Island& a);
/// Outward pass, root to leaf: closes the joints; rotations and joint points are left for
/// apply_poses(). For a correction that is all. The pass of the step also stores the multipliers
/// and updates limits and drives. True if the active set is unchanged.
bool outward_pass(World& world, Island& a, Real h, const Pass& pass);
/// Propagates forces towards the roots: `force` becomes the lambda at each joint, `torque` the
/// rotation of each body while joint and parent stay in place.
void propagate_inward(const Island& a, std::vector<Vec3x4>& force, std::vector<Vec3x4>& torque);
/// Propagates displacements towards the leaves: `force` becomes the translation of each joint
/// point, `torque` the rotation of each body.
void propagate_outward(const Island& a, std::vector<Vec3x4>& force, std::vector<Vec3x4>& torque);
/// Slot of the kinematic body that a root joint is attached to, or UINT32_MAX.
std::uint32_t held_body_of(const Island& a, std::size_t c);

/// Joints that constrain rotations (joint_terms.cpp): scratch.terms at the poses of the pass. A
/// correction leaves springs out, and limits keep their state.
void set_terms(const World& world, Island& a, Real h, const Pass& pass);
/// Turns limits into stiff rows, for islands with active contacts. After fill_base.
void regularise_limits(Island& a);
/// A joint after an outward pass: the rotations of its bodies, unclamped, and the linear response
/// of the own body and of its joint point (m), world axes.
struct JointResponse {
  Quat own, parent;
  Vec3 rotation, translation;
};
/// Updates the limits of a joint after an outward pass. True if the active set is unchanged.
bool update_limits(Island& a, std::size_t c, const JointResponse& moved);
/// Updates the torque fraction of a drive that reached its torque limit.
bool update_drive(World& world, Island& a, Real h, std::size_t c);
/// Work of the drive and the soft zones of a joint over the step, J.
Real work_of_springs(const Island& a, std::size_t c, Real h);
/// The free directions, and the limits that are near enough to have a direction, of a joint at the
/// given rotations of its bodies.
FreeAxes free_axes(const PackedJoint& joint, Quat own, Quat parent);
struct JointLimit {
  Vec3 along{0};  // world: the own body turns this way, relative to its parent, towards the limit
  Real clearance = 0;  // rad
  bool watched = false, both_ways = false;
};
void find_limits(const PackedJoint& joint, Quat own, Quat parent, JointLimit (&out)[4]);
/// The rotation of a joint, and a body's rotation from that and its parent's rotation.
Quat joint_rotation(const PackedJoint& joint, Quat own, Quat parent);
Quat own_rotation(const PackedJoint& joint, Quat parent, Quat rotation);
Quat parent_rotation(const World& world, const Island& a, std::size_t c, Work rotation_row);

/// Contacts (contacts.cpp): rows in the blocks of their bodies. Sets the targets from the predicted
/// poses.
void prepare_contacts(World& world, Island& a, Real h);
/// Adds the active rows to the blocks.
void add_contact_rows(const World& world, Island& a, std::vector<JointBlock>& blocks);
/// Updates contacts with fixed and kinematic bodies after an outward pass. True if the active set
/// is unchanged.
bool update_contacts(World& world, Island& a);
/// The contact point after a pass to first order, and the update of its deviation from the linear
/// response.
Vec3 moved_to(const Island& a, const ContactRow& t);
void update_nonlinearity(const Island& a, ContactRow& t, Vec3 anchor);

/// Projected Gauss-Seidel (contact_iteration.cpp): response of the island to its contacts and
/// limits (Delassus operator). After inward_pass; needs the free response in scratch.translation
/// and scratch.rotation.
void find_contact_response(const World& world, Island& a);
/// An iteration ends after `rounds` sweeps, or once a sweep moves nothing farther than `enough`, as
/// a fraction of the size.
struct IterationBounds {
  int rounds = 0;
  Real enough = 0;
};
/// Solves for all contacts and limits of these islands together.
void iterate_contacts(World& world, std::span<Island* const> all, Real h,
                      const IterationBounds& until);
/// Adds the lambdas found to the result of the inward pass.
void add_iterated_lambdas(World& world, Island& a);
/// Updates contacts after a pass with iterated lambdas. True if converged.
bool update_iterated(World& world, Island& a);
/// The free response to forces and joint gaps, into scratch.translation and scratch.rotation.
void free_response(Island& a, Work position_row);
/// Adds scratch.forces_in and torques_in, side 0, to the eliminated nodes.
void add_bias_lambdas(Island& a);

/// Contacts of a sleeping island keep their forces.
void keep_sleeping_contacts(World& world, Island& a, Real h);
/// Removes the remaining penetration of free trees by translating them.
void push_out_trees(World& world, Island& a);
/// Stores restitution, forces and depths of contacts; returns the work of the contacts, J.
Real finish_contacts(World& world, Island& a, Real h);

/// Rows: cables, pins and loops on top of the articulated solve (rows.cpp).
void add_cable_stiffness(const World& world, Island& a, std::vector<JointBlock>& blocks);
/// Solves for the lambdas of all rows and adds them to the result of the inward pass. Between
/// inward_pass and outward_pass.
void solve_rows(World& world, Island& a, Real h, const Pass& pass);
/// Largest elongation of a cable at the final poses, m; and largest gap of pins and loops.
Real worst_stretch(const World& world, const Island& a);
Real worst_pin_gap(const Island& a);
/// Target of a pin constraint at the given poses.
Vec3 target_of(const Island& a, const PackedPin& constraint, PoseRows at);

/// Relaxation (relax.cpp): sweeps from each pin in turn, then from the roots, on the final poses.
/// Taut cables may count as pins too.
enum class Relaxed : std::uint8_t { pins, pins_and_cables };
void relax(World& world, Island& a, Relaxed what);

/// The closing sweep alone: closes every joint within its limits, from the roots outwards.
void sweep_closed(const World& world, Island& a);

/// Moves a free root towards the meeting points with its neighbours, on the predicted poses.
void place_free_root(Island& a, const Tree& tree, Real h);

/// SHAKE: two Newton iterations with the Jacobian at the start of the step, then a closing sweep
/// (shake.cpp).
void close_shake(World& world, Island& a, const IslandView& p, Real h);

/// Solves m x = b for a symmetric positive definite m by LDL^T, with a lower bound on the pivots.
Vec3 solve_symmetric(const Mat3& m, Vec3 b);
/// Articulated mass and bias at the joint of a body, from the kernels' inward pass; ball joints
/// only.
inline Mat3 articulated_mass(const Island& a, std::size_t c) {
  PANTIN_ASSERT(kNodeSize * (c + 1) <= a.scratch.nodes.size());
  const Real* g = a.scratch.nodes.data() + kNodeSize * c + kArticulatedMass;
  return Mat3(g[0], g[4], g[8], g[1], g[5], g[9], g[2], g[6], g[10]);
}
inline Vec3 articulated_bias(const Island& a, std::size_t c) {
  PANTIN_ASSERT(kNodeSize * (c + 1) <= a.scratch.nodes.size());
  const Real* g = a.scratch.nodes.data() + kNodeSize * c + kArticulatedMass;
  return {g[3], g[7], g[11]};
}
/// Rotation per displacement of the own joint point, times a displacement.
inline Vec3 times_response(const Island& a, std::size_t c, Vec3 y) {
  PANTIN_ASSERT(kNodeSize * (c + 1) <= a.scratch.nodes.size());
  const Real* n = a.scratch.nodes.data() + kNodeSize * c + kResponse;
  return {n[0] * y.x + n[1] * y.y + n[2] * y.z, n[4] * y.x + n[5] * y.y + n[6] * y.z,
          n[8] * y.x + n[9] * y.y + n[10] * y.z};
}
/// Rotation of a body whose own joint point moves by `translation`.
inline Vec3 response_rotation(const Island& a, std::size_t c, Vec3 translation) {
  const Real* n = a.scratch.nodes.data() + kNodeSize * c + kResponse;
  return Vec3(n[3], n[7], n[11]) - times_response(a, c, translation);
}

/// The literal rule, root to leaf, into the final poses.
void literal_sweep(Island& a, Real h);

/// After a step that was predicted by the second-order rule, or from rest, and then ended by the
/// first-order one because of an impact (reactions.cpp): what a multiplier means as a force follows
/// from the momentum that the island gained. Sets Island::force_share and the contacts' forces.
void scale_to_momentum(World& world, Island& a, const EndSums& end, Real h);

/// Energy limiter (limiter.cpp): scales the velocities down where the energy grew by more than the
/// work done on the island. Numerical losses may return for a while (the reserve), since a stable
/// integrator exchanges energy within a swing.
void limit_energy(World& world, Island& a, const EndSums& end, Real h);

/// Elastic energy (elastic.cpp) of the cables and spring pins of an island, J: at the poses of its
/// bodies; at those with the anchors where they were a step before; at its final poses.
Real elastic_energy(const World& world, const Island& a);
Real elastic_energy_before(const World& world, const Island& a, Real h);
Real elastic_energy_of_final(const World& world, const Island& a);
/// A point of a body that this solver does not move, a step before.
Vec3 point_before(const World& world, std::uint32_t slot, Vec3 anchor, Real h);
/// What a spring pin exchanged in the step that ends, J: the work of its anchor, and what its
/// damper took.
struct SpringExchange {
  Real work, lost;
};
SpringExchange spring_exchange(const Island& a, const PackedPin& pin, Real h);

/// Of solvers that do not conserve energy: the energy of an island before a step, and whether the
/// step raised it severalfold above that and what kinematic bodies, forces and drives supplied
/// (StepResult::grew).
void begin_watch(const World& world, Island& a);
void end_watch(const World& world, Island& a, Real h);

/// Restores the momentum of free trees after the joints were closed (momentum.cpp). True if any
/// tree was corrected.
bool repair_momentum(World& world, Island& a, Real h);
/// The same for a tree whose bodies moved by the energy-momentum method: what its iterations left
/// of the angular momentum is taken from the velocities, as one rigid rotation.
void keep_angular_momentum(World& world, const Island& a, Tree& tree, Real h);
/// Angular momentum of a tree about its mass centre.
Vec3 angular_momentum(const World& world, const Island& a, const Tree& tree);

}  // namespace pantin::detail::articulated
