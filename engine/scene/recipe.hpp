#pragma once
/// A scene as a reader of some format leaves it: each value is typed and checked, names are not yet
/// looked up. It knows no format and no file. Errors of building name an element
/// (build_messages.hpp), and the reader knows the position of each element in its file.
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/joints/kinds.hpp"
#include "engine/scene/scene.hpp"
#include "engine/world/timed_event.hpp"

namespace pantin::detail {

/// Shapes and mass properties of a body, in its mass-centre frame.
struct BodyMassProperties {
  Real mass = 1;
  Vec3 inertia{1};
  Pose centre;            // the mass-centre frame in the body's own frame
  bool is_moved = false;  // false: both frames coincide
  bool is_point = false;  // nothing may exert torque on it
  std::vector<Shape> shapes;
};

struct BodyRecipe {
  std::string name;
  BodyMassProperties mass_properties;
  Pose pose;  // of the body's own frame, in that of `parent`
  std::optional<std::string> parent{};
  Body body;  // its pose, mass and inertia follow from the members above
  std::optional<SolverSettings> solver;
  std::optional<Collision> collision;
  bool is_lamina = false, is_finger = false;
};

/// A point given in the scene at the start, in a body's own frame, or omitted.
struct PointRecipe {
  std::optional<Vec3> in_scene, in_body;
};

/// The x axis of a joint, and the direction nearest its y axis; without `across` y is any
/// perpendicular direction.
struct AxesRecipe {
  Vec3 axis{1, 0, 0};
  std::optional<Vec3> across;
};

/// The name of a kind with its article, for messages: "a hinge joint".
std::string a_joint(JointKind kind);

/// Kind, limits and forces of a joint, without its position.
struct RotationRecipe {
  JointKind kind = JointKind::ball;
  JointLimits limits;
  std::optional<JointDrive> drive;
  Boxed<JointParameters> parameters;
  std::optional<Real> length;  // m, the parameter that defaults to the initial distance
  /// Whether it acts along the line between its anchors only.
  bool is_line() const { return info_of(kind).is_line; }
  /// Whether the orientation of the joint axes matters.
  bool needs_axes() const { return info_of(kind).uses_axes || limits.any() || drive; }
};

struct JointRecipe {
  std::string name;
  std::string a, b;
  std::optional<Vec3> anchor, anchor_a, anchor_b;
  std::optional<Vec3> point_a, point_b;  // of kinds along a line: in the scene
  AxesRecipe axes;                       // in the scene at the start, unless given in a body:
  std::optional<AxesRecipe> axes_a, axes_b;
  Quat rest{1, 0, 0, 0};  // initial Q; ignored if both axes are given
  RotationRecipe turn;
};

struct GearRecipe {
  std::string name;
  std::string first, second;                          // joints
  std::optional<bool> first_travels, second_travels;  // default: by the kind of joint
  Real ratio = 1;
  std::optional<Real> offset;  // rad or m
  bool in_degrees = false;     // unit of the angles in the file
  Real length_unit = 1;        // m, of the file; ratio and offset are in its unit
};

struct PulleyRecipe {
  std::string body;
  PointRecipe at;
  Real radius = 0;
  std::vector<Vec3> outline;  // in the body's own x and y; empty: round
  bool is_outside = false;
};

struct BeltRecipe {
  std::string name;
  std::vector<PulleyRecipe> pulleys;
  bool crossed = false;
  Real pretension = 0, friction = 0, width = 0.04;
  bool has_links = false;
  int links = 0;    // 0: as many as fit
  Real mass = 0.2;  // kg, of the links
  std::uint32_t material = 0;
};

/// One side of a contact of two surfaces.
struct SurfaceSideRecipe {
  std::string body;
  std::shared_ptr<const Surface> surface;  // of NURBS; null, without a curve: that of its shape
  std::shared_ptr<const nurbs::Wire> curve;
  std::string curve_name;    // of the list of curves
  std::optional<Pose> pose;  // in the body's own frame
};

struct SurfaceJointRecipe {
  std::string name;
  SurfaceSideRecipe a, b;
  SurfaceMotion motion = SurfaceMotion::sliding;
  bool lifts = false;
  OnRim on_rim = OnRim::stop;
  std::optional<Real> friction;
  std::optional<int> contacts;
};

struct GuideRecipe {
  std::string body;
  PointRecipe at;
  Vec3 axis{0};  // in the scene; any length
  Real radius = 0;
  int turns = 0;
};

struct CableRecipe {
  std::string name;
  std::string a, b;
  PointRecipe at_a, at_b;
  std::vector<GuideRecipe> over;
  std::optional<Real> length;
  Real slack = 1;
  Real compliance = 0;
};

struct PinRecipe {
  std::string name;
  std::string body;
  PointRecipe point;
  std::optional<Vec3> target;
  std::optional<std::string> to;
  std::optional<Vec3> anchor_to;  // in the own frame of `to`
  Pin pin;                        // priority, kind, stiffness
};

struct SensorRecipe {
  std::string name;
  SensorKind kind = SensorKind::point;
  std::string body, to, from, joint;             // empty: none
  Vec3 anchor{0}, to_anchor{0}, from_anchor{0};  // in the bodies' own frames
};

struct PathRecipe {
  std::string body;
  KinematicPath path;  // in a prefab's frame; values that are kLeftOpen follow from the start of
                       // the body
};

/// The pose of a body at the start, given once everything else is built.
struct PoseRecipe {
  std::string body;
  Pose pose;  // of the body's own frame, in the scene
};

/// A number of a joint or cable that assembly may change: "joints/3/length".
struct FreeRecipe {
  std::string of;
  std::optional<Real> least, most;  // in the unit of the file
  Real length_unit = 1;             // m, of the file
};

/// A plane at `offset` (m) along x, y or z.
struct MirrorPlane {
  int axis = 0;  // 0: x, 1: y, 2: z
  Real offset = 0;
};

/// Bodies of a group, with their connections, copied across a plane.
struct MirrorRecipe {
  MirrorPlane plane;
  std::vector<std::string> bodies;
};

struct InstanceRecipe {
  std::string name;
  std::string prefab;  // empty if it could not be read: already reported
  Pose pose;           // in the own frame of `parent`
  std::optional<std::string> parent{};
  Real time_offset = 0;
  std::optional<SolverSettings> solver;
  std::optional<std::string> world{};  // the body that "world" of the prefab stands for
  std::optional<int> mirror{};  // the axis across which the prefab is mirrored, in its own frame
};

struct GridRecipe {
  InstanceRecipe each;  // pose of the grid's middle
  std::array<int, 3> count{1, 1, 1};
  Vec3 spacing{1};
  // A ring: as many copies as count[0], rotated about an axis.
  bool is_ring = false;
  Vec3 axis{0, 1, 0};  // in the grid's frame
  Vec3 arm{0};         // of the first copy, m
  Real angle = 360;    // degrees from the first copy to the last; 360: to the first again
};

struct ChainRecipe {
  std::string name;
  int links = 0;
  Real length = 0;                       // of one link, joint to joint
  BodyRecipe link;                       // its own frame: middle of the link, -y along the chain
  std::vector<std::uint32_t> materials;  // used in turn; empty: those of the shapes
  Vec3 start{0}, direction{0, -1, 0}, sag{0, -1, 0};
  std::optional<Vec3> end;
  std::optional<std::string> attach, end_attach;
  Real mass_ratio = 1, tip_mass_factor = 1;
  std::vector<Vec3> path;    // positions of the joints, m; empty: laid out by the members above
  bool closed = false;       // the last link is jointed to the first
  std::optional<Vec3> axis;  // target of the links' own z axes
  RotationRecipe turn;
};

struct EventRecipe {
  TimedEvent event{};  // without the entity that it acts on
  std::string on;      // name of that entity; empty: all
  std::string member;  // the key of that name: "body", "joint", "cable", "pin" or "gear"
  std::vector<std::string> bodies;
  PointRecipe point;
  bool in_degrees = false;  // unit in the file of a motor's target, or of a drive's motion
  bool says_along = false;  // of that motion
  Real length_unit = 1;     // m, of the file; the values of a motor or motion are in its unit
};
/// Marks values of a motor or drive that an event leaves unchanged.
inline constexpr Real kAsBefore = std::numeric_limits<Real>::quiet_NaN();

/// Content of a prefab or of the scene itself. Names are unique in it.
struct Group {
  std::string name;
  std::uint32_t scope = 0;  // name space of its prefabs
  std::vector<BodyRecipe> bodies;
  std::vector<JointRecipe> joints;
  std::vector<GearRecipe> gears;
  std::vector<BeltRecipe> belts;
  std::vector<SurfaceJointRecipe> surface_joints;
  std::vector<CableRecipe> cables;
  std::vector<PinRecipe> pins;
  std::vector<PathRecipe> paths;
  std::vector<PoseRecipe> poses;  // of the scene itself only, like the next two
  std::vector<FreeRecipe> free;
  std::vector<SensorRecipe> sensors;
  std::vector<InstanceRecipe> instances;
  std::vector<GridRecipe> grids;
  std::vector<ChainRecipe> chains;
  std::vector<MirrorRecipe> mirrors;
  std::vector<EventRecipe> events;
  // Members that could not be read: names below "<member>/" are not reported as unknown.
  std::vector<std::string> broken;
};

/// A prefab that could not be read, which has been reported.
inline constexpr std::uint32_t kNoPrefab = UINT32_MAX;

/// The name of a prefab in the file of that scope; 0 is the scene's own.
struct PrefabName {
  std::uint32_t scope;
  std::string name;
  std::uint32_t prefab;  // index into Recipe::prefabs
};

/// A named surface or curve of the scene itself.
struct NetRecipe {
  std::string path;           // "surfaces/NAME" or "curves/NAME"
  std::uint32_t element = 0;  // in its list
  std::shared_ptr<const Surface> surface;
  std::optional<nurbs::Curve> curve;
  std::vector<bool> is_plain;  // by face: given by its control points, and not moved
};

/// The whole recipe. `scene` is complete except for its World's entities.
struct Recipe {
  Scene scene;
  bool plane = false;  // islands that stay in the plane are solved there
  Real error = 0;      // of the motion, as a fraction of its size; 0: not given
  Group top;
  std::vector<Group> prefabs;
  std::vector<PrefabName> prefab_names;
  std::vector<NetRecipe> nets;
};

}  // namespace pantin::detail
