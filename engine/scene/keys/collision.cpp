// Keys of collision, and of pairs of materials.
#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using C = Collision;
using M = MaterialPair;

constexpr Key kCollision[] = {
    number<&C::friction>(
        "friction", "", kNotNegative,
        "Coefficient of Coulomb friction; two bodies combine to the geometric mean."),
    number<&C::restitution>("restitution", "", kUnit,
                            "Coefficient of restitution; two bodies combine to the larger."),
    number<&C::rolling>(
        "rolling", "m", kNotNegative,
        "Rolling-resistance torque over normal force; two bodies combine to the larger."),
    number<&C::spinning>("spinning", "m", kNotNegative,
                         "Spinning-friction torque about the normal over normal force; likewise."),
    vector<&C::surface_velocity>(
        "surface_velocity", "m/s",
        "Velocity of the surface relative to the body, as of a conveyor, in the body's own frame."),
    vector<&C::one_way>(
        "one_way", "",
        "Outward direction of the only side that collides, in the body's own frame: bodies from "
        "other sides pass until they have left. Default: all sides collide."),
    row<&C::groups>("groups", ValueType::groups, "", "Collision groups of the body. Default: [0]."),
    row<&C::with>("with", ValueType::groups, "",
                  "Groups that it collides with; both bodies must agree. Default: all."),
    flag<&C::others>(
        "others",
        "Whether it collides with dynamic bodies of other islands; one of two bodies suffices."),
    flag<&C::self>("self",
                   "Whether it collides with dynamic bodies of its own island; both must agree."),
    flag<&C::sensor>("sensor",
                     "Whether it only reports overlaps, without contact forces. It detects every "
                     "body whose groups agree, dynamic ones regardless of \"others\"."),
};

constexpr Key kMaterialPair[] = {
    needed_reference<&M::a>("a", "the name of a material", "The first material."),
    needed_reference<&M::b>("b", "the name of a material", "The second material, or the same."),
    number<&M::friction>("friction", "", kNotNegative, "Coefficient of Coulomb friction."),
    number<&M::restitution>("restitution", "", kUnit, "Coefficient of restitution."),
    number<&M::rolling>("rolling", "m", kNotNegative,
                        "Rolling-resistance torque over normal force."),
    number<&M::spinning>("spinning", "m", kNotNegative,
                         "Spinning-friction torque about the normal over normal force."),
};
constexpr AnyOf kMaterialPairNeeds[] = {
    {"friction restitution rolling spinning",
     "found no values for the pair, expected friction, restitution, rolling or spinning"}};

constexpr std::size_t kGroups = 32;

/// The bit of a name, new or known, shared by all files; 0 if none is left.
std::uint32_t bit_of(std::vector<std::string_view>& names, std::string_view name) {
  const auto it = std::find(names.begin(), names.end(), name);
  const auto place = static_cast<std::size_t>(it - names.begin());
  if (place == kGroups) return 0;
  if (it == names.end()) names.push_back(name);
  return std::uint32_t(1) << place;
}

/// The bit of a group given by name or number; 0 after an error.
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

/// The value under "collision"; nothing if it is false.
std::optional<Collision> collision_at(const Reading& reading, NodeId node) {
  const JsonNode& value = reading.json[node];
  Collision base = reading.collision.value_or(Collision{});
  if (value.kind == JsonKind::object) {
    read_rows(reading, reading.open(node, "collision"), base);
  } else if (value.kind != JsonKind::boolean) {
    reading.diagnostics.error_value(node, "true, false or an object (collision)");
    return std::nullopt;
  } else if (!value.boolean) {
    return std::nullopt;
  }
  return base;
}

}  // namespace

constinit const KeySet keys::collision{"collision",
                                       "What a body collides with: every other body whose groups "
                                       "agree, except bodies of one joint, which never collide.",
                                       kCollision};
constinit const KeySet keys::material_pair{
    "material_pair",
    "Contact parameters of a pair of materials. Absent values are combined from the \"collision\" "
    "of the two bodies.",
    kMaterialPair, kNoPairs, kMaterialPairNeeds};

std::uint32_t read_groups(const Reading& reading, const std::vector<NodeId>& nodes) {
  std::uint32_t bits = 0;
  for (const NodeId node : nodes) bits |= group_bit(reading, node);
  return bits;
}

std::vector<MaterialPair> read_material_pairs(const Reading& reading, const Reader& scene) {
  std::vector<MaterialPair> pairs;
  std::map<std::pair<std::uint32_t, std::uint32_t>, NodeId> known;
  for (NodeId node : scene.items("material_pairs")) {
    const Reader from = reading.open(node, "material_pair");
    MaterialPair pair{.a = UINT32_MAX, .b = UINT32_MAX};
    read_rows(reading, from, pair);
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
      reading.diagnostics.error_value(node, "a name that no earlier group has");
    else if (const std::uint32_t bit = bit_of(reading.scene.groups, value.text))
      reading.groups.push_back(value.text), reading.group_bits.push_back(bit);
    else
      reading.diagnostics.error_value(node, "at most 32 groups");
  }
  const NodeId node = scene.find("collision");
  if (node != kNoNode) reading.collision = collision_at(reading, node);
}

std::optional<Collision> read_collision(const Reading& reading, const Reader& from,
                                        const std::optional<Collision>& otherwise) {
  const NodeId node = from.find("collision");
  return node == kNoNode ? otherwise : collision_at(reading, node);
}

bool read_collision_of(const RowValue& row, BodyRecipe& body) {
  const Reader& from = row.from;
  if (from.has("shape") || from.has("shapes"))
    body.collision = read_collision(row.reading, from, row.reading.collision);
  else if (from.says("collision") && collision_at(row.reading, row.node()))
    // A class may have it, since it applies only to bodies with shapes.
    row.from.error_at_key(
        row.key.name, "found \"collision\" of a body without a shape, expected a shape to collide");
  return true;
}

}  // namespace pantin::detail
