#pragma once
/// A scene file as read: every value typed and checked by itself, names not yet looked up.
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/scene/complaints.hpp"
#include "engine/scene/json.hpp"
#include "engine/scene/scene.hpp"

namespace pantin {

/// The name of something else in the file. Views into the file's text.
struct Reference {
  std::string_view name;
  NodeId at = kNoNode;
};

/// What a body is made of, in its mass-centre frame.
struct Matter {
  Real mass = 1;
  Vec3 inertia{1};
  Pose centre;            // the mass-centre frame in the body's own frame
  bool is_moved = false;  // false: both frames are the same
  std::vector<Shape> shapes;
};

struct BodyRecipe {
  std::string name;
  NodeId at = kNoNode;
  Matter matter;
  Pose pose;  // of the body's own frame
  Vec3 velocity{0}, spin{0};
  Real drag = 0.3, gravity_scale = 1;
  Motion motion = Motion::dynamic;
  std::optional<SolverSettings> solver;
  std::optional<Collision> collision;
};

/// A point given in the scene at the start, in a body's own frame, or not at all.
struct PointRecipe {
  std::optional<Vec3> in_scene, in_body;
};

/// The x axis of a joint and what its y axis is nearest to; without `across` some direction across.
struct AxesRecipe {
  Vec3 axis{1, 0, 0};
  std::optional<Vec3> across;
};

/// What a joint lets its bodies do, apart from where it is.
struct TurnRecipe {
  JointKind kind = JointKind::ball;
  JointLimits limits;
  std::optional<PoseDrive> drive;
  Rare<JointExtras> extras;
  std::optional<Real> length;  // m, the parameter that is by default as placed
  /// Whether its bodies are tied by their anchors' distance alone.
  bool is_line() const { return info_of(kind).is_line; }
  /// Whether it matters how the joint axes lie.
  bool needs_axes() const {
    return info_of(kind).uses_axes || limits.any() || drive;
  }
};

struct JointRecipe {
  std::string name;
  NodeId at = kNoNode;
  Reference a, b;
  std::optional<Vec3> anchor, anchor_a, anchor_b;
  std::optional<Vec3> point_a, point_b;    // of kinds that are lines: in the scene
  AxesRecipe axes;                         // in the scene at the start, unless given in a body:
  std::optional<AxesRecipe> axes_a, axes_b;
  Quat rest{1, 0, 0, 0};                   // Q at the start; with both axes given, those tell it
  TurnRecipe turn;
};

struct RatioRecipe {
  std::string name;
  NodeId at = kNoNode;
  Reference first, second;  // joints
  std::optional<bool> slides_first, slides_second;  // by default as the kind of joint
  Real ratio = 1;
  std::optional<Real> offset;  // as written
  bool in_degrees = false;
};

struct StringRecipe {
  std::string name;
  NodeId at = kNoNode;
  Reference a, b;
  PointRecipe at_a, at_b;
  std::optional<Real> length;
  Real slack = 1;
  Real compliance = 0;
};

struct PinRecipe {
  std::string name;
  NodeId at = kNoNode;
  Reference body;
  PointRecipe point;
  std::optional<Vec3> target;
  std::optional<Reference> to;
  std::optional<Vec3> anchor_to;  // in the own frame of `to`
  Pin pin;                        // priority, grip, stiffness
};

struct KeyRecipe {
  Real time = 0;
  std::optional<Vec3> position;
  std::optional<Quat> rotation;
};

struct DriveRecipe {
  NodeId at = kNoNode;
  Reference body;
  std::vector<KeyRecipe> keys;  // empty: a sway
  bool loop = false;
  Lissajous sway;  // angles of a prefab's frame; centre as below
  std::optional<Vec3> centre;
};

struct InstanceRecipe {
  std::string name;
  NodeId at = kNoNode;
  Reference prefab;
  Pose pose;
  Real time_offset = 0;
  std::optional<SolverSettings> solver;
};

struct GridRecipe {
  InstanceRecipe each;  // pose of the grid's middle
  std::array<int, 3> count{1, 1, 1};
  Vec3 spacing{1};
};

struct ChainRecipe {
  std::string name;
  NodeId at = kNoNode;
  int links = 0;
  Real length = 0;                       // of one link, joint to joint
  BodyRecipe link;                       // its own frame: middle of the link, -y along the chain
  std::vector<std::uint32_t> materials;  // taken in turn; empty: as the shapes say
  Vec3 start{0}, direction{0, -1, 0}, sag{0, -1, 0};
  std::optional<Vec3> end;
  std::optional<Reference> attach, end_attach;
  Real mass_ratio = 1, tip_mass_factor = 1;
  std::vector<Vec3> path;    // joint after joint, m; empty: laid out by what stands above
  bool closed = false;       // the last link is jointed to the first
  std::optional<Vec3> axis;  // where the links' own z axes point as nearly as they can
  TurnRecipe turn;
};

/// What a prefab and the scene itself have in common.
struct Group {
  std::string name;
  NodeId at = kNoNode;
  std::vector<BodyRecipe> bodies;
  std::vector<JointRecipe> joints;
  std::vector<RatioRecipe> ratios;
  std::vector<StringRecipe> strings;
  std::vector<PinRecipe> pins;
  std::vector<DriveRecipe> drives;
  std::vector<InstanceRecipe> instances;
  std::vector<GridRecipe> grids;
  std::vector<ChainRecipe> chains;
  // Members that could not be read: names below "<member>/" are unknown, not wrong.
  std::vector<std::string> broken;
};

/// The whole file. `scene` lacks only its World's entities.
struct Recipe {
  Scene scene;
  Group top;
  std::vector<Group> prefabs;
};

/// Files that the scene names are looked for in `folder`.
Recipe read_recipe(const JsonDocument& json, Complaints& complaints, const SceneLimits& limits,
                   const std::string& folder);

}  // namespace pantin
