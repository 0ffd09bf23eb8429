// Bodies, and chains of them.
#include <algorithm>
#include <limits>
#include <string>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using B = BodyRecipe;
using C = ChainRecipe;
using keys::acts;

constexpr std::string_view kMotions[] = {"dynamic", "fixed", "kinematic"};
constexpr std::string_view kOldMotions[] = {"", "", "driven"};
constexpr std::string_view kBodyOrWorld = "the name of a body, or \"world\"";

// Keys that a body and the links of a chain share. A class of bodies applies to links as well.
constexpr Key kShape = object("shape", "shape", "The body's one shape.");
constexpr Key kShapes =
    objects("shapes", "shape", "Several shapes. Where they overlap their mass counts twice.");
constexpr Key kShapeMaterial =
    reference("material", "the name of a material", "Material of all shapes that name none.");
constexpr Key kDensity =
    number("density", "kg/m^3", kWeight, "Of all shapes that name none. Not beside mass.")
        .or_else(1000);
constexpr Key kMass =
    number("mass", "kg", kWeight,
           "With shapes, their inertia is scaled to it. Alone it makes a point mass, to which only "
           "balls, distances, springs, cables and pins at its centre may be attached.")
        .expecting("a mass, or a shape that determines it");
constexpr Key kInertia =
    row("inertia", ValueType::inertia, "kg m^2",
        "About the mass centre, axes of the own frame: three principal moments, or the six entries "
        "xx, yy, zz, xy, xz, yz of the tensor (off-diagonal entries with the sign they have in the "
        "matrix). No moment may exceed the sum of the other two. Default: from the shapes.")
        .expecting("an inertia, or a shape that determines it");
constexpr Key kCentre =
    vector("centre_of_mass", "m", "In the own frame. Default: from the shapes.");
constexpr Key kDrag = number<&B::body, &Body::drag>(
    "drag", "1/s", kNotNegative, "Rate c of the damping exp(-c t) of all motion.");
constexpr Key kGravityScale = number<&B::body, &Body::gravity_scale>(
    "gravity_scale", "", kAnyNumber, "Factor of gravity on the body.");
constexpr Key kSolver = object<&B::solver>(
    "solver", "solver",
    "Solver settings for this island; absent keys are as in the scene's solver.");
constexpr Key kCollision = of_object<read_collision_of>(
    "collision", ValueType::object_or_flag, "collision",
    "Whether the body's shapes collide, and how. Absent keys are as in the scene's collision.");

constexpr Key kBody[] = {
    needed_name<&B::name>(),
    kClass,
    kParent.to<&B::parent>(),
    kShape,
    kShapes,
    kShapeMaterial,
    kDensity,
    kMass,
    kInertia,
    kCentre,
    kPosition.to<&B::pose>(),
    kRotation,
    kRotationDeg,
    vector<&B::body, &Body::velocity>("velocity", "m/s", "Of the mass centre at the start."),
    vector<&B::body, &Body::angular_velocity>("angular_velocity", "rad/s",
                                              "At the start, axes of the frame around the body."),
    kDrag,
    kGravityScale,
    word<&B::body, &Body::motion>("motion", kMotions,
                                  "dynamic: moved by forces and joints. fixed: never moves. "
                                  "kinematic: moved along a path, or by the program.")
        .once_words(kOldMotions),
    kSolver,
    kCollision,
};
constexpr auto kBodyClass = shared_keys<kBody, 3>("name class parent");
constexpr Exclusive kBodyPairs[] = {{"shape", "shapes"}, {"density", "mass"}};

constexpr Key kChain[] = {
    needed_name<&C::name>(),
    kClass,
    whole("links", 1, std::numeric_limits<int>::max(),
          "Number of links; they are called \"name/0\", \"name/1\", ..."),
    number("length", "m", kSize, "Of one link from joint to joint."),
    vector("start", "m", "The upper end.").or_else(0),
    direction("direction", "From start onwards.").or_else(0, -1, 0),
    vector("end", "m",
           "The other end instead of a direction; the chain lies on an arc if it is longer than "
           "the distance."),
    direction("sag", "Direction in which such an arc sags.").or_else(0, -1, 0),
    reference<&C::attach>("attach", kBodyOrWorld,
                          "Body that the start is jointed to. Default: none."),
    reference<&C::end_attach>("end_attach", kBodyOrWorld,
                              "Body that the end is jointed to. Default: none."),
    kShape,
    kShapes,
    kShapeMaterial,
    row("materials", ValueType::references, "", "Taken in turn, link by link, for all shapes."),
    kDensity,
    kMass,
    kInertia,
    kCentre,
    number<&C::mass_ratio>("mass_ratio", "", kPositive,
                           "Ratio of the mass of each link to that of the one before.")
        .or_else(1),
    number<&C::tip_mass_factor>("tip_mass_factor", "", kPositive,
                                "The last link's mass is multiplied by this.")
        .or_else(1),
    vector<&B::body, &Body::velocity>("velocity", "m/s", "Of the chain's middle at the start."),
    vector<&B::body, &Body::angular_velocity>("angular_velocity", "rad/s",
                                              "Of the chain as one rigid body about its middle."),
    kDrag,
    kGravityScale,
    kSolver,
    kCollision,
    row("path", ValueType::points, "m",
        "Positions of the joints, in place of links, length, start, direction, end and sag: one "
        "link from each point to the next."),
    flag<&C::closed>("closed",
                     "Joint the last link to the first. Equal links lie around a circle, the first "
                     "along direction, the next ones towards sag; of a path the last link returns "
                     "to the first point. That last joint is a ball.")
        .or_else(false),
    word("kind", keys::kWords<keys::is_of_chains>,
         "Of the joints. A hinge rotates about the links' own z; otherwise the joint axes have x "
         "along the chain and y along that z. Q = 1 where the chain is straight; where it is "
         "attached, at the start.")
        .or_else(0),
    direction<&C::axis>("axis",
                        "Direction to which the links' own z are as close as possible. Default: "
                        "normal to the plane in which the chain bends; of a straight chain as left "
                        "by the shortest rotation from -y to its direction."),
    object("limits", "limits", "Of all joints, including the attachments."),
    object("drive", "joint_drive", "Of all joints, including the attachments."),
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

int most_links(const Reading& reading) {
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<int>::max());
  return std::max(1, static_cast<int>(std::min(reading.limits.bodies, kMost)));
}

/// A chain through given points; no links if these are invalid.
void read_path(const Reading& reading, const Reader& from, ChainRecipe& chain) {
  const std::size_t refused_before = reading.diagnostics.error_count();
  const std::vector<NodeId> nodes = from.items("path");
  for (NodeId node : nodes) {
    Vec3 p(0);
    if (!from.numbers_at(node, {&p.x, 3}, kAnyNumber)) continue;
    if (!chain.path.empty() && glm::length(p - chain.path.back()) < kSize.least)
      reading.diagnostics.error(node, "found the previous point again, expected another");
    chain.path.push_back(p);
  }
  const std::size_t least = chain.closed ? 3 : 2;
  if (nodes.size() < least)
    from.error_value(
        "path", chain.closed ? "three points or more of a closed chain" : "two points or more");
  else if (reading.diagnostics.error_count() == refused_before && chain.closed &&
           glm::length(chain.path.back() - chain.path.front()) < kSize.least)
    reading.diagnostics.error(
        nodes.back(),
        "found the first point again, expected another: a closed chain returns by itself");
  if (reading.diagnostics.error_count() != refused_before) return;
  chain.links = static_cast<int>(chain.path.size()) - (chain.closed ? 0 : 1);
}

/// Whether the requested layout is possible; reports an error if not.
bool can_lie(const Reader& from, const ChainRecipe& chain, int links) {
  if (chain.closed && links < 3) {
    from.error_value("links", "3 links or more of a closed chain");
    return false;
  }
  if (!chain.end) return true;
  const Real reach = links * chain.length, span = glm::length(*chain.end - chain.start);
  if (span <= reach * (1 + 1e-9) && (links > 1 || span >= reach * (1 - 1e-9))) return true;
  from.error("end", "found an end " + written(span) + " m from the start, expected one that " +
                        written(reach) + " m of links can meet");
  return true;  // keeps the given number, so that names in it are known
}

/// Number of links of a chain and its layout; no links if the layout is impossible.
void read_course(const Reading& reading, const Reader& from, ChainRecipe& chain) {
  if (from.has("path")) return read_path(reading, from, chain);
  if (chain.closed && from.has("end"))
    from.error_at_key("end", "found \"end\" beside \"closed\", expected only one of them");
  const int links = from.whole("links", 0, most_links(reading));
  chain.length = from.number("length", 0);
  chain.start = from.vec("start");
  chain.direction = from.direction("direction", chain.direction);
  chain.end = from.vec_if("end");
  chain.sag = from.direction("sag", chain.sag);
  if (links == 0 || chain.length == 0) return;
  if (can_lie(from, chain, links)) chain.links = links;
}

}  // namespace

constinit const KeySet keys::body{
    "body",
    "A rigid body. Its own frame is the one its pose, shapes and anchors are given in; the mass "
    "centre may lie anywhere in it. A dynamic body needs shapes, or mass and inertia; with a mass "
    "alone it is a point mass.",
    kBody, kBodyPairs};
constinit const KeySet keys::body_class{
    "body_class", "Defaults of bodies and links of chains of a class.", kBodyClass, kBodyPairs};
constinit const KeySet keys::chain{
    "chain",
    "Links jointed end to end: equal ones by links and length, or along a path. A link's own frame "
    "is at its middle, -y along the chain; its shapes, or mass and inertia, are given there.",
    kChain, kChainPairs, kChainNeeds};

bool read_members(const Reading& reading, const Reader& from, BodyRecipe& body) {
  read_rows(reading, from, body);
  body.mass_properties = read_mass_properties(reading, from, body.body.motion);
  if (body.mass_properties.is_point && body.body.angular_velocity != Vec3(0))
    from.error(
        "angular_velocity",
        "found a point mass that rotates, expected a body with a \"shape\" or an \"inertia\"");
  return !body.name.empty();
}

ChainRecipe read_chain(const Reading& reading, NodeId node) {
  const Reader from = open_object(reading, node, "chain");
  ChainRecipe chain;
  if (!from.is_object()) return chain;
  read_rows(reading, from, chain), read_rows(reading, from, chain.link);
  read_course(reading, from, chain);
  if (chain.closed && from.has("end_attach"))
    from.error_at_key(
        "end_attach",
        "found \"end_attach\" of a closed chain, expected none: its end is its start");
  for (const NodeId material : from.items("materials"))
    chain.materials.push_back(find_material(reading, material, 0));
  chain.link.mass_properties = read_mass_properties(reading, from, Motion::dynamic);
  chain.turn = read_turn(reading, from);
  return chain;
}

}  // namespace pantin::detail
