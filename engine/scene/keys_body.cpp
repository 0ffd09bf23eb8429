// Keys of bodies, of chains of them, and of what holds and moves them.
#include <limits>

#include "engine/scene/keys.hpp"

namespace pantin::detail::keys {
namespace {

using namespace rows;

constexpr std::string_view kMotions[] = {"dynamic", "fixed", "kinematic"};
constexpr std::string_view kOldMotions[] = {"", "", "driven"};
constexpr std::string_view kPinKinds[] = {"exact", "spring"};
constexpr std::string_view kBodyOrWorld = "the name of a body, or \"world\"";

// What a body and the links of a chain both have.
constexpr Key kShape = object("shape", "shape", "The body's one shape.");
constexpr Key kShapes =
    objects("shapes", "shape", "Several shapes. Where they overlap their mass counts twice.");
constexpr Key kDensity =
    number("density", "kg/m^3", kWeight, "Of all shapes that name none. Not beside mass.")
        .or_else(1000);
constexpr Key kMass = number("mass", "kg", kWeight,
                             "With shapes, their inertia is scaled to it. Alone it makes a point "
                             "mass, which only what holds its centre may be tied to: balls, "
                             "distances, springs, cables and pins.")
                          .expecting("a mass, or a shape that tells it");
constexpr Key kInertia =
    row("inertia", ValueType::inertia, "kg m^2",
        "About the mass centre, axes of the own frame: three principal moments, or the six entries "
        "xx, yy, zz, xy, xz, yz of the tensor (off-diagonal entries with the sign they have in the "
        "matrix). No moment may exceed the sum of the other two. Default: from the shapes.")
        .expecting("an inertia, or a shape that tells it");
constexpr Key kCentre =
    vector("centre_of_mass", "m", "In the own frame. Default: from the shapes.");
constexpr Key kDrag =
    number("drag", "1/s", kNotNegative, "Rate c of the damping exp(-c t) of all motion.")
        .or_else(0);
constexpr Key kGravityScale =
    number("gravity_scale", "", kAnyNumber, "Part of gravity that the body feels.").or_else(1);
constexpr Key kSolver =
    object("solver", "solver",
           "Solver settings for this island; what is absent is as in the scene's solver.");
constexpr Key kCollision = of_object("collision", ValueType::object_or_flag, "collision",
                                     "Whether the body's shapes are solid, and how. What is absent "
                                     "is as the scene says.");

constexpr Key kBody[] = {
    needed_name(),
    kClass,
    kParent,
    kShape,
    kShapes,
    reference("material", "the name of a material", "Material of all shapes that name none."),
    kDensity,
    kMass,
    kInertia,
    kCentre,
    kPosition,
    kRotation,
    kRotationDeg,
    vector("velocity", "m/s", "Of the mass centre at the start.").or_else(0),
    vector("angular_velocity", "rad/s", "At the start, axes of the frame around the body.")
        .or_else(0),
    kDrag,
    kGravityScale,
    word("motion", kMotions,
         "dynamic: by forces and joints. fixed: never. kinematic: along a path, or by live calls.")
        .once_words(kOldMotions)
        .or_else(0),
    kSolver,
    kCollision,
};
constexpr auto kBodyClass = shared_keys<kBody, 3>("name class parent");
constexpr Exclusive kBodyPairs[] = {{"shape", "shapes"}, {"density", "mass"}};

constexpr Key kChain[] = {
    needed_name(),
    kClass,
    whole("links", 1, std::numeric_limits<int>::max(),
          "How many; they are called \"name/0\", \"name/1\", ..."),
    number("length", "m", kSize, "Of one link from joint to joint."),
    vector("start", "m", "The upper end.").or_else(0),
    direction("direction", "From start onwards.").or_else(0, -1, 0),
    vector(
        "end", "m",
        "The other end instead of a direction; the chain lies on an arc if it is longer than the "
        "way."),
    direction("sag", "Where such an arc hangs to.").or_else(0, -1, 0),
    reference("attach", kBodyOrWorld, "What the start is jointed to. Default: nothing."),
    reference("end_attach", kBodyOrWorld, "What the end is jointed to. Default: nothing."),
    kShape,
    kShapes,
    reference("material", "the name of a material", "Material of all shapes that name none."),
    row("materials", ValueType::references, "", "Taken in turn, link by link, for all shapes."),
    kDensity,
    kMass,
    kInertia,
    kCentre,
    number("mass_ratio", "", kPositive, "Mass of each link over that of the one before.")
        .or_else(1),
    number("tip_mass_factor", "", kPositive, "The last link's mass is multiplied by this.")
        .or_else(1),
    vector("velocity", "m/s", "Of the chain's middle at the start.").or_else(0),
    vector("angular_velocity", "rad/s", "Of the chain as one rigid thing about its middle.")
        .or_else(0),
    kDrag,
    kGravityScale,
    kSolver,
    kCollision,
    row("path", ValueType::points, "m",
        "Where the joints are, in place of links, length, start, direction, end and sag: one link "
        "from each point to the next."),
    flag(
        "closed",
        "Joint the last link to the first. Equal links lie around a circle, the first along "
        "direction, the next ones towards sag; of a path the last link returns to the first point. "
        "That last joint is a ball.")
        .or_else(false),
    word(
        "kind", kWords<is_of_chains>,
        "Of the joints. A hinge turns about the links' own z; otherwise the joint axes have x "
        "along "
        "the chain and y along that z. Q = 1 where the chain is straight; where it is attached, at "
        "the start.")
        .or_else(0),
    direction("axis",
              "Where the links' own z point as nearly as they can. Default: across the plane in "
              "which the chain bends; of a straight chain whatever is left by the shortest turn "
              "from -y to its direction."),
    object("limits", "limits", "Of all joints, where it is attached too."),
    object("drive", "joint_drive", "Of all joints, where it is attached too."),
    object("spring", "spring", "Of all joints that are hinges or universal.").of_kinds(acts),
    object("friction", "friction", "Likewise.").of_kinds(acts),
    object("motor", "motor", "Likewise.").of_kinds(acts),
};
constexpr Exclusive kChainPairs[] = {{"path", "links length start direction end sag"},
                                     {"direction", "end"},
                                     {"shape", "shapes"},
                                     {"material", "materials"},
                                     {"density", "mass"}};
constexpr AnyOf kChainNeeds[] = {
    {"links path", "found no \"links\", expected a number of links"},
    {"length path", "found no \"length\", expected the length of one link in m"}};

constexpr Key kEndA = reference("a", kBodyOrWorld,
                                "Name of a body of this scene or prefab, \"instance/body\" or "
                                "\"chain/0\"; \"world\" is what never moves.")
                          .needed(kBodyOrWorld);
constexpr Key kEndB =
    reference("b", kBodyOrWorld, "Likewise, the other body.").needed(kBodyOrWorld);

constexpr Key kGuide[] = {
    reference("body", kBodyOrWorld,
              "What the ring or the pulley is fixed to; \"world\" never moves.")
        .needed(kBodyOrWorld),
    vector("point", "m",
           "Ring, or centre of the pulley, at the start, in the frame of the scene or prefab."),
    vector("anchor", "m", "The same in the body's own frame. Default: its origin."),
    number("radius", "m", kNotNegative, "Of the pulley, to the middle of the cable; 0: a ring.")
        .or_else(0),
    vector(
        "axis", "",
        "Of the pulley, in the frame of the scene or prefab: from a to b the cable runs round it "
        "anticlockwise, as seen from where it points."),
    whole("turns", 0, 1000, "Whole turns round the pulley at the start, beside what is seen.")
        .or_else(0),
};
constexpr Exclusive kGuidePairs[] = {{"point", "anchor"}};
constexpr Beside kGuidePartners[] = {
    {"axis", "radius", "found \"axis\" without \"radius\", expected the pulley's radius too"},
    {"turns", "radius", "found \"turns\" without \"radius\", expected the pulley's radius too"}};

constexpr Key kCable[] = {
    own_name("Default \"a-b\"."),
    kClass,
    kEndA,
    kEndB,
    vector("point_a", "m",
           "Where the cable is tied to a, at the start, in the frame of the scene or prefab."),
    vector("point_b", "m", "Where the cable is tied to b, likewise."),
    vector("anchor_a", "m", "Where the cable is tied, in a's own frame. Default: its origin."),
    vector("anchor_b", "m", "Where the cable is tied, in b's own frame. Default: its origin."),
    objects(
        "over", "cable_guide",
        "Rings that the cable runs through and pulleys that it runs round, from a to b, without "
        "friction. Solver \"lagrangian\"."),
    number("length", "m", kSize, "Default: the distance at the start, over the guides."),
    number("slack", "", kPositive, "Length as a multiple of the distance at the start.").or_else(1),
    number("compliance", "m/N", kNotNegative, "How far it stretches under load.").or_else(0),
};
constexpr auto kCableClass = shared_keys<kCable, 4>("name class a b");
constexpr Exclusive kCablePairs[] = {
    {"point_a", "anchor_a"}, {"point_b", "anchor_b"}, {"length", "slack"}};

constexpr Key kPin[] = {
    own_name("Default \"body-pin\"."),
    kClass,
    reference("body", "the name of a body", "A dynamic body.").needed("the name of a body"),
    vector("point", "m", "The held point at the start, in the frame of the scene or prefab."),
    vector("anchor", "m", "The held point in the body's own frame. Default: its origin."),
    vector("target", "m",
           "Where the point is held, in the frame of the scene or prefab. Default: where it is at "
           "the start."),
    reference("to", "the name of a body",
              "Another body that is held on to: target is where its point lies at the start. "
              "Default: none, a place that never moves."),
    vector("anchor_to", "m",
           "Where the point is held in the own frame of that body, instead of target."),
    whole("priority", -1'000'000, 1'000'000, "Of several exact pins the highest is met exactly.")
        .or_else(0),
    word("kind", kPinKinds,
         "exact: goes to the target whatever it weighs. spring: drawn by a spring.")
        .once("grip")
        .or_else(0),
    number("stiffness", "N/m", kPositive, "Of a spring.").or_else(200),
    number("damping", "N s/m", kNotNegative,
           "Of a spring's damper; critical for a mass alone: 2 sqrt(stiffness mass).")
        .or_else(0),
};
constexpr auto kPinClass = shared_keys<kPin, 3>("name class body");
constexpr Exclusive kPinPairs[] = {{"point", "anchor"}, {"target", "anchor_to"}};
constexpr Beside kPinPartners[] = {
    {"anchor_to", "to", "found \"anchor_to\" without \"to\", expected the body it lies in"}};

constexpr Key kKeyframe[] = {
    number("time", "s", kTime, "When.").needed("a time in seconds"),
    vector("position", "m", "Default: where the body starts."),
    row("rotation", ValueType::quaternion, "",
        "Quaternion [x, y, z, w]. Default: as the body starts."),
    kRotationDeg,
};

}  // namespace

constinit const KeySet body{
    "body",
    "A rigid body. Its own frame is the one its pose, shapes and anchors are given in; the mass "
    "centre may lie anywhere in it. A dynamic body needs shapes, or mass and inertia; with a mass "
    "alone it is a point mass.",
    kBody, kBodyPairs};
constinit const KeySet body_class{
    "body_class", "What bodies of a class are, and links of chains, unless they say otherwise.",
    kBodyClass, kBodyPairs};
constinit const KeySet chain{
    "chain",
    "Links jointed end to end: equal ones laid out by links and length, or along a path. A link's "
    "own frame is at its middle, -y along the chain; its shapes, or mass and inertia, are given "
    "there.",
    kChain, kChainPairs, kChainNeeds};
constinit const KeySet cable_guide{
    "cable_guide", "A ring or a pulley that a cable is led over.", kGuide, kGuidePairs, {},
    kGuidePartners};
constinit const KeySet cable{"cable", "A cable: it pulls, never pushes.", kCable, kCablePairs};
constinit const KeySet cable_class{"cable_class",
                                   "What cables of a class are unless they say otherwise.",
                                   kCableClass, kCablePairs};
constinit const KeySet pin{"pin", "A nail, or a dragging hand.", kPin, kPinPairs, {}, kPinPartners};
constinit const KeySet pin_class{"pin_class", "What pins of a class are unless they say otherwise.",
                                 kPinClass, kPinPairs};
constinit const KeySet keyframe{"keyframe", "A pose at a time.", kKeyframe};

}  // namespace pantin::detail::keys
