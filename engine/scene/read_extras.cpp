#include <cmath>
#include <string>

#include "engine/scene/read.hpp"

namespace pantin {
namespace {

/// Sets of kinds, a bit each.
constexpr unsigned bit(JointKind kind) { return 1u << static_cast<unsigned>(kind); }
constexpr unsigned kScrew = bit(JointKind::screw), kCylinder = bit(JointKind::cylindrical),
                   kSpringKind = bit(JointKind::spring),
                   kLines = bit(JointKind::distance) | kSpringKind,
                   kMoved = bit(JointKind::hinge) | bit(JointKind::universal) | kCylinder | kScrew |
                            bit(JointKind::prismatic);

/// A key and the kinds that may have it.
struct KindKey {
  std::string_view key;
  unsigned kinds;
};
constexpr KindKey kKindKeys[] = {
    {"point_a", kLines},   {"point_b", kLines},         {"length", kLines},
    {"pitch", kScrew},     {"stiffness", kSpringKind},  {"damping", kSpringKind},
    {"spring", kMoved},    {"friction", kMoved},        {"motor", kMoved},
    {"angle", kCylinder},  {"travel", kCylinder},       {"anchor", ~kLines},
    {"axis", ~kLines},     {"across", ~kLines},         {"axis_a", ~kLines},
    {"across_a", ~kLines}, {"axis_b", ~kLines},         {"across_b", ~kLines},
    {"rest", ~kLines},     {"rest_deg", ~kLines}};

bool has_key(const KindKey& key, JointKind kind) { return (key.kinds & bit(kind)) != 0; }

std::string kinds_of(const KindKey& key) {
  std::vector<std::string_view> names;
  for (int i = 0; i < kJointKinds; ++i)
    if (has_key(key, static_cast<JointKind>(i)))
      names.push_back(name_of(static_cast<JointKind>(i)));
  return listed(names);
}

/// Complains of what belongs to other kinds.
void refuse_foreign_keys(const Reader& from, JointKind kind) {
  const bool is_chain = !from.accepts("pitch");  // its "length" and "axis" mean other things
  for (const KindKey& key : kKindKeys) {
    if (has_key(key, kind) || (is_chain && key.kinds != kMoved) || !from.has(key.key)) continue;
    const std::string found =
        "found \"" + std::string(key.key) + "\" of " + a_joint(kind) + ", expected ";
    from.complaints.refuse_key(
        from.find(key.key),
        found + (key.kinds == ~kLines ? "only its ends: \"point_a\" and \"point_b\" in the scene, "
                                        "or \"anchor_a\" and \"anchor_b\" in the bodies"
                                      : "it of these kinds only: " + kinds_of(key)));
  }
}

/// A coordinate of a joint or its rate: m, or an angle under `key` or `key`_deg.
Real read_coordinate(const Reader& from, std::string_view key, bool slides) {
  if (slides) {
    const std::string key_deg = std::string(key) + "_deg";
    if (from.has(key_deg))
      from.complaints.refuse_key(from.find(key_deg), "found \"" + key_deg +
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
    reading.complaints.refuse(node, "found neither \"stiffness\" nor \"damping\", expected one of "
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
    reading.complaints.refuse(node, "found neither \"viscous\" nor \"dry\", expected one of them: "
                                    "without them there is no friction");
  return friction;
}

Motor read_motor(const Reading& reading, NodeId node, bool slides) {
  constexpr std::string_view kTargets[] = {"velocity", "velocity_deg", "position", "position_deg"};
  Motor motor;
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
    from.complaints.refuse_key(from.find("damping"), "found \"damping\" of a motor that keeps a "
                                                     "speed, expected it with \"position\" only");
  return motor;
}

/// "spring", "friction" and "motor".
Freedom read_freedom(const Reading& reading, const Reader& from, bool slides) {
  Freedom freedom;
  if (const NodeId node = from.find("spring"); node != kNoNode)
    freedom.spring = read_spring(reading, node, slides);
  if (const NodeId node = from.find("friction"); node != kNoNode)
    freedom.friction = read_friction(reading, node);
  if (const NodeId node = from.find("motor"); node != kNoNode)
    freedom.motor = read_motor(reading, node, slides);
  return freedom;
}

bool has_freedom(const Reader& from) {
  return from.has("spring") || from.has("friction") || from.has("motor");
}

/// "angle" and "travel" of a cylindrical joint; beside them nothing stands for its turn.
void read_freedoms(const Reading& reading, const Reader& from, JointExtras& extras) {
  for (std::string_view key : {"spring", "friction", "motor"}) {
    const std::string_view both[] = {"angle", key};
    from.one_of(both);
  }
  if (const NodeId node = from.find("angle"); node != kNoNode)
    extras.turn = read_freedom(reading, reading.open(node, "dof"), false);
  if (const NodeId node = from.find("travel"); node != kNoNode)
    extras.slide = read_freedom(reading, reading.open(node, "dof"), true);
}

/// "length", and of a spring what it is made of.
void read_line(const Reader& from, TurnRecipe& turn) {
  const bool is_spring = turn.kind == JointKind::spring;
  if (from.has("length")) turn.length = from.number("length", 1, is_spring ? kNotNegative : kSize);
  if (!is_spring) return;
  from.need("stiffness", "how hard it pulls, in N/m");
  SpringDamper& spring = turn.extras.edit().slide.spring;
  spring.stiffness = from.number("stiffness", 0, kNotNegative);
  spring.damping = from.number("damping", 0, kNotNegative);
}

}  // namespace

void read_extras(const Reading& reading, const Reader& from, TurnRecipe& turn) {
  if (!from.is_object()) return;
  const JointKind kind = turn.kind;
  refuse_foreign_keys(from, kind);
  if (turn.is_line()) return read_line(from, turn);
  if (kind == JointKind::screw) {
    const NodeId node = from.need("pitch", "how far it slides for each rad it turns, in m");
    turn.extras.edit().pitch = from.number("pitch", 0, kAnyNumber);
    if (node != kNoNode && from.json[node].kind == JsonKind::number && from.json[node].number == 0)
      from.complaints.refuse_value(node, "a number other than 0: a screw without pitch is a hinge");
  }
  if (kind == JointKind::cylindrical) read_freedoms(reading, from, turn.extras.edit());
  if ((kMoved & bit(kind)) == 0 || !has_freedom(from)) return;
  const bool slides = kind == JointKind::prismatic;
  JointExtras& extras = turn.extras.edit();
  (slides ? extras.slide : extras.turn) = read_freedom(reading, from, slides);
}

}  // namespace pantin
