// Keys of springs, friction and motors along joint coordinates, and of the parameters of joint
// kinds.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using Info = JointKindInfo;
using S = SpringDamper;
using F = JointFriction;
using M = JointMotor;
using keys::acts, keys::acts_twice, keys::is_no_line;

constexpr Key kSpring[] = {
    number<&S::stiffness>("stiffness", "N m/rad", kNotNegative, "N/m for a translation."),
    number<&S::damping>("damping", "N m s/rad", kNotNegative, "N s/m for a translation."),
    number("rest", "rad", kAnyNumber, "Rest coordinate; m for a translation.").or_else(0),
    angle_deg("rest_deg", "The same for an angle."),
};
constexpr AnyOf kSpringNeeds[] = {{"stiffness damping",
                                   "found neither \"stiffness\" nor \"damping\", expected one of "
                                   "them: without them a spring has no effect"}};

constexpr Key kFriction[] = {
    number<&F::viscous>("viscous", "N m s/rad", kNotNegative, "N s/m for a translation."),
    number<&F::dry>("dry", "N m", kNotNegative, "N for a translation."),
    number<&F::slip>("slip", "rad/s", kPositive,
                     "Rate below which dry friction fades; m/s for a translation."),
};
constexpr AnyOf kFrictionNeeds[] = {{"viscous dry",
                                     "found neither \"viscous\" nor \"dry\", expected one of them: "
                                     "without them there is no friction"}};

constexpr Key kMotor[] = {
    number("velocity", "rad/s", kAnyNumber, "Target rate; m/s for a translation."),
    number("velocity_deg", "degrees/s", kDegreesRate, "The same for an angle."),
    number("position", "rad", kAnyNumber, "Target coordinate; m for a translation."),
    angle_deg("position_deg", "The same for an angle."),
    number<&M::gain>(
        "gain", "N m s/rad or N m/rad", kPositive,
        "Torque per unit of error; N s/m or N/m for a translation. Default: the motor is "
        "critically "
        "damped, for the inertia that it moves at the start, as fast as the step resolves.")
        .without_default(),
    number<&M::damping>("damping", "N m s/rad", kNotNegative,
                        "With a position only; N s/m for a translation."),
    number<&M::cap>("cap", "N m", kNotNegative,
                    "Maximum torque; N for a translation. Default: unlimited."),
};
constexpr Exclusive kMotorPairs[] = {{"velocity", "position position_deg"},
                                     {"velocity_deg", "position position_deg"}};
constexpr AnyOf kMotorNeeds[] = {
    {"velocity velocity_deg position position_deg",
     "found no \"velocity\", expected a target rate, or a target \"position\""}};
constexpr Beside kMotorPartners[] = {
    {"damping", "position position_deg",
     "found \"damping\" of a velocity motor, expected it with \"position\" only"},
    {"damping", "gain",
     "found \"damping\" without \"gain\", expected both, or neither: they are then chosen"}};

constexpr Key kDof[] = {
    object("spring", "spring", "Default: none."),
    object("friction", "friction", "Default: none."),
    object("motor", "motor", "Default: none."),
};

/// Reports keys that belong to other kinds.
void check_keys(const Reader& from, JointKind kind) {
  const bool is_chain = !from.accepts("type");  // its "length" and "axis" mean other things
  const auto error = [&](std::string_view key, const std::string& expected) {
    from.error_at_key(
        key, "found \"" + std::string(key) + "\" of " + a_joint(kind) + ", expected " + expected);
  };
  const std::string only = "it of these kinds only: ";
  for (const Key& key : keys::joint_parameters())
    if (!is_chain && from.has(key.name) && !keys::parameter_of(info_of(kind), key.name))
      error(key.name, only + kinds_where([&](const Info& info) {
                        return keys::parameter_of(info, key.name) != nullptr;
                      }));
  for (const Key& key : (is_chain ? keys::chain : keys::joint).keys) {
    const bool is_told_elsewhere = key.fits == keys::is_driven;
    if (!key.fits || key.fits(info_of(kind)) || is_told_elsewhere || !from.has(key.name)) continue;
    error(key.name, key.fits == is_no_line ? "only its ends: \"point_a\" and \"point_b\" in the "
                                             "scene, or \"anchor_a\" and \"anchor_b\" in the bodies"
                                           : only + kinds_where(key.fits));
  }
}

}  // namespace

Real read_coordinate(const Reader& from, std::string_view key, Coordinate along) {
  const std::string key_deg = std::string(key) + "_deg";
  const bool in_degrees = from.has(key_deg);
  if (in_degrees && along != Coordinate::travel) return from.number(key_deg, 0) * (kPi / 180);
  if (in_degrees)
    from.error_at_key(key_deg, "found \"" + key_deg + "\" for a travel, expected \"" +
                                   std::string(key) + "\" in m or m/s");
  return from.number(key, 0);
}

namespace {

/// Converts numbers along a coordinate to SI, of those keys that the file gives.
struct ToSi {
  const Reading& reading;
  Coordinate along;

  struct Member {
    std::string_view key;
    Real& value;
  };
  void operator()(const Reader& from, std::initializer_list<Member> members) const {
    if (reading.length_unit == 1) return;
    for (const Member& m : members)
      if (from.has(m.key)) m.value *= to_si(from.row(m.key).unit, along, reading.length_unit);
  }
};

/// "spring", "friction" and "motor".
Dof read_freedom(const Reading& reading, const Reader& from, Coordinate along) {
  Dof dof;
  const ToSi to_si_units{reading, along};
  if (const NodeId node = from.find("spring"); node != kNoNode) {
    const Reader spring = reading.open(node, "spring");
    read_rows(reading, spring, dof.spring);
    dof.spring.rest = read_coordinate(spring, "rest", along);
    to_si_units(spring, {{"stiffness", dof.spring.stiffness},
                         {"damping", dof.spring.damping},
                         {"rest", dof.spring.rest}});
  }
  if (const NodeId node = from.find("friction"); node != kNoNode) {
    const Reader friction = reading.open(node, "friction");
    read_rows(reading, friction, dof.friction);
    to_si_units(friction, {{"viscous", dof.friction.viscous},
                           {"dry", dof.friction.dry},
                           {"slip", dof.friction.slip}});
  }
  if (const NodeId node = from.find("motor"); node != kNoNode) {
    const Reader motor = reading.open(node, "motor");
    read_rows(reading, motor, dof.motor);
    const bool stands_at = either(motor, "position") != kNoNode;
    dof.motor.kind = stands_at ? MotorKind::position : MotorKind::velocity;
    const std::string_view target = stands_at ? "position" : "velocity";
    dof.motor.target = read_coordinate(motor, target, along);
    to_si_units(motor, {{target, dof.motor.target},
                        {"gain", dof.motor.gain},
                        {"damping", dof.motor.damping},
                        {"cap", dof.motor.cap}});
  }
  return dof;
}

bool has_freedom(const Reader& from) {
  return from.has("spring") || from.has("friction") || from.has("motor");
}

/// "angle" and "travel" of a cylindrical joint.
void read_freedoms(const Reading& reading, const Reader& from, JointParameters& parameters) {
  if (const NodeId node = from.find("angle"); node != kNoNode)
    parameters.rotation = read_freedom(reading, reading.open(node, "dof"), Coordinate::angle);
  if (const NodeId node = from.find("travel"); node != kNoNode)
    parameters.translation = read_freedom(reading, reading.open(node, "dof"), Coordinate::travel);
}

void read_parameter(const Reader& from, const Parameter& p, RotationRecipe& turn) {
  const Range range = keys::range_of(p);
  if (!p.needed.empty()) from.need(p.key);
  if (!p.as_placed)
    p.value(turn.parameters.edit()) = from.number(p.key, 0, range);
  else if (from.has(p.key))
    turn.length = from.number(p.key, 1, range);
}

}  // namespace

constinit const KeySet keys::spring{
    "spring", "A spring and damper about or along x. Needs stiffness, damping or both.", kSpring,
    kNoPairs, kSpringNeeds};
constinit const KeySet keys::friction{"friction",
                                      "Friction of a joint: viscous times the rate, and dry times "
                                      "tanh(rate / slip). Needs one of them or both.",
                                      kFriction, kNoPairs, kFrictionNeeds};
constinit const KeySet keys::motor{
    "motor",
    "Keeps a velocity with gain times the velocity error, or moves to a position with gain times "
    "the position error, less damping times the rate; limited to cap.",
    kMotor,
    kMotorPairs,
    kMotorNeeds,
    kMotorPartners};
constinit const KeySet keys::dof{"dof", "Forces along one degree of freedom of a joint.", kDof};

void read_parameters(const Reading& reading, const Reader& from, RotationRecipe& turn) {
  if (!from.is_object()) return;
  const Info& kind = info_of(turn.kind);
  check_keys(from, turn.kind);
  for (const Parameter& p : kind.parameters) read_parameter(from, p, turn);
  if (acts_twice(kind)) read_freedoms(reading, from, turn.parameters.edit());
  if (!acts(kind) || !has_freedom(from)) return;
  JointParameters& parameters = turn.parameters.edit();
  if (kind.is_used(Coordinate::angle, kActuated))
    parameters.rotation = read_freedom(reading, from, Coordinate::angle);
  else
    parameters.translation = read_freedom(reading, from, Coordinate::travel);
}

}  // namespace pantin::detail
