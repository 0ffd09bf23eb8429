#include <algorithm>
#include <cmath>
#include <string>

#include "engine/base/rotation.hpp"
#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

/// Keys of a coordinate's limit: of a swing there are two.
std::vector<std::string_view> keys_of(const FreeCoordinate& c) {
  if (c.limit.empty()) return {};
  if (c.which == Coordinate::swing) return {c.limit, "swing"};
  return {c.limit};
}

std::vector<std::string_view> limits_of(JointKind kind) {
  std::vector<std::string_view> keys;
  for (const FreeCoordinate& c : info_of(kind).coordinates)
    for (std::string_view key : keys_of(c)) keys.push_back(key);
  return keys;
}

bool may_have(JointKind kind, std::string_view limit) {
  return std::ranges::count(limits_of(kind), limit) > 0;
}

std::string limits_in_words(JointKind kind) {
  const std::vector<std::string_view> has = limits_of(kind);
  if (!has.empty()) return "those of " + a_joint(kind) + ": " + listed(has);
  return "none: " + a_joint(kind) +
         (turns_of(kind) == Turns::nowhere ? " turns nowhere" : " has no limits");
}

void check_limits(const Reader& from, JointKind kind) {
  for (const Key& row : keys::limits.keys) {
    const std::string_view limit = row.name;
    if (limit == "soft" || limit == "restitution" || !from.has(limit)) continue;
    const std::string_view key = limit.substr(0, limit.rfind("_deg"));
    if (!may_have(kind, key))
      from.diagnostics.error_at_key(from.find(limit), "found a limit \"" + std::string(limit) +
                                                          "\", expected " + limits_in_words(kind));
  }
}

/// Warns of a range that no joint leaves, since it does not count whole turns.
void warn_of_turns(const Reader& from, std::string_view key, const AngleLimit& limit) {
  constexpr Real kTurn = 2 * kPi * (1 + 1e-9);
  if (limit.high - limit.low <= kTurn && limit.high <= kTurn && limit.low >= -kTurn) return;
  const bool in_degrees = !from.has(key);
  const Real unit = in_degrees ? 180 / kPi : 1;
  from.diagnostics.warn(
      either(from, key), "more than a turn",
      "limits from " + written(limit.low * unit) + " to " + written(limit.high * unit) +
          (in_degrees
               ? " degrees reach beyond a turn, and whole turns are not counted"
               : " rad reach beyond a turn; degrees stand under \"" + std::string(key) + "_deg\""));
}

AngleLimit read_range(const Reader& from, std::string_view key) {
  AngleLimit limit;
  Real ends[2];
  if (!read_angles(from, key, ends)) return limit;
  limit = {true, ends[0], ends[1]};
  if (limit.low <= limit.high) return limit;
  const bool in_degrees = !from.has(key);
  const Real unit = in_degrees ? 180 / kPi : 1;
  from.diagnostics.error(either(from, key), "found limits from " + written(limit.low * unit) +
                                                " to " + written(limit.high * unit) +
                                                ", expected the lower one first");
  return {};
}

/// Half angles of the cone that a swing must stay in.
SwingLimit read_swing(const Reader& from) {
  Real half[2];
  const bool is_round = either(from, "cone") != kNoNode;
  const bool is_read =
      is_round ? read_angles(from, "cone", {half, 1}) : read_angles(from, "swing", half);
  if (!is_read) return {};
  if (is_round) half[1] = half[0];
  // 180 degrees need not round to pi.
  const auto fits = [](Real x) { return x >= 0 && x <= kPi * (1 + 1e-12); };
  if (fits(half[0]) && fits(half[1])) return {true, std::min(half[0], kPi), std::min(half[1], kPi)};
  const NodeId node = either(from, is_round ? "cone" : "swing");
  const Real worst = fits(half[0]) ? half[1] : half[0];
  from.diagnostics.error(node, "found a swing of " + written(worst) + " rad (" +
                                   written(worst * 180 / kPi) +
                                   " degrees), expected 0 to pi rad (180 degrees)");
  return {};
}

void read_soft(const Reading& reading, const Reader& outer, JointLimits& limits) {
  const NodeId node = outer.find("soft");
  if (node == kNoNode) return;
  const Reader from = reading.open(node, "soft");
  Real zone = 0;
  if (read_angles(from, "zone", {&zone, 1}) && !(zone > 0))
    from.diagnostics.error_value(either(from, "zone"), "an angle above 0");
  limits.soft_zone = std::max(zone, Real(0));
  limits.soft_stiffness = from.number("stiffness");
  limits.soft_damping = from.number("damping");
}

/// Range of travel of a joint, m.
AngleLimit read_travel(const Reader& from, std::string_view key) {
  const NodeId node = from.find(key);
  Real ends[2];
  if (!from.numbers(key, ends)) return {};
  if (ends[0] <= ends[1]) return {true, ends[0], ends[1]};
  from.diagnostics.error(node, "found travel from " + written(ends[0]) + " to " + written(ends[1]) +
                                   " m, expected the lower one first");
  return {};
}

/// Whether one angle about x determines Q.
bool turns_about_x(JointKind kind) { return turns_of(kind) == Turns::about_x; }

JointLimits read_limits(const Reading& reading, const Reader& outer, RotationRecipe& turn) {
  JointLimits limits;
  const NodeId node = outer.find("limits");
  if (node == kNoNode) return limits;
  const Reader from = reading.open(node, "limits");
  check_limits(from, turn.kind);
  for (const FreeCoordinate& c : info_of(turn.kind).coordinates) {
    if (c.limit.empty()) continue;
    if (c.which == Coordinate::angle) limits.angle = read_range(from, c.limit);
    if (c.which == Coordinate::second) limits.second = read_range(from, c.limit);
    if (c.which == Coordinate::angle && !info_of(turn.kind).counts_turns)
      warn_of_turns(from, c.limit, limits.angle);
    if (c.which == Coordinate::second) warn_of_turns(from, c.limit, limits.second);
    if (c.which == Coordinate::swing) limits.swing = read_swing(from);
    if (c.which == Coordinate::travel && from.has(c.limit))
      turn.parameters.edit().travel = read_travel(from, c.limit);
  }
  read_soft(reading, from, limits);
  if (from.has("restitution")) turn.parameters.edit().restitution = from.number("restitution");
  return limits;
}

/// Accepted forms of a rotation of joint axes; `whole` is the form that every kind accepts.
std::string turn_words(JointKind kind, std::string_view whole) {
  std::string words;
  if (turns_about_x(kind)) words = "an angle, or ";
  if (turns_of(kind) == Turns::about_two) words = "two angles, or ";
  return words.append(whole);
}

/// "target", or "angle" of a hinge.
std::optional<Quat> read_target(const Reader& from, JointKind kind) {
  const NodeId angle = either(from, "angle");
  if (angle == kNoNode) return read_joint_turn(from, "target", kind);
  Real x = 0;
  if (!read_angles(from, "angle", {&x, 1})) return std::nullopt;
  if (turns_about_x(kind)) return from_rotation_vector({x, 0, 0});
  from.diagnostics.error_at_key(angle, "found the angle of " + a_joint(kind) +
                                           ", expected \"target\": only a hinge has one angle");
  return std::nullopt;
}

std::optional<PoseKey> read_pose_key(const Reading& reading, NodeId node, JointKind kind) {
  const Reader from = reading.open(node, "pose_key");
  PoseKey key{from.number("time", NAN), read_target(from, kind).value_or(kIdentity)};
  if (std::isnan(key.time)) return std::nullopt;
  return key;
}

void read_pose_keys(const Reading& reading, const Reader& from, JointKind kind, JointDrive& drive) {
  const std::vector<NodeId> nodes = from.items("keys");
  for (NodeId node : nodes) {
    const auto key = read_pose_key(reading, node, kind);
    if (!key) continue;
    if (!drive.keys.empty() && !(key->time > drive.keys.back().time))
      reading.diagnostics.error(node, "found time " + written(key->time) + " after " +
                                          written(drive.keys.back().time) +
                                          ", expected a later one");
    drive.keys.push_back(*key);
  }
  const NodeId list = from.find("keys");
  const bool is_list = list != kNoNode && from.json[list].kind == JsonKind::array;
  if (is_list && nodes.size() < (drive.loop ? 2 : 1))
    reading.diagnostics.error_value(list,
                                    drive.loop ? "two keys or more for a loop" : "one key or more");
  if (!drive.loop || drive.keys.size() < 2) return;
  const Quat last = drive.keys.back().rotation, first = drive.keys.front().rotation;
  const Real turn = glm::length(rotation_vector(last * glm::conjugate(first)));
  if (turn > 1e-6)
    reading.diagnostics.error(from.find("keys"), "found a loop whose last key is " +
                                                     written(turn * 180 / kPi) +
                                                     " degrees from its first, expected the same");
}

std::optional<JointDrive> read_pose_drive(const Reading& reading, const Reader& outer,
                                          JointKind kind) {
  const NodeId node = outer.find("drive");
  if (node == kNoNode) return std::nullopt;
  const Reader from = reading.open(node, "joint_drive");
  if (holds_point(kind) && turns_of(kind) == Turns::nowhere)
    reading.diagnostics.error_at_key(
        node, "found a drive of " + a_joint(kind) + ", expected none: it turns nowhere");
  if (!holds_point(kind))
    reading.diagnostics.error_at_key(node,
                                     "found a drive of " + a_joint(kind) +
                                         ", expected a \"motor\" or a \"spring\": drives turn "
                                         "joints that share a point");
  JointDrive drive;
  drive.loop = from.flag("loop");
  drive.target = read_target(from, kind).value_or(kIdentity);
  drive.stiffness = from.number("stiffness");
  drive.damping = from.number("damping");
  drive.max_torque = from.number("max_torque", drive.max_torque);
  read_pose_keys(reading, from, kind, drive);
  return drive;
}

/// The kind under "kind", by its name or its alias; a chain has only kinds that share a point.
JointKind read_kind(const Reader& from) {
  const bool is_chain = !from.accepts("type");
  if (!is_chain) {
    from.word("type", 0);
  }
  const NodeId node = from.find("kind");
  if (node == kNoNode) return JointKind::ball;
  std::vector<JointKind> kinds;
  std::vector<std::string_view> names;
  for (int i = 0; i < kJointKinds; ++i) {
    const JointKindInfo& info = kJointKindInfos[i];
    if (!info.in_files || (is_chain && !info.holds_point)) continue;
    kinds.push_back(static_cast<JointKind>(i)), names.push_back(info.name);
  }
  const std::string_view word =
      from.json[node].kind == JsonKind::string ? from.json[node].text : "";
  JointKind named = JointKind::ball;
  const bool is_kind = joint_kind_from_name(word, named);
  if (is_kind && std::ranges::count(kinds, named) > 0) return named;
  if (is_chain || !is_kind || info_of(named).in_files) return kinds[from.word("kind", 0, names)];
  from.diagnostics.error_value(node, "a kind that a file can tell: " + a_joint(named) +
                                         " is made in C++, with JointExtras::custom");
  return JointKind::ball;
}

}  // namespace

std::string a_joint(JointKind kind) { return std::string("a ") + name_of(kind) + " joint"; }

NodeId either(const Reader& from, std::string_view key) {
  const NodeId node = from.find(key);
  return node != kNoNode ? node : from.find(std::string(key) + "_deg");
}

bool read_angles(const Reader& from, std::string_view key, std::span<Real> into) {
  const std::string key_deg = std::string(key) + "_deg";
  const bool in_degrees = from.has(key_deg);
  const NodeId node = either(from, key);
  if (node == kNoNode) return false;
  const Range& range = in_degrees ? kDegrees : kRadians;
  if (into.size() == 1) {
    const Real angle = from.number(in_degrees ? key_deg : key, NAN, range);
    if (std::isnan(angle)) return false;
    into[0] = angle;
  } else if (!from.numbers_at(node, into, range)) {
    return false;
  }
  if (in_degrees)
    for (Real& x : into) x *= kPi / 180;
  return true;
}

std::optional<Quat> read_joint_turn(const Reader& from, std::string_view key, JointKind kind) {
  const std::string key_deg = std::string(key) + "_deg";
  const NodeId node = either(from, key);
  if (node == kNoNode) return std::nullopt;
  Real angles[2];
  if (turns_about_x(kind) && from.json[node].kind == JsonKind::number) {
    if (!read_angles(from, key, {angles, 1})) return std::nullopt;
    return from_rotation_vector({angles[0], 0, 0});
  }
  if (turns_of(kind) == Turns::about_two && from.json[node].count == 2) {
    if (!read_angles(from, key, angles)) return std::nullopt;
    return rotation_of(UniversalAngles{angles[0], angles[1]});
  }
  const bool in_degrees = !from.has(key);
  if (from.json[node].count != (in_degrees ? 3u : 4u)) {
    from.diagnostics.error_value(node, turn_words(kind, in_degrees ? "three angles in degrees"
                                                                   : "a quaternion [x, y, z, w]"));
    return std::nullopt;
  }
  const Quat turn = from.rotation(kIdentity, key);
  const Real off = glm::length(rotation_vector(allowed_by_kind(kind, turn) * glm::conjugate(turn)));
  if (off <= 1e-6) return turn;
  from.diagnostics.error(node, "found a turn " + written(off * 180 / kPi) + " degrees from what " +
                                   a_joint(kind) + " can make, expected one that it can");
  return std::nullopt;
}

RotationRecipe read_turn(const Reading& reading, const Reader& from) {
  RotationRecipe turn;
  turn.kind = read_kind(from);
  turn.limits = read_limits(reading, from, turn);
  read_parameters(reading, from, turn);
  turn.drive = read_pose_drive(reading, from, turn.kind);
  return turn;
}

}  // namespace pantin::detail
