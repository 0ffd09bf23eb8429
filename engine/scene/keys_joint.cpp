// Keys of joints, of their limits, and of what acts along their freedoms.
#include <algorithm>
#include <array>

#include "engine/scene/keys.hpp"

namespace pantin::detail::keys {
namespace {

using namespace rows;

constexpr std::string_view kBallOnly[] = {"ball"};
constexpr std::string_view kCoordinates[] = {"angle", "travel"};
constexpr std::string_view kOldCoordinates[] = {"turn", "slide"};
constexpr std::string_view kBodyOrWorld = "the name of a body, or \"world\"";

/// One parameter of several kinds may have narrower bounds in some of them.
constexpr Range wider(const Range& a, const Range& b) {
  if (a.least == b.least && a.most == b.most) return a;
  return {std::min(a.least, b.least), std::max(a.most, b.most), "a number that fits the kind"};
}

/// Adds what a kind has of its own to `into`, from `count` on; counts only if there is no room.
constexpr void add_parameters(const JointKindInfo& kind, std::span<Key> into, std::size_t& count) {
  for (const Parameter& p : kind.parameters) {
    Key key = number(p.key, "", range_of(p),
                     p.as_placed ? "Default: as placed." : "Of kinds of joints that have it.");
    if (!p.needed.empty()) key.about = key.expected = p.needed;
    if (!p.never_zero.empty()) key = key.not_zero(p.never_zero);
    Key* same = nullptr;
    for (Key& k : into.first(std::min(count, into.size())))
      if (k.name == p.key) same = &k;
    if (same)
      same->range = wider(same->range, key.range);
    else if (count < into.size())
      into[count++] = key;
  }
}
constexpr auto kAllParameters = [] {
  std::array<Key, 64> keys{};
  std::size_t count = 0;
  for (const JointKindInfo& kind : kJointKindInfos) add_parameters(kind, keys, count);
  return std::pair(keys, count);
}();
constexpr std::size_t kParameterCount = kAllParameters.second;
static_assert(kParameterCount < std::size(kAllParameters.first));

constexpr Key kEveryJoint[] = {
    own_name("Default \"a-b\"."),
    kClass,
    word(
        "kind", kWords<is_of_files>,
        "ball (or spherical): all turns are free. hinge (or revolute): Q turns about x. universal: "
        "Q turns about y of a, then about z of b; x is the shaft. fixed: no turn. The others are "
        "for the solver lagrangian. cylindrical: turns about x and slides along it. prismatic: "
        "slides along x of a. screw: slides along x by pitch for each rad it turns about it. "
        "planar: slides across x, turns about it. distance: two points stay length apart. spring: "
        "a "
        "spring and damper between two points.")
        .or_else(0),
    word("type", kBallOnly, "An older word for \"kind\": \"ball\"."),
    reference("a", kBodyOrWorld,
              "Name of a body of this scene or prefab, \"instance/body\" or \"chain/0\"; \"world\" "
              "is what never moves.")
        .needed(kBodyOrWorld),
    reference("b", kBodyOrWorld, "Likewise, the other body.").needed(kBodyOrWorld),
    vector("anchor", "m", "The shared point at the start, in the frame of the scene or prefab.")
        .of_kinds(is_no_line),
    vector(
        "anchor_a", "m",
        "The point in a's own frame; alone, b's follows from where the bodies lie at the start."),
    vector("anchor_b", "m", "The point in b's own frame; alone, a's follows."),
    direction("axis",
              "The x axis at the start, in the frame of the scene or prefab, of any length: what a "
              "hinge turns about, what a ball twists about, the shaft of a universal joint.")
        .or_else(1, 0, 0)
        .of_kinds(is_no_line),
    direction("across",
              "The y axis, likewise; only its part across the axis counts. Default: [0, 1, 0] "
              "turned the shortest way with x to the axis.")
        .of_kinds(is_no_line),
    direction("axis_a",
              "The x axis in a's own frame instead; b's follows from how the bodies lie at the "
              "start.")
        .of_kinds(is_no_line),
    direction("across_a", "The y axis in a's own frame.").of_kinds(is_no_line),
    direction(
        "axis_b",
        "The x axis in b's own frame; a's follows. Beside axis_a, both acrosses are needed and "
        "Q is what follows.")
        .of_kinds(is_no_line),
    direction("across_b", "The y axis in b's own frame.").of_kinds(is_no_line),
    row("rest", ValueType::joint_turn, "", "Q at the start. Default: none.").of_kinds(is_no_line),
    row("rest_deg", ValueType::joint_turn_deg, "degrees", "The same.").of_kinds(is_no_line),
    object("limits", "limits", "How far it may turn. Default: as far as its kind lets it."),
    object("drive", "joint_drive", "A spring and damper that turn it. Default: none.")
        .of_kinds(is_driven),
    vector("point_a", "m",
           "Where it begins, at the start, in the frame of the scene or prefab. Default: a's "
           "origin.")
        .of_kinds(is_line),
    vector("point_b", "m", "Where it ends, likewise.").of_kinds(is_line),
    object("spring", "spring",
           "Acts on the turn of a hinge, a screw, a cylindrical joint, on the first turn of a "
           "universal one, on the slide of a prismatic one.")
        .of_kinds(acts),
    object("friction", "friction", "Likewise.").of_kinds(acts),
    object("motor", "motor", "Likewise.").of_kinds(acts),
    object("angle", "dof", "Of a cylindrical joint: springs, friction and motors of its rotation.")
        .of_kinds(acts_twice)
        .once("turn"),
    object("travel", "dof",
           "Of a cylindrical joint: springs, friction and motors of its translation.")
        .of_kinds(acts_twice)
        .once("slide"),
};
constexpr auto kJoint = [] {
  std::array<Key, std::size(kEveryJoint) + kParameterCount> keys{};
  std::copy_n(kAllParameters.first.begin(), kParameterCount,
              std::copy(std::begin(kEveryJoint), std::end(kEveryJoint), keys.begin()));
  return keys;
}();
constexpr auto kJointClass = shared_keys<kJoint, 5>("name class type a b");
constexpr Exclusive kJointPairs[] = {{"kind", "type"},
                                     {"anchor", "anchor_a anchor_b"},
                                     {"anchor_a", "point_a"},
                                     {"anchor_b", "point_b"},
                                     {"axis", "axis_a across_a axis_b across_b"},
                                     {"across", "axis_a across_a axis_b across_b"},
                                     {"angle", "spring friction motor"}};
constexpr auto kJointClassPairs = std::span(kJointPairs).subspan(1);  // without the older "type"

constexpr Key kLimits[] = {
    angles("angle", "Of a hinge, cylindrical, screw or planar joint about x: least and most."),
    angles_deg("angle_deg", "The same."),
    angles("twist", "Of a ball about x: least and most."),
    angles_deg("twist_deg", "The same."),
    angle("cone", "Of a ball: how far x may swing, half the cone's opening, 0 to half a turn."),
    angle_deg("cone_deg", "The same."),
    angles(
        "swing",
        "Of a ball: half openings of an elliptic cone, for swings about y and about z, 0 to half "
        "a turn."),
    angles_deg("swing_deg", "The same."),
    angles("first", "Of a universal joint about y of a: least and most."),
    angles_deg("first_deg", "The same."),
    angles("second", "Of a universal joint about z of b: least and most."),
    angles_deg("second_deg", "The same."),
    object("soft", "soft", "A spring before each stop. Default: none."),
    row("travel", ValueType::numbers, "m",
        "Of a cylindrical, prismatic or screw joint: least and most of b's anchor along x from "
        "a's.")
        .holding(2),
    number("restitution", "", kUnit,
           "Part of the speed with which a stop is left again. For the solver lagrangian.")
        .or_else(0),
};
constexpr Exclusive kLimitPairs[] = {{"cone", "swing swing_deg"}, {"cone_deg", "swing swing_deg"}};
constexpr Beside kLimitPartners[] = {
    {"soft",
     "angle angle_deg twist twist_deg cone cone_deg swing swing_deg first first_deg second "
     "second_deg",
     "found \"soft\" without a limit, expected one beside it, whose stops it softens"}};

constexpr Key kSoft[] = {
    angle("zone", "How far before the stop they begin, above 0."),
    angle_deg("zone_deg", "The same."),
    number("stiffness", "N m/rad", kNotNegative, "Of the spring.").or_else(0),
    number("damping", "N m s/rad", kNotNegative, "Of the damper.").or_else(0),
};
constexpr AnyOf kSoftNeeds[] = {
    {"zone zone_deg",
     "found no \"zone\", expected how far before the stop the spring begins, in rad, or "
     "\"zone_deg\""}};

constexpr Key kSpring[] = {
    number("stiffness", "N m/rad", kNotNegative, "Of a slide N/m.").or_else(0),
    number("damping", "N m s/rad", kNotNegative, "Of a slide N s/m.").or_else(0),
    number("rest", "rad", kAnyNumber, "Where it pulls to; of a slide m.").or_else(0),
    angle_deg("rest_deg", "The same, of an angle."),
};
constexpr AnyOf kSpringNeeds[] = {{"stiffness damping",
                                   "found neither \"stiffness\" nor \"damping\", expected one of "
                                   "them: without them a spring does "
                                   "nothing"}};

constexpr Key kFriction[] = {
    number("viscous", "N m s/rad", kNotNegative, "Of a slide N s/m.").or_else(0),
    number("dry", "N m", kNotNegative, "Of a slide N.").or_else(0),
    number("slip", "rad/s", kPositive, "Rate below which dry friction fades; of a slide m/s.")
        .or_else(0.01),
};
constexpr AnyOf kFrictionNeeds[] = {
    {"viscous dry",
     "found neither \"viscous\" nor \"dry\", expected one of them: without them there is no "
     "friction"}};

constexpr Key kMotor[] = {
    number("velocity", "rad/s", kAnyNumber, "The speed it keeps; of a slide m/s."),
    number("velocity_deg", "degrees/s", kDegrees, "The same, of an angle."),
    number("position", "rad", kAnyNumber, "Where it goes; of a slide m."),
    angle_deg("position_deg", "The same, of an angle."),
    number("gain", "", kPositive,
           "Effort for each unit: N m s/rad or N m/rad; of a slide N s/m or N/m.")
        .needed("how hard it corrects what is off: effort for each unit of it"),
    number("damping", "N m s/rad", kNotNegative, "Of a position; of a slide N s/m.").or_else(0),
    number("cap", "N m", kNotNegative, "Its most; of a slide N. Default: any."),
};
constexpr Exclusive kMotorPairs[] = {{"velocity", "position position_deg"},
                                     {"velocity_deg", "position position_deg"}};
constexpr AnyOf kMotorNeeds[] = {
    {"velocity velocity_deg position position_deg",
     "found no \"velocity\", expected the speed it keeps, or the \"position\" it goes to"}};
constexpr Beside kMotorPartners[] = {
    {"damping", "position position_deg",
     "found \"damping\" of a motor that keeps a speed, expected it with \"position\" only"}};

constexpr Key kDof[] = {
    object("spring", "spring", "Default: none."),
    object("friction", "friction", "Default: none."),
    object("motor", "motor", "Default: none."),
};

constexpr Key kGear[] = {
    own_name("Default \"first-second\"."),
    reference("first", "the name of a joint", "Name of a joint of this scene or prefab.")
        .needed("the name of a joint"),
    word("first_coordinate", kCoordinates,
         "Which coordinate of first. Default: angle; of a prismatic joint travel.")
        .once("first_moves")
        .once_words(kOldCoordinates),
    reference("second", "the name of a joint", "Name of another joint.")
        .needed("the name of a joint"),
    word("second_coordinate", kCoordinates, "Likewise of second.")
        .once("second_moves")
        .once_words(kOldCoordinates),
    number("ratio", "", kAnyNumber,
           "Of second for each unit of first: rad/rad, m/rad, rad/m or m/m. Gears that mesh turn "
           "against each other: below 0.")
        .needed("how far the second moves for each unit of the first")
        .not_zero(),
    number("offset", "rad", kAnyNumber, "Of travel m. Default: as placed."),
    angle_deg("offset_deg", "The same, of an angle."),
};

constexpr Key kJointDrive[] = {
    row("target", ValueType::joint_turn, "", "Where to. Default: Q = 1."),
    row("target_deg", ValueType::joint_turn_deg, "degrees", "The same."),
    angle("angle", "Where to, of a hinge."),
    angle_deg("angle_deg", "The same."),
    number("stiffness", "N m/rad", kNotNegative, "Of the spring.").or_else(0),
    number("damping", "N m s/rad", kNotNegative, "Of the damper.").or_else(0),
    number("max_torque", "N m", kNotNegative, "No more than this. Default: any."),
    objects(
        "keys", "pose_key",
        "Targets to follow instead, times rising, the shortest way from each to the next; before "
        "the first and after the last they rest."),
    flag("loop", "Repeat the keys for all times; the last must be the first turn again.")
        .or_else(false),
};
constexpr Exclusive kDrivePairs[] = {{"target", "angle angle_deg keys"},
                                     {"target_deg", "angle angle_deg keys"},
                                     {"angle", "keys"},
                                     {"angle_deg", "keys"}};
constexpr AnyOf kDriveNeeds[] = {
    {"stiffness damping",
     "found neither \"stiffness\" nor \"damping\", expected one of them: without them a drive does "
     "nothing"}};
constexpr Beside kDrivePartners[] = {
    {"loop", "keys", "found \"loop\" without \"keys\", expected it with them"}};

constexpr Key kPoseKey[] = {
    number("time", "s", kTime, "When.").needed("a time in seconds"),
    row("target", ValueType::joint_turn, "", "Where it is by then."),
    row("target_deg", ValueType::joint_turn_deg, "degrees", "The same."),
    angle("angle", "Of a hinge."),
    angle_deg("angle_deg", "The same."),
};
constexpr Exclusive kPosePairs[] = {{"target", "angle angle_deg"},
                                    {"target_deg", "angle angle_deg"}};
constexpr AnyOf kPoseNeeds[] = {{"target target_deg angle angle_deg",
                                 "found no \"target\", expected the turn to be reached by then"}};

}  // namespace

std::span<const Key> joint_parameters() {
  return std::span(kJoint).subspan(std::size(kEveryJoint));
}

constinit const KeySet joint{
    "joint",
    "A joint. Needs anchor, or anchor_a, anchor_b or both, unless it is a distance or a spring, "
    "whose ends are point_a or anchor_a and point_b or anchor_b; where both do not meet at the "
    "start, the first step closes the gap. Its axes x, y, z count for kinds other than ball, "
    "limits "
    "and drives. Q tells how b's stand in a's; limits are counted from Q = 1.",
    kJoint, kJointPairs};
constinit const KeySet joint_class{
    "joint_class", "What joints of a class are, and those of chains, unless they say otherwise.",
    kJointClass, kJointClassPairs};
constinit const KeySet limits{
    "limits",
    "How far a joint may turn, counted from Q = 1, or slide. A ball has twist and cone or swing; a "
    "hinge, cylindrical, screw or planar joint angle; a universal joint first and second; what "
    "slides along x travel.",
    kLimits,
    kLimitPairs,
    {},
    kLimitPartners};
constinit const KeySet soft{
    "soft", "A spring and a damper that act near a stop.", kSoft, {}, kSoftNeeds};
constinit const KeySet spring{
    "spring",
    "A spring and damper about or along x. Needs stiffness, damping or both.",
    kSpring,
    {},
    kSpringNeeds};
constinit const KeySet friction{"friction",
                                "Friction of a joint: viscous times the rate, and dry times "
                                "tanh(rate / slip). Needs one of them "
                                "or both.",
                                kFriction,
                                {},
                                kFrictionNeeds};
constinit const KeySet motor{
    "motor",
    "Keeps a speed with gain times what it lacks, or goes to a position with gain times what it is "
    "off, less damping times the rate; never with more than cap.",
    kMotor,
    kMotorPairs,
    kMotorNeeds,
    kMotorPartners};
constinit const KeySet dof{"dof", "Forces along one degree of freedom of a joint.", kDof};
constinit const KeySet gear{
    "gear",
    "Two joints that move in proportion: coordinate of second = ratio * coordinate of first + "
    "offset. For the solver lagrangian. Coordinates are angles about x (of hinge, cylindrical, "
    "screw) and travel along it (cylindrical, prismatic, screw).",
    kGear};
constinit const KeySet joint_drive{
    "joint_drive",
    "A spring and damper that turn a joint towards a target. Needs stiffness, damping or both.",
    kJointDrive,
    kDrivePairs,
    kDriveNeeds,
    kDrivePartners};
constinit const KeySet pose_key{"pose_key", "A target at a time.", kPoseKey, kPosePairs,
                                kPoseNeeds};

}  // namespace pantin::detail::keys
