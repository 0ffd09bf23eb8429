#pragma once
/// An island of the articulated solver: bodies that joints and cables tie together, packed in tree
/// order.
///
/// Compiled from the components when the structure changes, then kept from step to step.
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/joints/joint.hpp"
#include "engine/solvers/articulated/loads.hpp"
#include "engine/solvers/articulated/packed.hpp"
#include "engine/world/body.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/memory.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/settings.hpp"

namespace pantin {
struct World;
}

namespace pantin::articulated {

/// Rows of numbers, one column a body, packed in groups of kLanes columns.
class Table {
 public:
  void resize(std::size_t rows, std::size_t columns) {
    rows_ = rows;
    numbers_.assign(rows * ((columns + kLanes - 1) / kLanes * kLanes), 0.0);
  }
  Real& at(std::size_t row, std::size_t column) { return numbers_[place(row, column)]; }
  Real at(std::size_t row, std::size_t column) const { return numbers_[place(row, column)]; }
  Vec3 vec(std::size_t row, std::size_t column) const {
    const std::size_t p = place(row, column);
    return {numbers_[p], numbers_[p + kLanes], numbers_[p + 2 * kLanes]};
  }
  void set(std::size_t row, std::size_t column, Vec3 v) {
    const std::size_t p = place(row, column);
    numbers_[p] = v.x, numbers_[p + kLanes] = v.y, numbers_[p + 2 * kLanes] = v.z;
  }
  Quat quat(std::size_t row, std::size_t column) const {
    const std::size_t p = place(row, column);
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
    return (column / kLanes * rows_ + row) * kLanes + column % kLanes;
  }

  std::vector<Real> numbers_;
  std::size_t rows_ = 0;
};

/// One unilateral or bilateral row of the articulated solve: a direction at a point of a body and
/// the opposite at a point of another (or of the world).
struct Row {
  std::uint32_t column_a = UINT32_MAX, column_b = UINT32_MAX;
  Vec3 arm_a{0}, arm_b{0};  // from the joint points of these bodies, world axes
  Vec3 direction{0};        // of the force on b
  Real bound = 0;           // what direction . (u_b - u_a) has to be (or at least, if one-sided)
  Real softness = 0;        // compliance over step^2, 1/kg
  Real wanted = 0;          // how far the free motion falls short of the bound
  bool one_sided = false;
  bool rigid = false;  // nothing moves along it, or it follows from other rows
  std::uint32_t cord = UINT32_MAX;  // the string it stands for, in Island::cords
  Real load = 0;                    // multiplier, kg m
};

/// What elimination leaves of one body whose joint may be stiff; see tree.cpp.
struct JointNode {
  Mat3 give{0};       // G: relative turn per torque
  Mat3 follow{0};     // P: turn per turn of the parent
  Mat3 swing{0};      // Y: turn per displacement of the own joint point, reversed
  Mat3 group{0};      // M: mass that the joint feels of everything outboard, kg
  Mat3 lever{0};      // F: force at the joint per turn of the parent, transposed
  Vec3 turn{0};       // turn when neither the joint point nor the parent moves
  Vec3 load{0};       // at the joint, kg m
  Vec3 torque{0};     // that the parent feels, kg m^2
  bool loose = true;  // the parent's turn is not felt
};

/// The block of a body before its relative turn is eliminated: energy
/// t.tt.t / 2 + t.ty.y + y.yy.y / 2 - gt.t - gy.y of its turn t and its joint point's slide y.
struct JointBlock {
  Mat3 tt{0}, ty{0}, yy{0};
  Vec3 gt{0}, gy{0};
};

/// A stop of a joint in one direction: along . r <= room for the relative turn r. While it is on,
/// that direction is locked there and bears a load; with a weight it is a stiff row instead, which
/// keeps to the load it knows where others could bear as well.
struct Stop {
  Vec3 along{0};
  Real room = 0;  // rad
  Real bend = 0;  // rad: what large turns add to the linear answer, by the last pass
  Real load = 0;  // kg m^2, against `along`
  Real weight = 0;  // kg m^2/rad
  Real soft = 0;  // rad within the soft zone
  bool on = false, both_ways = false;
  bool is_lock() const { return on && weight == 0; }
  // For the load: along . (pull - by_turn t - by_slide y - by_relative r).
  Real pull = 0;
  Vec3 by_turn{0}, by_slide{0}, by_relative{0};
};

/// A joint that does more than hold a point, during one step. Relative turns are those of the own
/// body against the parent, world axes.
struct JointTerms {
  Vec3 align{0};        // c: brings the predicted pose to where the kind allows it
  Mat3 spring{0};       // K of soft zones, kg m^2/rad
  Vec3 torque{0};       // of the same at no relative turn, kg m^2
  Real drive_spring = 0;  // likewise of the drive, as if nothing capped it
  Vec3 drive_torque{0};
  Vec3 first, second;   // the free directions of hinge and universal
  Stop stops[4];        // turn low and high, second or swing low and high
  Quat parent{1, 0, 0, 0};  // predicted rotation of the parent
  Vec3 way{0};              // relative turn of the prediction since the start
  Vec3 turned{0};           // relative turn found by the last pass
};

/// A contact as one of its two bodies feels it.
struct Touch {
  std::uint32_t contact = 0;
  std::uint32_t column = 0;
  Real side = 1;         // 1: body a, -1: body b
  Vec3 arm{0};           // from the joint point to the point of contact, predicted
  Vec3 predicted{0};     // the point there, world
  Vec3 goal{0};          // where the row wants the point
  Vec3 bend{0};          // what turning adds to the linear answer, by the last pass
  Real weight = 0;       // kg, along the normal
  Real grip = 0;         // kg, across it
  bool listed = false;   // its load was iterated in the last pass
};

/// A contact or a stop whose load is found by iteration. It takes three numbers, or one.
struct LoadRow {
  bool is_stop = false;
  std::uint32_t column = 0;
  std::uint32_t touch = 0;   // of a contact, in StepScratch::touches
  std::uint32_t stop = 0;    // of a joint
  std::uint32_t number = 0;  // the first
  std::uint32_t other = UINT32_MAX, other_row = 0;  // articulation and row of a mutual contact's b
  Vec3 wanted{0};            // displacement beyond the free one; of a stop: x
  Real stiffness = 0, side_stiffness = 0;  // along the normal, across it
};

/// What one step of one articulation needs and forgets.
struct StepScratch {
  Table work;               // see Work
  std::vector<Real> nodes;  // kNodeSize a body, see Node
  Table forces;             // 6 rows: acceleration, torque; only where forces are used
  std::vector<Row> rows;
  std::vector<Real> blocks;                    // kBlockSize a body, for trees
  std::vector<Real> targets;                   // 3 a tree
  std::vector<Real> response, factor, solved;  // rows x rows, and a row each
  std::vector<Vec3> slide, turn;               // a body each: answer to a load
  std::vector<Vec3> levers;                    // a body each: joint point of the parent to its own
  std::vector<Vec3> gaps;                      // a body each: kGap, for more than one pass
  std::vector<Vec3> loads;                     // a body each
  std::vector<JointNode> joint_nodes;          // a body each, where joints are stiff or rows are
  std::vector<JointBlock> base, joint_blocks;  // likewise
  std::vector<JointTerms> terms;               // a body each, where joints are stiff
  std::vector<Touch> touches;                  // of this step
  std::vector<LoadRow> load_rows;              // contacts and stops whose loads are iterated
  std::vector<Real> load_response, load_moved;  // numbers x numbers, and a number each
  std::vector<Quat> rotations;                 // a body each: as the joints leave it
  std::vector<Loads> forces_in, torques_in;    // a body each
  std::vector<Vec3> velocities;                // a body each: at the start, while energy is watched
  std::vector<std::uint8_t> on_path;
  bool predicted = false;  // by an update stage; where it is not, one is to be made up for
  Real part = 1;  // of the way to the held points that the last round went
};

/// One tree of the articulation: bodies [first, first + count), parents before children.
struct Tree {
  std::uint32_t first = 0, count = 0;
  /// What holds the root: slot of a kinematic body and an anchor in it, or a pin; none if free.
  std::uint32_t held_body = UINT32_MAX;  // slot in World::bodies
  std::uint32_t held_pin = UINT32_MAX;   // slot in World::pins
  Vec3 anchor{0};                        // in the held body's frame
  Vec3 target{0};                        // world, this step
  Vec3 target_before{0};                 // world, last step
  Vec3 spin_momentum{0};                 // free trees: angular momentum about the mass centre
  bool keeps_spin = false;               // ... is known

  static void fields(auto& self, auto&& field) {
    field("first", derived(self.first));
    field("count", derived(self.count));
    field("held_body", derived(self.held_body));
    field("held_pin", derived(self.held_pin));
    field("anchor", derived(self.anchor));
    field("target", self.target);
    field("target_before", derived(self.target_before));
    field("spin_momentum", self.spin_momentum);
    field("keeps_spin", self.keeps_spin);
  }
};

/// A joint in packed form, where it does more than hold a point.
struct PackedJoint {
  Joint joint;
  bool stiff = false;      // more than a free ball joint
  bool own_is_a = false;   // the body of this column is the joint's body a
  std::uint32_t drive = UINT32_MAX;  // slot in World::pose_drives
};

/// What a joint that does more than hold a point remembers from step to step.
struct JointMemory {
  Real loads[4] = {0, 0, 0, 0};  // of the stops, kg m^2
  Real share = 1;                // of its torque that a capped drive may exert

  static void fields(auto& self, auto&& field) {
    field("loads", self.loads);
    field("share", self.share);
  }
};

/// A held point besides the roots: met by rows of the solve and by relaxation.
struct Hold {
  std::uint32_t column = 0;  // of the body in this articulation
  std::uint32_t partner = UINT32_MAX;  // column of the body it is held at; none: a place, as below
  std::uint32_t tree = 0;
  Vec3 anchor{0};                        // in the body's frame
  std::uint32_t held_body = UINT32_MAX;  // as in Tree
  std::uint32_t held_pin = UINT32_MAX;
  std::uint32_t held_link = UINT32_MAX;  // slot in World::links, of a joint to a kinematic body
  Vec3 held_anchor{0};
  Vec3 target{0}, target_before{0};
  int priority = 0;
  Real compliance = 0;             // m/N; 0 is exact
  Vec3 load{0};                    // multiplier of the last step, kg m
  Vec3 gap_before{0};              // point to target after the last step, for spring grips
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
    field("load", self.load);
    field("gap_before", self.gap_before);
    field("reach", derived(self.reach));
    field("dead_reach", derived(self.dead_reach));
    field("residual", passive(self.residual));
    field("reachable", passive(self.reachable));
  }
};

/// A string in packed form. A column of UINT32_MAX means a kinematic body at `slot`.
struct Cord {
  std::uint32_t string = 0;  // slot in World::strings
  std::uint32_t column_a = UINT32_MAX, column_b = UINT32_MAX;
  std::uint32_t slot_a = 0, slot_b = 0;
  Real load = 0;  // multiplier of the last step, kg m

  static void fields(auto& self, auto&& field) {
    field("string", derived(self.string));
    field("column_a", derived(self.column_a));
    field("column_b", derived(self.column_b));
    field("slot_a", derived(self.slot_a));
    field("slot_b", derived(self.slot_b));
    field("load", self.load);
  }
};

/// What an island is made of: const within a step.
struct IslandStructure {
  SolverSettings settings;
  std::vector<Entity> bodies;         // tree order
  std::vector<std::uint32_t> slots;   // in World::bodies, padded
  std::vector<std::int32_t> parents;  // column, kHeld or kFree
  std::vector<std::uint32_t> links;   // slot in World::links of the joint to the parent, or kNoSlot
  std::vector<PackedJoint> joints;    // a column each; empty where every joint is a free ball
  Table constants;                    // see Constant
  Real size = 0;                      // m, longest way through the joints; scales tolerances
  Real mass = 0;                      // kg
  bool is_chain = false;              // every parent is the column before: the fast path
  Entity unfit;                       // a body that no step can be computed with, or none

  static void fields(auto& self, auto&& field) {
    field("settings", self.settings);
    field("bodies", derived(self.bodies));
    field("slots", derived(self.slots));
    field("parents", derived(self.parents));
    field("links", derived(self.links));
    field("joints", derived(self.joints));
    field("constants", self.constants);
    field("size", derived(self.size));
    field("mass", derived(self.mass));
    field("is_chain", derived(self.is_chain));
    field("unfit", derived(self.unfit));
  }
};

/// What an island keeps from step to step: this and its bodies decide the next step.
struct IslandMemory {
  Table memory;  // see Memory
  std::vector<Tree> trees;
  std::vector<Hold> holds;
  std::vector<Cord> cords;
  std::vector<JointMemory> joint_memory;  // by column, as `joints`
  int calm_steps = 0;
  int iterating = 0;      // steps for which loads are iterated from the start, since guessing failed
  Real still_for = 0;     // s, without motion to speak of
  bool resting = false;   // asleep until something wakes it
  Vec3 resting_in{0};     // the gravity it rests in, m/s^2
  bool fresh = true;      // no step was taken yet, or all memory was dropped
  Real last_step = 0;     // s
  Real reserve = 0;       // J, lost to the integrator lately; the limiter lets it come back
  bool aimed = false;     // targets of roots and holds are known from the last step
  bool driven = false;    // a place that holds it moved in the last step
  // Of solvers that do not keep the energy: what they may have, and what they can swing with.
  bool watched = false;
  Real budget = 0, usual = 0;  // J

  static void fields(auto& self, auto&& field) {
    field("memory", self.memory);
    field("trees", in_place(self.trees));
    field("holds", in_place(self.holds));
    field("cords", in_place(self.cords));
    field("joint_memory", in_place(self.joint_memory));
    field("calm_steps", self.calm_steps);
    field("iterating", self.iterating);
    field("still_for", self.still_for);
    field("resting", self.resting);
    field("resting_in", self.resting_in);
    field("fresh", self.fresh);
    field("last_step", self.last_step);
    field("reserve", self.reserve);
    field("aimed", self.aimed);
    field("driven", self.driven);
    field("watched", self.watched);
    field("budget", self.budget);
    field("usual", self.usual);
  }
};

/// How this step is taken, chosen as it goes.
struct StepPlan {
  Real energy_before = 0, kinetic_before = 0, damped = 0;  // J
  Vec3 momentum_before{0};                                 // kg m/s
  Real force_share = 1;  // of a step's h^2 times a force over a mass in the displacement it makes
  bool forced = false;        // forces act from outside
  bool second_order = false;  // BDF2 instead of backward Euler
  bool changed = false;       // the motion was changed by hand
  bool finite = true;         // the prediction is
  bool mutual = false;        // a contact with another dynamic body: solved side by side with its own
  bool iterates = false;      // loads of stops and contacts are iterated in this step
  bool rows_hold = false;     // the last gathering had stiff rows of contacts
  int parts_left = 0;         // of a step taken in substeps, after this one
  std::uint32_t was = UINT32_MAX;  // its number before the last build, if that left it as it was
};

/// What the step left, for the report and for the choices of the next.
struct StepResult {
  bool limited = false;    // the energy was
  bool disturbed = false;  // by a stop, a contact or a large rotation: the order drops
  bool bears = false;      // a contact bears a load
  bool touching = false;   // a contact or a stop bore a load
  bool settled = false;    // the last pass changed nothing
  int rounds_used = 0, passes_used = 0, stops_hit = 0, drives_capped = 0;
  Real stop_work = 0;      // J, done by drives, soft zones and moving contacts
  Entity lost;             // a body whose numbers went out of bounds
  bool grew = false;       // has severalfold more energy than it can have
};

struct Island : IslandStructure, IslandMemory, StepPlan, StepResult {
  Scratch<StepScratch> room;

  std::size_t count() const { return bodies.size(); }

  // Plan and result belong to one step.
  static void fields(auto& self, auto&& field) {
    IslandStructure::fields(self, field);
    IslandMemory::fields(self, field);
    field("room", derived(self.room));
  }
};

/// All islands of the articulated solver, and what a repeated step starts from.
struct Islands {
  std::vector<Island> list;
  struct Saved {
    IslandMemory memory;
    std::vector<Body> bodies;
  };
  struct TogetherScratch {
    std::vector<Saved> saved;     // by island
    std::vector<Island*> mutual;  // islands that touch one another
  };
  Scratch<TogetherScratch> scratch;

  static void fields(auto& self, auto&& field) {
    field("list", in_place(self.list));
    field("scratch", derived(self.scratch));
  }
};

/// The islands of a World, as compiled last.
std::vector<Island>& islands_of(World& world);
const std::vector<Island>& islands_of(const World& world);

/// Packs all islands that this solver moves. What a change does not concern goes on as if there had
/// been none; of an island whose own structure changed memory is carried over by body. Links that
/// this solver cannot use are left out and listed in the partition's faults.
void compile(World& world, std::span<const IslandPlan> plans);

}  // namespace pantin::articulated
