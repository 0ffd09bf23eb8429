#include <algorithm>
#include <cmath>
#include <string>

#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

using Info = JointKindInfo;
using KindTest = bool (*)(const Info&);

/// How many coordinates springs, friction and motors may act along.
std::ptrdiff_t actuated(const Info& kind) {
  return std::ranges::count_if(kind.coordinates,
                               [](const FreeCoordinate& c) { return (c.use & kActuated) != 0; });
}
bool acts(const Info& kind) { return actuated(kind) > 0; }
bool acts_twice(const Info& kind) { return actuated(kind) > 1; }
bool is_line(const Info& kind) { return kind.is_line; }
bool is_no_line(const Info& kind) { return !kind.is_line; }

bool has_parameter(const Info& kind, std::string_view key) {
  return std::ranges::any_of(kind.parameters, [&](const Parameter& p) { return p.key == key; });
}

/// A key and the kinds that may have it.
struct KindKey {
  std::string_view key;
  KindTest fits;
};
constexpr KindKey kKindKeys[] = {
    {"point_a", is_line},    {"point_b", is_line},     {"spring", acts},
    {"friction", acts},      {"motor", acts},          {"angle", acts_twice},
    {"travel", acts_twice},  {"anchor", is_no_line},   {"axis", is_no_line},
    {"across", is_no_line},  {"axis_a", is_no_line},   {"across_a", is_no_line},
    {"axis_b", is_no_line},  {"across_b", is_no_line}, {"rest", is_no_line},
    {"rest_deg", is_no_line}};

/// Complains of what belongs to other kinds.
void check_keys(const Reader& from, JointKind kind) {
  const bool is_chain = !from.accepts("type");  // its "length" and "axis" mean other things
  const auto error = [&](std::string_view key, const std::string& expected) {
    from.diagnostics.error_at_key(from.find(key), "found \"" + std::string(key) + "\" of " +
                                                      a_joint(kind) + ", expected " + expected);
  };
  const std::string only = "it of these kinds only: ";
  for (std::string_view key : keys::kJointParameters)
    if (!is_chain && from.has(key) && !has_parameter(info_of(kind), key))
      error(key, only + kinds_where([&](const Info& info) { return has_parameter(info, key); }));
  for (const KindKey& key : kKindKeys) {
    if (key.fits(info_of(kind)) || (is_chain && key.fits != acts) || !from.has(key.key)) continue;
    error(key.key, key.fits == is_no_line
                       ? "only its ends: \"point_a\" and \"point_b\" in the scene, or "
                         "\"anchor_a\" and \"anchor_b\" in the bodies"
                       : only + kinds_where(key.fits));
  }
}

/// A coordinate of a joint or its rate: m, or an angle under `key` or `key`_deg.
Real read_coordinate(const Reader& from, std::string_view key, bool slides) {
  if (slides) {
    const std::string key_deg = std::string(key) + "_deg";
    if (from.has(key_deg))
      from.diagnostics.error_at_key(from.find(key_deg), "found \"" + key_deg +
                                                            "\" of a slide, expected \"" +
                                                            std::string(key) + "\" in m or m/s");
    return from.number(key, 0, kAnyNumber);
  }
  Real angle = 0;
  read_angles(from, key, {&angle, 1});
  return angle;
}

SpringDamper read_spring(const Reading& reading, NodeId node, bool slides) {
  SpringDamper spring;
  const Reader from = reading.open(node, "spring");
  spring.stiffness = from.number("stiffness", 0, kNotNegative);
  spring.damping = from.number("damping", 0, kNotNegative);
  spring.rest = read_coordinate(from, "rest", slides);
  if (from.is_object() && !from.has("stiffness") && !from.has("damping"))
    reading.diagnostics.error(node,
                              "found neither \"stiffness\" nor \"damping\", expected one of "
                              "them: without them a spring does nothing");
  return spring;
}

JointFriction read_friction(const Reading& reading, NodeId node) {
  JointFriction friction;
  const Reader from = reading.open(node, "friction");
  friction.viscous = from.number("viscous", 0, kNotNegative);
  friction.dry = from.number("dry", 0, kNotNegative);
  friction.slip = from.number("slip", friction.slip, kPositive);
  if (from.is_object() && !from.has("viscous") && !from.has("dry"))
    reading.diagnostics.error(node,
                              "found neither \"viscous\" nor \"dry\", expected one of them: "
                              "without them there is no friction");
  return friction;
}

JointMotor read_motor(const Reading& reading, NodeId node, bool slides) {
  constexpr std::string_view kTargets[] = {"velocity", "velocity_deg", "position", "position_deg"};
  JointMotor motor;
  const Reader from = reading.open(node, "motor");
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 2; k < 4; ++k) {
      const std::string_view both[] = {kTargets[i], kTargets[k]};
      from.one_of(both);
    }
  const bool turns_at = either(from, "velocity") != kNoNode;
  const bool stands_at = either(from, "position") != kNoNode;
  if (!turns_at && !stands_at)
    from.need("velocity", "the speed it keeps, or the \"position\" it goes to");
  motor.kind = stands_at ? MotorKind::position : MotorKind::velocity;
  motor.target = read_coordinate(from, stands_at ? "position" : "velocity", slides);
  from.need("gain", "how hard it corrects what is off: effort for each unit of it");
  motor.gain = from.number("gain", 0, kPositive);
  motor.damping = from.number("damping", 0, kNotNegative);
  motor.cap = from.number("cap", motor.cap, kNotNegative);
  if (from.has("damping") && !stands_at)
    from.diagnostics.error_at_key(from.find("damping"),
                                  "found \"damping\" of a motor that keeps a "
                                  "speed, expected it with \"position\" only");
  return motor;
}

/// "spring", "friction" and "motor".
Dof read_freedom(const Reading& reading, const Reader& from, bool slides) {
  Dof dof;
  if (const NodeId node = from.find("spring"); node != kNoNode)
    dof.spring = read_spring(reading, node, slides);
  if (const NodeId node = from.find("friction"); node != kNoNode)
    dof.friction = read_friction(reading, node);
  if (const NodeId node = from.find("motor"); node != kNoNode)
    dof.motor = read_motor(reading, node, slides);
  return dof;
}

bool has_freedom(const Reader& from) {
  return from.has("spring") || from.has("friction") || from.has("motor");
}

/// "angle" and "travel" of a cylindrical joint; they exclude "spring", "friction" and "motor"
/// beside "angle".
void read_freedoms(const Reading& reading, const Reader& from, JointParameters& parameters) {
  for (std::string_view key : {"spring", "friction", "motor"}) {
    const std::string_view both[] = {"angle", key};
    from.one_of(both);
  }
  if (const NodeId node = from.find("angle"); node != kNoNode)
    parameters.rotation = read_freedom(reading, reading.open(node, "dof"), false);
  if (const NodeId node = from.find("travel"); node != kNoNode)
    parameters.translation = read_freedom(reading, reading.open(node, "dof"), true);
}

Range range_of(const Parameter& p) {
  switch (p.range) {
    case ParameterRange::not_negative:
      return kNotNegative;
    case ParameterRange::size:
      return kSize;
    case ParameterRange::any:
      break;
  }
  return kAnyNumber;
}

void read_parameter(const Reader& from, const Parameter& p, TurnRecipe& turn) {
  if (!p.needed.empty()) from.need(p.key, p.needed);
  const NodeId node = from.find(p.key);
  if (p.as_placed) {
    if (node != kNoNode) turn.length = from.number(p.key, 1, range_of(p));
    return;
  }
  Real& value = p.value(turn.parameters.edit());
  value = from.number(p.key, 0, range_of(p));
  if (p.never_zero.empty() || node == kNoNode) return;
  if (from.json[node].kind == JsonKind::number && from.json[node].number == 0)
    from.diagnostics.error_value(node, "a number other than 0: " + std::string(p.never_zero));
}

}  // namespace

void read_parameters(const Reading& reading, const Reader& from, TurnRecipe& turn) {
  if (!from.is_object()) return;
  const Info& kind = info_of(turn.kind);
  check_keys(from, turn.kind);
  for (const Parameter& p : kind.parameters) read_parameter(from, p, turn);
  if (acts_twice(kind)) read_freedoms(reading, from, turn.parameters.edit());
  if (!acts(kind) || !has_freedom(from)) return;
  const bool slides = !kind.is_used(Coordinate::angle, kActuated);
  JointParameters& parameters = turn.parameters.edit();
  (slides ? parameters.translation : parameters.rotation) = read_freedom(reading, from, slides);
}

}  // namespace pantin::detail
