#include <algorithm>
#include <cmath>
#include <string>

#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

using Info = JointKindInfo;
using keys::acts, keys::acts_twice, keys::is_no_line;
/// Complains of what belongs to other kinds.
void check_keys(const Reader& from, JointKind kind) {
  const bool is_chain = !from.accepts("type");  // its "length" and "axis" mean other things
  const auto error = [&](std::string_view key, const std::string& expected) {
    from.diagnostics.error_at_key(from.find(key), "found \"" + std::string(key) + "\" of " +
                                                      a_joint(kind) + ", expected " + expected);
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
    error(key.name, key.fits == is_no_line
                        ? "only its ends: \"point_a\" and \"point_b\" in the scene, or "
                          "\"anchor_a\" and \"anchor_b\" in the bodies"
                        : only + kinds_where(key.fits));
  }
}

/// A coordinate of a joint or its rate: m, or an angle under `key` or `key`_deg.
Real read_coordinate(const Reader& from, std::string_view key, Coordinate along) {
  if (along == Coordinate::travel) {
    const std::string key_deg = std::string(key) + "_deg";
    if (from.has(key_deg))
      from.diagnostics.error_at_key(from.find(key_deg), "found \"" + key_deg +
                                                            "\" of a slide, expected \"" +
                                                            std::string(key) + "\" in m or m/s");
    return from.number(key, 0);
  }
  Real angle = 0;
  read_angles(from, key, {&angle, 1});
  return angle;
}

SpringDamper read_spring(const Reading& reading, NodeId node, Coordinate along) {
  SpringDamper spring;
  const Reader from = reading.open(node, "spring");
  spring.stiffness = from.number("stiffness");
  spring.damping = from.number("damping");
  spring.rest = read_coordinate(from, "rest", along);
  return spring;
}

JointFriction read_friction(const Reading& reading, NodeId node) {
  JointFriction friction;
  const Reader from = reading.open(node, "friction");
  friction.viscous = from.number("viscous");
  friction.dry = from.number("dry");
  friction.slip = from.number("slip");
  return friction;
}

JointMotor read_motor(const Reading& reading, NodeId node, Coordinate along) {
  JointMotor motor;
  const Reader from = reading.open(node, "motor");
  const bool stands_at = either(from, "position") != kNoNode;
  motor.kind = stands_at ? MotorKind::position : MotorKind::velocity;
  motor.target = read_coordinate(from, stands_at ? "position" : "velocity", along);
  motor.gain = from.number("gain", 0);
  motor.damping = from.number("damping");
  motor.cap = from.number("cap", motor.cap);
  return motor;
}

/// "spring", "friction" and "motor".
Dof read_freedom(const Reading& reading, const Reader& from, Coordinate along) {
  Dof dof;
  if (const NodeId node = from.find("spring"); node != kNoNode)
    dof.spring = read_spring(reading, node, along);
  if (const NodeId node = from.find("friction"); node != kNoNode)
    dof.friction = read_friction(reading, node);
  if (const NodeId node = from.find("motor"); node != kNoNode)
    dof.motor = read_motor(reading, node, along);
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
