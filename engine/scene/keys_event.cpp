// Keys of timed events, a set for each type.
#include "engine/scene/keys.hpp"
#include "engine/world/timed_event.hpp"

namespace pantin::detail::keys {
namespace {

using namespace rows;
using enum TimedEventKind;

constexpr Range kMoment{0, 1e6, "a time in seconds from 0 to 1e6"};
constexpr Range kRepeat{kShortestRepeat, 1e6, "a time in seconds from 1e-3 to 1e6"};
constexpr std::string_view kAnEvent = "a time in seconds";
constexpr std::string_view kSolverWords[] = {"auto",       "sweep",  "shake2",     "procedural",
                                             "lagrangian", "planar", "quasistatic"};

constexpr Key type_of(TimedEventKind kind) {
  Key key = word("type", std::span(kTimedEventNames).subspan(static_cast<std::size_t>(kind), 1),
                 "What happens.");
  key.is_needed = true;
  return key;
}

constexpr Key kAt =
    number("at", "s", kMoment, "When: at the step boundary nearest to it.").needed(kAnEvent);
constexpr Key kFrom = number("from", "s", kMoment, "When it begins.").or_else(0);
constexpr Key kTo = number("to", "s", kMoment, "When it ends. Default: never.");
constexpr Key kEvery = number("every", "s", kRepeat,
                              "It starts again so long after it started, again and again. Default: "
                              "once.");
constexpr Key kOver = number("over", "s", kMoment, "How long the change takes.").or_else(0);
constexpr Key kBody =
    reference("body", "the name of a body", "A dynamic body.").needed("the name of a body");
constexpr Key kAnchor =
    vector("anchor", "m",
           "Point of the body that it acts on, in the body's own frame. Default: "
           "its mass centre.");
constexpr Key kPoint = vector("point", "m", "The same, in the scene at the start.");
constexpr Exclusive kPointPairs[] = {{"anchor", "point"}};

constexpr Key kPush[] = {
    type_of(push),
    kBody,
    vector("force", "N", "In the axes of the scene.").or_else(0),
    vector("torque", "N m", "Likewise.").or_else(0),
    kAnchor,
    kPoint,
    kFrom,
    kTo,
    kEvery,
};
constexpr AnyOf kPushNeeds[] = {
    {"force torque", "found no \"force\", expected a force or a torque"}};
constexpr Beside kRepeats[] = {
    {"every", "to", "found \"every\" without \"to\", expected the end of the first time too"}};

constexpr Key kImpulse[] = {
    type_of(impulse),
    kBody,
    vector("impulse", "N s", "Mass times the change of velocity, in the axes of the scene.")
        .or_else(0),
    vector("angular_impulse", "N m s", "Likewise.").or_else(0),
    kAnchor,
    kPoint,
    kAt,
    kEvery,
};
constexpr AnyOf kImpulseNeeds[] = {
    {"impulse angular_impulse", "found no \"impulse\", expected an impulse or an angular impulse"}};

constexpr Key kWind[] = {
    type_of(wind),
    vector("velocity", "m/s", "Of the air.").or_else(0),
    row("gusts", ValueType::vector_or_number, "m/s",
        "How much faster or slower gusts make it at most, along all axes or along each.")
        .or_else(0),
    number("gust_time", "s", kRepeat, "From one gust to the next.").or_else(1),
    whole("seed", 0, 1'000'000'000,
          "Of the gusts: with the same seed the same ones, at any step length.")
        .or_else(1),
    number("drag", "1/s", kNotNegative,
           "Rate at which the air takes bodies along, beside their own drag. Default: by their own "
           "drag; what has none feels no wind."),
    row("bodies", ValueType::references, "",
        "Names of bodies, or of chains, instances and grids: all of theirs. Default: every body."),
    kFrom,
    kTo,
    kEvery,
};
constexpr AnyOf kWindNeeds[] = {
    {"velocity gusts", "found no \"velocity\", expected the velocity of the air, or \"gusts\""}};

constexpr Key kPull[] = {
    type_of(pull),
    kBody,
    vector("anchor", "m",
           "Where the hand takes it, in the body's own frame. Default: at that frame's origin."),
    kPoint,
    vector("target", "m", "Where the hand leads it.").needed("the place it is led to"),
    number("stiffness", "N/m", kNotNegative,
           "Of a hand that gives way like a spring; 0: it gets there exactly.")
        .or_else(0),
    number("damping", "N s/m", kNotNegative, "Of that spring's damper.").or_else(0),
    kFrom,
    number("to", "s", kMoment, "When the hand lets go. Default: never."),
    number("over", "s", kMoment,
           "How long the way takes, from rest to rest. Default: until it lets go, or 1."),
};

constexpr Key kCut[] = {
    type_of(cut),
    reference("joint", "the name of a joint",
              "Name of a joint, or of a chain, an instance or a grid: all of its joints."),
    reference("cable", "the name of a cable", "Likewise of a cable."),
    reference("pin", "the name of a pin", "Likewise of a pin."),
    reference("gear", "the name of a gear", "Likewise of a gear."),
    kAt,
};
constexpr Exclusive kCutPairs[] = {
    {"joint", "cable pin gear"}, {"cable", "pin gear"}, {"pin", "gear"}};
constexpr AnyOf kCutNeeds[] = {
    {"joint cable pin gear",
     "found no \"joint\", expected the name of a joint, or a \"cable\", \"pin\" or \"gear\""}};

constexpr Key kMotor[] = {
    type_of(motor),
    reference("joint", "the name of a joint",
              "Name of a joint with a motor, or of a group of them.")
        .needed("the name of a joint"),
    number("velocity", "rad/s", kAnyNumber, "The speed it keeps from now on; of a slide m/s."),
    number("velocity_deg", "degrees/s", kDegrees, "The same, of an angle."),
    number("position", "rad", kAnyNumber, "Where it goes; of a slide m."),
    angle_deg("position_deg", "The same, of an angle."),
    number("gain", "", kPositive, "As of a motor. Default: as before."),
    number("damping", "N m s/rad", kNotNegative, "As of a motor. Default: as before."),
    number("cap", "N m", kNotNegative, "Its most; 0 turns it off. Default: as before."),
    kAt,
    kOver,
};
constexpr Exclusive kMotorPairs[] = {{"velocity", "position position_deg"},
                                     {"velocity_deg", "position position_deg"}};
constexpr AnyOf kMotorNeeds[] = {
    {"velocity velocity_deg position position_deg gain damping cap",
     "found no \"velocity\", expected the speed it keeps, or the \"position\" it goes to"}};

constexpr Key kDrive[] = {
    type_of(drive),
    reference("joint", "the name of a joint",
              "Name of a joint with a drive, or of a group of them.")
        .needed("the name of a joint"),
    number("stiffness", "N m/rad", kNotNegative, "Of its spring. Default: as before."),
    number("damping", "N m s/rad", kNotNegative, "Of its damper. Default: as before."),
    number("max_torque", "N m", kNotNegative, "Its most; 0 lets go. Default: as before."),
    kAt,
    kOver,
};
constexpr AnyOf kDriveNeeds[] = {
    {"stiffness damping max_torque",
     "found no \"stiffness\", expected a stiffness, a damping or a greatest torque"}};

constexpr Key kWinch[] = {
    type_of(winch),
    reference("cable", "the name of a cable", "Name of a cable, or of a group of them.")
        .needed("the name of a cable"),
    number("length", "m", kSize, "How long it is then.").needed(kSize.words),
    kAt,
    number("over", "s", kMoment, "How long it takes, from rest to rest.").or_else(0),
};

constexpr Key kGravity[] = {
    type_of(gravity),
    vector("gravity", "m/s^2", "What all bodies fall with from now on.")
        .needed("an acceleration in m/s^2"),
    kAt,
    kOver,
};

constexpr Key kSolver[] = {
    type_of(solver),
    word("solver", kSolverWords, "The solver of all bodies from now on; its settings stay.")
        .needed("a solver"),
    kAt,
};

}  // namespace

constinit const KeySet push_event{
    "push_event", "A force on a body, from a time to a time; a part of a step in proportion.",
    kPush,        kPointPairs,
    kPushNeeds,   kRepeats};
constinit const KeySet impulse_event{"impulse_event", "A blow at one moment.", kImpulse,
                                     kPointPairs, kImpulseNeeds};
constinit const KeySet wind_event{
    "wind_event", "Air that moves, and takes bodies along by their drag.", kWind, {}, kWindNeeds,
    kRepeats};
constinit const KeySet pull_event{
    "pull_event", "A hand that takes a point of a body, leads it to a place and lets go.", kPull,
    kPointPairs};
constinit const KeySet cut_event{"cut_event", "A joint, cable, pin or gear is cut.", kCut,
                                 kCutPairs, kCutNeeds};
constinit const KeySet motor_event{"motor_event", "A motor gets another speed or place.", kMotor,
                                   kMotorPairs, kMotorNeeds};
constinit const KeySet drive_event{
    "drive_event", "A joint drive becomes stronger or weaker.", kDrive, {}, kDriveNeeds};
constinit const KeySet winch_event{"winch_event", "A cable is taken in or let out.", kWinch};
constinit const KeySet gravity_event{"gravity_event", "Another gravity.", kGravity};
constinit const KeySet solver_event{"solver_event", "Another solver.", kSolver};

}  // namespace pantin::detail::keys
