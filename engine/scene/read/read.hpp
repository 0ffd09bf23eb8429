#pragma once
/// The parts of read_recipe().
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/modes/lamina_plan.hpp"
#include "engine/nurbs/spline.hpp"
#include "engine/scene/keys/keys.hpp"
#include "engine/scene/poll.hpp"
#include "engine/scene/read/bind.hpp"
#include "engine/scene/read/json_recipe.hpp"
#include "engine/scene/read/reader.hpp"
#include "engine/scene/read/units.hpp"
#include "engine/scene/scene_files.hpp"

namespace pantin::detail {

/// Surfaces made from files, by kind, path and unit of length (m), shared by shapes that name the
/// same file. Null: invalid.
using SurfaceFiles =
    std::map<std::tuple<ShapeKind, std::string, double>, std::shared_ptr<const Surface>>;

/// A class, or the defaults of a file: values for bodies, joints, cables and pins.
struct ClassParts {
  NodeId body = kNoNode, joint = kNoNode, cable = kNoNode, pin = kNoNode;
};

/// State shared by the files of a scene while they are read.
struct SceneReading {
  Recipe& recipe;
  SceneFiles& files;
  JsonPlaces& places;
  const SceneLimits& limits;
  Poll poll;
  SurfaceFiles surfaces{};
  std::vector<std::string_view> groups{};  // collision groups: a name for each bit, from 0
  std::vector<std::string> open_files{};   // being read, outermost first, as full paths
  std::unordered_map<std::string, std::uint32_t> prefab_of{};  // by files read before
  std::uint32_t scopes = 0;                                    // number of name spaces of prefabs
  std::vector<NodeId> lamina_nodes{};                          // of Scene::laminas
};

/// Context for reading a file.
struct Reading {
  SceneReading& scene;
  SceneFile& file;
  const JsonDocument& json;
  Diagnostics& diagnostics;
  JsonPlaces& places;
  const SceneLimits& limits;
  Poll& poll;
  SurfaceFiles& surfaces;
  std::vector<Material>& materials;  // of all files; the first is the default
  std::size_t first_material = 1;    // index of the first of this file
  std::uint32_t scope = 0;           // name space of its prefabs
  std::unordered_map<std::string_view, std::uint32_t> material_of{};  // by name, in the text
  SolverSettings solver{};                  // of the scene; bodies and instances override parts of
                                            // it
  std::optional<Collision> collision{};     // default of bodies
  std::vector<std::string_view> groups{};   // collision groups, by name
  std::vector<std::uint32_t> group_bits{};  // of each of them
  std::string folder{};                     // folder of files named by the scene
  double length_unit = 1;                   // m, of lengths in the text; see units.hpp
  ClassParts defaults{};
  /// NURBS surfaces by name in the text; null: invalid.
  std::unordered_map<std::string_view, std::shared_ptr<const Surface>> surface_of{};
  /// Curves by name in the text; nothing: invalid.
  std::unordered_map<std::string_view, std::optional<nurbs::Curve>> curve_of{};
  /// By name in the text: the class, then those it inherits from.
  std::unordered_map<std::string_view, std::vector<ClassParts>> classes{};

  Reader open(NodeId node, std::string_view what) const {
    poll();
    return Reader(json, diagnostics, node, keys_of(what));
  }
};

/// Reads the prefabs of a file, including those in files of their own.
void read_prefabs(const Reading& reading, const Reader& from);

/// Reads a scene file without its head: the part that prefabs have too. `number` as in ElementId.
void read_content(Reading& reading, const Reader& from, std::uint32_t number);

/// Opens a file of the scene for reading.
Reading reading_of(SceneReading& scene, SceneFile& file);

/// "defaults" and "classes"; after the materials.
void read_classes(Reading& reading, const Reader& scene);

/// The index of a material by name, or of `otherwise`.
std::uint32_t read_material(const Reading& reading, const Reader& from, std::uint32_t otherwise);

/// The same, where `node` is the name itself.
std::uint32_t find_material(const Reading& reading, NodeId node, std::uint32_t otherwise);

/// Which of `names` the "type" of an object is; nothing after an error.
std::optional<std::size_t> read_type(const Reading& reading, NodeId node,
                                     std::span<const std::string_view> names);

/// A shape in the body's own frame, and its density.
struct ShapeWithDensity {
  Shape shape;
  Real density = 0;  // kg/m^3
};
struct ShapeDefaults {
  std::uint32_t material = 0;
  Real density = 1000;
  Motion motion = Motion::dynamic;
};
/// Reports what a body of this motion cannot have. Returns nothing if it cannot be read.
std::optional<ShapeWithDensity> read_shape(const Reading& reading, NodeId node,
                                           const ShapeDefaults& otherwise);

/// "scale", "position" and "rotation" of a surface, a face or a curve: scaled, rotated, then moved.
nurbs::Affine placing_of(const Reader& from);
inline constexpr std::string_view kPlacing = "scale position rotation rotation_deg";

/// Reverses a face. A face with errors, which check_face() reports, is unchanged.
nurbs::Surface turned(const nurbs::Surface& face);

/// Reads "surfaces".
void read_surfaces(Reading& reading, const Reader& scene);
/// The surface under "surface" of a shape; null after an error.
std::shared_ptr<const Surface> read_skin(const Reading& reading, const Reader& shape);
/// A surface: an object, alone or in a list or a shape; null after an error.
std::shared_ptr<const Surface> read_surface(const Reading& reading, NodeId node);
/// Reads "curves".
void read_curves(Reading& reading, const Reader& scene);
/// The curve under "curve" of a side of a joint; nothing after an error.
std::optional<nurbs::Curve> read_own_curve(const Reading& reading, const Reader& side);
/// A face; nothing after an error.
std::optional<nurbs::Surface> read_face(const Reading& reading, NodeId node);
/// A curve; nothing after an error.
std::optional<nurbs::Curve> read_curve(const Reading& reading, NodeId node);

/// "material_pairs"; after the materials.
std::vector<MaterialPair> read_material_pairs(const Reading& reading, const Reader& scene);

/// "collision_groups" and "collision" of the whole scene.
void read_scene_collision(Reading& reading, const Reader& scene);

/// "collision": true, false or an object; missing keys default to the scene's. Returns nothing for
/// a body that does not collide.
std::optional<Collision> read_collision(const Reading& reading, const Reader& from,
                                        const std::optional<Collision>& otherwise);

/// The same of a body or a link of a chain, with the scene's defaults; an error if it collides
/// without a shape.
bool read_collision_of(const RowValue& row, BodyRecipe& body);

/// Groups by their names or numbers, as bits.
std::uint32_t read_groups(const Reading& reading, const std::vector<NodeId>& nodes);

/// The value of `key` or `key`_deg.
NodeId either(const Reader& from, std::string_view key);

/// The parameters of the kind, and the laws along its coordinates: "pitch", "spring", "friction",
/// "motor", "angle", "travel" and so on. Reports keys that a joint of this kind cannot have.
void read_parameters(const Reading& reading, const Reader& from, RotationRecipe& turn);

/// "limits": those of the rotation and of the travel of a joint of this kind.
JointLimits read_limits(const Reading& reading, const Reader& from, RotationRecipe& turn);

/// "drive".
/// A coordinate of a joint or its rate: m, or an angle under `key` or `key`_deg.
Real read_coordinate(const Reader& from, std::string_view key, Coordinate along);
DriveMotion read_drive_motion(const Reader& from, const Reading& reading, JointKind kind);
/// The same for a joint that is not known yet, with lengths in the unit of the file, and whether it
/// says "along" and has angles in degrees.
struct UnboundMotion {
  DriveMotion motion;
  bool says_along = false, in_degrees = false;
};
UnboundMotion read_drive_motion(const Reader& from, const Reading& reading);
std::optional<JointDrive> read_pose_drive(const Reading& reading, const Reader& from,
                                          JointKind kind);

/// "kind", "limits", "drive" and extras of a joint, or of the joints of a chain.
RotationRecipe read_turn(const Reading& reading, const Reader& from);

/// One or more angles under `key` (rad) or `key`_deg, not both; returns false if neither is given
/// or the value is invalid.
bool read_angles(const Reader& from, std::string_view key, std::span<Real> into);

/// A rotation of joint axes under `key` or `key`_deg: a quaternion or three angles; one angle for a
/// hinge, two for a universal joint. Reports rotations that the kind does not allow.
std::optional<Quat> read_joint_turn(const Reader& from, std::string_view key, JointKind kind);

/// An array of names of bodies; reports invalid items.
std::vector<std::string> read_names(const Reading& reading, const Reader& from,
                                    std::string_view key);

/// An optional name, checked like a required one.
inline std::string optional_name(const Reader& from) { return from.has("name") ? from.name() : ""; }

/// Shapes, mass, mass centre and inertia. A body that is not dynamic keeps its own frame, since
/// nothing rotates it about its mass centre.
BodyMassProperties read_mass_properties(const Reading& reading, const Reader& from, Motion motion);

// ---- Values that rows cannot express: see bind.hpp ----------------------------------------------

bool read_value(const RowValue& row, std::optional<SolverSettings>& to);
bool read_value(const RowValue& row, modes::Vec2& to);
/// "ground", an object or a flag.
bool read_ground(const RowValue& row, View& view);
bool read_members(const Reading& reading, const Reader& from, BodyRecipe& body);
bool read_members(const Reading& reading, const Reader& from, JointRecipe& joint);
bool read_members(const Reading& reading, const Reader& from, GearRecipe& gear);
bool read_members(const Reading& reading, const Reader& from, BeltRecipe& belt);
bool read_members(const Reading& reading, const Reader& from, SensorRecipe& sensor);
bool read_members(const Reading& reading, const Reader& from, SurfaceSideRecipe& side);
bool read_members(const Reading& reading, const Reader& from, SurfaceJointRecipe& joint);
bool read_members(const Reading& reading, const Reader& from, GuideRecipe& guide);
bool read_members(const Reading& reading, const Reader& from, PathRecipe& path);
bool read_members(const Reading& reading, const Reader& from, PoseRecipe& pose);
bool read_members(const Reading& reading, const Reader& from, InstanceRecipe& instance);
bool read_members(const Reading& reading, const Reader& from, GridRecipe& grid);
bool read_members(const Reading& reading, const Reader& from, SolverSettings& settings);
bool read_members(const Reading& reading, const Reader& from, Camera& camera);

std::optional<LaminaPlan> read_lamina(const Reading& reading, NodeId node, Vec3 gravity);
std::optional<EventRecipe> read_event(const Reading& reading, NodeId node);
ChainRecipe read_chain(const Reading& reading, NodeId node);  // links == 0 if it cannot be read
BodyRecipe read_stairs(const Reading& reading, NodeId node);  // no name if it cannot be read

namespace rows {

/// A point in the scene at the start, or in a body's own frame: of a member like PointRecipe.
template <auto path>
constexpr Key point_in_scene(Text name, Text about) {
  return vector<path, &PointRecipe::in_scene>(name, "m", about);
}
template <auto path>
constexpr Key point_in_body(Text name, Text about) {
  return vector<path, &PointRecipe::in_body>(name, "m", about);
}

}  // namespace rows
}  // namespace pantin::detail
