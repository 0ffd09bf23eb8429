// Keys of belts.
#include "engine/scene/keys.hpp"

namespace pantin::detail::keys {
namespace {

using namespace rows;

constexpr std::string_view kSides[] = {"inside", "outside"};
constexpr std::string_view kLevels[] = {"line", "links"};

constexpr Key kPulley[] = {
    reference("body", "the name of a body", "Name of the body that turns.")
        .needed("the name of a body"),
    vector("point", "m", "Its centre, in the scene at the start."),
    vector("anchor", "m", "Its centre in the body's own frame. Default: the origin of that."),
    number("radius", "m", kSize, "Of a round pulley, to the middle of the belt."),
    row("half_axes", ValueType::numbers, "m",
        "Of an elliptic one, along the body's own x and y, to the middle of the belt.")
        .holding(2)
        .within(kSize),
    row("outline", ValueType::pairs, "m",
        "Corners of one of another shape, about its centre, in the body's own x and y. The belt "
        "runs round their convex hull."),
    word("side", kSides,
         "Whether it lies inside the loop of the belt, or presses on it from outside.")
        .or_else(0),
};
constexpr Exclusive kPulleyPairs[] = {
    {"point", "anchor"}, {"radius", "half_axes outline"}, {"half_axes", "outline"}};
constexpr AnyOf kPulleyNeeds[] = {
    {"radius half_axes outline",
     "found no \"radius\", expected it, or the \"half_axes\" or the \"outline\" of the pulley"}};

constexpr Key kBelt[] = {
    own_name("Default \"first-second\", of the bodies of its first two pulleys."),
    objects("pulleys", "belt_pulley", "2 to 16, in the order in which the belt meets them.")
        .needed("the pulleys, in their order"),
    flag("crossed",
         "Whether spans may cross. Of two pulleys: the belt runs round the second one the other "
         "way.")
        .or_else(false),
    word("level", kLevels,
         "line: a line without mass, exact. links: a chain of bodies \"NAME/0\", \"NAME/1\" ..., "
         "joined by hinges and driven by friction on the pulleys, which are solid and smaller by "
         "half of the belt's thickness, an eighth of its width.")
        .or_else(0),
    whole("links", 6, 2000, "How many. Default: of about twice the belt's thickness each."),
    number("mass", "kg", kWeight, "Of all links. Default 0.2.").or_else(0.2),
    number("pretension", "N", kNotNegative, "Of the belt at rest.").or_else(0),
    number("friction", "", kNotNegative,
           "Of links: theirs, default 0.6. Else on two pulleys, by which the belt slips where its "
           "tensions differ by more than it can "
           "bear: 2 T tanh(friction * wrap / 2), T the pretension, wrap the smaller angle in rad. "
           "Default: it never slips.")
        .or_else(0),
    number("width", "m", kSize, "Along z, as drawn.").or_else(0.04),
    reference("material", "the name of a material", "As drawn. Default: that of bodies."),
};
constexpr Exclusive kBeltPairs[] = {{"pretension", "links mass"}};
constexpr Beside kBeltPartners[] = {
    {"friction", "pretension level",
     "found \"friction\" without a \"pretension\", expected it: a belt without one transmits "
     "nothing"},
    {"links", "level", "found \"links\" without \"level\": \"links\", expected it"},
    {"mass", "level", "found \"mass\" without \"level\": \"links\", expected it"}};

}  // namespace

constinit const KeySet belt_pulley{"belt_pulley",
                                   "A pulley that turns about z, and a belt with it.", kPulley,
                                   kPulleyPairs, kPulleyNeeds};
constinit const KeySet belt{
    "belt",
    "A closed flat belt, without mass, that does not stretch, in a plane of x and y. It slips "
    "nowhere unless it has a friction, so round pulleys keep their ratio exactly. Where all axles "
    "stand still on one body and pulleys are out of round, its span from the last pulley to the "
    "first gives way. For the solvers planar and lagrangian.",
    kBelt,
    kBeltPairs,
    {},
    kBeltPartners};

}  // namespace pantin::detail::keys
