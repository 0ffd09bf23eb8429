#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kGroups = 32;

/// The bit of a name that all files share, old or new; 0 if there is none left.
std::uint32_t bit_of(std::vector<std::string_view>& names, std::string_view name) {
  const auto it = std::find(names.begin(), names.end(), name);
  const auto place = static_cast<std::size_t>(it - names.begin());
  if (place == kGroups) return 0;
  if (it == names.end()) names.push_back(name);
  return std::uint32_t(1) << place;
}

/// The bit of a group given by its name or its number; 0 after a complaint.
std::uint32_t group_bit(const Reading& reading, NodeId node) {
  const JsonNode& value = reading.json[node];
  if (value.kind == JsonKind::number && value.number >= 0 && value.number < kGroups &&
      value.number == static_cast<Real>(static_cast<std::uint32_t>(value.number)))
    return std::uint32_t(1) << static_cast<std::uint32_t>(value.number);
  const std::string_view name = value.kind == JsonKind::string ? value.text : "";
  const auto it = std::find(reading.groups.begin(), reading.groups.end(), name);
  if (it != reading.groups.end() && !name.empty())
    return reading.group_bits[static_cast<std::size_t>(it - reading.groups.begin())];
  reading.diagnostics.error_value(node, "a name of \"collision_groups\", or a number from 0 to 31" +
                                            reading.diagnostics.hints.of(name, reading.groups));
  return 0;
}

std::uint32_t read_bits(const Reading& reading, const Reader& from, std::string_view key,
                        std::uint32_t otherwise) {
  if (!from.has(key)) return otherwise;
  std::uint32_t bits = 0;
  for (NodeId node : from.items(key)) bits |= group_bit(reading, node);
  return bits;
}

Collision read_details(const Reading& reading, NodeId node, const Collision& base) {
  const Reader from = reading.open(node, "collision");
  Collision c = base;
  c.friction = from.number("friction", c.friction);
  c.restitution = from.number("restitution", c.restitution);
  c.rolling = from.number("rolling", c.rolling);
  c.spinning = from.number("spinning", c.spinning);
  c.surface_velocity = from.vec("surface_velocity", c.surface_velocity);
  c.one_way = from.vec("one_way", c.one_way);
  c.groups = read_bits(reading, from, "groups", c.groups);
  c.with = read_bits(reading, from, "with", c.with);
  c.others = from.flag("others", c.others);
  c.self = from.flag("self", c.self);
  c.sensor = from.flag("sensor", c.sensor);
  return c;
}

/// What stands under "collision"; nothing if it is false.
std::optional<Collision> read_value(const Reading& reading, NodeId node) {
  const Collision base = reading.collision.value_or(Collision{});
  if (reading.json[node].kind == JsonKind::object) return read_details(reading, node, base);
  if (reading.json[node].kind != JsonKind::boolean)
    reading.diagnostics.error_value(node, "true, false or an object (collision)");
  else if (reading.json[node].boolean)
    return base;
  return std::nullopt;
}

std::optional<Real> number_if(const Reader& from, std::string_view key) {
  return from.has(key) ? std::optional(from.number(key)) : std::nullopt;
}

}  // namespace

std::vector<MaterialPair> read_material_pairs(const Reading& reading, const Reader& scene) {
  std::vector<MaterialPair> pairs;
  std::map<std::pair<std::uint32_t, std::uint32_t>, NodeId> known;
  for (NodeId node : scene.items("material_pairs")) {
    const Reader from = reading.open(node, "material_pair");
    const auto material = [&](std::string_view key) {
      return from.has(key) ? find_material(reading, from.find(key), UINT32_MAX) : UINT32_MAX;
    };
    MaterialPair pair;
    pair.a = material("a"), pair.b = material("b");
    pair.friction = number_if(from, "friction");
    pair.restitution = number_if(from, "restitution");
    pair.rolling = number_if(from, "rolling");
    pair.spinning = number_if(from, "spinning");
    if (pair.a == UINT32_MAX || pair.b == UINT32_MAX) continue;
    const auto [first, is_new] = known.try_emplace(std::minmax(pair.a, pair.b), node);
    if (!is_new)
      reading.diagnostics.error(node,
                                "found a pair of the same materials again, expected one that " +
                                    reading.json.pointer(first->second) + " is not");
    pairs.push_back(pair);
  }
  return pairs;
}

void read_scene_collision(Reading& reading, const Reader& scene) {
  for (NodeId node : scene.items("collision_groups")) {
    const JsonNode& value = reading.json[node];
    const auto same = std::find(reading.groups.begin(), reading.groups.end(), value.text);
    if (value.kind != JsonKind::string || value.text.empty())
      reading.diagnostics.error_value(node, "the name of a group");
    else if (same != reading.groups.end())
      reading.diagnostics.error_value(node, "a name that no group before has");
    else if (const std::uint32_t bit = bit_of(reading.scene.groups, value.text))
      reading.groups.push_back(value.text), reading.group_bits.push_back(bit);
    else
      reading.diagnostics.error_value(node, "at most 32 groups");
  }
  const NodeId node = scene.find("collision");
  if (node != kNoNode) reading.collision = read_value(reading, node);
}

std::optional<Collision> read_collision(const Reading& reading, const Reader& from,
                                        const std::optional<Collision>& otherwise) {
  const NodeId node = from.find("collision");
  return node == kNoNode ? otherwise : read_value(reading, node);
}

void read_collision_of(const Reading& reading, const Reader& from, BodyRecipe& body) {
  if (from.has("shape") || from.has("shapes")) {
    body.collision = read_collision(reading, from, reading.collision);
    return;
  }
  if (!from.says("collision")) return;  // a class may say it for those that have shapes
  const NodeId node = from.find("collision");
  if (!read_value(reading, node)) return;
  reading.diagnostics.error_at_key(node,
                                   "found \"collision\" of a body without a shape, expected a "
                                   "shape that touches");
}

}  // namespace pantin::detail
