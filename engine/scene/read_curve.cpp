// Curves by name, and those of the sides of joints.
#include "engine/scene/read_named.hpp"

namespace pantin::detail {

void read_curves(Reading& reading, const Reader& scene) {
  read_named(reading, scene.items("curves"), reading.curve_of, read_curve);
}

std::optional<nurbs::Curve> read_own_curve(const Reading& reading, const Reader& side) {
  const NodeId node = side.find("curve");
  if (node == kNoNode) return std::nullopt;
  const JsonNode& value = reading.json[node];
  if (value.kind == JsonKind::object) return read_curve(reading, node);
  if (value.kind == JsonKind::string)
    if (const auto known = reading.curve_of.find(value.text); known != reading.curve_of.end())
      return known->second;
  refuse_unknown(reading, node, reading.curve_of, "the name of a curve, or a curve");
  return std::nullopt;
}

}  // namespace pantin::detail
