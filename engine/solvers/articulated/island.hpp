#pragma once
/// An island of the articulated solver: bodies connected by joints and cables, packed in tree
/// order.
///
/// Compiled from the components when the structure changes; kept from step to step.
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/invariants.hpp"
#include "engine/base/math.hpp"
#include "engine/base/stable_vector.hpp"
#include "engine/joints/joint.hpp"
#include "engine/joints/reel.hpp"
#include "engine/joints/stops.hpp"
#include "engine/solvers/articulated/impulses/group_scratch.hpp"
#include "engine/solvers/articulated/lane_layout.hpp"
#include "engine/solvers/articulated/smooth/conserving_node.hpp"
#include "engine/solvers/articulated/smooth/parted_step.hpp"
#include "engine/solvers/articulated/smooth/tie.hpp"
#include "engine/solvers/budget.hpp"
#include "engine/solvers/islands.hpp"
#include "engine/world/body.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/memory.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/settings.hpp"

namespace pantin::detail {
struct Rebuild;
}

namespace pantin::detail::articulated {

/// A table of rows of numbers with one column per body, stored in blocks of kLanes columns.
class LaneTable {
 public:
  void resize(std::size_t rows, std::size_t columns) {
    rows_ = rows;
    numbers_.assign(rows * ((columns + kLanes - 1) / kLanes * kLanes), 0.0);
  }
  Real& at(std::size_t row, std::size_t column) { return numbers_[place(row, column)]; }
  Real at(std::size_t row, std::size_t column) const { return numbers_[place(row, column)]; }
  Vec3 vec(std::size_t row, std::size_t column) const {
    const std::size_t p = place(row, column);
    PANTIN_ASSERT(row + 3 <= rows_);
    return {numbers_[p], numbers_[p + kLanes], numbers_[p + 2 * kLanes]};
  }
  void set(std::size_t row, std::size_t column, Vec3 v) {
    const std::size_t p = place(row, column);
    PANTIN_ASSERT(row + 3 <= rows_);
    numbers_[p] = v.x, numbers_[p + kLanes] = v.y, numbers_[p + 2 * kLanes] = v.z;
  }
  Quat quat(std::size_t row, std::size_t column) const {
    const std::size_t p = place(row, column);
    PANTIN_ASSERT(row + 4 <= rows_);
    return Quat(numbers_[p + 3 * kLanes], numbers_[p], numbers_[p + kLanes],
                numbers_[p + 2 * kLanes]);
  }
  void set(std::size_t row, std::size_t column, Quat q) {
    set(row, column, Vec3(q.x, q.y, q.z));
    at(row + 3, column) = q.w;
  }
  Real* data() { return numbers_.data(); }
  const std::vector<Real>& numbers() const { return numbers_; }

  static void fields(auto& self, auto&& field) {
    field("numbers", in_place(self.numbers_));
    field("rows", derived(self.rows_));
  }

 private:
  std::size_t place(std::size_t row, std::size_t column) const {
    PANTIN_ASSERT(row < rows_ && (column / kLanes + 1) * rows_ * kLanes <= numbers_.size());
    return (column / kLanes * rows_ + row) * kLanes + column % kLanes;
  }

  std::vector<Real> numbers_;
  std::size_t rows_ = 0;
};

/// A contact of this step, assigned to one of its two bodies.
struct ContactRow {
  std::uint32_t contact = 0;
  std::uint32_t column = 0;
  int side = 1;  // 1: body a, -1: body b
};

/// How the rules of the paper moved a body out of overlaps in this step.
struct BodyPush {
  Real out = 0;  // m, the length of its path along normals
  Vec3 way{0};   // m, sum of displacements along normals
  Vec3 held{0};  // m, displacement across normals, by friction
};

/// Workspace of bodies and trees.
struct BodyScratch {
  LaneTable work;             // see Work
  std::vector<Real> nodes;    // kNodeSize a body, see Node
  LaneTable forces;           // 6 rows: acceleration, torque; only where forces are used
  std::vector<Real> blocks;   // kBlockSize a body, for shake2
  std::vector<Real> targets;  // 3 a tree
  std::vector<Real> ways, anchor_velocities;  // likewise, for the energy-momentum method
  std::vector<Vec3> translation, rotation;    // shake2, per body: response to the gaps
  std::vector<Vec3> turned;                   // shake2, per body: rotation vector of the step, rad
  std::vector<Real> outboard;                 // of free trees, per body: mass of its subtree, kg
  std::vector<ContactRow> contact_rows;       // of this step
  std::vector<BodyPush> pushes;               // a body each, if any has a collider
  std::vector<Vec3> velocities;               // a body each: at the start of a step with ties
};

/// Workspace of the equations that couple ties.
struct TieEquations {
  std::vector<TiePathStep> tie_paths;          // of all ties, by tie_path_starts
  std::vector<std::uint32_t> tie_path_starts;  // one more than ties
  std::vector<TieRow> tie_rows;
  std::vector<TieShare> tie_shares;            // in the order of the rows
  std::vector<TiePassing> tie_passing;         // of the longest path
  std::vector<PathStep> tie_steps;             // as tie_paths, of ties with rows
  std::vector<std::uint32_t> tie_step_starts;  // by column: bodies, then places of free roots
  std::vector<Real> tie_blocks_of_row;         // a block for each tie with rows
  std::vector<Real> tie_matrix, tie_solution, tie_largest;
  std::vector<Real> tie_kept;  // copies of matrix and right-hand side
  std::vector<std::uint32_t> tie_order;
};

/// Workspace of ties and of joints that constrain rotations, in the energy-momentum method.
struct TieScratch {
  std::vector<ConservingTie> ties;
  std::vector<TieRows> tie_sets;                 // rows of each tie
  std::vector<ConservingSum> conserving_sums;    // a body each, if joints constrain rotations
  std::vector<ConservingNode> conserving_nodes;  // likewise
  bool stiff = false;  // joints are eliminated with their rows, in conserving_nodes
  Real tie_yield = 0;  // compliance of rigid ties, relative: see begin_ties()
  std::vector<Real> tie_blocks, tie_factors;                // see ConservingTies
  std::vector<std::uint8_t> tie_grounded;                   // likewise
  std::vector<Vec3> tie_impulses, tie_torques, tie_joints;  // a body each
  std::vector<CableRow> cable_rows, cable_rows_before;      // a cable each
  std::vector<Vec3> velocities_before;                      // 2 a body, for impacts of cables
  std::vector<Vec3> pin_gaps;                               // a pin each: see begin_closing()
  std::vector<Real> cable_gaps;                             // a cable each, m: likewise
  std::vector<Vec3> pins_before;  // a pin each: its target where sweeps take over the step
  std::vector<std::uint8_t> on_path;
  bool predicted = false;  // by the update stage; otherwise predicted later
};

/// Scratch memory of one step of one island.
/// What a step with a budget gives to an island, and what it took (update_rate.cpp).
struct Effort {
  Clock::time_point hurries_from = Clock::time_point::max();
  int attempts = 1;      // substeps tried in the last step
  bool hurried = false;  // impacts and losses of energy did not divide the end of it
};

struct StepScratch : BodyScratch, TieScratch, TieEquations, Effort {};

/// One tree of the island: bodies [first, first + count), parents before children.
struct Tree {
  std::uint32_t first = 0, count = 0;
  /// Anchor of the root: slot of a kinematic body and a point in it, or a pin; none if free.
  std::uint32_t held_body = UINT32_MAX;  // slot in World::bodies
  std::uint32_t held_pin = UINT32_MAX;   // slot in World::pins
  Vec3 anchor{0};                        // in the held body's frame
  Vec3 target{0};                        // world, this step
  Vec3 target_before{0};                 // world, last step
  Vec3 angular_momentum{0};              // free trees: about the mass centre
  bool knows_angular_momentum = false;   // ... is known

  static void fields(auto& self, auto&& field) {
    field("first", derived(self.first));
    field("count", derived(self.count));
    field("held_body", derived(self.held_body));
    field("held_pin", derived(self.held_pin));
    field("anchor", derived(self.anchor));
    field("target", self.target);
    field("target_before", derived(self.target_before));
    field("angular_momentum", self.angular_momentum);
    field("knows_angular_momentum", self.knows_angular_momentum);
  }
};

/// A joint in packed form, where it constrains rotations.
struct PackedJoint {
  Joint joint;
  bool stiff = false;                // more than a free ball joint
  bool own_is_a = false;             // the body of this column is the joint's body a
  std::uint32_t drive = UINT32_MAX;  // slot in World::joint_drives
};

/// State of a joint that constrains rotations.
struct JointMemory {
  Real lambdas[4] = {0, 0, 0, 0};  // of the limits, kg m^2
  Real torque_fraction = 1;        // fraction of the drive's torque that its limit allows
  Vec3 torque{0};  // N m, through the joint in the last step, without springs, if known
  Real angle = 0;  // rad, of an actuated joint, full turns counted
  // N m: of spring, friction and motor along their coordinate, mean over the last step; NaN where
  // their laws hold at the end of the step.
  Real actuation = std::numeric_limits<Real>::quiet_NaN();

  static void fields(auto& self, auto&& field) {
    field("lambdas", self.lambdas);
    field("torque_fraction", self.torque_fraction);
    field("angle", self.angle);
    field("torque", passive(self.torque));
    field("actuation", passive(self.actuation));
  }
};

/// A pin constraint besides the root anchors.
struct PackedPin {
  std::uint32_t column = 0;            // of the body in this island
  std::uint32_t partner = UINT32_MAX;  // column of the other body; none: anchored as below
  std::uint32_t tree = 0;
  Vec3 anchor{0};                        // in the body's frame
  std::uint32_t held_body = UINT32_MAX;  // as in Tree
  std::uint32_t held_pin = UINT32_MAX;
  std::uint32_t held_link = UINT32_MAX;  // slot in World::links, if it stands for a joint
  Vec3 held_anchor{0};
  Vec3 target{0}, target_before{0};
  int priority = 0;
  Real compliance = 0;             // m/N; 0 is exact
  Real damping = 0;                // N s/m, of a spring
  Vec3 lambda{0};                  // of the last step, kg m
  Vec3 gap_before{0};              // point to target after the last step, for springs
  Real reach = 0, dead_reach = 0;  // largest and smallest distance to the root's target
  Real residual = 0;
  bool reachable = true;

  static void fields(auto& self, auto&& field) {
    field("column", derived(self.column));
    field("partner", derived(self.partner));
    field("tree", derived(self.tree));
    field("anchor", derived(self.anchor));
    field("held_body", derived(self.held_body));
    field("held_pin", derived(self.held_pin));
    field("held_link", derived(self.held_link));
    field("held_anchor", derived(self.held_anchor));
    field("target", self.target);
    field("target_before", derived(self.target_before));
    field("priority", derived(self.priority));
    field("compliance", derived(self.compliance));
    field("damping", derived(self.damping));
    field("lambda", self.lambda);
    field("gap_before", self.gap_before);
    field("reach", derived(self.reach));
    field("dead_reach", derived(self.dead_reach));
    field("residual", passive(self.residual));
    field("reachable", passive(self.reachable));
  }
};

/// A cable in packed form. A column of UINT32_MAX means a kinematic body at `slot`.
struct PackedCable {
  std::uint32_t cable = 0;  // slot in World::cables
  std::uint32_t column_a = UINT32_MAX, column_b = UINT32_MAX;
  std::uint32_t slot_a = 0, slot_b = 0;
  Real lambda = 0;          // of the last step, kg m
  Real length_before = -1;  // m, when the island was last stepped; below 0: never
  Real rate_before = 0;     // m/s, likewise

  CableReel before() const { return {length_before, rate_before}; }

  static void fields(auto& self, auto&& field) {
    field("cable", derived(self.cable));
    field("column_a", derived(self.column_a));
    field("column_b", derived(self.column_b));
    field("slot_a", derived(self.slot_a));
    field("slot_b", derived(self.slot_b));
    field("lambda", self.lambda);
    field("length_before", self.length_before);
    field("rate_before", self.rate_before);
  }
};

/// Structure of an island: constant within a step.
struct IslandStructure {
  SolverSettings settings;
  std::vector<Entity> bodies;         // tree order
  std::vector<std::uint32_t> slots;   // in World::bodies, padded
  std::vector<std::int32_t> parents;  // column, kHeld or kFree
  std::vector<Children> children;     // per column; empty for a chain
  std::vector<std::uint32_t> links;   // slot in World::links of the joint to the parent, or kNoSlot
  std::vector<PackedJoint> joints;    // per column; empty where every joint is a free ball joint
  LaneTable constants;                // see Constant
  Real size = 0;                      // m, longest path through the joints; scales tolerances
  Real mass = 0;                      // kg
  bool is_even = false;               // see is_even() in compile.cpp
  bool is_chain = false;              // every parent is the previous column: fast path
  Entity unfit;                       // a body for which no step can be computed, or none

  static void fields(auto& self, auto&& field) {
    field("settings", self.settings);
    field("bodies", derived(self.bodies));
    field("slots", derived(self.slots));
    field("parents", derived(self.parents));
    field("children", derived(self.children));
    field("links", derived(self.links));
    field("joints", derived(self.joints));
    field("constants", self.constants);
    field("size", derived(self.size));
    field("mass", derived(self.mass));
    field("is_even", derived(self.is_even));
    field("is_chain", derived(self.is_chain));
    field("unfit", derived(self.unfit));
  }
};

/// State of an island: together with its bodies it determines the next step.
struct IslandMemory {
  LaneTable memory;  // see Memory
  std::vector<Tree> trees;
  std::vector<PackedPin> pins;
  std::vector<PackedCable> cables;
  std::vector<JointMemory> joint_memory;  // by column, as `joints`
  int swept_steps = 0;       // steps left to sweeps, after the energy-momentum method failed
  Real quiet_time = 0;       // s, with all speeds below the sleep speed
  std::vector<Pose> rests;   // by column, with colliders: poses at the start of rest_time
  Real rest_time = 0;        // s, since bodies last moved away from `rests`
  bool rested = false;       // the previous rest interval had ended as well
  std::uint8_t misses = 0;   // searches for rest of its group in vain, less the steps since
  std::uint8_t waits = 0;    // steps until the next search
  bool asleep = false;       // asleep until something wakes it
  Vec3 asleep_gravity{0};    // gravity when it fell asleep, m/s^2
  bool fresh = true;         // no step was taken yet, or the state was reset
  Real last_step = 0;        // s
  Real owed = 0;             // s: the steps since, which it was left out of (update_rate.cpp)
  bool has_targets = false;  // targets of roots and pins are known from the last step
  // Steps that do not conserve energy: bound on the energy, and scale of the motion.
  bool watched = false;
  Real budget = 0, usual = 0;  // J

  static void fields(auto& self, auto&& field) {
    field("memory", self.memory);
    field("trees", in_place(self.trees));
    field("pins", in_place(self.pins));
    field("cables", in_place(self.cables));
    field("joint_memory", in_place(self.joint_memory));
    field("swept_steps", self.swept_steps);
    field("quiet_time", self.quiet_time);
    field("rests", in_place(self.rests));
    field("rest_time", self.rest_time);
    field("rested", self.rested);
    field("misses", self.misses);
    field("waits", self.waits);
    field("asleep", self.asleep);
    field("asleep_gravity", self.asleep_gravity);
    field("fresh", self.fresh);
    field("last_step", self.last_step);
    field("owed", self.owed);
    field("has_targets", self.has_targets);
    field("watched", self.watched);
    field("budget", self.budget);
    field("usual", self.usual);
  }
};

/// Decisions taken during the step.
struct StepPlan {
  Real step = 0;           // s, its length with what is owed; 0: it is left out
  bool forced = false;     // external forces act
  bool changed = false;    // the caller changed the motion
  bool finite = true;      // the prediction is finite
  bool in_group = false;   // is stepped with its contact group: see step_group.cpp
  bool conserves = false;  // is stepped by the energy-momentum method, if not in contact
  bool in_crowd = false;   // is stepped in a batch: see crowd.cpp
};

/// What pins and inextensible cables miss.
struct Missed {
  Real worst = 0;  // m
  Entity at;
  int count = 0;  // beyond the tolerance
};

/// Results of the step, for the report and for the next step.
struct StepResult {
  Missed missed;
  bool limited = false;         // its energy was limited
  Real energy_removed = 0;      // J, by that, in all substeps
  bool contact_active = false;  // a contact is active
  int sweeps_used = 0, stops_hit = 0, drives_capped = 0;
  bool knows_torques = false;  // JointMemory::torque is of this step
  Entity lost;                 // a body whose state went out of bounds
  bool grew = false;           // has severalfold more energy than allowed
  bool jammed = false;         // in a substep, moving bodies left it no space
};

struct Island : IslandStructure, IslandMemory, StepPlan, StepResult {
  Scratch<StepScratch> scratch;

  std::size_t count() const { return bodies.size(); }

  // Plan and result belong to one step.
  static void fields(auto& self, auto&& field) {
    IslandStructure::fields(self, field);
    IslandMemory::fields(self, field);
    field("scratch", derived(self.scratch));
  }
};

/// Lists of awake and sleeping islands, from Island::asleep: a step visits the awake ones only.
struct RestLists {
  struct Sleeper {
    std::uint32_t island = 0;
    std::uint32_t slot = kNoSlot;  // of its only body, if free and untied; else kNoSlot
  };
  std::vector<std::uint32_t> changed;  // islands that fell asleep or woke since
  std::vector<std::uint32_t> awake;    // islands, ascending
  std::vector<Sleeper> sleepers;
  std::vector<std::uint32_t> more_awake;  // these two while lists are merged
  std::vector<Sleeper> more_sleepers;
  std::vector<std::uint32_t> touched;  // sleeping islands with contacts in this step
  Vec3 gravity{0};                     // m/s^2, when they were listed
  std::uint64_t version = 0;           // Partition::rest_version then
};

/// What the islands without contacts cost, and which are left out of a step with a budget.
struct UpdateRates {
  struct Candidate {
    Real urgency, weight;
    std::uint32_t island;
    bool waits;
  };
  std::vector<Candidate> candidates;
  Real cost = 0;    // s, of a unit of weight in a substep
  Real others = 0;  // s: of everything else in a substep, with all substeps of groups in contact
  Real weight = 0;  // of the islands that are stepped
  bool is_shared = false;  // Effort::hurries_from is set
  Clock::time_point began, stepping, stepped, until;
};

/// All islands of the articulated solver.
using IslandVector = StableVector<Island>;
struct Islands : IslandList<Island, IslandVector> {
  static constexpr std::string_view name = "articulated";  // in saved Worlds
  Scratch<RestLists> rest;
  Scratch<GroupScratch> groups;
  Scratch<CrowdScratch> crowd;
  Scratch<UpdateRates> rates;

  static void fields(auto& self, auto&& field) {
    IslandList::fields(self, field);
    field("rest", derived(self.rest));
    field("groups", derived(self.groups));
    field("crowd", derived(self.crowd));
    field("rates", derived(self.rates));
  }
};

/// The compiled islands of a World.
inline IslandVector& islands_of(World& world) { return world.memory.of<Islands>().list; }
inline const IslandVector& islands_of(const World& world) {
  return world.memory.of<Islands>().list;
}

/// Packs all islands that this solver moves. Islands of unchanged structure keep their state; for
/// others, state is carried over body by body. Links that this solver cannot use are left out and
/// listed in the partition's faults.
void compile(World& world, std::span<const IslandPlan> plans);
/// The same for the islands that a change concerns; the others stay as they are.
void recompile(World& world, const Rebuild& rebuild);

}  // namespace pantin::detail::articulated

// Code that copies, hashes and saves them is compiled once, in row.cpp.
namespace pantin::detail {
extern template articulated::Islands& Memories::create();
extern template const articulated::Islands& Memories::none();
}  // namespace pantin::detail
