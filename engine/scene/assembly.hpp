#pragma once
/// A recipe with its names looked up and its prefabs, grids and chains written out.
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/build_messages.hpp"
#include "engine/scene/recipe.hpp"

namespace pantin {

/// Stands for what never moves where a body is asked for.
inline constexpr std::uint32_t kWorldBody = UINT32_MAX;

struct PlacedBody {
  std::string name;
  ElementId at{};
  Body body;
  const Matter* matter = nullptr;
  const SolverSettings* solver = nullptr;
  std::uint32_t material = UINT32_MAX;  // for all its shapes; UINT32_MAX: as they say
  bool is_driven_by_path = false;
  const Collision* collision = nullptr;  // of solid bodies
};

struct PlacedJoint {
  std::string name;
  ElementId at{};
  std::uint32_t a = 0, b = 0;  // places in Assembly::bodies, or kWorldBody
  Joint joint;                 // an anchor and axes in the world are those of the assembly's frame
  std::optional<PoseDrive> drive{};
};

struct PlacedRatio {
  std::string name;
  ElementId at{};
  std::uint32_t first = 0, second = 0;  // places in Assembly::joints
  Ratio ratio;
};

struct PlacedString {
  std::string name;
  ElementId at{};
  std::uint32_t a = 0, b = 0;
  StringJoint joint;
};

struct PlacedPin {
  std::string name;
  ElementId at{};
  std::uint32_t body = 0;
  Pin pin;
  std::uint32_t to = kWorldBody;  // the body held on to; its target is in that one's frame
};

struct PlacedDrive {
  ElementId at{};
  std::uint32_t body = 0;
  Drive drive;
};

/// Bodies lie as at the start, in the assembly's own frame. Points into the recipe.
struct Assembly {
  std::vector<PlacedBody> bodies;
  std::vector<PlacedJoint> joints;
  std::vector<PlacedRatio> ratios;
  std::vector<PlacedString> strings;
  std::vector<PlacedPin> pins;
  std::vector<PlacedDrive> drives;

  std::size_t links() const { return joints.size() + ratios.size() + strings.size() + pins.size(); }
  Pose pose_of(std::uint32_t body) const {
    return body == kWorldBody ? Pose{} : bodies[body].body.pose;
  }
  bool is_dynamic(std::uint32_t body) const {
    return body != kWorldBody && bodies[body].body.motion == Motion::dynamic;
  }
};

/// Tells of names that lead nowhere, prefabs that contain themselves, and counts beyond the limits;
/// those before anything is copied. Throws Cancelled where the limits say so.
Assembly assemble(const Recipe& recipe, BuildMessages& messages, const SceneLimits& limits);

/// Places the links of a chain: the own frame of each, and where the chain ends.
struct ChainCourse {
  std::vector<Pose> links;
  std::vector<Vec3> joints;   // one more than links: both ends included
  std::vector<Real> lengths;  // m, of the links
  /// What the chain starts turning about.
  Vec3 middle(bool closed) const;
};
ChainCourse course_of(const ChainRecipe& chain);

/// The joint axes of a chain's joints in the own frame of a link: a hinge turns about its z; other
/// kinds have x along the chain and y along its z.
Quat chain_axes(JointKind kind);

/// Which solver moves each body that is dynamic: that of the first body, among all that joints and
/// ratios tie together, that names one.
std::vector<Solver> solvers_of(const Assembly& assembly, Solver otherwise);

/// Tells of joints and ratios that the solver of their bodies does not know.
void refuse_unsolved(const Assembly& assembly, const std::vector<Solver>& solvers,
                     BuildMessages& messages);

/// Warns of what will run but hardly as meant: mass ratios, pins out of reach, strings too short,
/// joints that start open or beyond their limits, or that close a loop and are more than a ball.
void warn_of_structure(const Assembly& assembly, const std::vector<Solver>& solvers,
                       BuildMessages& messages);

/// Fills the World of a scene.
void build_world(const Assembly& assembly, World& world);

}  // namespace pantin
