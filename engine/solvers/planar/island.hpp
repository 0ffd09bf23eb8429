#pragma once
/// State of the planar solver in a World.
#include <limits>
#include <string_view>
#include <vector>

#include "engine/base/check.hpp"
#include "engine/joints/rows.hpp"
#include "engine/solvers/drive_lag.hpp"
#include "engine/solvers/planar/curves.hpp"
#include "engine/solvers/planar/factor.hpp"
#include "engine/solvers/planar/plane.hpp"
#include "engine/world/memory.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::planar {

inline constexpr std::uint32_t kNobody = UINT32_MAX;

/// A body of the plane: one that the solver moves, that may collide with those, or that joints
/// attach them to. Its rotation is `turned` about z after `tilt`.
struct FlatBody {
  Entity body;
  std::uint32_t slot = 0;
  std::uint32_t island = kNobody;  // none: it is fixed, or moved by others
  bool solid = false;
  Real turned = 0;  // rad, whole turns counted
  Quat tilt{1, 0, 0, 0};
  Real height = 0;  // m, z of its centre, for which its sections were cut

  static void fields(auto& self, auto&& field) {
    field("body", derived(self.body));
    field("slot", derived(self.slot));
    field("island", derived(self.island));
    field("solid", derived(self.solid));
    field("turned", self.turned);
    field("tilt", self.tilt);
    field("height", derived(self.height));
  }
};

/// A link between two bodies of the plane.
struct FlatLink {
  Entity owner;
  std::uint32_t link = 0;  // slot
  std::uint32_t a = 0, b = 0;
  Real angle = 0;  // rad, of a hinge at the start of the step, whole turns counted

  static void fields(auto& self, auto&& field) {
    field("owner", derived(self.owner));
    field("link", derived(self.link));
    field("a", derived(self.a));
    field("b", derived(self.b));
    field("angle", self.angle);
  }
};

/// Whether the angle of a joint stops at its limits.
inline bool has_stops(const Joint& joint) {
  const AngleLimit& range = joint.limits->angle;
  return range.on && range.high - range.low < 2 * kPi;
}
/// Angles are counted from half a turn below this one to half a turn above it, rad.
inline Real middle_of_angles(const Joint& joint) {
  const AngleLimit& range = joint.limits->angle;
  return has_stops(joint) ? 0.5 * (range.low + range.high) : 0;
}

/// The angle that those of a joint are counted from: it is within half a turn of it, rad.
inline Real angle_near(const Joint& joint, const FlatLink& l) {
  return has_stops(joint) ? middle_of_angles(joint) : l.angle;
}

struct FlatPin {
  Entity owner;
  std::uint32_t pin = 0;  // slot
  std::uint32_t body = 0, to = kNobody;
};

/// A gear between two of the links. The coordinate of a joint is the rotation of its bodies, or the
/// travel, plus `first` or `second`.
struct FlatGear {
  Entity gear;
  std::uint32_t slot = 0;
  std::uint32_t links[2] = {0, 0};  // in Planar::links
  bool counted = false;             // the three below are known
  Real first = 0, second = 0, offset = 0;

  static void fields(auto& self, auto&& field) {
    field("gear", derived(self.gear));
    field("slot", derived(self.slot));
    field("links", derived(self.links));
    field("counted", self.counted);
    field("first", self.first);
    field("second", self.second);
    field("offset", self.offset);
  }
};

/// An exact drive of one of the links. Its coordinate is that of counted_row(), plus `first`.
struct FlatDrive {
  Entity owner;
  std::uint32_t drive = 0, link = 0;  // slot; in Planar::links
  bool travels = false;
  bool counted = false;                                 // `first` is known
  Real first = 0;                                       // rad or m
  Real value = std::numeric_limits<Real>::quiet_NaN();  // likewise: after the last step
  // Of the step:
  DriveLag lag;
  Real impulse = 0;  // N m s or N s, along the coordinate
  Real sign = 1;     // of the coordinate in the plane's joint
  Real beyond = 0;   // rad or m: how far its motion is beyond a limit of the joint

  static void fields(auto& self, auto&& field) {
    field("owner", derived(self.owner));
    field("drive", derived(self.drive));
    field("link", derived(self.link));
    field("travels", derived(self.travels));
    field("counted", self.counted);
    field("first", self.first);
    field("value", self.value);
    field("lag", derived(self.lag));
    field("impulse", derived(self.impulse));
    field("sign", derived(self.sign));
    field("beyond", derived(self.beyond));
  }
};

/// A span of a belt that is a row; the spans of a belt are consecutive.
struct FlatSpan {
  std::uint32_t belt = 0;      // slot
  std::uint32_t index = 0;     // of the pulley that it leaves
  std::uint32_t held = 0;      // number of the belt's spans that are rows
  std::uint32_t a = 0, b = 0;  // bodies
  int slips = 0;               // in this step: the sign of its friction force
  Real impulse = 0;            // N s, in this step; above 0 it pushes
};

/// Scratch of a mechanism's step: see rattle.cpp.
struct RattleRows {
  std::vector<Row> rows;
  std::vector<PlaceNow> nows;  // by curve and slot
  std::size_t first_drive = 0, first_span = 0, first_limit = 0, first_curve = 0;
};
struct RattleSpring {
  const PlaneJoint* joint = nullptr;
  bool is_soft = false;
  Real damping = 0, load = 0;
  Row row = {};
};
struct RattleLimit {
  const PlaneJoint* joint = nullptr;
  int side = 0;  // below 0: its low end is active
};
/// The last rows are of springs, which vary from step to step.
struct DampedFactor : Factor {
  std::vector<std::uint32_t> damped;  // joints
};
struct SpanLoad {
  Real impulse = 0;
  int slips = 0;
};
struct RattleWork {
  RattleRows start, now;
  std::vector<RattleSpring> springs;
  std::vector<RattleLimit> limits;
  std::vector<std::uint32_t> damped;  // joints whose springs are rows
  std::vector<Real> lambda, step, first, impulse, wanted, stage, answer;
  std::vector<Row> damped_rows;
  std::vector<Vec3> from, free, closed, from_velocity, free_velocity;  // of its bodies
  std::vector<Pose> searched;                        // by curve, like the next ones
  std::vector<std::array<Vec3, kMostPlaces>> means;  // N s: along the normal, and across
  std::vector<std::array<CurvePlace, kMostPlaces>> places, kept;
};

/// Bodies of one island connected by joints, gears, belts and curves. They move by RATTLE in double
/// precision while they have no other contacts.
struct Mechanism {
  std::vector<std::uint32_t> bodies;  // that it moves
  std::vector<std::uint32_t> driven;  // kinematic, moved by others
  std::vector<std::uint32_t> links, pins, gears, drives, spans, curves;
  // Of the step:
  bool moved = false;    // the results below are those of the step
  bool touched = false;  // bodies were in contact with it in the last step
  std::vector<Vec3> position, velocity;
  std::vector<std::array<CurvePlace, kMostPlaces>> places;  // of its curves
  std::vector<Pose> searched;                               // likewise
  std::vector<PlaceNow> starts, ends;                       // likewise, kMostPlaces each
  Real residual = 0;                                        // m, rad: of its rows
  std::vector<JointLoad> borne;  // mean loads of its links that are joints, and of its pins
  std::vector<SpanLoad> span_loads;
  std::vector<Real> row_impulses;  // N s, by row, of motors and closing, besides Box2D
  Factor positions, closing;
  DampedFactor velocities, damping;
  Scratch<RattleWork> work;
};

/// Bodies at the end of a step, by number; the last one holds the targets of pins.
struct Motions {
  std::vector<Vec3> position, velocity;  // x and y, with the angle or its rate as z
  std::vector<Vec3> inverse_mass;        // likewise
  std::vector<Real> gained;              // rad: the angle since the start of the step
  std::vector<Vec3> before, answer;      // scratch of an iteration
  Real time = 0;                         // s, since the start of the step: of what drives demand
};
/// Scratch of a step.
struct StepScratch {
  Plane plane;
  bool has_sections = false;            // outlines and corners of the plane are up to date
  std::vector<std::uint32_t> joint_of;  // by link, in the plane's joints; kNobody: none
  Motions motions;
  std::vector<Row> rows;        // of the mechanism that is closed
  std::vector<Row> start_rows;  // of spans, at the start of the step
  std::vector<Real> lambda;
  std::vector<PlaceNow> nows;       // of curves: kMostPlaces each
  std::size_t first_curve_row = 0;  // of `rows`
  std::vector<Pose> starts;         // of the bodies, before the step
  std::vector<PlaneContact> touches_before;
  std::vector<FlatCurve> curves_before;
  bool stepped = false;
  Real h = 0;  // s, of the last step
};

struct Planar {
  static constexpr std::string_view name = "planar";  // in saved Worlds
  std::vector<FlatBody> bodies;                       // in the order of their slots
  std::vector<FlatGear> gears;
  std::vector<FlatDrive> drives;
  std::vector<PlaneContact> touches;  // of the last step
  contact::NearPairs near;            // likewise
  std::vector<JointLoad> loads;       // likewise, of the links and then of the pins
  std::vector<JointLoad> reactions;   // of links in the last step, closing included
  std::vector<FlatLink> links;
  std::vector<FlatPin> pins;
  std::vector<FlatSpan> spans;
  std::vector<FlatCurve> curves;
  std::vector<Mechanism> mechanisms;
  std::vector<std::uint32_t> mechanism_of;  // by body; kNobody: none
  std::uint32_t islands = 0;
  Entity lost;          // a body of the last step with numbers that are not finite
  Entity lost_contact;  // of curves, that ended the last step, and why
  nurbs::ContactStatus lost_how = nurbs::ContactStatus::found;
  Real residual = 0;  // m, rad, m/s: of the joints, after the last step
  int still = 0;      // steps since any body was faster than the settings' sleep speed
  Real sleep_speed = 0;
  Vec3 gravity{0};  // in the last step
  Scratch<StepScratch> scratch;

  static void fields(auto& self, auto&& field) {
    field("bodies", in_place(self.bodies));
    field("gears", in_place(self.gears));
    field("drives", in_place(self.drives));
    field("touches", self.touches);
    field("near", self.near);
    field("loads", in_place(self.loads));
    field("reactions", derived(self.reactions));
    field("links", in_place(self.links));
    field("pins", derived(self.pins));
    field("spans", derived(self.spans));
    field("curves", in_place(self.curves));
    field("mechanisms", derived(self.mechanisms));
    field("mechanism_of", derived(self.mechanism_of));
    field("lost_contact", derived(self.lost_contact));
    field("lost_how", derived(self.lost_how));
    field("islands", derived(self.islands));
    field("lost", derived(self.lost));
    field("residual", passive(self.residual));
    field("still", self.still);
    field("gravity", self.gravity);
    field("sleep_speed", derived(self.sleep_speed));
    field("scratch", derived(self.scratch));
  }
};

inline Planar& plane_of(World& world) { return world.memory.of<Planar>(); }
inline const Planar& plane_of(const World& world) { return world.memory.of<Planar>(); }

void compile(World& world, std::span<const IslandPlan> plans);
/// Reads the bodies as the caller left them: their rotation about z, and their tilt.
void read_turns(const World& world, Planar& all);
/// Fills the plane of the step.
void gather(const World& world, Planar& all);

/// Counts the coordinates of new gears and drives from the poses before the step.
void count_coordinates(const World& world, Planar& all);
/// The coordinate of a link as the joint counts it, relative to a reference, as a row.
Row counted_row(const World& world, const Planar& all, std::uint32_t link, Coordinate which);
/// Closes joints and gears, positions and velocities, by mass-weighted least changes. Records the
/// remaining residual.
void close(const World& world, Planar& all, Real h);

/// Writes the rows of a mechanism at the current motions: of joints, gears, curves and belts.
void find_rows(const World& world, Planar& all, const Mechanism& of);
/// The angle of b about a, or the travel along the axis, of a hinge or slider, as a row.
Row coordinate_row(const PlaneJoint& joint, const Motions& m);
/// Applies springs and motors of belt and gear trains before Box2D's step (motors.cpp).
void drive_tied(const World& world, Planar& all, Real h);
/// How many rows a joint has.
int rows_of(const PlaneJoint& joint);
/// A vector after a turn by an angle, rad.
Vec3 turned(Vec3 v, Real angle);

/// A pulley of a belt, and the number of its body.
struct PulleyAt {
  const Belt& belt;
  std::size_t index;
  std::uint32_t body;
};
/// Reads the angles of pulleys before a step, and writes the rows of that time.
void begin_belts(World& world, Planar& all);
/// A span at the current motions; empty if it slips.
Row span_row(const World& world, const Planar& all, const FlatSpan& of);
/// The row of a span, whether it slips or not.
Row span_pull(const World& world, const Planar& all, const FlatSpan& of);
bool may_slip(const World& world, const Planar& all, const Mechanism& of);
/// Lets belts slip whose tension difference exceeds their friction; the spans are the last rows.
void let_slip(const World& world, Planar& all, const Mechanism& of, Real h);
/// After the bodies were written: stores positions and tensions of belts.
void end_belts(World& world, Planar& all, Real h);

/// The row of an exact drive at the current motions and their time; without a Jacobian where it
/// yields.
Row drive_row(const World& world, const Planar& all, const FlatDrive& of);
/// The row of its coordinate.
Row drive_pull(const World& world, const Planar& all, const FlatDrive& of);
/// Finds the lags of drives with a maximum, from the motions at the start of the step, and tells
/// Box2D's joints what they demand.
void begin_drives(const World& world, Planar& all, Real h);
/// After Box2D's step: takes over the forces of drives whose mechanisms it moved.
void take_drives(const World& world, Planar& all, Real h);
/// Stores the results of drives.
void write_drives(World& world, Planar& all, Real h);
/// The rate along a row by a unit impulse along it, with the closing factor of the mechanism, which
/// is up to date; where other rows stop it, that of its bodies alone.
Real mobility_of(StepScratch& s, const Mechanism& of, const Row& along);

/// The rows of a joint, and of a gear, at the current motions.
void append_joint_rows(const PlaneJoint& joint, const Motions& m, std::vector<Row>& rows);
Row gear_row(const World& world, const Planar& all, const FlatGear& gear);
/// The coordinate along which a joint's spring or motor acts: its row, with `c` as the coordinate
/// that PlaneSpring counts from.
Row sprung_row(const PlaneJoint& joint, const Motions& m);

/// Lists the mechanisms, once bodies and their connections are known.
void list_mechanisms(const World& world, Planar& all);
/// Sets a body's motion as it is at the start of a step.
void begin_motion(const PlaneBody& body, Real h, std::uint32_t number, Motions& m);
void begin_motions(Planar& all, Real h);
/// Steps one mechanism from its initial motions; false, without changes, on failure.
bool move_by_rattle(const World& world, Planar& all, Mechanism& of, Real h);
/// Steps the mechanisms, and passes the forces of their curves to the plane.
void move_mechanisms(const World& world, Planar& all, Real h);
/// After the plane's step: takes over the motions of mechanisms without other contacts.
void take_mechanisms(Planar& all);
/// Appends the rows of its curves.
void append_curve_rows(Planar& all, const Mechanism& of, std::vector<Row>& rows);
/// Applies the impulses that closed those rows to velocities too; unilateral ones never pull.
void take_curve_impulses(Planar& all, const Mechanism& of, Real h);
/// Calls `f` for the joints of the plane that its links and pins have; not all links have one.
template <class F>
void each_joint(Planar& all, const Mechanism& of, F&& f) {
  StepScratch& s = all.scratch;
  PANTIN_ASSERT(s.joint_of.size() == all.links.size() && s.plane.joints.size() >= all.pins.size());
  for (const std::uint32_t link : of.links)
    if (const std::uint32_t at = s.joint_of[link]; at != kNobody) f(s.plane.joints[at]);
  const std::size_t pins = s.plane.joints.size() - all.pins.size();
  for (const std::uint32_t pin : of.pins) f(s.plane.joints[pins + pin]);
}
/// Finds bilateral or active curves that lost their contact: releases them, or ends the step.
void find_lost_curves(const World& world, Planar& all);
/// After the bodies were written: stores contact points and forces of curves.
void write_curves(World& world, Planar& all);

}  // namespace pantin::detail::planar

// Copying, hashing and saving them is compiled once, in row.cpp.
namespace pantin::detail {
extern template planar::Planar& Memories::create();
extern template const planar::Planar& Memories::none();
}  // namespace pantin::detail
