// Keys of laminas and of their fingers.
#include "engine/scene/keys.hpp"

namespace pantin::detail::keys {
namespace {

using namespace rows;

constexpr Key pair(Text name, Text unit, Text about) {
  return row(name, ValueType::numbers, unit, about).holding(2);
}

constexpr Key kLamina[] = {
    needed_name(),
    row("outline", ValueType::pairs, "m",
        "Corners [x, y] of its outline at the start, in order, in the scene's x-y plane. Default: "
        "unknown; then every finger tells its normal and the lamina cannot be moved on."),
    number("mass", "kg", kNotNegative, "It weighs mass times the scene's gravity.").or_else(1),
    pair("centre_of_mass", "m",
         "At the start. Default: the middle of the outline's area; the "
         "origin without an outline."),
    pair("force", "N", "What else acts on the mass centre. Default: nothing."),
    number("torque", "N m", kAnyNumber, "What else turns it, counter-clockwise.").or_else(0),
    objects("fingers", "finger", "What holds or pushes it, 1 to 32.").needed("1 to 32 fingers"),
};

constexpr Key kFinger[] = {
    own_name("Default: its number, from 1."),
    pair("point", "m", "Where it touches at the start; with an outline it may wait outside.")
        .needed("a point: two numbers"),
    pair("normal", "", "Into the lamina, of any length. Default: across the outline's edge."),
    flag("flat",
         "Whether the finger is an edge, across its normal, that a corner of the lamina "
         "touches; otherwise it is a point that touches an edge.")
        .or_else(false),
    pair("velocity", "m/s", "Steady. Default: it rests."),
    row("waypoints", ValueType::points, "s, m, m",
        "Instead: [time, x, y] after the start, times rising. It moves straight and steadily from "
        "one to the next, and rests after the last."),
    row("friction", ValueType::number_or_pair, "",
        "Coulomb's coefficient, or two: where the contact rolls (sticks), where it slides. Default "
        "0.5.")
        .within(kNotNegative),
    pair("friction_between", "",
         "Bounds of a coefficient that is not certain; the same for rolling and sliding. Default: "
         "none, it is known.")
        .within(kNotNegative),
    number("friction_deviation", "", kPositive,
           "Of a normal distribution about \"friction\", cut off at these bounds. Default: every "
           "value between them is equally likely."),
};
constexpr Exclusive kFingerPairs[] = {{"velocity", "waypoints"}};
constexpr Beside kFingerPartners[] = {
    {"friction_deviation", "friction_between",
     "found \"friction_deviation\" without \"friction_between\", expected the bounds too"}};

}  // namespace

constinit const KeySet lamina{
    "lamina",
    "A rigid part in the scene's x-y plane, held or pushed by fingers so slowly that inertia does "
    "not count. `pantin modes` tells which contacts stick, slide or separate, and for which "
    "friction.",
    kLamina};
constinit const KeySet finger{
    "finger", "A point, or an edge, that touches a lamina and moves as it is told.",
    kFinger,  kFingerPairs,
    {},       kFingerPartners};

}  // namespace pantin::detail::keys
