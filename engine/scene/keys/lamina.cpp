// Keys of laminas and of their fingers; invalid values are rejected by name and position.
#include <algorithm>
#include <string>

#include "engine/modes/outline.hpp"
#include "engine/scene/read/read.hpp"

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
        "Corners [x, y] of its outline at the start, in order, in the scene's xy plane. Default: "
        "unknown; then every finger needs a normal and the lamina cannot be moved."),
    number<&L::mass>("mass", "kg", kNotNegative, "Its weight is mass times the scene's gravity."),
    pair("centre_of_mass", "m",
         "At the start. Default: the middle of the outline's area; the origin without an outline."),
    pair("force", "N", "External force on the mass centre. Default: none."),
    number<&L::torque>("torque", "N m", kAnyNumber, "External torque, counter-clockwise."),
    objects("fingers", "finger", "The fingers that hold or push it, 1 to 32.")
        .needed("1 to 32 fingers"),
};

constexpr Key kFinger[] = {
    own_name("Default: its number, from 1."),
    pair<&F::point>("point", "m",
                    "Contact point at the start; with an outline it may start outside.")
        .needed("a point: two numbers"),
    pair<&F::normal>("normal", "",
                     "Into the lamina, of any length. Default: normal to the outline's edge."),
    flag<&F::flat>("flat",
                   "Whether the finger is an edge, perpendicular to its normal, that a corner of "
                   "the lamina touches; otherwise it is a point that touches an edge."),
    pair("velocity", "m/s", "Constant. Default: it rests."),
    row("waypoints", ValueType::points, "s, m, m",
        "Instead: [time, x, y] after the start, in order of time. It moves at constant velocity "
        "from one to the next, and rests after the last."),
    row("friction", ValueType::number_or_pair, "",
        "Coefficient of Coulomb friction, or two: for rolling (sticking) and for sliding. Default "
        "0.5.")
        .within(kNotNegative),
    pair("friction_between", "",
         "Bounds of an uncertain coefficient; the same for rolling and sliding. Default: none, it "
         "is known.")
        .within(kNotNegative),
    number("friction_deviation", "", kPositive,
           "Of a normal distribution about \"friction\", truncated at these bounds. Default: a "
           "uniform distribution between them."),
};
constexpr Exclusive kFingerPairs[] = {{"velocity", "waypoints"}};
constexpr Beside kFingerPartners[] = {
    {"friction_deviation", "friction_between",
     "found \"friction_deviation\" without \"friction_between\", expected the bounds too"}};

std::optional<Vec2> pair_if(const Reader& from, std::string_view key) {
  Real v[2];
  if (!from.has(key) || !from.numbers(key, v)) return std::nullopt;
  return Vec2{v[0], v[1]};
}

/// Reports the fault of a lamina or a finger at the value concerned.
void tell(const Reader& from, const LaminaFault& fault) {
  using enum LaminaFault::Place;
  const NodeId node = fault.place == outline  ? from.find("outline")
                      : fault.place == corner ? from.items("outline")[fault.corner]
                      : fault.place == point  ? from.find("point")
                      : fault.place == normal ? from.find("normal")
                                              : from.node;
  from.diagnostics.error(node, "found " + fault.found + ", expected " + fault.expected);
}

/// Returns false if the outline encloses no area.
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
    const auto finger = read_finger(reading, item, lamina, i + 1);
    if (!finger) continue;
    for (const LaminaFault& fault : repeated(lamina, *finger)) tell(item, fault);
    lamina.fingers.push_back(*finger);
  }
}

}  // namespace

constinit const KeySet keys::lamina{
    "lamina",
    "A rigid part in the scene's xy plane, held or pushed by fingers quasistatically. `pantin "
    "modes` tells which contacts stick, slide or separate, and for which friction.",
    kLamina};
constinit const KeySet keys::finger{
    "finger", "A point, or an edge, that touches a lamina and moves as prescribed.",
    kFinger,  kFingerPairs,
    kNoNeeds, kFingerPartners};

bool read_value(const RowValue& row, Vec2& to) {
  to = pair_if(row.from, row.key.name).value_or(to);
  return true;
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
  if (const auto fault = check_load(lamina)) tell(from, *fault);
  if (is_bad) return std::nullopt;  // fingers would be checked against a wrong outline
  read_fingers(reading, from, lamina);
  if (reading.diagnostics.error_count() != before) return std::nullopt;
  return lamina;
}

}  // namespace pantin::detail
