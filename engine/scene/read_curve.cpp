// Curves by name, and those of the sides of joints.
#include <algorithm>

#include "engine/scene/read.hpp"

namespace pantin::detail {

void read_curves(Reading& reading, const Reader& scene) {
  std::unordered_map<std::string_view, NodeId> known;
  for (NodeId node : scene.items("curves")) {
    auto curve = read_curve(reading, node);
    if (reading.json[node].kind != JsonKind::object) continue;
    const NodeId name = reading.json.member(node, "name");
    if (name == kNoNode) {
      reading.diagnostics.error(node, "found no \"name\", expected a name");
      continue;
    }
    if (reading.json[name].kind != JsonKind::string) continue;  // told already
    const std::string_view text = reading.json[name].text;
    const auto [first, is_new] = known.try_emplace(text, node);
    if (!is_new)
      reading.diagnostics.error(name, "found the name \"" + std::string(text) +
                                          "\" again, expected one that " +
                                          reading.json.pointer(first->second) + " does not have");
    reading.curve_of.try_emplace(text, std::move(curve));
  }
}

std::optional<nurbs::Curve> read_own_curve(const Reading& reading, const Reader& side) {
  const NodeId node = side.find("curve");
  if (node == kNoNode) return std::nullopt;
  const JsonNode& value = reading.json[node];
  if (value.kind == JsonKind::object) return read_curve(reading, node);
  if (value.kind == JsonKind::string)
    if (const auto known = reading.curve_of.find(value.text); known != reading.curve_of.end())
      return known->second;
  std::vector<std::string_view> names;
  for (const auto& [name, curve] : reading.curve_of) names.push_back(name);
  std::sort(names.begin(), names.end());
  const std::string_view word = value.kind == JsonKind::string ? value.text : "";
  reading.diagnostics.error_value(
      node, "the name of a curve, or a curve" + reading.diagnostics.hints.of(word, names));
  return std::nullopt;
}

}  // namespace pantin::detail
