// Keys of the limits of joints.
#include <algorithm>
#include <cmath>
#include <string>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using L = JointLimits;

constexpr Key kLimits[] = {
    angles("angle", "Of a hinge, cylindrical, screw or planar joint about x: minimum and maximum."),
    angles_deg("angle_deg", "The same."),
    angles("twist", "Of a ball about x: minimum and maximum."),
    angles_deg("twist_deg", "The same."),
    angle("cone",
          "Of a ball: maximum swing of x, half the cone's opening, 0 to half a turn. Less than "
          "1e-3 rad "
          "makes the joint a hinge about x under \"auto\"."),
    angle_deg("cone_deg", "The same."),
    angles("swing",
           "Of a ball: half openings of an elliptic cone, for swings about y and about z, 0 to "
           "half a turn."),
    angles_deg("swing_deg", "The same."),
    angles("first", "Of a universal joint about y of a: minimum and maximum."),
    angles_deg("first_deg", "The same."),
    angles("second", "Of a universal joint about z of b: minimum and maximum."),
    angles_deg("second_deg", "The same."),
    object("soft", "soft", "A spring near each stop. Default: none."),
    row("travel", ValueType::numbers, "m",
        "Of a cylindrical, prismatic or screw joint: minimum and maximum of b's anchor along x "
        "from a's.")
        .holding(2),
    number("restitution", "", kUnit,
           "Coefficient of restitution at a stop. For the solver lagrangian.")
        .or_else(0),
};
constexpr Exclusive kLimitPairs[] = {{"cone", "swing swing_deg"}, {"cone_deg", "swing swing_deg"}};
constexpr Beside kLimitPartners[] = {
    {"soft",
     "angle angle_deg twist twist_deg cone cone_deg swing swing_deg first first_deg second "
     "second_deg",
     "found \"soft\" without a limit, expected a limit beside it"}};

constexpr Key kSoft[] = {
    angle("zone", "Distance before the stop at which they begin, above 0."),
    angle_deg("zone_deg", "The same."),
    number<&L::soft_stiffness>("stiffness", "N m/rad", kNotNegative, "Of the spring."),
    number<&L::soft_damping>("damping", "N m s/rad", kNotNegative, "Of the damper."),
};
constexpr AnyOf kSoftNeeds[] = {{"zone zone_deg",
                                 "found no \"zone\", expected how far before the stop the spring "
                                 "begins, in rad, or \"zone_deg\""}};

/// The keys of a coordinate's limit; a swing has two.
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
         (turns_of(kind) == Turns::nowhere ? " has no rotation" : " has no limits");
}

void check_limits(const Reader& from, JointKind kind) {
  for (const Key& row : keys::limits.keys) {
    const std::string_view limit = row.name;
    if (limit == "soft" || limit == "restitution" || !from.has(limit)) continue;
    const std::string_view key = limit.substr(0, limit.rfind("_deg"));
    if (!may_have(kind, key))
      from.error_at_key(
          limit, "found a limit \"" + std::string(limit) + "\", expected " + limits_in_words(kind));
  }
}

/// Warns of a range that covers a whole turn and so never limits: angles do not count turns.
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

/// Minimum and maximum of an angle, or of a travel in m.
AngleLimit read_range(const Reader& from, const FreeCoordinate& c) {
  const bool travels = c.which == Coordinate::travel;
  Real ends[2];
  if (!(travels ? from.numbers(c.limit, ends) : read_angles(from, c.limit, ends))) return {};
  if (ends[0] <= ends[1]) return {true, ends[0], ends[1]};
  const Real unit = from.has(c.limit) ? 1 : 180 / kPi;
  from.diagnostics.error(either(from, c.limit),
                         (travels ? "found travel from " : "found limits from ") +
                             written(ends[0] * unit) + " to " + written(ends[1] * unit) +
                             (travels ? " m" : "") + ", expected the lower one first");
  return {};
}

/// Half angles of the cone that limits a swing.
SwingLimit read_swing(const Reader& from) {
  Real half[2];
  const bool is_round = either(from, "cone") != kNoNode;
  const bool is_read =
      is_round ? read_angles(from, "cone", {half, 1}) : read_angles(from, "swing", half);
  if (!is_read) return {};
  if (is_round) half[1] = half[0];
  // 180 degrees may round to more than pi.
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
  read_rows(reading, from, limits);
}

}  // namespace

constinit const KeySet keys::limits{
    "limits",
    "Limits of a joint's rotation, measured from Q = 1, or translation. A ball has twist and cone "
    "or swing; a hinge, cylindrical, screw or planar joint angle; a universal joint first and "
    "second; a joint that translates along x travel.",
    kLimits,
    kLimitPairs,
    kNoNeeds,
    kLimitPartners};
constinit const KeySet keys::soft{"soft", "A spring and a damper that act near a stop.", kSoft,
                                  kNoPairs, kSoftNeeds};

JointLimits read_limits(const Reading& reading, const Reader& outer, RotationRecipe& turn) {
  JointLimits limits;
  const NodeId node = outer.find("limits");
  if (node == kNoNode) return limits;
  const Reader from = reading.open(node, "limits");
  check_limits(from, turn.kind);
  for (const FreeCoordinate& c : info_of(turn.kind).coordinates) {
    if (c.limit.empty()) continue;
    if (c.which == Coordinate::angle) limits.angle = read_range(from, c);
    if (c.which == Coordinate::second) limits.second = read_range(from, c);
    if (c.which == Coordinate::angle && !info_of(turn.kind).counts_turns)
      warn_of_turns(from, c.limit, limits.angle);
    if (c.which == Coordinate::second) warn_of_turns(from, c.limit, limits.second);
    if (c.which == Coordinate::swing) limits.swing = read_swing(from);
    if (c.which == Coordinate::travel && from.has(c.limit))
      turn.parameters.edit().travel = read_range(from, c);
  }
  read_soft(reading, from, limits);
  if (from.has("restitution")) turn.parameters.edit().restitution = from.number("restitution");
  return limits;
}

}  // namespace pantin::detail
