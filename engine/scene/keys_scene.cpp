// Keys of a scene's head, its groups and its generators.
#include "engine/scene/keys.hpp"
#include "engine/world/settings.hpp"

namespace pantin::detail::keys {
namespace {

using namespace rows;

constexpr SolverSettings kSettings;  // what a scene that says nothing has

constexpr std::string_view kSolvers[] = {"auto",       "sweep",  "shake2",     "procedural",
                                         "lagrangian", "planar", "quasistatic"};
constexpr std::string_view kOldSolvers[] = {"", "", "", "paper", "", "", ""};
constexpr std::string_view kStabilisations[] = {"projection", "baumgarte", "none"};
constexpr std::string_view kReluctances[] = {"inertia_over_mass", "literal_step"};

constexpr Range kVersion{1, 1, "1, the version this program reads"};
constexpr Range kStep{0, 1, "a step above 0, at most 1 s", true};
constexpr Range kDuration{0, 1e6, "a duration above 0, at most 1e6 s", true};
constexpr Range kOpening{1, 170, "an angle from 1 to 170 degrees"};
constexpr Range kStrength{0, 1000, "a number from 0 to 1000"};
constexpr Range kLit{0, 100, "a number from 0 to 100"};
constexpr Range kPixels{16, 16384, "a whole number of pixels from 16 to 16384"};
constexpr Range kRate{0, 1000, "a number of frames a second above 0, at most 1000", true};
constexpr Range kCopies{1, 1e6, "a whole number from 1 to 1000000"};

// What a scene and a prefab both have.
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
    text("title", "Default: the file's name."),
    vector("gravity", "m/s^2", "What all bodies fall with.").or_else(0, -9.81, 0),
    number("step", "s", kStep, "Length of one step.").or_else(1.0 / 60),
    flag("plane",
         "Whether what stays in the plane of x and y is solved by \"planar\", which is cheaper: "
         "each island of joints, where all that is solid stays there; a warning tells why another "
         "does not. Bodies with a solver of their own keep it.")
        .or_else(false),
    whole("substeps", 1, 1000, "Equal parts each step is taken in.").or_else(1),
    number("duration", "s", kDuration, "How long the scene runs.").or_else(5),
    number(
        "drift_bound", "", kPositive,
        "Joint gap that counts as failure, as a fraction of the island's size. Default: what the "
        "solvers promise, 1e-12, or 1e-5 where joints of \"auto\" close loops."),
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
    object("camera", "camera", "Where pictures are taken from."),
    object("light", "light", "Sun and sky."),
    of_object("ground", ValueType::object_or_flag, "ground",
              "The drawn ground, or whether there is one. It stops nothing."),
    object("output", "output",
           "What pictures and videos are like unless the command line says otherwise."),
};

constexpr Key kSolver[] = {
    word(
        "type", kSolvers,
        "auto: dynamics, stable at any step. sweep: kinematic posing. shake2: accurate at small "
        "steps. procedural: the rotation rule as printed by Lee et al. (2000), for comparison. "
        "lagrangian: exact joints of "
        "every kind, by forces of constraint. planar: bodies that stay in the plane of x and y, by "
        "Box2D, with joints closed exactly. quasistatic: laminas, which have it without being "
        "told.")
        .once_words(kOldSolvers)
        .or_else(0),
    number("rotation_stiffness", "", kNotNegative, "Of sweep: 0 swings, large values slide.")
        .or_else(kSettings.rotation_stiffness)
        .once("turn_stiffness"),
    number("calm_angle_deg", "degrees", kPositive,
           "A body that turns farther in a step makes it less accurate and more stable. Default "
           "28.6."),
    number("reservoir_time", "s", kNotNegative,
           "How long numerical losses may be given back; 0 never.")
        .or_else(kSettings.reservoir_time),
    whole("active_set_iterations", 1, 64,
          "Most solves of a step, to find which limits, contacts and drives are active.")
        .or_else(kSettings.active_set_iterations)
        .once("passes"),
    number(
        "sleep_speed", "m/s", kNotNegative,
        "What rests on fixed things and moves no faster for half a second falls asleep; heaps of "
        "jointed bodies as soon as no body but a swaying arm left its place for a second (2.5 s "
        "times this, an arm 40 s times this); 0 never.")
        .or_else(kSettings.sleep_speed)
        .once("rest_speed"),
    whole("sweeps", 1, 10'000, "Most relaxation sweeps over several held points.")
        .or_else(kSettings.sweeps)
        .once("rounds"),
    number("tolerance", "", kPositive,
           "Residual of a held point that counts as met, as a fraction of the island's size.")
        .or_else(kSettings.tolerance),
    number("stall_drop", "", kUnit, "Least relative gain of a sweep; below it the sweeps end.")
        .or_else(kSettings.stall_drop),
    flag("tension_stiffness", "Off only to show what it is for.")
        .or_else(kSettings.tension_stiffness),
    flag("limiter", "The energy limiter; off only to show what it is for.")
        .or_else(kSettings.limiter),
    word("procedural_reluctance", kReluctances, "Of procedural: which length^2 h the rule takes.")
        .or_else(0)
        .once("paper_reluctance"),
    word("integrator", kIntegratorNames,
         "Of lagrangian. euler: order 1, never blows up. rattle: symplectic, order 2, energy "
         "bounded "
         "in long runs. rk4: Runge-Kutta, order 4. implicit: order 2, stiff springs do not limit "
         "the "
         "step. radau: order 5, likewise.")
        .or_else(Real(kSettings.integrator)),
    word("stabilisation", kStabilisations,
         "Of lagrangian: what is done about joints that drift apart. projection: back onto them "
         "after every step. The others are for comparison.")
        .or_else(0),
    number("baumgarte", "", kNotNegative,
           "Of lagrangian, with that stabilisation. euler: part of a gap closed in a step, at most "
           "1; 0 stands for 0.2. Otherwise a rate, 1/s; 0 stands for 5.")
        .or_else(kSettings.baumgarte),
    number("step_tolerance", "", kPositive,
           "Of lagrangian with rk4 or radau: steps are divided so that each errs by less, in m, "
           "rad, m/s and "
           "rad/s. Default: not divided."),
    number("damping_ratio", "", kUnit,
           "Of lagrangian with implicit: what is left of the fastest vibrations after a step.")
        .or_else(kSettings.damping_ratio),
};

constexpr Key kMaterial[] = {
    needed_name(),
    row("colour", ValueType::colour, "", "Default a light grey.").within(kUnit).once("color"),
    number("roughness", "", kUnit, "0 mirrors, 1 is chalk.").or_else(0.5),
    number("metallic", "", kUnit, "0 or 1.").or_else(0),
};

constexpr Key kOfBodies =
    object("body", "body_class",
           "Of bodies, and of the links of chains: shapes, mass, drag, gravity_scale, solver and "
           "collision.");
constexpr Key kOfJoints =
    object("joint", "joint_class",
           "Of joints, and of those of chains: kind, limits, drive, spring, friction and motor. "
           "What a joint's kind cannot have is left out.");
constexpr Key kOfCables = object("cable", "cable_class", "Of cables.");
constexpr Key kOfPins = object("pin", "pin_class", "Of pins.");
constexpr Key kDefaults[] = {kOfBodies, kOfJoints, kOfCables, kOfPins};
constexpr Key kObjectClass[] = {
    needed_name(),
    reference("class", "the name of a class",
              "Name of a class that stands above: what this one does not say is as that one says."),
    kOfBodies,
    kOfJoints,
    kOfCables,
    kOfPins,
};

constexpr Key kMaterialPair[] = {
    reference("a", "the name of a material", "One of the two.").needed("the name of a material"),
    reference("b", "the name of a material", "The other, or the same.")
        .needed("the name of a material"),
    number("friction", "", kNotNegative, "Coulomb's coefficient."),
    number("restitution", "", kUnit, "Part of the approach given back."),
    number("rolling", "m", kNotNegative, "Most torque against rolling, over the normal force."),
    number("spinning", "m", kNotNegative,
           "Most torque against turning about the normal, over the normal force."),
};
constexpr AnyOf kMaterialPairNeeds[] = {
    {"friction restitution rolling spinning",
     "found nothing about the two, expected friction, restitution, rolling or spinning"}};

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

constexpr Key kOfPrefab =
    reference("prefab", "the name of a prefab", "Name of a prefab.").needed("the name of a prefab");
constexpr Key kItsSolver = object("solver", "solver", "Solver settings for all its islands.");

constexpr std::string_view kAxes[] = {"x", "y", "z"};
constexpr Key kMirrored =
    word("mirror", kAxes,
         "Take the mirror image of the prefab: across the plane through its origin that this axis "
         "of it is normal to. Names of parts change sides. Default: no mirror image.");

constexpr Key kInstance[] = {
    needed_name(),
    kOfPrefab,
    kParent,
    kPosition,
    kRotation,
    kRotationDeg,
    kMirrored,
    number("time_offset", "s", kTime, "Its paths and drives run ahead by this time.").or_else(0),
    kItsSolver,
};

constexpr Key kGenerated[] = {
    objects("chains", "chain", "Chains of equal links."),
    objects("grids", "grid", "Prefabs in rows."),
    objects("stairs", "stairs", "Flights of steps."),
    objects("mirrors", "mirror", "Left and right: bodies copied across a plane."),
};

constexpr Key kMirror[] = {
    row("bodies", ValueType::references, "",
        "Names of bodies of this scene or prefab, or of chains, instances and grids: all of "
        "theirs. "
        "Each name has a side: \"left\" or \"right\" in it, or \"l\" or \"r\" as in \"arm_l\"; the "
        "image has the other.")
        .needed("the names of the bodies"),
    word("axis", kAxes, "What the plane is normal to, in the frame of the scene or prefab.")
        .or_else(0),
    number("offset", "m", kAnyNumber, "Where the plane is along it.").or_else(0),
};

constexpr Key kGrid[] = {
    needed_name(),
    kOfPrefab,
    row("count", ValueType::wholes, "",
        "Copies along x, y and z; they are called \"name/0\", \"name/1\", ..., x first, then z, "
        "then y.")
        .holding(3)
        .within(kCopies)
        .needed("how many copies along x, y and z"),
    vector("spacing", "m", "Between neighbours along x, y and z.").or_else(1),
    kParent,
    vector("position", "m", "Where the grid's middle is.").or_else(0),
    kRotation,
    kRotationDeg,
    kMirrored,
    number("time_offset", "s", kTime,
           "The paths and drives of each copy run ahead of the one before by this time.")
        .or_else(0),
    kItsSolver,
};

constexpr Key kStairs[] = {
    needed_name(),
    whole("count", 1, 10'000, "How many steps.").needed("a number of steps"),
    number("width", "m", kSize, "Along z.").needed(kSize.words),
    number("rise", "m", kSize, "Height of one step.").needed(kSize.words),
    number("run", "m", kSize, "Depth of one step.").needed(kSize.words),
    kPosition,
    kRotation,
    kRotationDeg,
    rows::kMaterial,
    of_object("collision", ValueType::object_or_flag, "collision",
              "Default: solid, as the scene says of how."),
};

constexpr Key kCollision[] = {
    number("friction", "", kNotNegative,
           "Coulomb's coefficient; of two bodies the geometric mean counts.")
        .or_else(0.5),
    number("restitution", "", kUnit,
           "Part of the approach given back; of two bodies the larger counts.")
        .or_else(0),
    number("rolling", "m", kNotNegative,
           "Most torque against rolling, over the normal force; of two bodies the larger counts.")
        .or_else(0),
    number("spinning", "m", kNotNegative,
           "Most torque against turning about the normal, over the normal force; likewise.")
        .or_else(0),
    vector("surface_velocity", "m/s",
           "How the surface moves on the body, as a belt's does, in the body's own frame.")
        .or_else(0),
    vector("one_way", "",
           "Outwards of the side that is solid, in the body's own frame: what comes from elsewhere "
           "passes until it has left. Default: all sides are solid.")
        .or_else(0),
    row("groups", ValueType::groups, "", "What the body is. Default: [0]."),
    row("with", ValueType::groups, "", "What it touches; both bodies have to agree. Default: all."),
    flag("others",
         "Whether it touches dynamic bodies of other islands; of two bodies one has to say so.")
        .or_else(true),
    flag("self", "Whether it touches dynamic bodies of its own island; both have to say so.")
        .or_else(true),
    flag("sensor",
         "Whether it only reports what overlaps it and pushes nothing. Every body whose groups "
         "agree "
         "is seen, dynamic ones whatever their \"others\" too.")
        .or_else(false),
};

constexpr Key kCamera[] = {
    vector("eye", "m", "Where it stands."),
    vector("target", "m", "What it looks at; not the eye."),
    number("field_of_view_deg", "degrees", kOpening, "From bottom to top. Default 40.1."),
    flag("automatic",
         "Frame the whole scene, looking the way eye and target say. Default: true unless both are "
         "given."),
};

constexpr Key kLight[] = {
    direction("direction", "The way the sun's light goes."),
    row("colour", ValueType::colour, "", "Of the sun.").within(kLit).once("color"),
    number("strength", "", kStrength, "Of the sun.").or_else(3),
    row("sky", ValueType::colour, "", "Light from above.").within(kLit),
    row("ground", ValueType::colour, "", "Light from below.").within(kLit),
};

constexpr Key kGround[] = {
    flag("visible", "Draw it.").or_else(true),
    number("height", "m", kAnyNumber, "Where it lies.").or_else(0),
};

constexpr Key kOutput[] = {
    row("size", ValueType::wholes, "pixels", "Width and height.")
        .holding(2)
        .within(kPixels)
        .or_else(1280, 720, 0),
    number("fps", "", kRate, "Frames a second.").or_else(60),
};

}  // namespace

constinit const KeySet scene{
    "scene", "A scene: SI units, +Y up, right-handed; keys in _deg are degrees.", kScene};
constinit const KeySet solver{"solver", "Solver settings.", kSolver};
constinit const KeySet material{"material", "A surface.", kMaterial};
constinit const KeySet material_pair{
    "material_pair",
    "What shapes of two materials are to each other where they touch. What is not said is combined "
    "from the two bodies, as their \"collision\" says.",
    kMaterialPair,
    {},
    kMaterialPairNeeds};
constinit const KeySet defaults{
    "defaults",
    "What holds unless something else is said: the object itself comes first, then its class, then "
    "these.",
    kDefaults};
constinit const KeySet object_class{
    "class",
    "A named set of keys. A body takes those under \"body\", a joint those under \"joint\" and so "
    "on; a value is taken whole, an object too.",
    kObjectClass};
constinit const KeySet prefab{"prefab",
                              "A group of bodies with all that ties and moves them, in a frame of "
                              "its own. \"world\" in it is "
                              "what never moves. It may hold instances of other prefabs.",
                              kPrefab, kPrefabPairs};
constinit const KeySet instance{"instance", "A copy of a prefab.", kInstance};
constinit const KeySet generators{"generators", "Rules that write many things out.", kGenerated};
constinit const KeySet grid{"grid", "Copies of a prefab in rows.", kGrid};
constinit const KeySet stairs{
    "stairs",
    "A fixed body of steps that rise along its x axis, as wide along z. Its origin is the middle "
    "of "
    "the first step's lower front edge; every step reaches down to the floor.",
    kStairs};
constinit const KeySet mirror{
    "mirror",
    "Copies bodies across a plane with all joints, cables, pins and gears that tie them to each "
    "other, to the world or to bodies that have no image: left becomes right. A hinge's image "
    "turns "
    "the mirrored way through the same angles.",
    kMirror};
constinit const KeySet collision{
    "collision",
    "What a body touches: every other one whose groups agree, but for bodies of one joint, which "
    "never touch.",
    kCollision};
constinit const KeySet camera{"camera", "A camera.", kCamera};
constinit const KeySet light{"light", "Sun and sky.", kLight};
constinit const KeySet ground{"ground", "The ground grid.", kGround};
constinit const KeySet output{"output", "Picture defaults.", kOutput};

}  // namespace pantin::detail::keys
