// Keys of belts.
#include <cmath>
#include <string>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using P = PulleyRecipe;
using B = BeltRecipe;

constexpr int kEllipseCorners = 720;

bool read_ellipse(const RowValue& row, PulleyRecipe& pulley) {
  Real half_axes[2] = {};
  if (!row.from.numbers(row.key.name, half_axes)) return true;
  for (int i = 0; i < kEllipseCorners; ++i) {
    const Real at = 2 * kPi * i / kEllipseCorners;
    pulley.outline.push_back({half_axes[0] * std::cos(at), half_axes[1] * std::sin(at), 0});
  }
  return true;
}

bool read_outline(const RowValue& row, PulleyRecipe& pulley) {
  if (!row.is_there()) return true;
  std::vector<Vec3> points;
  for (const NodeId node : row.from.items(row.key.name)) {
    Real at[2] = {};
    if (!row.from.numbers_at(node, at, kAnyNumber)) return true;
    points.push_back({at[0], at[1], 0});
  }
  if (hull_outline(points).corners.empty())
    row.from.error_value(row.key.name, "three corners or more that do not lie on one line");
  pulley.outline = std::move(points);
  return true;
}

constexpr std::string_view kSides[] = {"inside", "outside"};
constexpr std::string_view kLevels[] = {"line", "links"};

constexpr Key kPulley[] = {
    needed_reference<&P::body>("body", "the name of a body", "Name of the rotating body."),
    point_in_scene<&P::at>("point", "Its centre, in the scene at the start."),
    point_in_body<&P::at>("anchor", "Its centre in the body's own frame. Default: its origin."),
    number<&P::radius>("radius", "m", kSize, "Of a round pulley, to the centreline of the belt."),
    row<read_ellipse>(
        "half_axes", ValueType::numbers, "m",
        "Of an elliptic one, along the body's own x and y, to the centreline of the belt.")
        .holding(2)
        .within(kSize),
    row<read_outline>("outline", ValueType::pairs, "m",
                      "Corners of a pulley of another shape, about its centre, in the body's own x "
                      "and y. The belt runs round their convex hull."),
    word<&P::is_outside>(
        "side", kSides, "Whether it lies inside the loop of the belt, or touches it from outside."),
};
constexpr Exclusive kPulleyPairs[] = {
    {"point", "anchor"}, {"radius", "half_axes outline"}, {"half_axes", "outline"}};
constexpr AnyOf kPulleyNeeds[] = {
    {"radius half_axes outline",
     "found no \"radius\", expected it, or the \"half_axes\" or the \"outline\" of the pulley"}};

constexpr Key kBelt[] = {
    own_name<&B::name>("Default \"first-second\", of the bodies of its first two pulleys."),
    objects<&B::pulleys>("pulleys", "belt_pulley",
                         "2 to 16, in the order in which the belt meets them.")
        .needed("the pulleys, in their order"),
    flag<&B::crossed>("crossed",
                      "Whether spans may cross. Of two pulleys: the belt runs round the second one "
                      "the other way."),
    word<&B::has_links>(
        "level", kLevels,
        "line: a massless line, exact. links: a chain of bodies \"NAME/0\", \"NAME/1\" ..., joined "
        "by hinges and driven by friction on the pulleys, which collide and are smaller by half of "
        "the belt's thickness, an eighth of its width."),
    whole<&B::links>("links", 6, 2000,
                     "Number of links. Default: of about twice the belt's thickness each."),
    number<&B::mass>("mass", "kg", kWeight, "Of all links. Default 0.2."),
    number<&B::pretension>("pretension", "N", kNotNegative, "Tension of the belt at rest."),
    number<&B::friction>("friction", "", kNotNegative,
                         "Of links: theirs, default 0.6. Else on two pulleys: the belt slips where "
                         "its tensions differ by more than 2 T tanh(friction * wrap / 2), T the "
                         "pretension, wrap the smaller angle in rad. Default: it never slips."),
    number<&B::width>("width", "m", kSize, "Along z, as drawn."),
    reference<&B::material>("material", "the name of a material",
                            "As drawn. Default: that of bodies."),
};
constexpr Exclusive kBeltPairs[] = {{"pretension", "links mass"}};
constexpr Beside kBeltPartners[] = {
    {"friction", "pretension level",
     "found \"friction\" without a \"pretension\", expected both: without tension there is no "
     "friction"},
    {"links", "level", "found \"links\" without \"level\": \"links\", expected it"},
    {"mass", "level", "found \"mass\" without \"level\": \"links\", expected it"}};

}  // namespace

constinit const KeySet keys::belt_pulley{"belt_pulley",
                                         "A pulley that rotates about z and drives a belt.",
                                         kPulley, kPulleyPairs, kPulleyNeeds};
constinit const KeySet keys::belt{
    "belt",
    "A closed, flat, massless and inextensible belt in a plane parallel to xy. It slips only if it "
    "has a friction, so round pulleys keep their ratio exactly. Where all axles are fixed on one "
    "body and pulleys are not round, its span from the last pulley to the first changes its "
    "length. For the solvers planar and lagrangian.",
    kBelt,
    kBeltPairs,
    kNoNeeds,
    kBeltPartners};

bool read_members(const Reading& reading, const Reader& from, BeltRecipe& belt) {
  read_rows(reading, from, belt);
  if (belt.has_links && !from.has("friction")) belt.friction = 0.6;
  const std::size_t count = belt.pulleys.size();
  const bool is_whole = count == from.items("pulleys").size();
  const bool is_right = count >= 2 && count <= kMostPulleys;
  if (from.has("pulleys") && is_whole && !is_right)
    from.error("pulleys", "found " + std::to_string(count) + " pulleys, expected 2 to " +
                              std::to_string(kMostPulleys));
  if (belt.friction > 0 && count > 2 && !belt.has_links)
    from.error("friction",
               "found \"friction\" of a belt over " + std::to_string(count) +
                   " pulleys, expected 2: with more the slipping pulley is undetermined");
  return is_whole && is_right;
}

}  // namespace pantin::detail
