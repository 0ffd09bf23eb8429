#pragma once
/// An island of the Lagrangian solver: bodies connected by joints, packed for the solver.
///
/// Compiled from the components when the structure changes, then kept from step to step.
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/invariants.hpp"
#include "engine/base/math.hpp"
#include "engine/contact/memory.hpp"
#include "engine/joints/rows.hpp"
#include "engine/solvers/islands.hpp"
#include "engine/solvers/lagrangian/blow_scratch.hpp"
#include "engine/solvers/lagrangian/complex.hpp"
#include "engine/solvers/lagrangian/contact_group.hpp"
#include "engine/solvers/lagrangian/frame.hpp"
#include "engine/solvers/lagrangian/touches.hpp"
#include "engine/world/body.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/settings.hpp"

namespace pantin::detail::lagrangian {

/// Origin of a block of rows.
enum class BlockKind : std::uint8_t {
  joint,    // a link
  pin,      // a pin: rows of a ball joint
  gear,     // a gear
  belt,     // a span of a belt
  limit,    // one side of a limited coordinate; a row only while it is active
  cable,    // a cable: a row only while it is taut
  surface,  // gap of two surfaces in contact; if unilateral, a row only while it is active
  roll,     // of the block before: no slip and no spin there. Constrains poses only if holonomic.
            // With friction, a row only while it sticks: BlockMemory::active
  drive,    // an exact drive: a row unless it yields
  spring,   // a joint force treated implicitly (Euler, implicit, radau)
  // Other compliant elements (radau).
  elastic_cable,
  elastic_pin,
  joint_torque  // a drive, soft stops
};

/// Blocks whose rows are compliant forces, not constraints.
inline bool is_compliant(BlockKind kind) { return kind >= BlockKind::spring; }

/// Bodies of a block; cables over guides have the most.
inline constexpr std::size_t kMostBlockBodies = 8;

/// Rows that are eliminated together: 1 to 6 rows on up to 8 bodies.
struct Block {
  BlockKind kind = BlockKind::joint;
  Coordinate coordinate = Coordinate::angle;  // limit, drive, spring; gear: of the first link
  Coordinate second = Coordinate::angle;      // gear: of the second link
  bool upper = false;                         // limit: the upper bound
  bool lock = false;                          // limit: both bounds are equal; surface: bilateral;
                                              // roll, skate: sticks at any force
  bool holonomic = true;                      // its rows constrain poses; false: velocities only
  bool point = false;                         // rows 0 to 2 constrain a point, the others rotations
  std::uint8_t rows = 0, count = 0;           // of rows, of bodies
  std::uint32_t source = 0;                   // slot in the store of its kind; limit, drive,
                                              // spring: links
  std::uint32_t body[kMostBlockBodies] = {};  // in the island
  std::uint8_t ends[4] = {};      // gear: bodies a and b of the first and of the second link
  std::uint32_t first_place = 0;  // of a cable over guides: in Island::places; of surfaces and
                                  // their rolling: in Island::touches; of a joint that may slip:
                                  // likewise; of a belt: its pulley
  std::uint32_t first_row = 0;
  std::uint32_t first_vector = 0;  // in the Jacobian: see solvers/lagrangian/jacobian.hpp
  Real bound = 0;                  // limit: value; gear: offset; roll: friction; a joint that may
                                   // slip: its grip, N, or its share of friction with a carrier
  std::uint32_t carrier = UINT32_MAX;  // a joint that may slip: the block whose normal force is its
                                       // load, or none
  bool carries = false;                // it is such a block

  static void fields(auto& self, auto&& field) {
    field("kind", derived(self.kind));
    field("coordinate", derived(self.coordinate));
    field("second", derived(self.second));
    field("upper", derived(self.upper));
    field("lock", derived(self.lock));
    field("holonomic", derived(self.holonomic));
    field("point", derived(self.point));
    field("rows", derived(self.rows));
    field("count", derived(self.count));
    field("source", derived(self.source));
    field("body", derived(self.body));
    field("ends", derived(self.ends));
    field("first_place", derived(self.first_place));
    field("first_row", derived(self.first_row));
    field("first_vector", derived(self.first_vector));
    field("bound", self.bound);
    field("carrier", derived(self.carrier));
    field("carries", derived(self.carries));
  }
};

/// Whether its rows constrain velocities only.
inline bool binds_no_poses(const Block& b) { return !b.holonomic; }

/// Whether it sticks up to a force and slips beyond: rolling with friction, a skate with a grip.
inline bool may_slip(const Block& b) { return !b.holonomic && !b.lock; }

/// State of a block.
struct BlockMemory {
  Real before[2] = {0, 0};  // coordinates after the last step, whole revolutions counted
  bool counted = false;     // from the initial pose on; before that, the nearest revolution holds
  bool active = false;      // limit, cable: the row is active; may_slip(): it sticks

  static void fields(auto& self, auto&& field) {
    field("before", self.before);
    field("counted", self.counted);
    field("active", self.active);
  }
};

/// A force law along a coordinate of a link: spring, friction, motor.
struct JointForce {
  std::uint32_t link = 0, body[2] = {};
  Coordinate coordinate = Coordinate::angle;
  Real before = 0;  // the coordinate at the last step, 0 before the first

  static void fields(auto& self, auto&& field) {
    field("link", derived(self.link));
    field("body", derived(self.body));
    field("coordinate", derived(self.coordinate));
    field("before", self.before);
  }
};

/// A force between two bodies, by its slot in its store.
struct BodyPairForce {
  std::uint32_t source = 0, body[2] = {};
  Real beside = 1;  // spring pins: the largest number of them at either body
};

/// A fault of an island in its present state.
struct Fault {
  enum Kind : std::uint8_t { redundant, inconsistent, wrong_branch } kind = redundant;
  std::uint32_t block = 0;  // see block_of
  int rows = 0;             // redundant: number of its dependent rows
  Real residual = 0;        // inconsistent: residual of the joint in m or rad, or in m/s^2
  Entity with = {};         // inconsistent: a body that the joint presses into by `residual`, m
};

/// Elimination order and fill pattern of the factor.
///
/// Bodies with few blocks are eliminated first, which gives J M^-1 J^T of their blocks. Hubs,
/// bodies with many blocks, remain as six unknowns each. Nodes are the blocks, then the hubs.
struct KktPattern {
  std::vector<std::uint32_t> order, place;   // node at each position; position of each node
  std::vector<std::uint8_t> size;            // unknowns, by place
  std::vector<std::uint32_t> unknown;        // first of them, by place: rows, then hubs
  std::vector<std::uint32_t> diagonal;       // in `values`, by place
  std::vector<std::uint32_t> first;          // by place: into later and offset
  std::vector<std::uint32_t> below, offset;  // column structure: positions of the nonzero blocks
                                             // below the diagonal; their numbers
  std::vector<std::uint32_t> first_target, targets;  // targets of the products of pairs of those
  struct BlockProduct {  // contribution of one body to the product of two blocks
    std::uint32_t p = 0, q = 0, target = 0;
    std::uint8_t at_p = 0, at_q = 0;
    bool flipped = false;      // `target` is stored with q's rows first
    bool all_points = false;   // all blocks of the body constrain points
    bool first_write = false;  // the first product written to `target`
  };
  std::vector<std::uint32_t> first_product;  // by body
  std::vector<BlockProduct> products;
  struct HubProduct {
    std::uint32_t block = 0, target = 0;
    std::uint8_t at = 0;
    bool flipped = false;
  };
  std::vector<HubProduct> hub_products;
  struct Range {
    std::uint32_t from = 0, count = 0;
  };
  std::vector<Range> fill_ranges;  // numbers that no product writes: fill and hubs
  struct Incident {
    std::uint32_t block = 0;
    std::uint8_t at = 0;
  };
  std::vector<std::uint32_t> first_incident;  // by body
  std::vector<Incident> incidents;
  std::vector<std::uint32_t> framed;  // blocks with a frame among their bodies
  std::vector<std::uint32_t> hubs;    // bodies
  std::vector<std::uint32_t> hub_of;  // by body, or UINT32_MAX
  std::size_t numbers = 0, unknowns = 0;
};

/// State of all bodies of an island at one time, frames last, and parameters of surface contacts.
struct Motions {
  std::vector<Vec3> x;
  std::vector<Quat> q;
  std::vector<Vec3> v, w;
  std::vector<SurfaceCoordinates> touches;
};

/// Scratch memory of an implicit step of three stages (radau). A state or its rate has four vectors
/// a body: displacement, rotation, velocity, angular velocity, relative to the start of the step.
struct CollocationScratch {
  std::vector<Vec3> stage[3], rate[3];  // of the stages
  std::vector<Vec3> part[3];            // transformed to one real and one complex system
  std::vector<Vec3> rate_at_start, error;
  std::vector<Mat3> inverse_inertia;     // at the start
  std::vector<Real> stiffness, damping;  // of compliant rows, at the start
  std::vector<Real> mobility;            // of compliant rows, at the start
  std::vector<Real> values, right;
  std::vector<Complex> complex_values, complex_right;
  std::vector<Real> share;  // by body: fraction of its inverse mass that drag leaves
  Real h = 0;
  bool stiff = false, braked = false;  // slopes of forces count; slopes of drag count
};

/// The equations of motion at one state, and their solution.
struct EquationScratch {
  bool ready = false;
  KktPattern pattern;
  std::vector<Real> values, scales;  // of the factor
  std::vector<BodyState> body_states;
  std::vector<Mat3> inverse_inertia;  // world inverse inertia
  std::vector<Vec3> jacobian, jacobian_before;
  std::vector<Real> c, gamma;
  std::vector<Vec3> force;     // and torque, two a body
  std::vector<Vec3> motion;    // accelerations, two a body, frames last
  std::vector<Vec3> solution;  // of the last solve: twists or corrections, two a body
  std::vector<Real> right, lambda, step_lambda;
  std::vector<Real> row_residual;  // right - J a, and the unknowns of hubs
};

/// States of a step, and external forces.
struct MotionScratch {
  // Current state; state at the start of a substep, of one integrator step, of an attempt.
  Motions state, start, from, begin;
  // Of the whole step: the state at its start, and where frames were then. Contacts need them.
  Motions entry;
  std::vector<FrameStart> frame_starts;
  bool stepped = false;       // both are set, and the bodies are at the end of the step
  std::vector<Vec3> applied;  // external forces and torques, two a body
  bool pushed = false;        // external or contact forces are not zero
};

/// Data that integrators keep within a step.
struct IntegratorScratch {
  // Integrators in momenta, two a body: momenta, and those before forces or impulses were added.
  std::vector<Vec3> momenta, momenta_before;
  // Implicit, two a body: unknown accelerations at the end of the step, residuals of the forces.
  std::vector<Vec3> end_accelerations, force_residuals;
  std::vector<Vec3> rates[7];  // Runge-Kutta: v and accelerations, three a body
  std::vector<Quat> quat_rates[7];
  std::vector<Real> sum_lambda, lambda_before, impulses, impulses_at_start,
      impulses_before;           // by row, of the step so far
  std::vector<Real> weights;     // implicit: compliances of spring rows
  std::vector<Real> dependence;  // RATTLE: of the rows at the start of the step
  bool shuns_singular = false;   // RATTLE: fail a step near a singular configuration
  bool beside_singular = false;  // such a step failed
  CollocationScratch collocation;
  BlowScratch blow;
};

/// Options for the evaluation of forces and projections.
struct ForceScratch {
  bool springs_active = false;
  Real forces_over = 0;      // s: spring pins, drives and soft stops act as at the end of a step of
                             // this length; 0: as at the current state
  Real time = 0;             // s, at which frames and drives are evaluated
  Real opened = 0;           // residual before the last projection
  Real projection_work = 0;  // J, of scratch.force along the last projection of poses
  // Projections are part of the motion, not error corrections: they rotate angular velocities, too.
  bool projection_moves = false;
  // Leaves out rows that constrain velocities only.
  bool poses_only = false;
  // A part of a step with contacts: by Euler's method, whose compliances of springs are kept.
  bool in_parts = false;
  // Then, by row: the force of a motor at its bound, or NaN; the forces of the parts before.
  std::vector<Real> held, forces_before;
  // Leaves out redundant gap rows of surfaces: off the joints, as in the stages of a step, they
  // contradict the rolling rows.
  bool leaves_gaps = false;
};

/// Scratch memory of a step, kept allocated between steps.
struct StepScratch : EquationScratch, MotionScratch, IntegratorScratch, ForceScratch {
  std::vector<SurfaceFound> touching;
  // The first surface contact that was lost since this was cleared, and why.
  std::uint32_t lost_touch = UINT32_MAX;
  nurbs::ContactStatus lost_how = nurbs::ContactStatus::found;
  Real part_h = 0;           // s: length of the current substep
  bool frames_rest = false;  // no frame moves in the current advance()
  // s: end of the first substep where a unilateral row is tensile, or friction exceeds mu N.
  Real pulled_at = 1e300;
  int turned_over = 0;  // in this step: how often a pair of curves was replaced by another
  int relooked = 0;     // in this step: searches of all pairs for a lost one
  Real worst_relative_residual = 0;  // of J a = gamma, relative to its terms
  std::uint32_t worst_relative_block = 0;
};

/// Surface joints of an island, by touch.
struct TouchStructure {
  std::vector<std::uint32_t> touch_sources;  // slots in World::surface_contacts
  std::vector<std::uint32_t> touch_blocks;   // blocks of their gaps
  std::vector<SurfaceWays> touch_ways;       // arc lengths of holonomic rolling
  std::uint32_t slips = 0;                   // joints that may slip: their touches come last
  bool rubs = false;                         // friction of surface joints, joints that may slip

  static void fields(auto& self, auto&& field) {
    field("touch_sources", derived(self.touch_sources));
    field("touch_blocks", derived(self.touch_blocks));
    field("touch_ways", derived(self.touch_ways));
    field("slips", derived(self.slips));
    field("rubs", derived(self.rubs));
  }
};

/// Structure of an island: constant within a step.
struct IslandStructure {
  SolverSettings settings;
  std::vector<Entity> bodies;        // its bodies
  std::vector<std::uint32_t> slots;  // in World::bodies
  std::vector<Real> mass, drag, gravity_scale;
  std::vector<Vec3> inertia;
  std::vector<Block> blocks;
  std::vector<BodyPairForce> joint_torques;  // of drives and soft stops, by link
  std::vector<BodyPairForce> elastic_cables, elastic_pins;
  std::vector<Block> elastic_paths;  // elastic cables over guides, as forces
  std::vector<std::uint8_t> places;  // of cables over guides: bodies of their blocks, a to b
  std::size_t rows = 0, vectors = 0;
  std::size_t joint_force_rows = 0;  // rows of joint forces
  Real size = 0;                     // m, scales tolerances
  Real reach = 0;                    // m, the longest arm of a joint
  bool loops = false;                // closed loops: rows may be dependent
  bool unilateral = false;           // limits, cables or surfaces that may lift off
  bool rolls = false;                // has rows that constrain velocities only
  bool damped = false;
  bool driven = false;  // has exact drives
  Entity unfit;         // a body that cannot be stepped, or none

  static void fields(auto& self, auto&& field) {
    field("settings", self.settings);
    field("bodies", derived(self.bodies));
    field("slots", derived(self.slots));
    field("mass", in_place(self.mass));
    field("drag", in_place(self.drag));
    field("gravity_scale", in_place(self.gravity_scale));
    field("inertia", in_place(self.inertia));
    field("blocks", in_place(self.blocks));
    field("joint_torques", derived(self.joint_torques));
    field("elastic_cables", derived(self.elastic_cables));
    field("elastic_pins", derived(self.elastic_pins));
    field("elastic_paths", derived(self.elastic_paths));
    field("places", derived(self.places));
    field("rows", derived(self.rows));
    field("vectors", derived(self.vectors));
    field("joint_force_rows", derived(self.joint_force_rows));
    field("size", derived(self.size));
    field("reach", derived(self.reach));
    field("loops", self.loops);
    field("unilateral", derived(self.unilateral));
    field("rolls", derived(self.rolls));
    field("damped", derived(self.damped));
    field("driven", derived(self.driven));
    field("unfit", derived(self.unfit));
  }
};

/// State of an island: together with its bodies it determines the next step.
struct IslandMemory {
  std::vector<BlockMemory> memory;
  std::vector<Real> mean_lambda;  // by row: N or N m, mean over the last integrator step
  std::vector<Frame> frames;      // numbered after the bodies
  std::vector<JointForce> joint_forces;
  std::vector<SurfaceMemory> touches;
  std::vector<Vec3> accelerations, lagged;  // implicit: two a body
  std::vector<Vec3> known_forces;           // likewise: of the last step, see implicit.cpp
  // Radau: of the stages of the last step, two a body each, and its length, s.
  std::vector<Vec3> stage_accelerations;
  Real stage_step = 0;
  bool fresh = true;
  Real try_step = 0;  // s, adaptive
  int rescues = 0;    // consecutive steps that fell back to Euler

  static void fields(auto& self, auto&& field) {
    field("memory", in_place(self.memory));
    field("mean_lambda", in_place(self.mean_lambda));
    field("frames", in_place(self.frames));
    field("joint_forces", in_place(self.joint_forces));
    field("touches", in_place(self.touches));
    field("accelerations", in_place(self.accelerations));
    field("lagged", in_place(self.lagged));
    field("known_forces", in_place(self.known_forces));
    field("stage_accelerations", in_place(self.stage_accelerations));
    field("stage_step", self.stage_step);
    field("fresh", self.fresh);
    field("try_step", self.try_step);
    field("rescues", self.rescues);
  }
};

/// Results of the step, for the report.
struct StepResult {
  std::vector<Real> forces;  // by row: mean over the last step
  std::vector<Fault> faults;
  std::size_t rank = 0;
  Entity lost;
  Real residual = 0;  // largest constraint residual after the step
  int solves = 0, substeps = 0, iterations = 0, events = 0;
  Entity lost_contact;  // surface joint that ended the step, and why
  nurbs::ContactStatus lost_how = nurbs::ContactStatus::found;
  int released = 0;           // surface joints that were released
  bool cannot_close = false;  // the joints of the initial pose cannot be closed
};

struct Island : IslandStructure, TouchStructure, IslandMemory, StepResult {
  Scratch<StepScratch> scratch;
  Scratch<IslandMemory> entry_memory;  // at the start of a step with drives that may yield

  std::size_t count() const { return bodies.size(); }
  /// Rows of constraints.
  std::size_t equations() const { return rows - joint_force_rows; }

  // The result belongs to one step.
  static void fields(auto& self, auto&& field) {
    IslandStructure::fields(self, field);
    TouchStructure::fields(self, field);
    IslandMemory::fields(self, field);
    field("scratch", derived(self.scratch));
    field("entry_memory", derived(self.entry_memory));
  }
};

/// All islands of the Lagrangian solver.
struct Islands : IslandList<Island> {
  static constexpr std::string_view name = "lagrangian";  // in saved Worlds
  Scratch<ContactScratch> contacts;

  static void fields(auto& self, auto&& field) {
    IslandList::fields(self, field);
    field("contacts", derived(self.contacts));
  }
};

/// The compiled islands of a World.
inline std::vector<Island>& islands_of(World& world) { return world.memory.of<Islands>().list; }
inline const std::vector<Island>& islands_of(const World& world) {
  return world.memory.of<Islands>().list;
}

/// The block of a fault. Numbers beyond the blocks count on in Island::elastic_paths.
inline const Block& block_of(const Island& m, const Fault& fault) {
  const std::size_t count = m.blocks.size();
  return fault.block < count ? m.blocks[fault.block] : m.elastic_paths[fault.block - count];
}

/// The link, pin, cable, gear or surface joint of a block.
Entity joint_of(const World& world, const Block& block);

/// Packs all islands of this solver. State is carried over by body and joint.
void compile(World& world, std::span<const IslandPlan> plans);

}  // namespace pantin::detail::lagrangian

// Copying, hashing and saving them is compiled once, in row.cpp.
namespace pantin::detail {
extern template lagrangian::Islands& Memories::create();
extern template const lagrangian::Islands& Memories::none();
}  // namespace pantin::detail
