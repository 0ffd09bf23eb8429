// Keys of joints and gears.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using keys::acts, keys::acts_twice, keys::is_driven, keys::is_line, keys::is_no_line,
    keys::is_of_files;
using keys::kWords, keys::range_of;
using J = JointRecipe;
using G = GearRecipe;

constexpr std::string_view kBallOnly[] = {"ball"};
constexpr std::string_view kCoordinates[] = {"angle", "travel"};
constexpr std::string_view kOldCoordinates[] = {"turn", "slide"};
constexpr std::string_view kBodyOrWorld = "the name of a body, or \"world\"";

/// The union of two ranges: kinds that share a parameter may bound it differently.
constexpr Range wider(const Range& a, const Range& b) {
  if (a.least == b.least && a.most == b.most) return a;
  return {std::min(a.least, b.least), std::max(a.most, b.most), "a number that fits the kind"};
}

/// The units of the parameters of joint kinds, by key.
struct UnitOfParameter {
  std::string_view key, unit;
};
constexpr UnitOfParameter kUnitsOfParameters[] = {
    {"length", "m"},      {"radius", "m"}, {"pitch", "m/rad"},          {"stiffness", "N/m"},
    {"damping", "N s/m"}, {"grip", "N"},   {"friction_coefficient", ""}};
constexpr const UnitOfParameter* unit_of_parameter(std::string_view key) {
  for (const UnitOfParameter& u : kUnitsOfParameters)
    if (u.key == key) return &u;
  return nullptr;
}
static_assert(
    [] {
      for (const JointKindInfo& kind : kJointKindInfos)
        for (const Parameter& p : kind.parameters)
          if (!unit_of_parameter(p.key)) return false;
      return true;
    }(),
    "a parameter of a joint kind has no unit: add its key to kUnitsOfParameters");

/// Adds the parameters of a kind to `into`, from `count` on; only counts them if `into` is full.
constexpr void add_parameters(const JointKindInfo& kind, std::span<Key> into, std::size_t& count) {
  for (const Parameter& p : kind.parameters) {
    Key key = number(p.key, unit_of_parameter(p.key)->unit, range_of(p),
                     p.as_placed ? "Default: as placed." : "Of kinds of joints that have it.");
    if (!p.about.empty()) key.about = p.about;
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
    own_name<&J::name>("Default \"a-b\"."),
    kClass,
    word(
        "kind", kWords<is_of_files>,
        "ball (or spherical): free rotation. hinge (or revolute): Q rotates about x. universal: Q "
        "rotates about y of a, then about z of b; x is the shaft. fixed: no rotation. The others "
        "are for the solver lagrangian. cylindrical: rotates about x and translates along it. "
        "prismatic: translates along x of a. screw: translates along x by pitch per rad of "
        "rotation about it. planar: translates across x, rotates about it. distance: two points "
        "stay length apart. spring: a spring and damper between two points. skate (or knife_edge): "
        "b's anchor does not move along x of b. wheel: a disc about x of b rolls on a plane of a "
        "whose normal is y.")
        .or_else(0),
    word("type", kBallOnly, "An older word for \"kind\": \"ball\"."),
    needed_reference<&J::a>("a", kBodyOrWorld,
                            "Name of a body of this scene or prefab, \"instance/body\" or "
                            "\"chain/0\"; \"world\" never moves."),
    needed_reference<&J::b>("b", kBodyOrWorld, "Likewise, the other body."),
    vector<&J::anchor>("anchor", "m",
                       "The shared point at the start, in the frame of the scene or prefab.")
        .of_kinds(is_no_line),
    vector<&J::anchor_a>("anchor_a", "m",
                         "The point in a's own frame; alone, b's follows from the initial poses."),
    vector<&J::anchor_b>("anchor_b", "m", "The point in b's own frame; alone, a's follows."),
    direction("axis",
              "The x axis at the start, in the frame of the scene or prefab, of any length: the "
              "axis of a hinge, the twist axis of a ball, the shaft of a universal joint.")
        .or_else(1, 0, 0)
        .of_kinds(is_no_line),
    direction("across",
              "The y axis, likewise; only its component across the axis counts. Default: [0, 1, 0] "
              "under the shortest rotation of x to the axis.")
        .of_kinds(is_no_line),
    direction("axis_a", "The x axis in a's own frame instead; b's follows from the initial poses.")
        .of_kinds(is_no_line),
    direction("across_a", "The y axis in a's own frame.").of_kinds(is_no_line),
    direction("axis_b",
              "The x axis in b's own frame; a's follows. Beside axis_a, across_a and across_b are "
              "needed and Q follows.")
        .of_kinds(is_no_line),
    direction("across_b", "The y axis in b's own frame.").of_kinds(is_no_line),
    row("rest", ValueType::joint_turn, "", "Q at the start. Default: none.").of_kinds(is_no_line),
    row("rest_deg", ValueType::joint_turn_deg, "degrees", "The same.").of_kinds(is_no_line),
    object("limits", "limits", "Limits of its coordinates. Default: those of its kind."),
    object("drive", "joint_drive",
           "A spring and damper towards a target, or an exact motion. Default: none.")
        .of_kinds(is_driven),
    vector<&J::point_a>(
        "point_a", "m",
        "End on a at the start, in the frame of the scene or prefab. Default: a's origin.")
        .of_kinds(is_line),
    vector<&J::point_b>("point_b", "m", "End on b, likewise.").of_kinds(is_line),
    object("spring", "spring",
           "Acts on the rotation of a hinge, a screw, a cylindrical joint, on the first rotation "
           "of a universal joint, on the translation of a prismatic joint.")
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

constexpr Key kGear[] = {
    own_name<&G::name>("Default \"first-second\"."),
    needed_reference<&G::first>("first", "the name of a joint",
                                "Name of a joint of this scene or prefab."),
    word<&G::first_travels>(
        "first_coordinate", kCoordinates,
        "Which coordinate of first. Default: angle; of a prismatic joint travel.")
        .once("first_moves")
        .once_words(kOldCoordinates),
    needed_reference<&G::second>("second", "the name of a joint", "Name of another joint."),
    word<&G::second_travels>("second_coordinate", kCoordinates, "Likewise of second.")
        .once("second_moves")
        .once_words(kOldCoordinates),
    number<&G::ratio>("ratio", "", kAnyNumber,
                      "Of second per unit of first: rad/rad, m/rad, rad/m or m/m. Meshing gears "
                      "rotate in opposite senses: below 0.")
        .needed("the motion of second per unit of first")
        .not_zero(),
    number<&G::offset>("offset", "rad", kAnyNumber, "m for a travel. Default: as placed."),
    angle_deg<&G::offset>("offset_deg", "The same for an angle."),
};

/// "axis" and "across", or the same with `suffix` in a body's own frame; nothing without both.
std::optional<AxesRecipe> read_axes(const Reader& from, const std::string& suffix) {
  const std::string axis = "axis" + suffix, across = "across" + suffix;
  if (!from.has(axis) && !from.has(across)) return std::nullopt;
  AxesRecipe axes;
  if (from.has(axis)) axes.axis = from.direction(axis, axes.axis);
  if (!from.has(across)) return axes;
  axes.across = from.direction(across, Vec3(0, 1, 0));
  if (glm::length(glm::cross(axes.axis, *axes.across)) > 1e-6) return axes;
  from.error_value(across, "a direction not parallel to \"" + axis + "\"");
  axes.across.reset();
  return axes;
}

void read_frames(const Reader& from, JointRecipe& joint) {
  if (const auto axes = read_axes(from, "")) joint.axes = *axes;
  joint.axes_a = read_axes(from, "_a"), joint.axes_b = read_axes(from, "_b");
  if (joint.axes_a && joint.axes_b) {
    if (!joint.axes_a->across || !joint.axes_b->across)
      from.error(
          "found \"axis_a\" and \"axis_b\", expected \"across_a\" and \"across_b\" beside them: "
          "they define the zero of the joint");
    for (std::string_view key : {"rest", "rest_deg"})
      if (from.has(key))
        from.error_at_key(key, "found \"" + std::string(key) +
                                   "\" beside the axes in both bodies, expected only one of them: "
                                   "the axes determine it");
    return;
  }
  joint.rest = read_joint_turn(from, "rest", joint.turn.kind).value_or(kIdentity);
}

/// The kind under "kind", by its name or its alias; a chain has only kinds that share a point.
JointKind read_kind(const Reader& from) {
  const bool is_chain = !from.accepts("type");
  if (!is_chain) from.word("type", 0);
  const NodeId node = from.find("kind");
  if (node == kNoNode) return JointKind::ball;
  std::vector<JointKind> kinds;
  std::vector<std::string_view> names;
  for (int i = 0; i < kJointKinds; ++i) {
    const JointKindInfo& info = kJointKindInfos[i];
    if (!info.in_files || (is_chain && !info.holds_point)) continue;
    kinds.push_back(static_cast<JointKind>(i)), names.push_back(info.name);
  }
  const std::string_view word =
      from.json[node].kind == JsonKind::string ? from.json[node].text : "";
  JointKind named = JointKind::ball;
  const bool is_kind = joint_kind_from_name(word, named);
  if (is_kind && std::ranges::count(kinds, named) > 0) return named;
  if (is_chain || !is_kind || info_of(named).in_files) return kinds[from.word("kind", 0, names)];
  from.diagnostics.error_value(node, "a kind that a file can define: " + a_joint(named) +
                                         " is defined in C++, by JointParameters::custom");
  return JointKind::ball;
}

}  // namespace

std::span<const Key> keys::joint_parameters() {
  return std::span(kJoint).subspan(std::size(kEveryJoint));
}

constinit const KeySet keys::joint{
    "joint",
    "A joint. Needs anchor, or anchor_a, anchor_b or both, unless it is a distance or a spring, "
    "whose ends are point_a or anchor_a and point_b or anchor_b; where both do not meet at the "
    "start, the first step closes the gap. Its axes x, y, z matter for kinds other than ball, "
    "limits and drives. Q is the rotation of b's axes in a's; limits are measured from Q = 1.",
    kJoint, kJointPairs};
constinit const KeySet keys::joint_class{"joint_class",
                                         "Defaults of joints of a class, and of those of chains.",
                                         kJointClass, kJointClassPairs};
constinit const KeySet keys::gear{
    "gear",
    "A gear couples two joints: coordinate of second = ratio * coordinate of first + offset. For "
    "the solver lagrangian. Coordinates are angles about x (of hinge, cylindrical, screw) and "
    "travel along it (cylindrical, prismatic, screw).",
    kGear};

std::string a_joint(JointKind kind) { return std::string("a ") + name_of(kind) + " joint"; }

NodeId either(const Reader& from, std::string_view key) {
  const NodeId node = from.find(key);
  return node != kNoNode ? node : from.find(std::string(key) + "_deg");
}

bool read_angles(const Reader& from, std::string_view key, std::span<Real> into) {
  const std::string key_deg = std::string(key) + "_deg";
  const bool in_degrees = from.has(key_deg);
  const NodeId node = either(from, key);
  if (node == kNoNode) return false;
  const Range& range = in_degrees ? kDegrees : kRadians;
  if (into.size() == 1) {
    const Real angle = from.number(in_degrees ? key_deg : key, NAN, range);
    if (std::isnan(angle)) return false;
    into[0] = angle;
  } else if (!from.numbers_at(node, into, range)) {
    return false;
  }
  if (in_degrees)
    for (Real& x : into) x *= kPi / 180;
  return true;
}

RotationRecipe read_turn(const Reading& reading, const Reader& from) {
  RotationRecipe turn;
  turn.kind = read_kind(from);
  turn.limits = read_limits(reading, from, turn);
  read_parameters(reading, from, turn);
  turn.drive = read_pose_drive(reading, from, turn.kind);
  return turn;
}

bool read_members(const Reading& reading, const Reader& from, JointRecipe& joint) {
  const bool is_whole = read_rows(reading, from, joint);
  joint.turn = read_turn(reading, from);
  if (joint.turn.is_line()) return is_whole;
  if (!joint.anchor && !joint.anchor_a && !joint.anchor_b)
    from.error(
        "found no \"anchor\", expected the point of the scene where the bodies meet, or "
        "\"anchor_a\" and \"anchor_b\" in their own frames");
  read_frames(from, joint);
  return is_whole;
}

bool read_members(const Reading& reading, const Reader& from, GearRecipe& gear) {
  gear.in_degrees = from.has("offset_deg"), gear.length_unit = reading.length_unit;
  return read_rows(reading, from, gear);
}

}  // namespace pantin::detail
