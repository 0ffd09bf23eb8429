#include "engine/scene/shape_keys.hpp"

#include <array>
#include <sstream>
#include <vector>

#include "engine/geometry/kinds.hpp"

namespace pantin::detail {
namespace {

/// A key whose value does not depend on the kind.
struct CommonKey {
  std::string_view key, value;  // the value's schema
};

constexpr std::string_view kSizes = R"("minimum": 1e-09, "maximum": 1000000000.0)";

constexpr CommonKey kPosition{
    "position",
    R"({"$ref": "#/$defs/vector", "description": "Where the frame's origin is, m. Default [0, 0, 0]."})"};
constexpr CommonKey kRotations[] = {
    {"rotation",
     R"({"$ref": "#/$defs/quaternion", "description": "Quaternion [x, y, z, w] from the own frame to the frame around it. Default: none."})"},
    {"rotation_deg",
     R"({"$ref": "#/$defs/vector", "description": "The same as three angles in degrees: about the fixed x axis first, then y, then z."})"}};
constexpr CommonKey kMaterial{
    "material", R"({"type": "string", "minLength": 1, "description": "Name of a material."})"};
constexpr CommonKey kDensity{
    "density",
    R"({"type": "number", "minimum": 1e-12, "maximum": 1000000000000.0, "description": "kg/m^3; beside a body's mass only the ratios between shapes count."})"};

constexpr CommonKey kPointKeys[] = {
    {"points",
     R"({"$ref": "#/$defs/points", "description": "In the shape's frame, m. Points inside do no harm."})"},
    {"file",
     R"({"type": "string", "minLength": 1, "description": "A Wavefront OBJ file instead, m: its points. The path starts from the scene file's folder."})"}};
constexpr CommonKey kTriangleKeys[] = {
    {"points", R"({"$ref": "#/$defs/points", "description": "In the shape's frame, m."})"},
    {"triangles",
     R"({"type": "array", "items": {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 3, "maxItems": 3}, "description": "Three places in points each, counted from 0."})"},
    {"file",
     R"({"type": "string", "minLength": 1, "description": "A Wavefront OBJ file instead, m: its lines v and f; faces of more corners become fans. The path starts from the scene file's folder."})"}};
constexpr CommonKey kHeightKeys[] = {
    {"columns",
     R"({"type": "integer", "minimum": 2, "maximum": 1048576, "description": "Heights along x."})"},
    {"rows",
     R"({"type": "integer", "minimum": 2, "maximum": 1048576, "description": "Heights along z."})"},
    {"spacing",
     R"({"oneOf": [{"type": "number", "minimum": 1e-09, "maximum": 1000000000.0}, {"type": "array", "items": {"type": "number", "minimum": 1e-09, "maximum": 1000000000.0}, "minItems": 2, "maxItems": 2}], "description": "Between neighbours, m: one number, or along x and along z."})"},
    {"heights",
     R"({"type": "array", "items": {"type": "number", "minimum": -1000000000.0, "maximum": 1000000000.0}, "description": "m: row after row from low z on, each from low x on."})"}};

/// Keys of what a surface is made of.
std::span<const CommonKey> keys_of(SurfaceSource source) {
  switch (source) {
    case SurfaceSource::points:
      return kPointKeys;
    case SurfaceSource::triangles:
      return kTriangleKeys;
    case SurfaceSource::heights:
      return kHeightKeys;
    case SurfaceSource::none:
      break;
  }
  return {};
}

/// What the schema asks of them, from "required" on.
std::string_view needs_of(SurfaceSource source) {
  switch (source) {
    case SurfaceSource::points:
      return R"("required": ["type"], "oneOf": [{"required": ["points"]}, {"required": ["file"]}])";
    case SurfaceSource::triangles:
      return R"("required": ["type"], "oneOf": [{"required": ["points", "triangles"], "not": {"required": ["file"]}}, {"required": ["file"], "not": {"anyOf": [{"required": ["points"]}, {"required": ["triangles"]}]}}])";
    case SurfaceSource::heights:
      return R"("required": ["type", "columns", "rows", "spacing", "heights"])";
    case SurfaceSource::none:
      break;
  }
  return {};
}

bool has_mass(const ShapeTraits& kind) { return kind.volume || kind.enclosed; }

std::vector<std::string_view> list_keys(const ShapeTraits& kind) {
  std::vector<std::string_view> keys{"type"};
  for (const SizeKey& size : kind.sizes) keys.push_back(size.key);
  for (const CommonKey& c : keys_of(kind.source)) keys.push_back(c.key);
  keys.push_back(kPosition.key);
  if (!kind.is_round)
    for (const CommonKey& c : kRotations) keys.push_back(c.key);
  keys.push_back(kMaterial.key);
  if (has_mass(kind)) keys.push_back(kDensity.key);
  return keys;
}

std::string text_of(const SizeKey& size) {
  std::ostringstream out;
  const std::string about = "\"description\": \"" + std::string(size.about) + "\"";
  if (size.count == 3) return "{\"$ref\": \"#/$defs/positive_vector\", " + about + "}";
  out << R"({"type": "number", )" << kSizes << ", ";
  if (size.otherwise > 0) out << "\"default\": " << size.otherwise << ", ";
  out << about << "}";
  return out.str();
}

}  // namespace

const KeySet& keys_of(ShapeKind kind) {
  constexpr std::size_t kCount = std::size(kShapeNames);
  struct Sets {
    std::array<std::vector<std::string_view>, kCount> keys;
    std::array<KeySet, kCount> sets;
  };
  static const Sets all = [] {
    Sets made;
    for (std::size_t i = 0; i < kCount; ++i) {
      made.keys[i] = list_keys(*kShapeTraits[i]);
      made.sets[i] = {kShapeNames[i], made.keys[i]};
    }
    return made;
  }();
  return all.sets[static_cast<std::size_t>(kind)];
}

std::string schema_of(ShapeKind kind) {
  const ShapeTraits& traits = traits_of(kind);
  std::ostringstream out;
  out << R"({"type": "object", "description": ")" << traits.about
      << R"(", "additionalProperties": false, "properties": {"type": {"const": ")" << name_of(kind)
      << "\"}";
  const auto add = [&](std::string_view key, std::string_view value) {
    out << ", \"" << key << "\": " << value;
  };
  for (const SizeKey& size : traits.sizes) add(size.key, text_of(size));
  for (const CommonKey& c : keys_of(traits.source)) add(c.key, c.value);
  add(kPosition.key, kPosition.value);
  if (!traits.is_round)
    for (const CommonKey& c : kRotations) add(c.key, c.value);
  add(kMaterial.key, kMaterial.value);
  if (has_mass(traits)) add(kDensity.key, kDensity.value);
  out << "}, ";
  if (has_surface(kind)) {
    out << needs_of(traits.source);
  } else {
    out << R"("required": ["type")";
    for (const SizeKey& size : traits.sizes)
      if (size.otherwise == 0) out << ", \"" << size.key << '"';
    out << "]";
  }
  if (!traits.is_round) out << R"(, "not": {"required": ["rotation", "rotation_deg"]})";
  out << "}";
  return out.str();
}

}  // namespace pantin::detail
