// Keys of laminas and of their fingers; what means nothing is refused by name and place.
#include <algorithm>
#include <string>

#include "engine/modes/outline.hpp"
#include "engine/scene/read.hpp"

namespace pantin::detail {

using modes::Vec2;

namespace {

using namespace rows;
using L = LaminaPlan;
using F = FingerPlan;

template <auto... path>
constexpr Key pair(Text name, Text unit, Text about) {
  return row<path...>(name, ValueType::numbers, unit, about).holding(2);
}

constexpr Key kLamina[] = {
    needed_name(),
    row("outline", ValueType::pairs, "m",
        "Corners [x, y] of its outline at the start, in order, in the scene's x-y plane. Default: "
        "unknown; then every finger tells its normal and the lamina cannot be moved on."),
    number<&L::mass>("mass", "kg", kNotNegative, "It weighs mass times the scene's gravity."),
    pair("centre_of_mass", "m",
         "At the start. Default: the middle of the outline's area; the origin without an outline."),
    pair("force", "N", "What else acts on the mass centre. Default: nothing."),
    number<&L::torque>("torque", "N m", kAnyNumber, "What else turns it, counter-clockwise."),
    objects("fingers", "finger", "What holds or pushes it, 1 to 32.").needed("1 to 32 fingers"),
};

constexpr Key kFinger[] = {
    own_name("Default: its number, from 1."),
    pair<&F::point>("point", "m",
                    "Where it touches at the start; with an outline it may wait outside.")
        .needed("a point: two numbers"),
    pair<&F::normal>("normal", "",
                     "Into the lamina, of any length. Default: across the outline's edge."),
    flag<&F::flat>("flat",
                   "Whether the finger is an edge, across its normal, that a corner of the lamina "
                   "touches; otherwise it is a point that touches an edge."),
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

constexpr Real kTouch = 1e-6;        // of the outline's extent: a point this near is on it
constexpr Real kLeastArea = 1e-12;   // of the extent's square
constexpr Real kLeastExtent = 1e-9;  // m

std::string written(Vec2 p) {
  return "[" + detail::written(p.x + 0.0) + ", " + detail::written(p.y + 0.0) + "]";  // no -0
}

std::optional<Vec2> pair_if(const Reader& from, std::string_view key) {
  Real v[2];
  if (!from.has(key) || !from.numbers(key, v)) return std::nullopt;
  return Vec2{v[0], v[1]};
}

/// Refuses outlines that bound no area; false if it did.
bool check_outline(const Reader& from, std::vector<Vec2>& corners) {
  Diagnostics& d = from.diagnostics;
  const NodeId node = from.find("outline");
  if (corners.size() < 3) {
    d.error_value(node, "three corners or more");
    return false;
  }
  const std::vector<NodeId> nodes = from.items("outline");
  const Real size = modes::extent(corners);
  if (!(size >= kLeastExtent)) {
    d.error(node,
            "found an outline " + detail::written(size) + " m large, expected 1e-9 m or more");
    return false;
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::size_t next = (i + 1) % corners.size();
    if (length(corners[next] - corners[i]) > kTouch * size) continue;
    d.error(nodes[next], "found the corner before again, expected another");
    return false;
  }
  if (const auto pair = modes::crossing(corners)) {
    d.error(node, "found edges from corners " + std::to_string(pair->first) + " and " +
                      std::to_string(pair->second) + " that meet, expected none that do");
    return false;
  }
  const Real area = modes::area(corners);
  if (std::abs(area) <= kLeastArea * size * size) {
    d.error(node, "found corners on one line, expected an outline around some area");
    return false;
  }
  if (area < 0) std::reverse(corners.begin(), corners.end());
  return true;
}

std::vector<Vec2> read_outline(const Reader& from) {
  std::vector<Vec2> corners;
  if (!from.has("outline")) return corners;
  const std::size_t before = from.diagnostics.error_count();
  for (const NodeId node : from.items("outline")) {
    Real v[2];
    if (from.numbers_at(node, v, kAnyNumber)) corners.push_back({v[0], v[1]});
  }
  if (from.diagnostics.error_count() != before || !check_outline(from, corners)) corners.clear();
  return corners;
}

void read_friction(const Reader& from, FingerPlan& finger) {
  const NodeId node = from.find("friction");
  Real two[2];
  if (node != kNoNode && from.json[node].kind == JsonKind::array) {
    if (from.numbers("friction", two)) finger.roll = two[0], finger.slide = two[1];
  } else {
    finger.roll = finger.slide = from.number("friction", 0.5);
  }
  finger.spread = modes::Spread::at(finger.slide);
  if (!from.has("friction_between") || !from.numbers("friction_between", two)) {
    from.number("friction_deviation", 1);
    return;
  }
  finger.spread = modes::Spread::between(two[0], two[1]);
  if (from.has("friction_deviation"))
    finger.spread =
        modes::Spread::around(finger.slide, from.number("friction_deviation", 1), two[0], two[1]);
  if (const auto good = modes::check(std::span(&finger.spread, 1), 1); !good)
    from.error_value(
        "friction_between",
        "two bounds of friction, the lower one first, not far from where the distribution lies");
}

void read_waypoints(const Reader& from, FingerPlan& finger) {
  finger.path = {{0, finger.point}};
  for (const NodeId node : from.items("waypoints")) {
    Real v[3];
    if (!from.numbers_at(node, v, kAnyNumber)) continue;
    if (!(v[0] > finger.path.back().time))
      from.diagnostics.error(node, "found time " + detail::written(v[0]) + " after " +
                                       detail::written(finger.path.back().time) +
                                       ", expected a later one");
    finger.path.push_back({v[0], {v[1], v[2]}});
  }
  if (finger.path.size() > 1) return;
  const Vec2 velocity = pair_if(from, "velocity").value_or(Vec2{});
  constexpr Real kForEver = 1e6;  // s
  finger.path.push_back({kForEver, finger.point + kForEver * velocity});
}

/// Where the finger starts, and if it is steady where it goes to.
void shift(FingerPlan& finger, Vec2 by) {
  finger.point = finger.point + by;
  finger.path[0].at = finger.point;
  if (finger.path.size() == 2) finger.path[1].at = finger.path[1].at + by;
}

/// A point finger against an outline: the edge that it touches, or that it waits off.
void place_on_edge(const Reader& from, const LaminaPlan& lamina, FingerPlan& finger) {
  const Real tolerance = kTouch * modes::extent(lamina.outline);
  const modes::Nearest at = modes::nearest_edge(lamina.outline, finger.point, tolerance);
  finger.touches = at.distance <= tolerance;
  const NodeId point = from.find("point");
  const modes::Edge edge = modes::edge_of(lamina.outline, at.edge);
  const Vec2 across = edge.normal;
  if (!finger.touches) {
    if (!from.has("normal")) finger.normal = across;
    if (modes::is_inside(lamina.outline, finger.point))
      from.diagnostics.error(point, "found a point " + detail::written(at.distance) +
                                        " m inside the outline, expected one on it or outside");
    return;
  }
  shift(finger, -dot(across, finger.point - edge.from) * across);
  const bool told = from.has("normal");
  if (at.is_corner && !told)
    from.diagnostics.error(point, "found a corner of the outline, expected a \"normal\" too");
  if (!at.is_corner && told && length(finger.normal - across) > 1e-6)
    from.error("normal",
               "found " + written(finger.normal) + ", expected the edge's own, " + written(across));
  if (!told) finger.normal = across;
}

/// A flat finger: a corner of the lamina lies on it, or before it.
void place_on_corner(const Reader& from, const LaminaPlan& lamina, FingerPlan& finger) {
  const Real size = modes::extent(lamina.outline);
  Real least = 1e300;
  for (const Vec2 c : lamina.outline) least = std::min(least, dot(finger.normal, c - finger.point));
  finger.touches = least <= kTouch * size;
  if (finger.touches && least > -kTouch * size) shift(finger, least * finger.normal);
  if (least < -kTouch * size)
    from.error("point", "found a flat finger " + detail::written(-least) +
                            " m inside the outline, expected it outside");
}

std::optional<FingerPlan> read_finger(const Reading& reading, const Reader& from,
                                      const LaminaPlan& lamina, std::size_t number) {
  if (!from.is_object()) return std::nullopt;
  const std::size_t before = from.diagnostics.error_count();
  FingerPlan finger;
  finger.name = from.has("name") ? from.name() : std::to_string(number);
  read_rows(reading, from, finger);
  read_friction(from, finger);
  read_waypoints(from, finger);
  if (from.diagnostics.error_count() != before || !from.has("point")) return std::nullopt;
  const bool is_bare = lamina.outline.empty();
  if (const Real size = length(finger.normal); size > 0)
    finger.normal = 1 / size * finger.normal;
  else if (from.has("normal"))
    from.error_value("normal", "a direction: two numbers, not both 0");
  else if (is_bare || finger.flat)
    from.error("found no \"normal\", expected one: two numbers, into the lamina");
  if (from.diagnostics.error_count() != before) return std::nullopt;
  if (!is_bare && finger.flat) place_on_corner(from, lamina, finger);
  if (!is_bare && !finger.flat) place_on_edge(from, lamina, finger);
  return finger;
}

void read_fingers(const Reading& reading, const Reader& from, LaminaPlan& lamina) {
  const std::vector<NodeId> nodes = from.items("fingers");
  const NodeId all = from.find("fingers");
  if (all != kNoNode && (nodes.empty() || nodes.size() > modes::kMostContacts))
    reading.diagnostics.error_value(all, "1 to 32 fingers");
  for (std::size_t i = 0; i < nodes.size() && i < modes::kMostContacts; ++i) {
    const Reader item = reading.open(nodes[i], "finger");
    const auto finger = read_finger(reading, item, lamina, i + 1);
    if (!finger) continue;
    for (std::size_t j = 0; j < lamina.fingers.size(); ++j) {
      const FingerPlan& other = lamina.fingers[j];
      if (other.name == finger->name)
        reading.diagnostics.error(
            nodes[i], "found the name \"" + finger->name + "\" again, expected another");
      else if (length(other.point - finger->point) == 0 &&
               length(other.normal - finger->normal) == 0)
        reading.diagnostics.error(nodes[i], "found the point and the normal of \"" + other.name +
                                                "\" again, expected another contact");
    }
    lamina.fingers.push_back(*finger);
  }
}

}  // namespace

constinit const KeySet keys::lamina{
    "lamina",
    "A rigid part in the scene's x-y plane, held or pushed by fingers so slowly that inertia does "
    "not count. `pantin modes` tells which contacts stick, slide or separate, and for which "
    "friction.",
    kLamina};
constinit const KeySet keys::finger{
    "finger", "A point, or an edge, that touches a lamina and moves as it is told.",
    kFinger,  kFingerPairs,
    kNoNeeds, kFingerPartners};

bool read_value(const RowValue& row, Vec2& to) {
  to = pair_if(row.from, row.key.name).value_or(to);
  return true;
}

Vec2 first_velocity(const FingerPlan& finger) {
  const Waypoint &a = finger.path[0], &b = finger.path[1];
  return 1 / (b.time - a.time) * (b.at - a.at);
}

std::optional<LaminaPlan> read_lamina(const Reading& reading, NodeId node, Vec3 gravity) {
  const Reader from = reading.open(node, "lamina");
  if (!from.is_object()) return std::nullopt;
  const std::size_t before = reading.diagnostics.error_count();
  LaminaPlan lamina;
  lamina.name = from.name();
  lamina.outline = read_outline(from);
  const bool is_bad = reading.diagnostics.error_count() != before;
  read_rows(reading, from, lamina);
  if (!lamina.outline.empty()) lamina.centre = modes::centroid(lamina.outline);
  lamina.centre = pair_if(from, "centre_of_mass").value_or(lamina.centre);
  const Vec2 force = pair_if(from, "force").value_or(Vec2{});
  lamina.force = {force.x + lamina.mass * gravity.x, force.y + lamina.mass * gravity.y};
  if (lamina.load() == Vec3(0))
    reading.diagnostics.error(node,
                              "found no load, expected a \"force\", a \"torque\" or weight: "
                              "without one all that the fingers allow holds without force");
  if (is_bad) return std::nullopt;  // fingers would be misjudged
  read_fingers(reading, from, lamina);
  if (reading.diagnostics.error_count() != before) return std::nullopt;
  return lamina;
}

}  // namespace pantin::detail
