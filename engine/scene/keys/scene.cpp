// Keys of a scene, and of prefabs.
#include "engine/scene/read/read.hpp"

namespace pantin::detail::keys {
namespace {

using namespace rows;
using S = Scene;

constexpr Range kVersion{1, 1, "1, the version this program reads"};
constexpr Range kStep{0, 1, "a step above 0, at most 1 s", true};
constexpr Range kDuration{0, 1e6, "a duration above 0, at most 1e6 s", true};

// Keys that a scene and a prefab share.
constexpr Key kBodies = objects("bodies", "body", "Rigid bodies.");
constexpr Key kJoints = objects("joints", "joint",
                                "Joints. Of one that closes a loop of dynamic bodies, or holds "
                                "them in place once more, the sweeps hold only the point.");
constexpr Key kGears =
    objects("gears", "gear", "Gears, racks: joints that move in proportion.").once("ratios");
constexpr Key kBelts = objects("belts", "belt", "Closed belts round pulleys, in a plane.");
constexpr Key kSurfaceJoints =
    objects("surface_joints", "surface_joint",
            "Bodies whose surfaces, or curves, touch: they slide or roll.");
constexpr Key kCables =
    objects("cables", "cable", "Cables: they pull and never push.").once("strings");
constexpr Key kPins = objects("pins", "pin", "Points of bodies held at a place.");
constexpr Key kPaths = objects("paths", "path", "Paths of kinematic bodies.").once("drives");
constexpr Key kInstances = objects("instances", "instance", "Copies of prefabs.");
constexpr Key kGenerators =
    object("generators", "generators", "Chains, grids and stairs written out by rule.");

constexpr Key kScene[] = {
    text("$schema", "Where editors find this schema; not read."),
    number("version", "", kVersion, "Of this format.").needed("the version of the format: 1"),
    text<&S::title>("title", "Default: the file's name."),
    vector<&S::world, &World::gravity>("gravity", "m/s^2", "What all bodies fall with.")
        .or_else(0, -9.81, 0),
    number<&S::step>("step", "s", kStep, "Length of one step.").or_else(1.0 / 60),
    flag<&Recipe::plane>(
        "plane",
        "Whether what stays in the plane of x and y is solved by \"planar\", which is cheaper: "
        "each island of joints, where all that is solid stays there; a warning tells why another "
        "does not. Bodies with a solver of their own keep it.")
        .or_else(false),
    whole<&S::substeps>("substeps", 1, 1000, "Equal parts each step is taken in.").or_else(1),
    number<&S::duration>("duration", "s", kDuration, "How long the scene runs.").or_else(5),
    number<&S::drift_bound>(
        "drift_bound", "", kPositive,
        "Joint gap that counts as failure, as a fraction of the island's size. Default: what the "
        "solvers promise, 1e-12, or 1e-5 where joints of \"auto\" close loops.")
        .without_default(),
    of_object("collision", ValueType::object_or_flag, "collision",
              "Of all bodies with shapes that say nothing of it. Default: nothing is solid."),
    row("collision_groups", ValueType::group_names, "",
        "Names for groups: the first is bit 0, and so on."),
    object("solver", "solver", "Settings of all islands that name none."),
    objects("materials", "material", "What surfaces look like."),
    objects("surfaces", "surface", "NURBS surfaces that shapes name."),
    objects("curves", "curve", "Curves that surface joints name."),
    objects("material_pairs", "material_pair", "What two materials are to each other."),
    object("defaults", "defaults",
           "What bodies, joints, cables and pins of this file are unless they or their class say "
           "otherwise."),
    objects("classes", "class", "Named sets of keys that bodies, joints, cables and pins take."),
    kBodies,
    kJoints,
    kGears,
    kBelts,
    kSurfaceJoints,
    kCables,
    kPins,
    kPaths,
    kInstances,
    kGenerators,
    objects(
        "laminas", "lamina",
        "Planar parts held or pushed by fingers, so slowly that inertia does not count. Each is a "
        "body of its name, solved by \"quasistatic\"; its fingers are bodies NAME/FINGER."),
    objects("events", "event", "What is done to it while it runs, by time."),
    objects("prefabs", "prefab", "Named groups to copy; they do nothing by themselves."),
    object<&View::camera>("camera", "camera", "Where pictures are taken from."),
    object<&View::light>("light", "light", "Sun and sky."),
    of_object<read_ground>("ground", ValueType::object_or_flag, "ground",
                           "The drawn ground, or whether there is one. It stops nothing."),
    object<&S::output>("output", "output",
                       "What pictures and videos are like unless the command line says otherwise."),
};

constexpr Key kPrefabEvents =
    objects("events", "event",
            "What is done to its parts while it runs: push, impulse, pull, cut, motor, drive and "
            "winch. Each copy has its own; time_offset does not shift them.");
constexpr Key kPrefab[] = {
    needed_name(),
    reference("file", "the path of a scene file",
              "A scene file that holds the prefab instead: its bodies and what ties, moves and "
              "happens to them, with its own materials, classes, defaults, collision and prefabs. "
              "Its other keys are not read. The path starts from this file's folder."),
    kBodies,
    kJoints,
    kGears,
    kBelts,
    kSurfaceJoints,
    kCables,
    kPins,
    kPaths,
    kInstances,
    kGenerators,
    kPrefabEvents,
};
constexpr Exclusive kPrefabPairs[] = {
    {"file",
     "bodies joints gears belts surface_joints cables pins paths instances generators events"}};

}  // namespace

constinit const KeySet scene{
    "scene", "A scene: SI units, +Y up, right-handed; keys in _deg are degrees.", kScene};
constinit const KeySet prefab{
    "prefab",
    "A group of bodies with all that ties and moves them, in a frame of its own. \"world\" in it "
    "is what never moves. It may hold instances of other prefabs.",
    kPrefab, kPrefabPairs};

}  // namespace pantin::detail::keys
