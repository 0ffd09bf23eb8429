#pragma once
/// Joints described in world space: `world.add(HingeJoint{...})`.
///
/// Anchors and axes are points (m) and directions in world space at the present poses of the
/// bodies. The two sides of a joint therefore cannot contradict each other: every joint starts
/// closed, at angle and travel zero. Directions need not be of unit length. For bodies that are not
/// assembled yet, `frames` gives each side in its own body instead.
///
/// Adding checks everything and, on errors, changes nothing: the errors of the Result name the
/// joint, the member, what was found and what was expected. A feature that the solver of the bodies
/// does not support is an error too, so choose solvers (World::default_settings, World::settings)
/// before adding. If a later joint gives an island another solver, check(world) and
/// StepReport::faults report unsupported features. A joint is an entity; remove it with
/// World::destroy().
#include <memory>
#include <optional>
#include <pantin/world.hpp>
#include <string>
#include <vector>

namespace pantin {

/// A closed range: rad or m.
struct Interval {
  Real low = 0, high = 0;
};

/// The joint frame in each body, relative to the frame the body was placed by
/// (RigidBody::position). x is the axis of the joint; y and z depend on the kind.
struct LocalFrames {
  Pose in_a = {}, in_b = {};
};

/// Soft limit: within `zone` of the limit a spring acts, with torque up to stiffness * zone.
struct SoftStop {
  Real zone = 0;       // rad
  Real stiffness = 0;  // N m/rad
  Real damping = 0;    // N m s/rad, within the zone
};

/// Half angles of a cone of elliptic section, rad, from 0 to pi.
struct ConeLimit {
  Real y = 0, z = 0;  // of swings about the joint's y and z
};

/// A shared point; all rotations are free, within an optional cone and range of twist.
struct BallJoint {
  Entity a = {}, b = {};
  Vec3 anchor{0};
  Vec3 axis{1, 0, 0};                  // of the twist: along the bone of b
  Vec3 across{0};                      // y of the cone; zero: any
  std::optional<Vec3> cone_axis = {};  // middle of the cone, fixed in a; none: `axis`
  std::optional<ConeLimit> cone = {};  // how far `axis` may swing from the middle
  std::optional<Interval> twist = {};  // rad, about `axis`
  std::optional<SoftStop> soft_stop = {};
  std::optional<JointDrive> drive = {};    // a joint drive
  std::optional<LocalFrames> frames = {};  // instead of anchor and axes
  std::string name = {};
};

/// A shared point and a shared axis: a door hinge, a knee.
struct HingeJoint {
  Entity a = {}, b = {};
  Vec3 anchor{0};
  Vec3 axis{0};                         // b rotates anticlockwise about it
  std::optional<Interval> limits = {};  // rad
  std::optional<SoftStop> soft_stop = {};
  JointMotor motor = {};  // along the angle, as are the next two
  SpringDamper spring = {};
  JointFriction friction = {};
  Real restitution = 0;                  // of the stops, 0 to 1; Lagrangian solver
  std::optional<JointDrive> drive = {};  // a joint drive
  std::optional<LocalFrames> frames = {};
  std::string name = {};
};

/// No relative motion: two bodies act as one.
struct FixedJoint {
  Entity a = {}, b = {};
  Vec3 anchor{0};
  std::optional<LocalFrames> frames = {};
  std::string name = {};
};

/// A shared point and two perpendicular axes, one fixed in each body: a Cardan joint.
struct UniversalJoint {
  Entity a = {}, b = {};
  Vec3 anchor{0};
  Vec3 axis_a{0};                              // the first rotation, fixed in a
  Vec3 axis_b{0};                              // the second, fixed in b
  std::optional<Interval> limits = {};         // rad, about axis_a
  std::optional<Interval> second_limits = {};  // rad, about axis_b
  std::optional<SoftStop> soft_stop = {};
  std::optional<JointDrive> drive = {};    // a joint drive
  std::optional<LocalFrames> frames = {};  // y and z are the axes
  std::string name = {};
};

/// Translation along an axis without rotation. Lagrangian solver.
struct PrismaticJoint {
  Entity a = {}, b = {};
  Vec3 anchor{0};
  Vec3 axis{0};
  std::optional<Interval> travel = {};  // m
  JointMotor motor = {};
  SpringDamper spring = {};
  JointFriction friction = {};
  Real restitution = 0;
  std::optional<JointDrive> drive = {};  // an exact one
  std::optional<LocalFrames> frames = {};
  std::string name = {};
};

/// Translation along an axis and rotation about it. Lagrangian solver.
struct CylindricalJoint {
  Entity a = {}, b = {};
  Vec3 anchor{0};
  Vec3 axis{0};
  std::optional<Interval> limits = {};  // rad
  std::optional<Interval> travel = {};  // m
  JointMotor motor = {};                // of the rotation
  JointMotor travel_motor = {};
  SpringDamper spring = {}, travel_spring = {};
  JointFriction friction = {}, travel_friction = {};
  Real restitution = 0;
  std::optional<JointDrive> drive = {};  // an exact one
  std::optional<LocalFrames> frames = {};
  std::string name = {};
};

/// Translation along an axis by `pitch` per radian of rotation about it. Lagrangian solver.
struct ScrewJoint {
  Entity a = {}, b = {};
  Vec3 anchor{0};
  Vec3 axis{0};
  Real pitch = 0;                       // m/rad, not zero
  std::optional<Interval> limits = {};  // rad
  std::optional<Interval> travel = {};  // m
  JointMotor motor = {};                // of the rotation
  SpringDamper spring = {};
  JointFriction friction = {};
  Real restitution = 0;
  std::optional<JointDrive> drive = {};  // an exact one
  std::optional<LocalFrames> frames = {};
  std::string name = {};
};

/// Translation in a plane and rotation about its normal. Lagrangian solver.
struct PlanarJoint {
  Entity a = {}, b = {};
  Vec3 anchor{0};
  Vec3 normal{0};
  std::optional<LocalFrames> frames = {};  // x is the normal
  std::string name = {};
};

/// A blade of b that does not move sideways: the velocity of a point of b along `across`, relative
/// to a, is 0. A skate, the knife edge of a sleigh. It constrains velocities only. Its load is the
/// normal force of the one joint between a and b, or a and a body joined to b, shared equally by
/// those on it. Lagrangian solver.
struct SkateJoint {
  Entity a = {}, b = {};
  Vec3 anchor{0};                          // the point of b
  Vec3 across{0};                          // fixed in b, perpendicular to the blade
  Real grip = 0;                           // N; beyond it the blade slides sideways; 0: never
  Real friction = 0;                       // or a coefficient: it slides beyond friction * load
  std::optional<LocalFrames> frames = {};  // x of b is `across`
  std::string name = {};
};

/// A thin wheel b that rolls without slip on a plane of a. Nothing keeps it at its height, and it
/// need not touch the plane: other joints hold it. It constrains velocities only. Its load is that
/// of a SkateJoint. Lagrangian solver.
struct WheelJoint {
  Entity a = {}, b = {};
  Vec3 anchor{0};                          // the hub
  Vec3 axle{0};                            // fixed in b
  Vec3 normal{0, 1, 0};                    // of the plane, fixed in a
  Real radius = 0;                         // m
  Real grip = 0;                           // N; beyond it the wheel slips; 0: never
  Real friction = 0;                       // or a coefficient: it slips beyond friction * load
  std::optional<LocalFrames> frames = {};  // x of b is the axle, y of a the normal
  std::string name = {};
};

/// A massless rod: two points keep their distance. Lagrangian solver.
struct DistanceJoint {
  Entity a = {}, b = {};
  Vec3 anchor_a{0}, anchor_b{0};
  std::optional<Real> length = {};  // m; none: the initial distance
  std::string name = {};
};

/// A spring and damper between two points. Lagrangian solver.
struct SpringJoint {
  Entity a = {}, b = {};
  Vec3 anchor_a{0}, anchor_b{0};
  Real stiffness = 0;                    // N/m
  Real damping = 0;                      // N s/m
  std::optional<Real> rest_length = {};  // m; none: the initial distance
  std::string name = {};
};

/// A cable between two points: it transmits tension, never compression.
struct CableJoint {
  /// A frictionless ring that the cable passes through, or a pulley that it runs round.
  struct Guide {
    Entity body = {};  // the body it is fixed to
    Vec3 point{0};     // the ring, or the pulley's centre
    Vec3 axis{0};      // of a pulley: from a to b the cable runs round it anticlockwise
    Real radius = 0;   // m, of a pulley, to the middle of the cable; 0: a ring
    int turns = 0;     // whole turns round a pulley at the start, besides the visible wrap
  };
  Entity a = {}, b = {};
  Vec3 anchor_a{0}, anchor_b{0};
  std::optional<Real> length = {};  // m; none: the initial distance, over the guides
  Real compliance = 0;              // m/N; 0: inextensible
  std::vector<Guide> over = {};     // from a to b, 14 at most; Lagrangian solver
  std::string name = {};
};

/// A joint with one to six constraint equations of your own. Lagrangian solver.
struct CustomConstraint {
  Entity a = {}, b = {};
  std::shared_ptr<const CustomJoint> equations = {};
  std::string name = {};
};

/// Spring, friction and motor along a free coordinate of a joint.
struct JointAction {
  JointMotor motor = {};
  SpringDamper spring = {};
  JointFriction friction = {};
};

/// A parameter of a joint kind, by its key in scene files.
struct JointParameter {
  std::string key = {};
  Real value = 0;
};

/// A joint of any kind, by the kind's name. This includes kinds added to the engine as
/// CONTRIBUTING.md shows:
///
///   world.add(AnyJoint{.kind = "screw", .a = nut, .b = bolt, .axis = {0, 1, 0},
///                      .parameters = {{"pitch", 0.002}}});
///
/// A member that the kind does not have is an error, which lists the kinds that do.
struct AnyJoint {
  std::string kind = {};  // one of joint_kinds(), or an alias in scene files
  Entity a = {}, b = {};
  Vec3 anchor{0};
  std::optional<Vec3> anchor_b = {};            // in b, for kinds without a shared point; none:
                                                // `anchor`
  Vec3 axis{1, 0, 0};                           // x of the joint's axes
  Vec3 across{0};                               // y, as nearly as `axis` allows; zero: any
  std::optional<LocalFrames> frames = {};       // instead of anchors and axes
  std::vector<JointParameter> parameters = {};  // those of the kind: parameters_of_kind()
  std::optional<Interval> limits = {};          // rad, of the angle about x, of a twist
  std::optional<Interval> second_limits = {};   // rad, of a second angle
  std::optional<Interval> travel_limits = {};   // m, along x
  std::optional<ConeLimit> cone = {};           // of swings of x
  std::optional<SoftStop> soft_stop = {};
  Real restitution = 0;                 // of the stops, 0 to 1
  JointAction angle = {}, travel = {};  // along the angle, along the travel
  std::optional<JointDrive> drive = {};
  std::string name = {};
};
/// Names of the kinds that AnyJoint can make.
std::vector<std::string> joint_kinds();
/// Keys of the parameters of a kind; empty for an unknown kind.
std::vector<std::string> parameters_of_kind(const std::string& kind);

/// Holds a point of a body at a point of the world or of another body.
struct PinConstraint {
  Entity body = {};
  Vec3 point{0};                    // of the body
  std::optional<Vec3> target = {};  // none: the point's present position
  Entity to = {};                   // the body that the target is fixed in; none: the world
  Real stiffness = 0;               // N/m of a spring; 0: exact
  Real damping = 0;                 // N s/m, of that spring's damper
  int priority = 0;  // among exact pins that conflict, the highest priority is met exactly
  std::string name = {};
};

enum class JointCoordinate : std::uint8_t {
  angle,   // rad, about the axis
  travel,  // m, along the axis
};

/// Couples a coordinate of one joint to a coordinate of another, as gears, belts and racks do:
///
///   coordinate of second = ratio * coordinate of first + offset
///
/// Lagrangian solver.
struct GearJoint {
  Entity first = {}, second = {};  // joints
  JointCoordinate of_first = JointCoordinate::angle, of_second = JointCoordinate::angle;
  Real ratio = 1;
  std::optional<Real> offset = {};  // none: from the present coordinates
  std::string name = {};
};

/// A closed flat belt round pulleys that turn about z. It is massless and inextensible, and does
/// not slip unless it has a friction. If one body holds all axles and pulleys are not round, the
/// length of the span from the last pulley to the first is not enforced. Planar and Lagrangian
/// solver.
///
/// Errors: fewer than 2 pulleys or more than 16; two on one body, on a fixed one, or at different
/// z; pulleys that overlap; a belt that does not touch a pulley from its side, that crosses itself,
/// or runs through a pulley; friction with more than two pulleys.
struct BeltJoint {
  struct Pulley {
    Entity body = {};
    Vec3 point{0};    // its centre, world
    Real radius = 0;  // m, to the middle of the belt
    std::vector<Vec3> outline =
        {};                   // about the centre, world axes, m: the belt runs round its hull
    bool is_outside = false;  // it touches the belt from outside the loop
  };
  std::vector<Pulley> pulleys = {};  // in the order in which the belt meets them
  bool crossed = false;              // with two pulleys: the second turns the other way
  Real pretension = 0;               // N
  Real friction = 0;                 // coefficient, two pulleys only; 0: it never slips
  std::string name = {};
};

/// The state of a belt after a step.
struct BeltState {
  Real length = 0;                  // m, of its route
  Real defect = 0;                  // m, by which the route is longer than the belt
  Real travel = 0;                  // m, by which it has run past the first pulley
  bool slips = false;               // in the last step
  std::vector<Real> tensions = {};  // N, of the span that leaves each pulley, mean over the step
};
/// The state of a BeltJoint; none for any other entity.
std::optional<BeltState> belt_state(const World& world, Entity belt);

/// A smooth rational curve. Its outside is the outside of a closed planar curve, and the right side
/// of an open one in its direction.
struct NurbsCurve {
  int degree = 3;                  // 1 to 25
  std::vector<Real> knots = {};    // not decreasing; points + degree + 1 of them
  std::vector<Vec3> points = {};   // m; those of a planar curve have z = 0
  std::vector<Real> weights = {};  // above 0, one for each point; empty: all 1
  bool periodic = false;           // both ends coincide
  Pose at = {};                    // of its frame, in the frame by which the body is placed
  bool inside_out = false;         // exchanges outside and inside, as for a slot

  static NurbsCurve line(Vec3 from, Vec3 to);
  static NurbsCurve circle(Real radius);      // m, about the origin
  static NurbsCurve ellipse(Real a, Real b);  // m, half axes along x and y
  /// The cubic through points: open, or closed (`around`). An error names the point.
  static Result<NurbsCurve> through(const std::vector<Vec3>& points);
  static Result<NurbsCurve> around(const std::vector<Vec3>& points);
  /// The closed polygon with corners rounded by arcs of this radius, m. An error names the corner.
  static Result<NurbsCurve> outline(const std::vector<Vec3>& corners, Real rounding);
};

/// Two bodies with smooth surfaces in contact, which slide or roll on one another. They start where
/// the gap is smallest at present; the solver closes it. Lagrangian solver; for two curves in the
/// xy plane Solver::planar, too.
///
/// Errors: bodies without a smooth shape; surfaces that do not face one another within the size of
/// the smaller one, are conforming, or have a crease; curves that cross themselves, or are not in
/// one plane; friction below 0, or with rolling without spin; several contacts of a bilateral
/// joint.
struct SurfaceJoint {
  Entity a = {}, b = {};
  // In the frame by which the body is placed. None: the first smooth one of the body's own shapes:
  // a sphere, an ellipsoid, the side of a cylinder, a plane, a NURBS shape.
  std::optional<Shape> surface_a = {}, surface_b = {};
  // Instead of a surface: a curve of a on b's surface or curve, or of both.
  std::optional<NurbsCurve> curve_a = {}, curve_b = {};
  SurfaceMotion motion = SurfaceMotion::rolling;
  bool may_lift = false;  // unilateral: separates and touches again, without bouncing; else
                          // bilateral
  OnRim on_rim = OnRim::stop;
  // Coulomb's coefficient of sliding or rolling, >= 0. None: sliding is frictionless, rolling never
  // slips.
  std::optional<Real> friction = {};
  // Unilateral joints: most simultaneous contact points, from 1 to 8. None: 1 for an ellipsoid on
  // another or on a plane, else 4.
  std::optional<int> contacts = {};
  std::string name = {};
};

/// A contact point of two surfaces.
struct SurfaceTouch {
  bool touches = false;  // false: they are apart, or the joint has released
  bool slips = false;    // the contact slips
  Vec3 point{0};         // world, m
  Vec3 normal{0};        // world, out of b, unit
  Vec3 force{0};         // N, on b, world axes, mean over the last step
  Real gap = 0;          // m
};
/// The contact of a SurfaceJoint after a step; none for any other entity.
std::optional<SurfaceTouch> surface_touch(const World& world, Entity joint);
/// All contact points that it tracks, active or near, starting with the one above.
std::vector<SurfaceTouch> surface_touches(const World& world, Entity joint);

Result<Entity> add_to(World& world, const BallJoint& joint);
Result<Entity> add_to(World& world, const HingeJoint& joint);
Result<Entity> add_to(World& world, const FixedJoint& joint);
Result<Entity> add_to(World& world, const UniversalJoint& joint);
Result<Entity> add_to(World& world, const PrismaticJoint& joint);
Result<Entity> add_to(World& world, const CylindricalJoint& joint);
Result<Entity> add_to(World& world, const ScrewJoint& joint);
Result<Entity> add_to(World& world, const PlanarJoint& joint);
Result<Entity> add_to(World& world, const SkateJoint& joint);
Result<Entity> add_to(World& world, const WheelJoint& joint);
Result<Entity> add_to(World& world, const DistanceJoint& joint);
Result<Entity> add_to(World& world, const SpringJoint& joint);
Result<Entity> add_to(World& world, const CableJoint& joint);
Result<Entity> add_to(World& world, const AnyJoint& joint);
Result<Entity> add_to(World& world, const CustomConstraint& joint);
Result<Entity> add_to(World& world, const PinConstraint& pin);
Result<Entity> add_to(World& world, const GearJoint& gear);
Result<Entity> add_to(World& world, const SurfaceJoint& joint);
Result<Entity> add_to(World& world, const BeltJoint& belt);

}  // namespace pantin
