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
                                "Joints. If one closes a loop of dynamic bodies, or fixes them "
                                "once more, sweep solvers constrain only its point.");
constexpr Key kGears =
    objects("gears", "gear", "Gears and racks, which couple two joints.").once("ratios");
constexpr Key kBelts = objects("belts", "belt", "Closed belts round pulleys, in a plane.");
constexpr Key kSurfaceJoints =
    objects("surface_joints", "surface_joint",
            "Surface joints: bodies that slide or roll on each other by surfaces or curves.");
constexpr Key kCables =
    objects("cables", "cable", "Cables, which pull and never push.").once("strings");
constexpr Key kPins = objects("pins", "pin", "Pins, which hold points of bodies at a target.");
constexpr Key kPaths = objects("paths", "path", "Paths of kinematic bodies.").once("drives");
constexpr Key kPoses = objects(
    "poses", "pose",
    "Poses of bodies at the start, given once everything else is built: joints, cables and other "
    "ties keep what follows from the poses of the bodies themselves. `pantin assemble --out` "
    "writes them.");
constexpr Key kFree = of_object(
    "free", ValueType::objects_or_references, "free_number",
    "Numbers of laws that `pantin assemble` may change together with the poses, as little as "
    "possible: \"joints/3/length\", \"surfaces/cam/points/2/1\".");
constexpr Key kInstances = objects("instances", "instance", "Copies of prefabs.");
constexpr Key kGenerators = object("generators", "generators",
                                   "Generators of chains, grids, rings, stairs and mirror images.");

constexpr Key kScene[] = {
    text("$schema", "Where editors find this schema; not read."),
    number("version", "", kVersion, "Of this format.").needed("the version of the format: 1"),
    word("units", kLengthUnits,
         "Unit of length of this file. mm: m stands for mm in the unit of every key, so that a "
         "torque is in N mm, a stiffness in N/mm, an inertia in kg mm^2; densities stay in "
         "kg/m^3. Results are in SI units whatever the file has.")
        .or_else(0),
    text<&S::title>("title", "Default: the file's name."),
    vector<&S::world, &World::gravity>("gravity", "m/s^2", "Acceleration of gravity.")
        .or_else(0, -9.81, 0),
    number<&S::step>("step", "s", kStep, "Length of one step.").or_else(1.0 / 60),
    flag<&Recipe::plane>(
        "plane",
        "Whether islands that move in the xy plane are solved by \"planar\", which is faster: all "
        "colliding bodies must move in that plane too; a warning tells why an island does not. "
        "Bodies with a solver of their own keep it.")
        .or_else(false),
    whole<&S::substeps>("substeps", 1, 1000,
                        "Number of equal parts that each step is divided into.")
        .or_else(1),
    number<&S::budget_ms>("budget_ms", "ms", kNotNegative,
                          "Time in which a step should be computed. Beyond it jointed bodies "
                          "that neither collide nor hang on cables wait for up to three steps, and "
                          "bodies in contact take fewer substeps. Results then depend on the "
                          "machine. 0: none.")
        .or_else(0),
    number<&Recipe::error>(
        "error", "", kUnit,
        "Error of the motion that is accepted, as a fraction of its size: \"auto\" then chooses "
        "the cheapest model for each group of bodies that cannot meet another: \"planar\" for "
        "loops in the xy plane, and from 0.01 on for free bodies that collide there. The step "
        "stays as it is; `pantin tune` chooses it, too. 0: none is given.")
        .or_else(0),
    number<&S::duration>("duration", "s", kDuration, "Duration of the scene.").or_else(5),
    number<&S::drift_bound>(
        "drift_bound", "", kPositive,
        "Joint gap that counts as failure, as a fraction of the island's size. Default: the "
        "accuracy of the solvers, 1e-12, or 1e-5 where joints of \"auto\" close loops.")
        .without_default(),
    of_object("collision", ValueType::object_or_flag, "collision",
              "Default of all bodies with shapes. Default: nothing collides."),
    row("collision_groups", ValueType::group_names, "",
        "Names for groups: the first is bit 0, and so on."),
    object("solver", "solver", "Settings of all islands without their own."),
    objects("materials", "material", "Appearance of surfaces."),
    objects("surfaces", "surface", "NURBS surfaces that shapes name."),
    objects("curves", "curve", "Curves that surface joints name."),
    objects("material_pairs", "material_pair", "Contact parameters of pairs of materials."),
    object("defaults", "defaults",
           "Default values of bodies, joints, cables and pins of this file, unless they or their "
           "class give others."),
    objects("classes", "class", "Named sets of keys that bodies, joints, cables and pins take."),
    kBodies,
    kJoints,
    kGears,
    kBelts,
    kSurfaceJoints,
    kCables,
    kPins,
    kPaths,
    kPoses,
    kFree,
    kInstances,
    kGenerators,
    objects("laminas", "lamina",
            "Planar parts held or pushed by fingers quasistatically. Each is a body of its name, "
            "solved by \"quasistatic\"; its fingers are bodies NAME/FINGER."),
    objects("events", "event", "Timed changes while the scene runs."),
    objects("sensors", "sensor",
            "Quantities that records (`pantin run --record`) and programs read."),
    objects("prefabs", "prefab", "Named groups to instantiate; they have no effect by themselves."),
    object<&View::camera>("camera", "camera", "Viewpoint of pictures."),
    object<&View::light>("light", "light", "Sun and sky."),
    of_object<read_ground>("ground", ValueType::object_or_flag, "ground",
                           "The drawn ground, or whether there is one. It does not collide."),
    object<&S::output>("output", "output",
                       "Defaults of pictures and videos; the command line overrides them."),
};

constexpr Key kPrefabEvents =
    objects("events", "event",
            "Timed changes to its objects: push, impulse, pull, cut, motor, drive and winch. Each "
            "copy has its own; time_offset does not shift them.");
constexpr Key kPrefab[] = {
    needed_name(),
    reference("file", "the path of a scene file",
              "A scene file that contains the prefab instead: bodies, joints and other ties, paths "
              "and events, with its own materials, classes, defaults, collision and prefabs. Its "
              "other keys are ignored. The path is relative to this file's folder."),
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
    "scene", "A scene: SI units, or mm for lengths, +Y up, right-handed; keys in _deg are degrees.",
    kScene};
constinit const KeySet prefab{
    "prefab",
    "A group of bodies with their joints, other ties, paths and events, in its own frame. "
    "\"world\" in it is the fixed world. It may contain instances of other prefabs.",
    kPrefab, kPrefabPairs};

}  // namespace pantin::detail::keys
