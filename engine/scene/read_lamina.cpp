// Laminas and their fingers: what means nothing is refused here, by name and place.
#include <algorithm>
#include <string>

#include "engine/modes/outline.hpp"
#include "engine/scene/read.hpp"

namespace pantin::detail {

using modes::Vec2;

namespace {

std::optional<Vec2> pair_if(const Reader& from, std::string_view key) {
  Real v[2];
  if (!from.has(key) || !from.numbers(key, v)) return std::nullopt;
  return Vec2{v[0], v[1]};
}

/// Tells what is wrong with a lamina or a finger, at the value that it is about.
void tell(const Reader& from, const LaminaFault& fault) {
  using enum LaminaFault::Place;
  const NodeId node = fault.place == outline  ? from.find("outline")
                      : fault.place == corner ? from.items("outline")[fault.corner]
                      : fault.place == point  ? from.find("point")
                      : fault.place == normal ? from.find("normal")
                                              : from.node;
  from.diagnostics.error(node, "found " + fault.found + ", expected " + fault.expected);
}

/// False if it bounds no area.
bool is_outline(const Reader& from, std::vector<Vec2>& corners) {
  const std::size_t count = corners.size();
  const LaminaFinding fault = check_outline(corners);
  if (fault && count < 3)
    from.diagnostics.error_value(from.find("outline"), fault->expected);
  else if (fault)
    tell(from, *fault);
  return !fault;
}

std::vector<Vec2> read_outline(const Reader& from) {
  std::vector<Vec2> corners;
  if (!from.has("outline")) return corners;
  const std::size_t before = from.diagnostics.error_count();
  for (const NodeId node : from.items("outline")) {
    Real v[2];
    if (from.numbers_at(node, v, kAnyNumber)) corners.push_back({v[0], v[1]});
  }
  if (from.diagnostics.error_count() != before || !is_outline(from, corners)) corners.clear();
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
    from.diagnostics.error_value(from.find("friction_between"),
                                 "two bounds of friction, the lower one first, not far from where "
                                 "the distribution lies");
}

void read_waypoints(const Reader& from, FingerPlan& finger) {
  start_path(finger);
  for (const NodeId node : from.items("waypoints")) {
    Real v[3];
    if (!from.numbers_at(node, v, kAnyNumber)) continue;
    if (const auto fault = add_waypoint(finger, {v[0], {v[1], v[2]}}))
      from.diagnostics.error(node, "found " + fault->found + ", expected " + fault->expected);
  }
  move_steadily(finger, pair_if(from, "velocity").value_or(Vec2{}));
}

std::optional<FingerPlan> read_finger(const Reader& from, const LaminaPlan& lamina,
                                      std::size_t number) {
  if (!from.is_object()) return std::nullopt;
  const std::size_t before = from.diagnostics.error_count();
  FingerPlan finger;
  finger.name = from.has("name") ? from.name() : std::to_string(number);
  finger.point = pair_if(from, "point").value_or(Vec2{});
  finger.flat = from.flag("flat");
  finger.normal = pair_if(from, "normal").value_or(Vec2{});
  read_friction(from, finger);
  read_waypoints(from, finger);
  if (from.diagnostics.error_count() != before || !from.has("point")) return std::nullopt;
  if (from.has("normal") && !(length(finger.normal) > 0)) {
    from.diagnostics.error_value(from.find("normal"), "a direction: two numbers, not both 0");
    return std::nullopt;
  }
  if (const auto fault = place_finger(lamina, finger)) {
    tell(from, *fault);
    if (fault->place == LaminaFault::Place::finger) return std::nullopt;
  }
  return finger;
}

void read_fingers(const Reading& reading, const Reader& from, LaminaPlan& lamina) {
  const std::vector<NodeId> nodes = from.items("fingers");
  const NodeId all = from.find("fingers");
  if (all != kNoNode && (nodes.empty() || nodes.size() > modes::kMostContacts))
    reading.diagnostics.error_value(all, "1 to 32 fingers");
  for (std::size_t i = 0; i < nodes.size() && i < modes::kMostContacts; ++i) {
    const Reader item = reading.open(nodes[i], "finger");
    const auto finger = read_finger(item, lamina, i + 1);
    if (!finger) continue;
    for (const LaminaFault& fault : repeated(lamina, *finger)) tell(item, fault);
    lamina.fingers.push_back(*finger);
  }
}

}  // namespace

std::optional<LaminaPlan> read_lamina(const Reading& reading, NodeId node, Vec3 gravity) {
  const Reader from = reading.open(node, "lamina");
  if (!from.is_object()) return std::nullopt;
  const std::size_t before = reading.diagnostics.error_count();
  LaminaPlan lamina;
  lamina.name = from.name();
  lamina.outline = read_outline(from);
  const bool is_bad = reading.diagnostics.error_count() != before;
  lamina.mass = from.number("mass");
  if (!lamina.outline.empty()) lamina.centre = modes::centroid(lamina.outline);
  lamina.centre = pair_if(from, "centre_of_mass").value_or(lamina.centre);
  const Vec2 force = pair_if(from, "force").value_or(Vec2{});
  lamina.force = {force.x + lamina.mass * gravity.x, force.y + lamina.mass * gravity.y};
  lamina.torque = from.number("torque");
  if (const auto fault = check_load(lamina)) tell(from, *fault);
  if (is_bad) return std::nullopt;  // fingers would be misjudged
  read_fingers(reading, from, lamina);
  if (reading.diagnostics.error_count() != before) return std::nullopt;
  return lamina;
}

}  // namespace pantin::detail
