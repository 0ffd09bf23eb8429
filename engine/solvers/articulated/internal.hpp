#pragma once
/// Declarations shared by the files of the articulated solver.
#include "engine/contact/memory.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "engine/solvers/articulated/kernels.hpp"
#include "engine/solvers/articulated/smooth/parted_step.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail {
struct StepTask;
struct Rebuild;
class Pace;
}  // namespace pantin::detail

namespace pantin::detail::articulated {

/// The island as seen by the kernels.
IslandView view_of(World& world, Island& a);

/// Asserts the invariants of a packed island, and of a gathered group; no code in unchecked builds
/// (invariants.cpp).
void assert_packed(const Island& a);
void assert_gathered(const Group& g);

/// Packs islands from their plans, with all that ties them in the scope (compile.cpp).
IslandVector pack_islands(World& world, const Scope& scope, std::span<const IslandPlan> plans);
/// The end of a build: carries the state of the previous islands over to those made from the same
/// bodies. Islands of unchanged structure keep their whole state.
void carry_over(World& world, IslandVector& before, IslandVector& made);
/// Before it: keeps the leading islands that are unchanged free bodies, and returns their number.
/// Bodies added to a World come after them.
std::size_t keep_first(World& world, std::span<const IslandPlan> plans, IslandVector& list);

/// Poses of the packed bodies: rows of the work table.
struct PoseRows {
  Work position, rotation;
};
inline constexpr PoseRows kPredictedPoses{kPosition, kRotation};
inline constexpr PoseRows kFinalPoses{kFinalPosition, kFinalRotation};

/// A point of a packed body at the given poses, and one of a body of the World.
Vec3 point_at(const Island& a, std::size_t column, Vec3 anchor, PoseRows at);
Vec3 point_on(const World& world, std::uint32_t slot, Vec3 anchor);

/// The integration rule of this step.
Rule rule_of(const Island& a);
/// The free motion of the bodies over the step, into the work table (predict.cpp).
void predict_motion(World& world, Island& a, Real h);

/// Update rates in a step with a budget (update_rate.cpp). Sets Island::step of all that are awake:
/// islands without colliders may be left out of up to three steps in a row, and then take one for
/// all the time.
void choose_steps(World& world, const StepTask& task);
/// Lets those candidates wait that fit neither into `time`, s, nor into a weight of `least`, the
/// least urgent first.
void fit_into(Real time, Real least, UpdateRates& r);
/// Leaves an island out of the step.
void leave_out(World& world, Island& a, Real h);
/// Before and after the islands without contacts are stepped, and at the end of the substep: learns
/// what they cost.
/// Relative cost of a substep of an island.
Real weight_of(const Island& a);
/// Whether substeps of a weight, which have to be taken, leave no time for others.
bool is_late(const UpdateRates& r, Real weight);
/// Sets Effort::hurries_from of the islands that are stepped one after the other.
void share_time(World& world, const StepTask& task);
inline bool has_to_hurry(const Island& a) {
  const Clock::time_point from = a.scratch.hurries_from;
  return from != Clock::time_point::max() && Clock::now() > from;
}
void note_stepping(World& world, const StepTask& task);
void note_stepped(World& world, const StepTask& task);
void note_end(World& world, const StepTask& task);

/// Sleep (sleep.cpp). Whether something wakes a sleeping island, after its targets are known.
bool must_wake(const World& world, const Island& a);
/// Wakes those islands that the caller, an anchor or gravity wakes.
void wake_changed(World& world, const StepTask& task);
/// Brings the lists up to date after a rebuild: without it they are listed again.
void renumber_rests(World& world, const Rebuild& rebuild);
/// Updates the lists of awake and sleeping islands.
RestLists& rest_lists(World& world);
/// Calls `each(island)` for the islands that were awake in the step.
template <class Each>
void each_awake(const World& world, const Each& each) {
  const Islands& all = world.memory.of<Islands>();
  if (all.rest.version == 0)
    for (const Island& a : all.list) each(a);
  else
    for (const std::uint32_t i : all.rest.awake) each(all.list[i]);
}
/// The prediction of an island that does not move, for contact detection.
void predict_still(const World& world, Island& a);
void fall_asleep(World& world, Island& a);
/// Whether an island has stayed in place for a second, or creeps; less than half of its mass may
/// sway. To be called once a step.
enum class Limbs : std::uint8_t { sway_a_little, sway };
bool has_rested(const World& world, Island& a, Real h, Limbs limbs);
/// Slows an island of which more than half has stayed in place for a second: joints have no
/// friction of their own, and limbs in a pile would swing for minutes.
void slow_limbs(World& world, const Island& a, Real h);
inline constexpr Real kTimeToSleep = 0.5;  // s
/// rad/s of sleep speed per m/s.
inline constexpr Real kTurning = 10;
/// Wakes an island and resets its quiet time; the same for one that is not in the list yet.
void rouse(World& world, Island& a);
void stir(Island& a);
/// Sets the targets of roots and pins for this step (predict.cpp).
void set_targets(const World& world, Island& a, Real h);

/// Gathers contacts by group, and each group's bodies with the fixed ones that it touches
/// (gather_groups.cpp). step_group() takes a step of one group (step_group.cpp): dynamic bodies
/// come first, then fixed and kinematic ones; contacts hold mean forces before and after.
void gather_groups(const World& world, GroupScratch& r, Real h);
Rest step_group(const Group& g, Real h, Pace& pace);
/// After the step: puts islands of the group to sleep that have been still for long enough, with
/// all that they touch (group_sleep.cpp). All islands are sets of their own in GroupScratch::sets.
void let_sleep(World& world, const Group& g, Real h);
Mat3 inverse_inertia(const GroupBody& b, Quat rotation);

/// Whether pins, cables or loops act on the island.
inline bool has_rows(const Island& a) { return !a.pins.empty() || !a.cables.empty(); }
/// Whether these, or joints that constrain rotations, do.
inline bool is_tied(const Island& a) { return has_rows(a) || !a.joints.empty(); }

/// Closes the joints of the step by the rule of the island, and updates the velocities
/// (close.cpp). False if a position is out of bounds.
bool close_joints(World& world, Island& a, Real h);

/// Whether any tree has no anchor.
bool has_free_tree(const Island& a);

/// A step by the rules of the paper (step.cpp): sweeps close joints, relaxation closes several
/// pins. `auto` uses it if its own methods find no step, and limits the energy. False if a body is
/// lost, which `lost` then names.
bool close_by_sweeps(World& world, Island& a, Real h, Entity& lost);

/// The energy-momentum method (conserving.cpp). Whether it can step the island: see can_limit() and
/// can_tie(); not directly after a step in which it failed.
bool conserves(const World& world, const Island& a);
/// The whole step. False if a body is lost, which `lost` then names.
bool step_conserving(World& world, Island& a, Real h, Entity& lost);
/// Loops, pins and cables in that method (conserving_ties.cpp). Whether it can step those of the
/// island: not too many ties, exact pins in reach, inextensible cables near their lengths.
bool can_tie(const World& world, const Island& a);
inline constexpr std::size_t kMostTies = 200;
/// Fraction of the island's size: sweeps close ties with larger errors.
inline constexpr Real kNearTie = 0.1;
/// Compliance of a rigid tie, as a fraction of the motion by its impulse in the step.
inline constexpr Real kTieSoftness = 1e-7;
std::size_t tie_count(const Island& a);
/// At the start of a step: finds the gaps of rigid pins and loops, which the step closes evenly, as
/// if their targets moved. Returns whether there are any.
bool begin_closing(const World& world, Island& a, Real h);
/// Prepares the ties for a substep; stores their multipliers after it.
void begin_ties(const World& world, Island& a, const StepPart& part);
void store_ties(Island& a, const StepPart& part);
/// Whether rigid joints or pins close loops of the island; whether any tie is a rigid pin or loop.
bool has_loops(const Island& a);
bool has_rigid_pins(const Island& a);
/// Whether no tie is connected to a moving point; whether none has an open gap, so that its energy
/// is known; whether each connects a tree to itself.
bool ties_hold_still(const Island& a);
bool ties_are_closed(const Island& a);
bool ties_are_inner(const Island& a);
/// Whether no joint exceeds its limits by more than rounding.
bool can_limit(const World& world, const Island& a);
/// Kernels::conserve with ties and joints that constrain rotations, for a substep.
struct TiedPart {
  const StepPart& part;
  Real units = 1;  // its length, in the shortest units of time
  bool may_end_early = true;
  bool may_divide = true;  // if gradients of cones rotate too far
  int iterations = 0;      // so far
  bool tautened = false;   // in the last one cables became taut
  Real shorter = 0;     // units: to be repeated with this length, as a cable is taut or a limit hit
  Real longest = 1e9;   // units of the next one at most, for gradients of cones
  bool inner = true;    // no tie is connected to the world or to another tree
  bool struck = false;  // impacts of cables or limits dissipated energy
  Real place_work = 0, struck_work = 0;  // J, by moving points of ties; of that, by impacts
};
bool conserve_tied(World& world, Island& a, ConservingInput in, TiedPart& with);
/// A step in substeps: begin_part() prepares the next one and returns the input of the kernels;
/// tied_part() returns that of its ties.
PartedStep begin_parts(World& world, Island& a, Real h);
ConservingInput begin_part(World& world, Island& a, PartedStep& step);
TiedPart tied_part(const PartedStep& step);
/// After PartedStep::taken is known.
void end_part(World& world, Island& a, PartedStep& step, const TiedPart& with);
/// Takes a whole substep of an island alone.
void take_part(World& world, Island& a, PartedStep& step);
/// A substep with limits that are not active (open_limits.cpp), of an island whose joints have no
/// more than limits.
struct OpenPart {
  const World& world;
  Island& a;
  const StepPart& part;
  bool are_clear = true;  // so far
};
bool has_only_limits(const Island& a);
bool opens_limits(const Island& a);
OpenLimits open_limits(OpenPart& part);
/// After the last substep. False if a body is lost, which `lost` then names.
bool end_parts(World& world, Island& a, const PartedStep& step, Entity& lost);
/// Before a step: clears the result of the last one.
inline void forget_result(Island& a) {
  a.lost = Entity{}, a.energy_removed = 0, a.jammed = a.scratch.hurried = false;
  a.missed = {};
}
/// Batches of islands of equal structure (crowd.cpp): finds them after a build; steps them.
void find_crowds(const World& world, Islands& all);
/// After a rebuild: batches lose islands, and are found again after many came.
void renumber_crowds(Islands& all, const Rebuild& rebuild);
void step_crowds(World& world, const StepTask& task);
void reserve_ties(Island& a);
void reserve_tie_rows(Island& a);
/// Joints that constrain rotations or exert torques in that method (conserving_joints.cpp), before
/// the step.
void begin_joints(World& world, Island& a);
/// Limits in that method (conserving_limits.cpp): warm start from the last step; state at the start
/// of a substep; multipliers after it. store_joints() stores torques after an accepted substep.
enum class Blows : std::uint8_t { followed, within_part };
void begin_limits(Island& a);
void begin_limits(const World& world, Island& a, const StepPart& part, Blows blows);
void store_limits(Island& a, std::size_t c, const StepPart& part);
void store_joints(World& world, Island& a, const StepPart& part);
/// Updates the angles of actuated joints, full turns counted, after a step by any method.
void count_turns(const World& world, Island& a);
bool counts_turns(const Island& a, std::size_t c);
/// Whether a spring, friction or a motor acts along the coordinate of a joint.
bool is_actuated(const PackedJoint& joint);
const Dof& dof_of(const World& world, const Island& a, std::size_t c);
/// Whether a joint has a drive, a motor or a spring: it may move without external forces.
bool is_driven(const World& world, const Island& a, std::size_t c);
/// The coordinate of a joint, rad, within one turn.
Real coordinate_of(const PackedJoint& joint, Quat own, Quat parent);
/// The same at the bodies' poses, full turns counted.
Real angle_of(const World& world, const Island& a, std::size_t c);
/// Its rate, rad/s.
Real rate_of(const World& world, const Island& a, std::size_t c);
/// The angle that differs from `near` by less than half a turn.
Real unwound(Real angle, Real near);
/// The body of a joint whose drive, motor, spring or friction has an invalid value, if any.
Entity find_unsound(const World& world, const Island& a);
/// The axis of that coordinate, world; the sign of the own body's rotation about it.
Vec3 actuated_axis(const PackedJoint& joint, Quat own, Quat parent);
inline Real sign_of(const PackedJoint& joint) { return joint.own_is_a ? -1 : 1; }
/// Solves the n equations in tie_matrix for tie_solution, which holds the right-hand side, by
/// elimination with diagonal pivots, else partial, else complete pivoting (tie_equations.cpp).
/// Dependent rows get no impulse. False if a number is not finite.
bool solve_tie_equations(StepScratch& r, std::size_t n);
/// The end of a step by any method (step.cpp): stores the state that the next step starts from.
void remember_step(World& world, Island& a, Real h);
Missed missed_by(const World& world, const Island& a);

/// The matrix of the cross product v x.
inline Mat3 cross_matrix(Vec3 v) { return Mat3(0, v.z, -v.y, -v.z, 0, v.x, v.y, -v.x, 0); }
/// G = S (S^T K S)^-1 S^T for the first `count` directions S (group_trees.cpp).
Mat3 compliance_of(const Mat3& stiffness, const Vec3 (&free)[3], std::size_t count);
/// Slot of the kinematic body that a root joint is attached to, or UINT32_MAX.
std::uint32_t held_body_of(const Island& a, std::size_t c);

/// The free directions of a joint, and its watched limits with their directions, at the given
/// rotations of its bodies.
FreeAxes free_axes(const PackedJoint& joint, Quat own, Quat parent);
struct JointLimit {
  Vec3 along{0};       // world: relative rotation of the own body about it approaches the limit
  Real clearance = 0;  // rad
  bool watched = false, both_ways = false;
};
void find_limits(const PackedJoint& joint, Quat own, Quat parent, JointLimit (&out)[4]);
/// Whether a joint is farther than `margin`, rad, from every limit; a sufficient condition.
bool is_far_from_limits(const PackedJoint& joint, Quat own, Quat parent, Real margin);
/// The rotation of a joint; a body's rotation from that and its parent's; its parent's from its
/// own.
Quat joint_rotation(const PackedJoint& joint, Quat own, Quat parent);
Quat own_rotation(const PackedJoint& joint, Quat parent, Quat rotation);
Quat inboard_rotation(const PackedJoint& joint, Quat own, Quat rotation);
Quat parent_rotation(const World& world, const Island& a, std::size_t c, Work rotation_row);

/// Contacts of a sleeping island keep their forces.
void keep_sleeping_contacts(World& world, Island& a, Real h);
/// Pushes bodies out of bodies that this solver does not move, and closes their joints again
/// (procedural/push_out_trees.cpp).
void push_out_trees(World& world, Island& a, Real h);
/// Whether the joints between a pin and the root can span the distance to the root's target
/// (relax.cpp).
bool is_in_reach(const Island& a, const PackedPin& pin);
/// Relaxation (relax.cpp): sweeps from each pin and each taut cable in turn, then from the roots,
/// on the final poses.
void relax(World& world, Island& a);

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

/// The pose of a body that this solver does not move, one step before; a point of it.
Pose pose_before(const World& world, std::uint32_t slot, Real h);
Vec3 point_before(const World& world, std::uint32_t slot, Vec3 anchor, Real h);
/// Energy of steps that do not conserve it (watch.cpp). begin_watch() records it before a step.
/// end_watch() tells if it grew severalfold beyond that and the work of kinematic bodies and forces
/// (StepResult::grew). A step of `auto` has its excess energy removed.
void begin_watch(const World& world, Island& a);
void end_watch(World& world, Island& a, Real h);
/// Removes the energy that closing gaps has added to a step.
void end_closing(World& world, Island& a, Real h);

/// Restores the momentum of free trees after the joints were closed (momentum.cpp).
void repair_momentum(World& world, Island& a, Real h);
/// The same for a tree after the energy-momentum method: corrects the residual angular momentum of
/// its iterations by a rigid rotation of the velocities.
void keep_angular_momentum(World& world, const Island& a, Tree& tree, Real h);
/// Angular momentum of a tree about its mass centre.
Vec3 angular_momentum(const World& world, const Island& a, const Tree& tree);

}  // namespace pantin::detail::articulated
