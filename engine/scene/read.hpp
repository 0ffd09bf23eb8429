#pragma once
/// The pieces that read_recipe() is made of.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/scene/reader.hpp"
#include "engine/scene/recipe.hpp"

namespace pantin {

/// What every part of a file is read against.
struct Reading {
  const JsonDocument& json;
  Complaints& complaints;
  const SceneLimits& limits;
  std::vector<Material> materials{};  // the first is the default
  SolverSettings solver{};            // of the scene; bodies and instances change some of it
  std::optional<Collision> collision{};           // of bodies that say nothing of it
  std::vector<std::string_view> groups{};         // of collision: a name for each bit, from 0
  std::string folder{};                           // where files that the scene names lie

  Reader open(NodeId node, std::string_view what) const {
    return Reader(json, complaints, node, keys_of(what));
  }
};

/// Settings under "solver", where keys that are absent keep the values of `base`.
std::optional<SolverSettings> read_solver(const Reading& reading, const Reader& from,
                                          const SolverSettings& base);

/// The index of a material by name, or of `otherwise`.
std::uint32_t read_material(const Reading& reading, const Reader& from, std::uint32_t otherwise);

/// The same, where `node` is the name itself.
std::uint32_t find_material(const Reading& reading, NodeId node, std::uint32_t otherwise);

/// A shape in the body's own frame, and its density.
struct DenseShape {
  Shape shape;
  Real density = 0;  // kg/m^3
};
struct ShapeDefaults {
  std::uint32_t material = 0;
  Real density = 1000;
  Motion motion = Motion::dynamic;
};
/// Complains of what a body of this motion cannot have. Nothing if it cannot be read.
std::optional<DenseShape> read_shape(const Reading& reading, NodeId node,
                                     const ShapeDefaults& otherwise);

/// "collision_groups" and "collision" of the whole scene.
void read_scene_collision(Reading& reading, const Reader& scene);

/// "collision": true, false or an object; what is absent is as in the scene's. Nothing for a body
/// that is not solid; complains if one is to be solid that has no shape.
std::optional<Collision> read_collision(const Reading& reading, const Reader& from, bool has_shapes,
                                        const std::optional<Collision>& otherwise);

/// The value of `key` or `key`_deg.
NodeId either(const Reader& from, std::string_view key);

/// The name of a kind with its article: "a hinge joint".
std::string a_joint(JointKind kind);

/// Measures of the kind and what acts along its freedoms: "pitch", "spring", "friction", "motor",
/// "angle", "travel" and so on. Complains of keys that a joint of this kind cannot have.
void read_extras(const Reading& reading, const Reader& from, TurnRecipe& turn);

/// "kind", "limits", "drive" and extras of a joint, or of the joints of a chain.
TurnRecipe read_turn(const Reading& reading, const Reader& from);

/// An angle or angles under `key` (rad) or `key`_deg, not both; false if neither is given or it does
/// not fit.
bool read_angles(const Reader& from, std::string_view key, std::span<Real> into);

/// A turn of joint axes under `key` or `key`_deg: a quaternion or three angles; for a hinge one
/// angle, for a universal joint two. Complains of turns that the kind cannot make.
std::optional<Quat> read_joint_turn(const Reader& from, std::string_view key, JointKind kind);

/// A name that may be left out; complaints as for one that may not.
inline std::string optional_name(const Reader& from) { return from.has("name") ? from.name() : ""; }

inline constexpr std::string_view kBodyOrWorld = "the name of a body, or \"world\"";
inline constexpr Range kDegrees{-1e6, 1e6, "an angle in degrees, between -1e6 and 1e6"};
inline constexpr Range kRadians{-1e4, 1e4, "an angle in rad, between -1e4 and 1e4"};
inline constexpr Range kTime{-1e6, 1e6, "a time in seconds, between -1e6 and 1e6"};

/// Shapes, mass, mass centre and inertia. The frame of a body that is not dynamic stays its own,
/// since nothing turns it about its mass centre.
Matter read_matter(const Reading& reading, const Reader& from, Motion motion);

std::optional<Reference> read_reference(const Reader& from, std::string_view key,
                                        std::string_view expected, bool is_needed);

BodyRecipe read_body(const Reading& reading, NodeId node);
std::optional<JointRecipe> read_joint(const Reading& reading, NodeId node);
std::optional<RatioRecipe> read_ratio(const Reading& reading, NodeId node);
std::optional<StringRecipe> read_string(const Reading& reading, NodeId node);
std::optional<PinRecipe> read_pin(const Reading& reading, NodeId node);
std::optional<DriveRecipe> read_drive(const Reading& reading, NodeId node);
std::optional<InstanceRecipe> read_instance(const Reading& reading, NodeId node);
std::optional<GridRecipe> read_grid(const Reading& reading, NodeId node);
ChainRecipe read_chain(const Reading& reading, NodeId node);  // links == 0 if it cannot be read
BodyRecipe read_stairs(const Reading& reading, NodeId node);  // no name if it cannot be read

}  // namespace pantin
