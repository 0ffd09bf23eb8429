// Cables, their guides, and pins.
#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using G = GuideRecipe;
using C = CableRecipe;
using P = PinRecipe;

constexpr std::string_view kPinKinds[] = {"exact", "spring"};
constexpr std::string_view kBodyOrWorld = "the name of a body, or \"world\"";

constexpr Key kGuide[] = {
    needed_reference<&G::body>(
        "body", kBodyOrWorld,
        "Body that the ring or the pulley is fixed to; \"world\" never moves."),
    point_in_scene<&G::at>(
        "point",
        "Ring, or centre of the pulley, at the start, in the frame of the scene or prefab."),
    point_in_body<&G::at>("anchor", "The same in the body's own frame. Default: its origin."),
    number<&G::radius>("radius", "m", kNotNegative,
                       "Of the pulley, to the centreline of the cable; 0: a ring."),
    vector<&G::axis>("axis", "",
                     "Of the pulley, in the frame of the scene or prefab: from a to b the cable "
                     "runs round it anticlockwise about this axis.")
        .without_default(),
    whole<&G::turns>("turns", 0, 1000,
                     "Whole turns round the pulley at the start, beyond the shortest wrap."),
};
constexpr Exclusive kGuidePairs[] = {{"point", "anchor"}};
constexpr Beside kGuidePartners[] = {
    {"axis", "radius", "found \"axis\" without \"radius\", expected the pulley's radius too"},
    {"turns", "radius", "found \"turns\" without \"radius\", expected the pulley's radius too"}};

constexpr Key kCable[] = {
    own_name<&C::name>("Default \"a-b\"."),
    kClass,
    needed_reference<&C::a>("a", kBodyOrWorld,
                            "Name of a body of this scene or prefab, \"instance/body\" or "
                            "\"chain/0\"; \"world\" never moves."),
    needed_reference<&C::b>("b", kBodyOrWorld, "Likewise, the other body."),
    point_in_scene<&C::at_a>("point_a",
                             "Attachment to a at the start, in the frame of the scene or prefab."),
    point_in_scene<&C::at_b>("point_b", "Attachment to b, likewise."),
    point_in_body<&C::at_a>("anchor_a", "Attachment in a's own frame. Default: its origin."),
    point_in_body<&C::at_b>("anchor_b", "Attachment in b's own frame. Default: its origin."),
    objects<&C::over>("over", "cable_guide",
                      "Frictionless rings and pulleys that the cable runs over, from a to b. "
                      "Solver \"lagrangian\"."),
    number<&C::length>("length", "m", kSize,
                       "Default: the distance at the start, over the guides."),
    number<&C::slack>("slack", "", kPositive, "Length as a multiple of the distance at the start."),
    number<&C::compliance>("compliance", "m/N", kNotNegative, "Elongation per unit of tension."),
};
constexpr auto kCableClass = shared_keys<kCable, 4>("name class a b");
constexpr Exclusive kCablePairs[] = {
    {"point_a", "anchor_a"}, {"point_b", "anchor_b"}, {"length", "slack"}};

constexpr Key kPin[] = {
    own_name<&P::name>("Default \"body-pin\"."),
    kClass,
    needed_reference<&P::body>("body", "the name of a body", "A dynamic body."),
    point_in_scene<&P::point>(
        "point", "The pinned point at the start, in the frame of the scene or prefab."),
    point_in_body<&P::point>("anchor",
                             "The pinned point in the body's own frame. Default: its origin."),
    vector<&P::target>("target", "m",
                       "Target of the point, in the frame of the scene or prefab. Default: where "
                       "it is at the start."),
    reference<&P::to>("to", "the name of a body",
                      "Another body to pin to: target is where its point lies at the start. "
                      "Default: none, a fixed target."),
    vector<&P::anchor_to>("anchor_to", "m",
                          "Target in the own frame of that body, instead of target."),
    whole<&P::pin, &Pin::priority>(
        "priority", -1'000'000, 1'000'000,
        "Among several exact pins the one of highest priority is met exactly."),
    word<&P::pin, &Pin::kind>("kind", kPinKinds,
                              "exact: reaches the target at any load. spring: pulled by a spring.")
        .once("grip"),
    number<&P::pin, &Pin::stiffness>("stiffness", "N/m", kPositive, "Of a spring."),
    number<&P::pin, &Pin::damping>(
        "damping", "N s/m", kNotNegative,
        "Of a spring's damper; critical damping of a single mass: 2 sqrt(stiffness mass)."),
};
constexpr auto kPinClass = shared_keys<kPin, 3>("name class body");
constexpr Exclusive kPinPairs[] = {{"point", "anchor"}, {"target", "anchor_to"}};
constexpr Beside kPinPartners[] = {
    {"anchor_to", "to", "found \"anchor_to\" without \"to\", expected the body it lies in"}};

}  // namespace

constinit const KeySet keys::cable_guide{
    "cable_guide", "A ring or a pulley that a cable runs over.", kGuide, kGuidePairs, kNoNeeds,
    kGuidePartners};
constinit const KeySet keys::cable{"cable", "A cable: it pulls, never pushes.", kCable,
                                   kCablePairs};
constinit const KeySet keys::cable_class{"cable_class", "Defaults of cables of a class.",
                                         kCableClass, kCablePairs};
constinit const KeySet keys::pin{
    "pin",    "A pin: holds a point of a body at a target, as a nail or the mouse does.",
    kPin,     kPinPairs,
    kNoNeeds, kPinPartners};
constinit const KeySet keys::pin_class{"pin_class", "Defaults of pins of a class.", kPinClass,
                                       kPinPairs};

bool read_members(const Reading& reading, const Reader& from, GuideRecipe& guide) {
  const bool is_whole = read_rows(reading, from, guide);
  if (guide.radius > 0 && !(glm::length(guide.axis) > 0))
    reading.diagnostics.error_value(from.has("axis") ? from.find("axis") : from.node,
                                    "the \"axis\" of a pulley, a vector that is not zero");
  return is_whole;
}

}  // namespace pantin::detail
