#include "engine/scene/read/units.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/scene/keys/keys.hpp"

namespace pantin::detail {
namespace {

/// Kinds of objects whose readers convert their numbers.
constexpr std::string_view kByCoordinate[] = {"spring",      "friction",    "motor",       "gear",
                                              "motor_event", "free_number", "drive_motion"};
/// Kinds of objects that are told apart by "type", and the suffix of their names.
struct Typed {
  std::string_view object, suffix;
};
constexpr Typed kTyped[] = {
    {"shape", ""}, {"event", "_event"}, {"face", "_face"}, {"curve", "_curve"}};

bool is_unit_sign(char c) { return c != ' ' && c != '/' && c != '^'; }

/// Multiplies the numbers of a value, in arrays too.
struct Scaling {
  JsonDocument& json;
  double length_unit;

  void scale(NodeId node, double factor) {
    if (json[node].kind == JsonKind::number) json.nodes[node].number *= factor;
    if (json[node].kind != JsonKind::array) return;
    for (NodeId c = json[node].first_child; c != kNoNode; c = json[c].next) scale(c, factor);
  }
  /// The items of an array except each n-th, from `first` on.
  void scale_all_but(NodeId array, std::size_t n, std::size_t first) {
    std::size_t i = 0;
    if (json[array].kind != JsonKind::array) return;
    for (NodeId c = json[array].first_child; c != kNoNode; c = json[c].next, ++i)
      if (i % n != first) scale(c, length_unit);
  }
  void convert_value(const Key& key, NodeId value);
  void convert_object(std::string_view what, NodeId object);
  void convert(const KeySet& set, NodeId object);
};

void Scaling::convert_value(const Key& key, NodeId value) {
  if (key.name == "trims") return;  // in the plane of the parameters
  if (!key.object.empty()) {
    if (json[value].kind == JsonKind::object) return convert_object(key.object, value);
    if (json[value].kind != JsonKind::array) return;
    for (NodeId c = json[value].first_child; c != kNoNode; c = json[c].next)
      convert_object(key.object, c);
  } else if (key.name == "homogeneous") {
    scale_all_but(value, 4, 3);  // x w, y w, z w, w
  } else if (key.name == "waypoints") {
    for (NodeId c = json[value].first_child; c != kNoNode; c = json[c].next)
      scale_all_but(c, 3, 0);  // time, x, y
  } else if (const int exponent = length_exponent(key.unit); exponent != 0) {
    scale(value, std::pow(length_unit, exponent));
  }
}

void Scaling::convert_object(std::string_view what, NodeId object) {
  if (json[object].kind != JsonKind::object) return;
  const auto typed = std::ranges::find(kTyped, what, &Typed::object);
  std::string name(what);
  if (typed != std::end(kTyped)) {
    const NodeId type = json.member(object, "type");
    if (type == kNoNode || json[type].kind != JsonKind::string) return;
    name = std::string(json[type].text) + std::string(typed->suffix);
  }
  if (std::ranges::count(kByCoordinate, name) > 0) return;
  for (const KeySet* set : all_key_sets())
    if (set->what == name) return convert(*set, object);
}

void Scaling::convert(const KeySet& set, NodeId object) {
  for (NodeId c = json[object].first_child; c != kNoNode; c = json[c].next) {
    const std::string_view name = json[c].key;
    const auto key = std::ranges::find_if(
        set.keys, [&](const Key& k) { return k.name == name || (!name.empty() && k.old == name); });
    if (key != set.keys.end()) convert_value(*key, c);
  }
}

}  // namespace

double length_unit_of(const JsonDocument& scene) {
  if (scene.nodes.empty() || scene[0].kind != JsonKind::object) return 1;
  const NodeId unit = scene.member(0, "units");
  if (unit == kNoNode || scene[unit].kind != JsonKind::string) return 1;
  const auto word = std::ranges::find(kLengthUnits, scene[unit].text);
  return word == std::end(kLengthUnits) ? 1 : kMetresOf[word - std::begin(kLengthUnits)];
}

int length_exponent(std::string_view unit) {
  unit = unit.substr(0, unit.find(" or "));
  if (unit == "kg/m^3") return 0;
  int exponent = 0, sign = 1;
  for (std::size_t i = 0; i < unit.size();) {
    if (!is_unit_sign(unit[i])) {
      if (unit[i] == '/') sign = -1;  // all that follows
      ++i;
      continue;
    }
    const std::size_t start = i;
    while (i < unit.size() && is_unit_sign(unit[i])) ++i;
    const std::string_view symbol = unit.substr(start, i - start);
    int power = 1;
    if (i + 1 < unit.size() && unit[i] == '^') power = unit[i + 1] - '0', i += 2;
    if (symbol == "m") exponent += sign * power;
  }
  return exponent;
}

double to_si(std::string_view unit, Coordinate along, double length_unit) {
  int exponent = length_exponent(unit);
  if (along == Coordinate::travel) {
    const std::string_view first = unit.substr(0, unit.find(" or "));
    const std::size_t slash = first.find('/');
    if (first.starts_with("N m")) --exponent;
    if (first.starts_with("rad")) ++exponent;
    if (slash != first.npos && first.find("rad", slash) != first.npos) --exponent;
  }
  return std::pow(length_unit, exponent);
}

void convert_to_si(JsonDocument& scene) {
  const double unit = length_unit_of(scene);
  if (unit != 1) Scaling{scene, unit}.convert(keys::scene, 0);
}

}  // namespace pantin::detail
