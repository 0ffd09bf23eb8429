#pragma once
/// Groups of bodies and trees in contact, while they are stepped: see step_group.cpp.
#include <algorithm>
#include <cstdint>
#include <span>

#include "engine/base/block_factor.hpp"
#include "engine/base/invariants.hpp"
#include "engine/base/math.hpp"
#include "engine/base/threads.hpp"
#include "engine/contact/contact_axes.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/rolling_friction.hpp"
#include "engine/nurbs/skin.hpp"
#include "engine/solvers/articulated/impulses/group_pairs.hpp"
#include "engine/solvers/articulated/impulses/rest_parts.hpp"
#include "engine/solvers/articulated/lane_layout.hpp"

namespace pantin {
struct JointDrive;
struct Shape;
}  // namespace pantin
namespace pantin::detail {
struct Dof;
}
namespace pantin::detail::articulated {

inline constexpr std::uint32_t kNoNode = UINT32_MAX;

/// A body in contact during a step: free, in a tree, or fixed or kinematic (inverse mass zero).
struct GroupBody {
  std::uint32_t slot = 0, island = UINT32_MAX;
  std::uint32_t node = kNoNode;  // in the group, of a body in a tree
  Pose pose;
  /// m/s, rad/s. Of a body in a tree, between prepare_trees and release_trees, those of its joint.
  Vec3 velocity{0}, spin{0};
  Vec3 angular_momentum{0};        // kg m^2/s, about the mass centre, world axes
  Real per_mass = 0;               // 1/kg
  Vec3 per_inertia{0};             // 1/(kg m^2), principal
  Mat3 response{0};                // inverse inertia, world axes
  Vec3 acceleration{0};            // m/s^2, of weight and applied force
  Vec3 torque{0};                  // N m
  Real drag = 0;                   // 1/s
  Vec3 centre{0};                  // m, world: origin of the contacts' arms
  Vec3 before{0};                  // velocity at the start of the substep
  std::uint32_t looped = kNoNode;  // in GroupScratch::looped, if its island has loops
  bool touched = false;            // it moves by its end velocity in this substep
  bool jammed = false;             // in this step: see is_jammed()
  // Before the impulses of the substep, see forget_impulses():
  Vec3 free_velocity{0}, free_spin{0}, free_momentum{0};
  Vec3 from{0};  // m, position at the start of the step
  Pose kept;     // see part_overlaps()
};

/// Number of bodies that are free or in trees; these come first.
inline std::size_t free_bodies(std::span<const GroupBody> bodies) {
  const auto fixed = std::find_if(bodies.begin(), bodies.end(),
                                  [](const GroupBody& b) { return b.per_mass == 0; });
  return static_cast<std::size_t>(fixed - bodies.begin());
}

inline const Vec3 kAxes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/// Whether the body is dynamic: neither fixed nor kinematic.
inline bool can_give_way(const GroupBody& b) { return b.per_mass > 0; }

/// m/s: velocity of the body's point at an arm from `centre`.
inline Vec3 speed_at(const GroupBody& b, Vec3 arm) { return b.velocity + glm::cross(b.spin, arm); }

struct PackedJoint;

/// A limited direction of a joint in a substep.
struct GroupLimit {
  Vec3 along{0};       // world: relative rotation about it approaches the limit
  Real clearance = 0;  // rad
  Real response = 0;   // 1/(kg m^2)
  Real impulse = 0;    // N m s of a substep, against `along`
  Real before = 0;     // the impulse of the previous substep
  bool listed = false;
  bool both_ways = false;  // a lock
};

/// A spring, friction and a motor along the coordinate of a joint.
struct GroupActuator {
  const Dof* dof = nullptr;  // null: the joint has no actuator
  Vec3 axis{0};              // world: the own body rotates about it as the coordinate grows
  Real angle = 0;            // rad, full turns counted
  Real response = 0;         // 1/(kg m^2)
  Real impulse = 0;          // N m s of a substep
};

/// Data of a node for the whole step.
struct NodeBody {
  std::uint32_t parent = kNoNode;      // node; kNoNode at a root
  std::uint32_t body = 0;              // in the group
  std::uint32_t tree = 0;              // in the group
  std::uint32_t column = 0;            // in the island
  std::uint32_t depth = 0;             // joints from the root
  std::uint32_t next = kNoNode;        // child on the path to the node visited next
  const PackedJoint* joint = nullptr;  // none: a free ball joint
  const JointDrive* drive = nullptr;
  bool free_root = false;
  Real drive_share = 1;                  // fraction of the drive's torque that its bound allows
  Real drive_torque = 0;                 // N m
  Vec3 own_anchor{0}, parent_anchor{0};  // m, body frames
  Real mass = 0;                         // kg
  Vec3 inertia{0};                       // kg m^2, principal
};

/// A node in a substep: its position and its response to impulses.
struct NodeResponse {
  // In a substep, from the pose at its start:
  Vec3 arm{0};    // from the joint to the mass centre
  Vec3 lever{0};  // from the parent's joint to this one
  Quat rotation{1, 0, 0, 0};
  Mat3 world_inertia{0};
  SpatialInertia whole;  // articulated inertia of the body and those outboard of it
  Mat3 mobility{0};      // relative spin by torque at the joint
  bool is_ball = false;  // a free ball joint: passes no torque on
  Vec3 torque{0};        // N m s at the joint, of all impulses outboard of it so far
  Wrench pending;        // impulses not yet passed on to the parent
  Response response;
};

/// A body of a tree. Wrenches and motions refer to its joint, at a free root to its mass centre.
struct GroupNode : NodeBody, NodeResponse {
  Vec3 velocity{0};                // m/s, of the mass centre at the start
  Wrench begin, load;              // momentum and forces; impulses of contacts and ties
  Vec3 free_torque{0};             // these three before the impulses of the substep, see
  Wrench free_pending, free_load;  // forget_impulses()
  Wrench passing;                  // through the joint in the substep
  Vec3 pulled{0};                  // N s through the joint in the substep before
  Vec3 pulled_earlier{0};          // and in the one before that
  Mat3 tautness{0};                // kg m^2: h^2 times geometric stiffness, see stiffen()
  SpatialInertia pressed;          // added by bodies pressing on it, see press()
  Vec3 goal{0};                    // m: mass centre integrated by its velocity
  Vec3 missed_by{0};               // m: from `goal` to where the joints placed it
  Quat turned{1, 0, 0, 0};         // rotation integrated by the spin
  Pose kept;                       // pose before a correction, to undo it
  Vec3 spring_torque{0};           // N m s, of soft zones and the drive at zero relative spin
  Mat3 spring{0};                  // its decrease per relative spin
  bool has_spring = false, is_limited = false;
  bool is_driven = false;  // may move without external forces: see is_driven
  GroupActuator actuator;
  GroupLimit limits[4];
  std::uint32_t step = kNoPathStep;  // of the first tie through its joint (group_loops.cpp)
  Wrench reaction;  // of the step: N s through the joint; the torque about it, without springs
};

/// One tree of a group.
struct GroupTree {
  std::uint32_t first = 0, count = 0;  // nodes
  std::uint32_t island = 0, number = 0;
  std::uint32_t at = 0;  // visited last: motions from here to the root are current
  // Its anchor over the step; `held` refers to the body that carries the anchor:
  Pose held_before, held_after;
  Vec3 from{0}, to{0};                    // m
  Vec3 anchor_velocity{0}, held_spin{0};  // m/s, rad/s
  Quat held_rotation{1, 0, 0, 0};         // now
  Real mass = 0;
  Vec3 before{0};           // m/s, of a free tree's mass centre, before forces
  Real energy_removed = 0;  // J, from all of the group over the step
  bool touched = false;
  bool can_be_held = false, is_held = false;  // see hold_contacts()
  bool stands = false;                        // in a part of a step solved by rest_group()
  bool has_loops = false;                     // its island has rigid ties
  std::uint32_t loops = kNoNode;              // its GroupLoops, in the group
  std::uint32_t first_tie = kNoNode;          // the first rigid tie on this tree
  bool is_tied_outside = false;               // to other trees or to fixed points
};

/// Where two bodies of a group touch.
struct ContactPlace {
  std::uint32_t contact = 0;        // in contacts_of(world)
  std::uint32_t a = 0, b = 0;       // bodies of the group
  std::uint32_t cross = kNoNode;    // of two bodies of one tree: in GroupScratch::crosses
  std::uint32_t rolling = kNoNode;  // in GroupScratch::rollings
  std::uint32_t skins = kNoNode;    // in GroupScratch::skins
  Vec3 axes[3];                     // the normal, from b to a, and two tangents
  contact::TouchedPlace on_a, on_b;
  Vec3 arm_a{0}, arm_b{0};    // m, world: where impulses act
  Vec3 lead_a{0}, lead_b{0};  // m, world: where velocities are evaluated, see lead()
};

/// One contact point between two bodies.
struct GroupContact : ContactPlace {
  Real gap = 0, asked = 0;                                       // m; see part_overlaps()
  Real along = 0, aside = 0, cross_first = 0, cross_second = 0;  // response, 1/kg
  Real comes = 0;         // m/s: of a towards a fixed or led b, before impulses act
  bool works = true;      // active: near enough, and the bodies respond to it
  bool in_lanes = false;  // as GroupPair::in_lanes
  Real friction = 0, restitution = 0;
  Real surface_first = 0, surface_second = 0;  // m/s, Contact::surface_velocity across the normal
  contact::RollingLengths lengths;
  Real rest = 0, settling = 0;  // m: see Contact; error of it that is left, see take_up()
  Real shallow = 0;             // m: overlaps up to this are removed without adding velocity
  Vec3 impulse{0};              // N s of a substep, along the axes; between steps the mean force, N
  Real before = 0;              // N s, along the normal in the previous substep
  Vec3 passed{0};               // N s over the step so far
};

/// Two NURBS shapes in contact, and the places of their faces where they are closest.
struct TouchingSkins {
  const Shape *a = nullptr, *b = nullptr;
  nurbs::Place on_a, on_b;
};

/// Rolling and spinning friction of all points of two bodies: a torque on a, the opposite on b.
struct GroupRolling {
  std::uint32_t first = 0, count = 0;  // contacts
  Vec3 axes[3];                        // the mean of their normals, and two tangents
  Real about = 0, across = 0;  // response to a torque along the first and across it, 1/(kg m^2)
  Vec3 impulse{0};  // N m s of a substep, along the axes; between steps the mean torque, N m
  Vec3 passed{0};   // N m s over the step so far
};

inline bool have_same_bodies(const GroupContact& c, const GroupContact& d) {
  return c.a == d.a && c.b == d.b;
}

/// A vector given by its components along the axes of a contact.
inline Vec3 to_world(const GroupContact& c, Vec3 v) { return contact::in_world(c.axes, v); }
inline Vec3 to_world(const GroupRolling& r, Vec3 v) { return contact::in_world(r.axes, v); }

/// Response of body a of a pair to a wrench on body b, both of one tree.
struct CrossResponse {
  Mat3 vf{0}, vt{0}, wf{0}, wt{0};
};

/// A constraint between a point of body a and one of body b: rigid, a spring or a cable.
struct GroupTie {
  enum class Kind : std::uint8_t { rigid, spring, cable };
  Kind kind = Kind::rigid;
  std::uint32_t a = 0, b = 0;               // bodies of the group
  std::uint32_t cross = kNoNode;            // as in ContactPlace
  std::uint32_t island = 0, number = 0;     // pin or cable of the island
  Vec3 anchor_a{0}, anchor_b{0};            // m, body frames
  Real length = 0;                          // m, of a cable
  Real stiffness = 0, damping = 0;          // N/m, N s/m; a cable of zero stiffness is inextensible
  Vec3 arm_a{0}, arm_b{0};                  // m, world
  Vec3 apart{0};                            // m, from a's point to b's
  Mat3 response{0}, inverse{0};             // of the relative velocity; of the implicit equation
  Real along = 0;                           // of a cable, 1/kg
  std::uint32_t first_step = 0, steps = 0;  // rigid tie: its path to the root
  std::uint32_t first = 0;                  // rigid: first tie of its island that is coupled to it
  std::size_t row = 0;      // rigid: in GroupScratch::number_list, from block `first`
  Real yield = 0;           // 1/kg, regularisation
  bool is_joint = false;    // `number` is a column of the island
  Real parting = 0;         // m/s, of a cable's ends without impulses; not below 0
  bool is_reeled = false;   // a cable whose length changes in the step
  bool has_moved = false;   // placed at the end of the substep, see follow_cables()
  Vec3 impulse{0};          // N s of a substep on b, of a cable its tension in x
  Vec3 passed{0};           // N s over the step so far
  Real energy_removed = 0;  // J, as GroupTree's, in a group without trees
};

/// The rigid ties of one island, solved together: group_loops.cpp.
struct GroupLoops {
  std::uint32_t first_tie = 0, ties = 0;
  std::uint32_t first_tree = 0, trees = 0;
  std::uint32_t first_step = 0;  // in GroupScratch::path_steps, of a body's path to the root
  Real open = 0;                 // m: smaller gaps are closed gradually
  std::size_t row = 0;           // in GroupScratch::number_list: a row while it is factored
  std::size_t left = 0;          // there too: the vector z of group_loops.cpp
};

/// A body of such an island on which contacts, springs or cables act.
struct LoopedBody {
  std::uint32_t loops = 0, node = 0;  // in the group
  std::size_t rows = 0;               // in GroupScratch::number_list: by force, then by torque
  std::uint32_t first = 0;            // the rows before this tie's are zero
  bool known = false;                 // computed in this substep
  Response response;                  // with all loops closed
};

/// One group of a step: bodies that touch one another, and the fixed ones that they touch.
struct Group {
  std::span<GroupBody> bodies;
  std::span<GroupContact> contacts;
  std::span<GroupPair> pairs;
  std::span<GroupNode> nodes;
  std::span<GroupTree> trees;
  std::span<CrossResponse> crosses;
  std::span<GroupTie> ties;
  std::span<GroupRolling> rollings;
  std::span<TouchingSkins> skins;  // of all groups
  std::span<GroupLoops> loops;
  std::span<LoopedBody> looped;
  std::span<PathStep> path_steps;
  std::span<Real> numbers;  // of loops or of a group that rests, then of pairs, then of lanes
  std::span<const LanedPair> laned;  // by colour
  std::span<PairBatch> batches;      // the first that is empty ends them
  std::size_t lane_numbers = 0;      // in `numbers`
  // Of a group that rests:
  std::span<RestBody> resting;
  std::span<RestContact> rest_contacts;
  BlockPattern rest_pattern;
  std::span<RestLink> rest_links;
  bool pressed = false;  // see is_pressed()
  bool waits = false;    // until a search for rest is tried again
  Real time = 0;         // s, at the start of the step
  Threads threads;       // for this group alone

  GroupBody& a(const GroupContact& c) const { return bodies[c.a]; }
  GroupBody& b(const GroupContact& c) const { return bodies[c.b]; }
  bool is_fixed(const GroupContact& c) const { return b(c).per_mass == 0; }
  /// Whether at most `most` bodies are dynamic, all of them without joints.
  bool has_at_most(std::size_t most) const {
    return trees.empty() && ties.empty() && (bodies.size() <= most || bodies[most].per_mass == 0);
  }
  bool is_single() const { return has_at_most(1); }
};

/// A section of a step: its length, s, and the fractions of the step at which it begins and ends.
struct GroupPart {
  Real h = 0, begin = 0, end = 1;
  Real whole = 0;  // s, of the step
};

/// A soft constraint in a substep, as factors of a rigid contact's impulse. [Catto 2024]
struct Softness {
  Real rate = 0;        // 1/s: speed of separation per penetration
  Real by_mass = 1;     // factor of the rigid contact's increment
  Real by_impulse = 0;  // factor of the accumulated impulse
};

// Trees in a group (group_trees.cpp): joints stay closed exactly, whatever impulses act.

/// Prepares trees for impulses at their current poses: motions from momenta and the forces of the
/// substep.
void prepare_trees(const Group& g, const GroupPart& part);
/// Before that: adds the geometric stiffness of tension to bodies of islands with loops.
void stiffen(const Group& g, Real h);
/// Adds the inertia of pressing bodies while loops are closed; removes it again.
void press(const Group& g);
void release(const Group& g);
/// The rotation of a tree's anchor body at a fraction of the step; the rotation of a node's parent
/// (of a root: of the anchor body) at the start of the substep.
Quat held_rotation_at(const GroupTree& t, Real fraction);
Quat parent_rotation(const Group& g, const GroupNode& n);
/// Updates the motion of a body in a tree.
void visit(const Group& g, std::uint32_t node);
/// Applies an impulse to the body that was visited last in its tree.
void apply(const Group& g, std::uint32_t node, const Wrench& impulse);
/// The spin of a node relative to its parent, rad/s.
Vec3 relative_spin(const Group& g, std::uint32_t node);
/// The response of this relative spin to an impulse of torque at the joint.
Vec3 joint_response(const Group& g, const GroupNode& n, Vec3 along);
/// Applies an impulse of torque to a node, and the opposite to its parent.
void apply_at_joint(const Group& g, std::uint32_t node, Vec3 torque);
/// The response of one body of a tree to a wrench on another.
CrossResponse cross_response(const Group& g, std::uint32_t node, std::uint32_t on);
/// The response of a tree to the impulses in `passing`: an inward pass, node by node, then an
/// outward pass, which leaves there the changes of the nodes' motions.
void gather_impulse(const Group& g, std::uint32_t node);
void follow_impulse(const Group& g, std::uint32_t node);
/// Updates the motions of all trees.
void settle_trees(const Group& g);
/// Moves the trees by their motions (group_motion.cpp). Of a tree that stands, the bodies that are
/// pressed move as they would without joints.
void move_trees(const Group& g, const GroupPart& part);
/// Updates the motions of one tree.
void settle_tree(const Group& g, GroupTree& t);
/// After settle_trees: computes velocities of mass centres, momenta and joint forces.
void release_trees(const Group& g, const GroupPart& part);
/// A soft zone or a drive about one axis, in a substep: the own body gets the torque impulse
/// `torque - damping * relative spin` along it.
struct TurnSpring {
  Vec3 along;        // world
  Real damping = 0;  // N m s per rad/s
  Real torque = 0;   // N m s
};
/// Those of one joint: of four limits at most, and of its drive along three axes.
class TurnSprings {
 public:
  static constexpr std::size_t kMost = 7;
  void add(const TurnSpring& s) { list_[count_++] = s; }
  const TurnSpring* begin() const { return list_; }
  const TurnSpring* end() const { return list_ + count_; }

 private:
  TurnSpring list_[kMost];
  std::size_t count_ = 0;
};
/// Rotations of a joint's bodies in a part of the step that began at `time`, s.
struct JointTurn {
  Quat own, parent;
  Real time;
  const GroupPart& part;
};
/// Limits, springs and drives of the joints of trees (group_joints.cpp).
TurnSprings springs_of(const GroupNode& n, const JointTurn& at);
void prepare_springs(const Group& g, GroupNode& n, const GroupPart& part);
void prepare_limits(const Group& g, std::uint32_t node);
void push_limits(const Group& g);
/// The spring before a limit acts from this clearance on, rad. Without one, active limits are kept
/// from closing further.
struct LimitSpring {
  Real buffer = 0;
  const Softness* by = nullptr;
};
/// One sweep over the limits. Returns the largest change of a mass centre's speed, m/s.
Real solve_limits(const Group& g, Real h, const LimitSpring& spring);
void bound_drives(const Group& g, Real h);
/// Springs, friction and motors along the joints' coordinates (group_actuators.cpp): preparation,
/// warm start, one sweep.
void prepare_actuator(const Group& g, std::uint32_t node);
void push_actuators(const Group& g);
void solve_actuators(const Group& g, Real h);
/// m/s: bound on the speed that they can give to a point within a time h, beyond the present one.
Real speed_by_actuators(const Group& g, Real h);
/// The axis of an actuator at given rotations of the joint's bodies, world, and its coordinate,
/// full turns counted.
struct ActuatedAxis {
  Vec3 axis;
  Real angle;  // rad
};
ActuatedAxis actuated_axis_of(const GroupNode& n, Quat own, Quat parent);

// Bounds on the energy that truncated iterations leave (group_energy.cpp).
/// Whether only weight and moving obstacles can add energy to the group.
bool is_left_alone(const Group& g);
/// J: work of moving surfaces and kinematic bodies, by impulses of a substep, or of so many; at
/// least 0. The latter give at most that of elastic blows to bodies of kinetic energy `before`.
Real work_of_surfaces(const Group& g, Real before, Vec3 GroupContact::*by = &GroupContact::impulse,
                      int blows = 1);
void note_approach(const Group& g);  // by the free motions, which are kept
/// J: energy that springs and elastic cables store.
Real elastic_energy(const Group& g);
/// J: kinetic energy of the bodies' own velocities, between substeps.
Real energy_of_bodies(const Group& g);
/// J: work of weight and applied forces since the start of the step.
Real work_of_external_forces(const Group& g);
/// Saves all motions before impulses; restores them; clears the impulses, too.
void remember_free(const Group& g);
void restore_free_motions(const Group& g);
void forget_impulses(const Group& g);
/// J: kinetic energy of the current motions, within a substep.
Real kinetic_energy(const Group& g);
/// Scales all motions down alike, which neither opens joints nor makes bodies approach.
void bound_energy(const Group& g, Real before);
/// The same between substeps, given the energy of the bodies' own velocities.
void slow_bodies(const Group& g, Real now, Real before);

// Groups at rest, solved as a whole (group_rest.cpp).

/// Whether bodies, of which the first `free` are dynamic, hardly move in a step of h seconds. Light
/// bodies with joints may, unless they are `touched`.
bool is_calm(std::span<const GroupBody> bodies, std::size_t free, Real h);
/// Whether a contact bears: it had an impulse in the last step, or nearly no gap.
bool bears(const GroupContact& c);
/// Whether bodies, of which the first `free` are dynamic, glide on one another: they do not turn,
/// nor part from what bears them. Those that are borne are `touched`.
bool may_glide(std::span<const GroupBody> bodies, std::span<const GroupContact> contacts,
               std::size_t free);
/// What rest_group() found: the group rests; a body moves; it is not of this kind; a search found
/// no such solution.
enum class Rest : std::uint8_t { taken, moves, fails, missed };
/// Takes the step, or a part of it, if the group stays at rest, and leaves impulses of part.h
/// seconds. Else it moves nothing. In a part of a step light arms that touch nothing may swing.
Rest rest_group(const Group& g, const GroupPart& part);
/// Takes a part of the step of such a group, whatever its motion.
Rest move_group(const Group& g, const GroupPart& part);

// Loops and exact pins besides those of the roots (group_loops.cpp).

/// Assembles and factors the equations of the rigid ties; after prepare_trees.
void prepare_loops(const Group& g);
/// The response of a body with its loops closed; of one body to a wrench on another, both of one
/// tree or one island with loops.
void prepare_looped(const Group& g, std::uint32_t body);
CrossResponse cross_response_of(const Group& g, std::uint32_t a, std::uint32_t b);
/// From here to end_loops, impulses on looped bodies act through the loop-closed response. Loops
/// close the fraction `part` of their gaps in the substep.
void begin_loops(const Group& g, Real h, Real part);
/// Applies the loops' impulses to the trees.
void end_loops(const Group& g);
/// Change of a body's motion by the loops' impulses so far.
Wrench change_by_loops(const Group& g, const LoopedBody& b);
void push_looped(const Group& g, const LoopedBody& b, const Wrench& impulse);
/// The gaps of loops at the current poses.
struct LoopGaps {
  Real worst = 0;    // m
  Real squares = 0;  // m^2, their sum
};
/// Measures the gaps; updates `apart` of all ties.
LoopGaps gaps_of(const Group& g, const GroupLoops& l);
/// Closes cut joints exactly by translating trees; their gaps move to the loops.
void close_cuts(const Group& g);
/// Adds to `passing` the impulses that close gaps larger than `open`.
void push_closing(const Group& g, const GroupLoops& l);
/// Whether gaps are larger than `open` by this factor; closes them by rotating bodies at the start
/// of a substep. The latter returns whether the equations must be rebuilt (group_motion.cpp).
bool are_open(const Group& g, Real times = 1);
bool close_loops(const Group& g, const GroupPart& part);
/// Moves bodies until inextensible cables are not too long, once for each. Returns whether any was;
/// the equations must then be rebuilt (group_motion.cpp).
bool shorten_cables(const Group& g, const GroupPart& part);

}  // namespace pantin::detail::articulated
