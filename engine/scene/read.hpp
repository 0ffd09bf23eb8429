#pragma once
/// The pieces that read_recipe() is made of.
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/scene/json_recipe.hpp"
#include "engine/scene/keys.hpp"
#include "engine/scene/poll.hpp"
#include "engine/scene/reader.hpp"

namespace pantin::detail {

/// Surfaces made from files, by kind and path: shapes that name one file share it. Null: refused.
using SurfaceFiles = std::map<std::pair<ShapeKind, std::string>, std::shared_ptr<const Surface>>;

/// Context for reading a file.
struct Reading {
  const JsonDocument& json;
  Diagnostics& diagnostics;
  JsonPlaces& places;
  const SceneLimits& limits;
  Poll& poll;
  SurfaceFiles& surfaces;
  std::vector<Material> materials{};                                  // the first is the default
  std::unordered_map<std::string_view, std::uint32_t> material_of{};  // by name, in the text
  SolverSettings solver{};                 // of the scene; bodies and instances change some of it
  std::optional<Collision> collision{};    // of bodies without their own
  std::vector<std::string_view> groups{};  // of collision: a name for each bit, from 0
  std::string folder{};                    // folder of files named by the scene

  Reader open(NodeId node, std::string_view what) const {
    poll();
    return Reader(json, diagnostics, node, keys_of(what));
  }
};

/// Settings under "solver", where keys that are absent keep the values of `base`.
std::optional<SolverSettings> read_solver(const Reading& reading, const Reader& from,
                                          const SolverSettings& base);

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
/// Reports what a body of this motion cannot have. Nothing if it cannot be read.
std::optional<ShapeWithDensity> read_shape(const Reading& reading, NodeId node,
                                           const ShapeDefaults& otherwise);

/// "material_pairs"; after the materials.
std::vector<MaterialPair> read_material_pairs(const Reading& reading, const Reader& scene);

/// "collision_groups" and "collision" of the whole scene.
void read_scene_collision(Reading& reading, const Reader& scene);

/// "collision": true, false or an object; absent keys default to the scene's. Nothing for a body
/// that does not collide.
std::optional<Collision> read_collision(const Reading& reading, const Reader& from,
                                        const std::optional<Collision>& otherwise);

/// The same of a body or a link of a chain, with the scene's defaults; an error if it collides
/// without a shape.
void read_collision_of(const Reading& reading, const Reader& from, BodyRecipe& body);

/// The value of `key` or `key`_deg.
NodeId either(const Reader& from, std::string_view key);

/// Measures of the kind and what acts along its freedoms: "pitch", "spring", "friction", "motor",
/// "angle", "travel" and so on. Reports keys that a joint of this kind cannot have.
void read_parameters(const Reading& reading, const Reader& from, RotationRecipe& turn);

/// "kind", "limits", "drive" and extras of a joint, or of the joints of a chain.
RotationRecipe read_turn(const Reading& reading, const Reader& from);

/// An angle or angles under `key` (rad) or `key`_deg, not both; false if neither is given or it
/// does not fit.
bool read_angles(const Reader& from, std::string_view key, std::span<Real> into);

/// A rotation of joint axes under `key` or `key`_deg: a quaternion or three angles; one angle for a
/// hinge, two for a universal joint. Reports rotations that the kind does not allow.
std::optional<Quat> read_joint_turn(const Reader& from, std::string_view key, JointKind kind);

/// An optional name, checked like a required one.
inline std::string optional_name(const Reader& from) { return from.has("name") ? from.name() : ""; }

/// Shapes, mass, mass centre and inertia. A body that is not dynamic keeps its own frame, since
/// nothing rotates it about its mass centre.
BodyMassProperties read_mass_properties(const Reading& reading, const Reader& from, Motion motion);

BodyRecipe read_body(const Reading& reading, NodeId node);
std::optional<JointRecipe> read_joint(const Reading& reading, NodeId node);
std::optional<GearRecipe> read_gear(const Reading& reading, NodeId node);
std::optional<CableRecipe> read_cable(const Reading& reading, NodeId node);
std::optional<PinRecipe> read_pin(const Reading& reading, NodeId node);
std::optional<PathRecipe> read_path(const Reading& reading, NodeId node);
std::optional<InstanceRecipe> read_instance(const Reading& reading, NodeId node);
std::optional<GridRecipe> read_grid(const Reading& reading, NodeId node);
std::optional<EventRecipe> read_event(const Reading& reading, NodeId node);
ChainRecipe read_chain(const Reading& reading, NodeId node);  // links == 0 if it cannot be read
BodyRecipe read_stairs(const Reading& reading, NodeId node);  // no name if it cannot be read

}  // namespace pantin::detail
