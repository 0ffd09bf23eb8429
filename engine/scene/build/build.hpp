#pragma once
/// The scene after name lookup, with prefabs, grids and chains expanded.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/build/build_messages.hpp"
#include "engine/scene/recipe.hpp"
#include "engine/world/design.hpp"

namespace pantin::detail {

/// Denotes the world where the index of a body is expected.
inline constexpr std::uint32_t kWorldBody = UINT32_MAX;

struct BuiltScene;

struct BuiltBody {
  std::string name;
  ElementId at{};
  Body body;
  std::shared_ptr<const BodyMassProperties> mass_properties;  // the recipe's, or a mirror image
  const SolverSettings* solver = nullptr;
  std::uint32_t material = UINT32_MAX;  // of all its shapes; UINT32_MAX: each has its own
  bool has_path = false;
  bool is_lamina = false, is_finger = false;
  std::shared_ptr<const Collision> collision;  // null unless it collides; the recipe's, or a mirror
                                               // image
};

struct BuiltJoint {
  std::string name;
  ElementId at{};
  std::uint32_t a = 0, b = 0;  // indices into BuiltScene::bodies, or kWorldBody
  Joint joint;                 // anchors and axes on the world are in the scene's frame
  std::optional<JointDrive> drive{};
};

struct BuiltGear {
  std::string name;
  ElementId at{};
  std::uint32_t first = 0, second = 0;  // indices into BuiltScene::joints
  Gear ratio;
};

struct BuiltBelt {
  std::string name;
  ElementId at{};
  std::vector<std::uint32_t> bodies;  // of its pulleys
  Belt belt;                          // entities are not set yet
  std::vector<Pose> laid;             // poses of these bodies where it was laid
};

struct BuiltGuide {
  std::uint32_t body = 0;
  CableGuide guide;  // entity is not set yet
};

struct BuiltCable {
  std::string name;
  ElementId at{};
  std::uint32_t a = 0, b = 0;
  CableParameters joint;
  std::vector<BuiltGuide> guides = {};
};

struct BuiltSurfaceJoint {
  std::string name;
  ElementId at{};
  std::uint32_t a = 0, b = 0;
  SurfaceContact contact;        // entities are not set yet
  std::string curve_a, curve_b;  // names of their curves in the list
  std::string apart{};           // why the bodies are not in contact where they are built
};

struct BuiltPin {
  std::string name;
  ElementId at{};
  std::uint32_t body = 0;
  Pin pin;
  std::uint32_t to = kWorldBody;  // the other body; the target is in its frame
};

struct BuiltPath {
  ElementId at{};
  std::uint32_t body = 0;
  KinematicPath path;
};

struct BuiltPose {
  ElementId at{};
  std::uint32_t body = 0;
  Pose pose;  // of its mass-centre frame
};

/// A design variable; its law is an element of a list of BuiltScene.
struct BuiltFree {
  DesignVariable variable;                // entity is not set yet
  ElementKind kind = ElementKind::joint;  // joint, string, ratio, belt or surface_joint
  std::uint32_t law = 0;
  const NetRecipe* net = nullptr;       // of a control point or weight
  std::vector<std::uint32_t> images{};  // numbers of the control point in the file
};
/// Finds the number that a path names; otherwise sets the fault, "found ..., expected ...".
struct FreeSource {
  const BuiltScene& built;
  const std::vector<NetRecipe>& nets;
};
std::optional<BuiltFree> find_free(const FreeSource& in, const FreeRecipe& recipe,
                                   std::string& fault);
/// Reports paths that name no number of an equation, and bounds that exclude its value.
void check_free(const FreeSource& in, const std::vector<FreeRecipe>& all, BuildMessages& messages);

/// The type of entity that an event acts on.
enum class EventObject : std::uint8_t { none, body, joint, cable, pin, gear };

struct BuiltEvent {
  ElementId at{};
  TimedEvent event;  // entities are not set yet
  EventObject object = EventObject::none;
  std::uint32_t on = 0;               // index into the list of that type
  std::vector<std::uint32_t> bodies;  // of a wind; none: all
};

/// A pointer to a member of the recipe, with shared ownership.
template <class T>
std::shared_ptr<const T> of_recipe(const T& owned) {
  return {std::shared_ptr<const T>(), &owned};
}

/// Bodies at their initial poses, in the frame of the scene or prefab. Points into the recipe.
struct BuiltSensor {
  Sensor sensor;                      // entities are not set yet
  std::uint32_t a = 0, b = 0, c = 0;  // bodies of its points, or kWorldBody
  std::uint32_t joint = 0;
};

struct BuiltScene {
  std::vector<BuiltBody> bodies;
  std::vector<BuiltJoint> joints;
  std::vector<BuiltGear> gears;
  std::vector<BuiltBelt> belts;
  std::vector<BuiltCable> cables;
  std::vector<BuiltPin> pins;
  std::vector<BuiltSurfaceJoint> surface_joints;
  std::vector<BuiltPath> paths;
  std::vector<BuiltPose> poses;
  std::vector<BuiltEvent> events;
  std::vector<BuiltSensor> sensors;

  std::size_t links() const {
    return joints.size() + gears.size() + belts.size() + cables.size() + pins.size() +
           surface_joints.size();
  }
  Pose pose_of(std::uint32_t body) const {
    return body == kWorldBody ? Pose{} : bodies[body].body.pose;
  }
  bool is_dynamic(std::uint32_t body) const {
    return body != kWorldBody && bodies[body].body.motion == Motion::dynamic;
  }
};

/// Reports unknown names, prefabs that contain themselves, and counts beyond the limits; the latter
/// before anything is copied. Throws Cancelled if the limits' callback says so.
/// Whether bilateral surfaces must be in contact at the start.
enum class Start : std::uint8_t { in_contact, anywhere };
BuiltScene build_scene(const Recipe& recipe, BuildMessages& messages, const SceneLimits& limits,
                       Start start = Start::in_contact);

/// Layout of a chain: the frame of each link, and the positions of the joints.
struct ChainLayout {
  std::vector<Pose> links;
  std::vector<Vec3> joints;   // one more than links: both ends included
  std::vector<Real> lengths;  // m, of the links
  bool is_closed = false;     // the last link is joined to the first
  /// The point about which the chain rotates initially.
  Vec3 middle() const;
};
ChainLayout layout_of(const ChainRecipe& chain);

/// The joint axes of a chain in a link's own frame: a hinge rotates about the link's z; other kinds
/// have x along the chain and y along the link's z.
Quat chain_axes(JointKind kind);

/// The solver of each dynamic body: that of the first body with settings in its island.
std::vector<Solver> solvers_of(const BuiltScene& built, Solver otherwise);

/// Reports joints and gears that the solver of their bodies does not support.
void check_solvers(const BuiltScene& built, const std::vector<Solver>& solvers,
                   BuildMessages& messages);

/// Reports what solver "planar" cannot keep in the xy plane: bodies, joints, gravity.
void check_planes(const BuiltScene& built, const std::vector<Solver>& solvers, Vec3 gravity,
                  BuildMessages& messages);

/// Reports bodies that solver "quasistatic" cannot move: those that are not laminas, and laminas
/// with joints or other ties. Fingers have no paths but their own.
void check_laminas(const BuiltScene& built, const std::vector<Solver>& solvers,
                   BuildMessages& messages);

/// Reports events that a solver does not support. Warns of events without effect: those after the
/// end of the scene, winds that move no body.
void check_events(const BuiltScene& built, const std::vector<Solver>& solvers,
                  BuildMessages& messages);
void warn_of_events(const BuiltScene& built, Real duration, BuildMessages& messages);

/// Assigns the solver "planar" to islands that stay in the xy plane; warns of others.
void choose_plane(World& world, BuildMessages& messages);

/// The cheapest model of a group of bodies that no other group can meet.
struct ModelChoice {
  std::vector<std::uint32_t> slots;  // in World::bodies, ascending
  Solver solver = Solver::articulated;
  std::string why;  // a clause
};
/// The choices for all groups without solver settings of their own, where an error of `error` is
/// accepted, a fraction of the motion's size. Bodies of two groups cannot meet: they are not
/// joined, and their colliders never meet. "planar", for motion in the xy plane, closes loops and
/// knows joints that "auto" leaves to "lagrangian"; it is cheaper for free bodies that collide,
/// too, to about 0.5 % at 60 Hz. On trees of joints "auto" is cheaper.
std::vector<ModelChoice> choose_models(const World& world, Real error);
/// Withdraws the choice "planar" where the scene would be refused with it.
void withdraw_refused(const BuiltScene& built, Vec3 gravity, std::vector<ModelChoice>& choices);
/// Gives bodies their choice: the settings `planar`, or, if all have that solver, none. Returns the
/// solver of the scene.
Solver give_models(const std::vector<ModelChoice>& choices, const SolverSettings& planar,
                   BuiltScene& built);
/// The bodies at which pairs of joined bodies close a loop; indices of `count` or more are ground.
std::vector<bool> loop_closers(std::uint32_t count,
                               const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs);

/// Warns of likely mistakes: mass ratios, pins out of reach, short cables, joints that start open
/// or beyond their limits, loops closed by joints other than ball joints.
void warn_of_structure(const BuiltScene& built, const std::vector<Solver>& solvers,
                       BuildMessages& messages);

/// Warns of bodies whose collision groups match no other body, and of bodies that fall for ever:
/// nothing holds them, and no collider can stop them.
void warn_of_contacts(const BuiltScene& built, Vec3 gravity, BuildMessages& messages);

/// Fills the World of a scene.
/// `sensors`: those of the scene, or null.
void build_world(const BuiltScene& built, World& world, std::vector<Sensor>* sensors = nullptr);

/// Adds the bodies of laminas: see add_lamina_bodies.
void add_laminas(const std::vector<LaminaPlan>& laminas, World& world);

}  // namespace pantin::detail
