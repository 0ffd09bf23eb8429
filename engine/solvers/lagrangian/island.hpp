#pragma once
/// An island of the Lagrangian solver: bodies whose joints it keeps, packed for it.
///
/// Compiled from the components when the structure changes, then kept from step to step.
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/contact/memory.hpp"
#include "engine/joints/rows.hpp"
#include "engine/world/body.hpp"
#include "engine/world/entity.hpp"
#include "engine/world/settings.hpp"

namespace pantin {
struct World;
}

namespace pantin::lagrangian {

/// Where a block of rows comes from.
enum class BlockKind : std::uint8_t {
  joint,   // a link
  pin,     // a pin: the rows of a ball joint
  ratio,   // a ratio
  limit,   // one side of a coordinate of a link; bears only while it is active
  cable,   // a cable: likewise
  interface, // what an island of another solver is tied to: see contact::Interface
  spring   // a freedom of a link whose effort is met at the end of the step (Euler, implicit)
};

/// Rows that are eliminated together: 1 to 6, on up to 4 bodies.
struct Block {
  BlockKind kind = BlockKind::joint;
  Coordinate coordinate = Coordinate::turn;  // limit, spring; ratio: of the first link
  Coordinate second = Coordinate::turn;      // ratio: of the second link
  bool upper = false;                        // limit: the upper bound
  bool lock = false;                         // limit: both bounds are one
  bool point = false;                        // rows 0 to 2 hold a point, the others turn
  std::uint8_t rows = 0, count = 0;          // of rows, of bodies
  std::uint32_t source = 0;                  // slot in the store of its kind; limit, spring: links
  std::uint32_t body[4] = {};                // in the mechanism
  std::uint8_t ends[4] = {};                 // ratio: of a, b of the first link and of the second
  std::uint32_t first_row = 0;
  std::uint32_t first_vector = 0;  // in the Jacobian: see solvers/lagrangian/jacobian.hpp
  Real bound = 0;                  // limit: value; ratio: offset

  static void fields(auto& self, auto&& field) {
    field("kind", derived(self.kind));
    field("coordinate", derived(self.coordinate));
    field("second", derived(self.second));
    field("upper", derived(self.upper));
    field("lock", derived(self.lock));
    field("point", derived(self.point));
    field("rows", derived(self.rows));
    field("count", derived(self.count));
    field("source", derived(self.source));
    field("body", derived(self.body));
    field("ends", derived(self.ends));
    field("first_row", derived(self.first_row));
    field("first_vector", derived(self.first_vector));
    field("bound", self.bound);
  }
};

/// What a block remembers.
struct BlockMemory {
  Real before[2] = {0, 0};  // coordinates at the last step, whole turns counted
  bool active = false;      // limit, string: it bears

  static void fields(auto& self, auto&& field) {
    field("before", self.before);
    field("active", self.active);
  }
};

/// A freedom of a link along which something acts.
struct Effort {
  std::uint32_t link = 0, body[2] = {};
  Coordinate coordinate = Coordinate::turn;
  Real before = 0;    // the coordinate at the last step

  static void fields(auto& self, auto&& field) {
    field("link", derived(self.link));
    field("body", derived(self.body));
    field("coordinate", derived(self.coordinate));
    field("before", self.before);
  }
};

/// Something that pulls between two bodies, by its slot in its store.
struct Pulling {
  std::uint32_t source = 0, body[2] = {};
};

/// A body that the mechanism does not move: the world, a fixed or driven body, a pin's place.
struct Frame {
  std::uint32_t slot = UINT32_MAX;  // in World::bodies; none: see pin
  std::uint32_t pin = UINT32_MAX;   // in World::pins; none: the world
  Pose before;                      // at the end of the last step
  bool known = false;

  static void fields(auto& self, auto&& field) {
    field("slot", derived(self.slot));
    field("pin", derived(self.pin));
    field("before", self.before);
    field("known", self.known);
  }
};

/// What is wrong with a mechanism as it stands.
struct Fault {
  enum Kind : std::uint8_t { redundant, inconsistent, wrong_branch } kind = redundant;
  std::uint32_t block = 0;  // see joint_of
  int rows = 0;             // redundant: how many of its rows follow from others
  Real residual = 0;        // inconsistent: m or rad that the joint lacks, or m/s^2 of it
};

/// One elimination order of rows and hubs, and where its numbers go.
///
/// Bodies on few blocks are eliminated first: J M^-1 J^T of the blocks that meet there. Hubs, bodies
/// on many, stay as six unknowns each. Nodes are the blocks, then the hubs.
struct KktPattern {
  std::vector<std::uint32_t> order, place;  // node at each place; place of each node
  std::vector<std::uint8_t> size;           // unknowns, by place
  std::vector<std::uint32_t> unknown;       // first of them, by place: rows, then hubs
  std::vector<std::uint32_t> diagonal;      // in `values`, by place
  std::vector<std::uint32_t> first;         // by place: into later and offset
  std::vector<std::uint32_t> later, offset; // places that a place still meets; their numbers
  std::vector<std::uint32_t> first_target, targets;  // of the products of pairs of those
  struct Meeting {  // of two blocks at a body
    std::uint32_t p = 0, q = 0, target = 0;
    std::uint8_t at_p = 0, at_q = 0;
    bool flipped = false;  // the numbers at `target` have q's rows first
    bool plain = false;    // all that p meets there holds a point, as p does
    bool opens = false;    // the first to write at `target`
  };
  std::vector<std::uint32_t> first_meeting;  // by body
  std::vector<Meeting> meetings;
  struct HubMeeting {
    std::uint32_t block = 0, target = 0;
    std::uint8_t at = 0;
    bool flipped = false;
  };
  std::vector<HubMeeting> hub_meetings;
  struct Range {
    std::uint32_t from = 0, count = 0;
  };
  std::vector<Range> untouched;  // numbers that no meeting writes: fill, hubs
  struct Incident {
    std::uint32_t block = 0;
    std::uint8_t at = 0;
  };
  std::vector<std::uint32_t> first_incident;  // by body
  std::vector<Incident> incidents;
  std::vector<std::uint32_t> framed;  // blocks that have a frame among their bodies
  std::vector<std::uint32_t> hubs;    // bodies
  std::vector<std::uint32_t> hub_of;  // by body, or UINT32_MAX
  std::size_t numbers = 0, unknowns = 0;
};

/// The motion of all bodies of a mechanism at one time, frames last.
struct Motions {
  std::vector<Vec3> x;
  std::vector<Quat> q;
  std::vector<Vec3> v, w;
};

/// Room for a step, kept between steps.
struct StepScratch {
  bool ready = false;
  bool in_step = false;  // the step that runs has begun with it
  KktPattern pattern;
  std::vector<Real> values, scales;            // of the factor
  std::vector<Placed> placed;
  std::vector<Mat3> give;                      // world inverse inertia
  std::vector<Vec3> jacobian, jacobian_before;
  std::vector<Real> c, gamma;
  std::vector<Vec3> force;                     // and torque, two a body
  std::vector<Vec3> motion, correction;        // accelerations or twists, two a body
  std::vector<Real> right, lambda, step_lambda;
  std::vector<Real> lack;                      // and the unknowns of hubs
  // Now; at the start of a part of the step, of one step of the integrator, of an attempt.
  Motions state, start, from, begin;
  std::vector<Vec3> applied;                   // forces and torques from outside, two a body
  bool pushed = false;                         // any of those, or owed, is not zero
  std::vector<Vec3> momenta, residuals;        // two a body
  std::vector<Vec3> rates[7];                  // Runge-Kutta: v and accelerations, three a body
  std::vector<Quat> quat_rates[7];
  std::vector<Real> sum_lambda;
  std::vector<Real> impulses, impulses_at_start, impulses_before;  // by row, of the step so far
  std::vector<Real> weights;                   // implicit: compliances of spring rows
  bool springs_bear = false;
  Real time = 0;                               // s, that frames and drives are placed at
  Real opened = 0;                             // residual before the last projection
  Real worst_lack = 0;                         // of J a = gamma, part of what was asked
  std::uint32_t worst_lack_block = 0;
};

/// What an island is made of: const within a step.
struct IslandStructure {
  SolverSettings settings;
  std::vector<Entity> bodies;        // the ones it moves; last, the point masses of interfaces
  std::vector<std::uint32_t> slots;  // in World::bodies
  std::vector<Real> mass, drag, gravity_scale;
  std::vector<Vec3> inertia;
  std::vector<Block> blocks;
  std::vector<Pulling> pose_drives;      // by link
  std::vector<Pulling> elastic_strings, elastic_pins;
  std::size_t rows = 0, vectors = 0;
  std::size_t effort_rows = 0;  // of the rows, those of efforts
  Real size = 0;                // m, scales tolerances
  Real reach = 0;               // m, the longest arm of a joint
  bool loops = false;           // rows may depend on one another
  bool unilateral = false;      // limits or cables
  bool damped = false;
  Entity unfit;  // a body that no step can be computed with, or none

  static void fields(auto& self, auto&& field) {
    field("settings", self.settings);
    field("bodies", derived(self.bodies));
    field("slots", derived(self.slots));
    field("mass", in_place(self.mass));
    field("drag", in_place(self.drag));
    field("gravity_scale", in_place(self.gravity_scale));
    field("inertia", in_place(self.inertia));
    field("blocks", in_place(self.blocks));
    field("pose_drives", derived(self.pose_drives));
    field("elastic_strings", derived(self.elastic_strings));
    field("elastic_pins", derived(self.elastic_pins));
    field("rows", derived(self.rows));
    field("vectors", derived(self.vectors));
    field("effort_rows", derived(self.effort_rows));
    field("size", derived(self.size));
    field("reach", derived(self.reach));
    field("loops", derived(self.loops));
    field("unilateral", derived(self.unilateral));
    field("damped", derived(self.damped));
    field("unfit", derived(self.unfit));
  }
};

/// What an island keeps from step to step: this and its bodies decide the next step.
struct IslandMemory {
  std::vector<BlockMemory> memory;
  std::vector<Real> loads;                  // by row: N or N m over the integrator's last step
  std::vector<Frame> frames;                // numbered after the bodies
  std::vector<Effort> efforts;
  std::vector<Vec3> accelerations, lagged;  // implicit: two a body
  bool fresh = true;
  bool counted = false;  // whole turns have been counted from the start
  Real try_step = 0;     // s, adaptive
  int rescues = 0;       // steps in a row that Euler took, since the integrator could not

  static void fields(auto& self, auto&& field) {
    field("memory", in_place(self.memory));
    field("loads", in_place(self.loads));
    field("frames", in_place(self.frames));
    field("efforts", in_place(self.efforts));
    field("accelerations", in_place(self.accelerations));
    field("lagged", in_place(self.lagged));
    field("fresh", self.fresh);
    field("counted", self.counted);
    field("try_step", self.try_step);
    field("rescues", self.rescues);
  }
};

/// What the step left, for the report.
struct StepResult {
  std::vector<Real> forces;  // by row: mean over the whole of the last step
  std::vector<Fault> faults;
  std::size_t rank = 0;
  Entity lost;
  Real residual = 0;          // worst of C after the step
  int solves = 0, parts = 0, iterations = 0, events = 0;
  bool cannot_close = false;  // its joints, as they were given
  bool sits_out = false;      // compiled within a step, which it does not take part in any more
};

struct Island : IslandStructure, IslandMemory, StepResult {
  std::vector<contact::Interface> interfaces;
  std::vector<Vec3> owed;  // forces and torques of what presses on it in this step, two a body
  Scratch<StepScratch> room;

  std::size_t count() const { return bodies.size(); }
  /// Bodies of the World, without the point masses of interfaces.
  std::size_t own() const { return bodies.size() - interfaces.size(); }
  /// Of the joints.
  std::size_t equations() const { return rows - effort_rows; }

  // The result belongs to one step, and `owed` is gathered in each.
  static void fields(auto& self, auto&& field) {
    IslandStructure::fields(self, field);
    IslandMemory::fields(self, field);
    field("interfaces", in_place(self.interfaces));
    field("owed", derived(self.owed));
    field("room", derived(self.room));
  }
};

/// All islands of the Lagrangian solver, and what a repeated step starts from.
struct Islands {
  std::vector<Island> list;
  struct Saved {
    IslandMemory memory;
    std::vector<Body> bodies;
  };
  struct TogetherScratch {
    std::vector<Saved> saved;  // by island
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

/// The link, pin, cable or gear that a block comes from.
Entity joint_of(const World& world, const Block& block);

/// Packs all islands that this solver moves, carrying memory over by body and joint.
void compile(World& world, std::span<const IslandPlan> plans);

}  // namespace pantin::lagrangian
