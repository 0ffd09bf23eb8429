#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <system_error>

#include "engine/geometry/kinds.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/scene/obj.hpp"
#include "engine/scene/read.hpp"
#include "engine/scene/text_file.hpp"

namespace pantin::detail {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using SurfacePointer = std::shared_ptr<const Surface>;

std::vector<Vec3> read_points(const Reader& from) {
  std::vector<Vec3> points;
  for (NodeId node : from.items("points")) {
    Vec3 p(0);
    from.numbers_at(node, {&p.x, 3}, kAnyNumber);
    points.push_back(p);  // also where it is wrong, so that triangles are checked against them all
  }
  return points;
}

std::vector<Triangle> read_triangles(const Reader& from, std::size_t points) {
  const Range corner{0, static_cast<Real>(points) - 1,
                     "the place of a point in \"points\", counted from 0"};
  std::vector<Triangle> triangles;
  for (NodeId node : from.items("triangles")) {
    Real c[3] = {0, 0, 0};
    if (!from.numbers_at(node, c, corner)) continue;
    const bool is_whole = std::all_of(c, c + 3, [](Real x) { return x == std::floor(x); });
    if (!is_whole) from.diagnostics.error_value(node, "three whole numbers");
    const auto place = [&](int i) { return static_cast<std::uint32_t>(c[i]); };
    triangles.push_back({place(0), place(1), place(2)});
  }
  return triangles;
}

/// Stores a surface, or reports its errors at the shape.
SurfacePointer kept(const Reader& from, Result<SurfacePointer> made) {
  if (made) return std::move(*made);
  for (const Error& e : made.errors()) from.diagnostics.error(from.node, e.message);
  return nullptr;
}

/// Makes a surface of an OBJ file's contents; null after a complaint at `node`.
SurfacePointer surface_of_file(const Reading& reading, const Reader& from, ShapeKind kind,
                               const std::string& path) {
  const NodeId node = from.find("file");
  std::error_code trouble;
  if (std::filesystem::is_other(path, trouble)) {  // a pipe may never end
    from.diagnostics.error(node, path + ": found a device or a pipe, expected an OBJ file");
    return nullptr;
  }
  const auto text = read_text(path, reading.limits.bytes, "an OBJ file");
  if (!text) {
    from.diagnostics.error(node, text.errors().front().message);
    return nullptr;
  }
  const auto mesh = parse_obj(*text, path);
  if (mesh)
    return kept(from, kind == ShapeKind::hull ? make_hull(mesh->points)
                                              : make_mesh(mesh->points, mesh->triangles));
  for (const Error& e : mesh.errors()) from.diagnostics.error(node, e.message);
  return nullptr;
}

/// The surface of the OBJ file under "file"; null after a complaint. Each file is read once,
/// however many shapes name it.
SurfacePointer read_obj(const Reading& reading, const Reader& from, ShapeKind kind) {
  const NodeId node = from.find("file");
  const std::string name = from.text("file", "");
  if (name.empty()) {
    if (reading.json[node].kind == JsonKind::string)
      from.diagnostics.error_value(node, "the path of an OBJ file");
    return nullptr;
  }
  const std::string path = (std::filesystem::path(reading.folder) / name).string();
  const auto [known, is_new] = reading.surfaces.try_emplace({kind, path});
  if (is_new)
    known->second = surface_of_file(reading, from, kind, path);
  else if (!known->second)
    from.diagnostics.error_value(node, "another file: this one was refused above");
  return known->second;
}

SurfacePointer read_hull(const Reading& reading, const Reader& from) {
  if (from.has("file")) return read_obj(reading, from, ShapeKind::hull);
  if (!from.has("points")) return nullptr;
  const std::size_t refused_before = from.diagnostics.error_count();
  const std::vector<Vec3> points = read_points(from);
  return from.diagnostics.error_count() == refused_before ? kept(from, make_hull(points)) : nullptr;
}

SurfacePointer read_mesh(const Reading& reading, const Reader& from) {
  if (from.has("file")) return read_obj(reading, from, ShapeKind::mesh);
  const std::size_t refused_before = from.diagnostics.error_count();
  const std::vector<Vec3> points = read_points(from);
  const std::vector<Triangle> triangles = read_triangles(from, points.size());
  if (!from.has("points") || !from.has("triangles")) return nullptr;
  if (from.diagnostics.error_count() != refused_before) return nullptr;
  return kept(from, make_mesh(points, triangles));
}

SurfacePointer read_height_field(const Reader& from) {
  bool is_whole = true;
  for (std::string_view key : {"columns", "rows", "spacing", "heights"})
    is_whole = from.has(key) && is_whole;
  const std::size_t refused_before = from.diagnostics.error_count();
  const int columns = from.whole("columns", 2), rows = from.whole("rows", 2);
  Real spacing[2] = {1, 1};
  const NodeId at = from.find("spacing");
  if (at != kNoNode && from.json[at].kind == JsonKind::array)
    from.numbers("spacing", spacing);
  else
    spacing[0] = spacing[1] = from.number("spacing", 1);
  std::vector<Real> heights(from.items("heights").size());
  if (!heights.empty()) from.numbers("heights", heights);
  if (!is_whole || from.diagnostics.error_count() != refused_before) return nullptr;
  return kept(
      from, make_height_field({static_cast<std::uint32_t>(columns),
                               static_cast<std::uint32_t>(rows), spacing[0], spacing[1], heights}));
}

/// The shortest rotation from y to a direction.
Quat from_y_to(Vec3 way) {
  if (way.y > 1 - 1e-15) return kIdentity;
  if (way.y < -1 + 1e-12) return Quat(0, 1, 0, 0);
  return glm::normalize(Quat(1 + way.y, glm::cross(Vec3(0, 1, 0), way)));
}

/// Length and pose from the two ends; false if they do not tell them.
bool read_ends(const Reader& from, const SizeKey& length, Shape& shape) {
  if (!from.has("to")) return false;  // told already
  const std::size_t refused_before = from.diagnostics.error_count();
  const Vec3 begin = from.vec("from", Vec3(0)), end = from.vec("to", Vec3(0));
  if (from.diagnostics.error_count() != refused_before) return false;
  const Vec3 way = end - begin;
  const Real distance = glm::length(way);
  if (!kSize.holds(distance)) {
    from.diagnostics.error(from.find("to"), "found an end " + written(distance) +
                                                " m from the other, expected " +
                                                std::string(kSize.words));
    return false;
  }
  shape.size[length.first] = length.scale * distance;
  shape.local.position = begin + 0.5 * way;
  shape.local.rotation = from_y_to(way / distance);
  return true;
}

/// The lengths that the kind has in scenes; false if one is missing.
bool read_size(const Reader& from, Shape& shape) {
  bool is_whole = true;
  shape.size = Vec3(0);
  for (const SizeKey& size : traits_of(shape.kind).sizes) {
    if (&size == length_of(traits_of(shape.kind)) && from.has("from")) {
      is_whole = read_ends(from, size, shape) && is_whole;
      continue;
    }
    if (size.otherwise == 0) is_whole = from.has(size.key) && is_whole;
    const Real otherwise = size.otherwise > 0 ? size.otherwise : 1;
    if (size.count == 3)
      shape.size = size.scale * from.vec(size.key, Vec3(otherwise));
    else
      shape.size[size.first] = size.scale * from.number(size.key, otherwise);
  }
  return is_whole;
}

bool read_form(const Reading& reading, const Reader& from, Shape& shape) {
  switch (traits_of(shape.kind).source) {
    case SurfaceSource::points:
      return bool(shape.surface = read_hull(reading, from));
    case SurfaceSource::triangles:
      return bool(shape.surface = read_mesh(reading, from));
    case SurfaceSource::heights:
      return bool(shape.surface = read_height_field(from));
    case SurfaceSource::skin:
      return bool(shape.surface = read_skin(reading, from));
    case SurfaceSource::none:
      break;
  }
  return read_size(from, shape);
}

/// Grounds and hollow things only stand: contacts with them are sought one way.
void refuse_moving(const Reader& from, ShapeKind kind, Motion motion) {
  if (motion != Motion::dynamic || can_move(kind)) return;
  const bool closed = traits_of(kind).shape_class == ShapeClass::mesh;
  from.diagnostics.error(from.find("type"),
                         "found a " + std::string(name_of(kind)) +
                             " on a dynamic body, expected it on a fixed or kinematic one" +
                             (closed ? "; a hull, or several, can move" : ""));
}

}  // namespace

std::optional<std::size_t> read_type(const Reading& reading, NodeId node,
                                     std::span<const std::string_view> names) {
  const JsonDocument& json = reading.json;
  if (json[node].kind != JsonKind::object) {
    reading.diagnostics.error_value(node, "an object (" + listed(names) + ")");
    return std::nullopt;
  }
  const NodeId type = json.member(node, "type");
  if (type == kNoNode) {
    reading.diagnostics.error(node, "found no \"type\", expected " + listed(names));
    return std::nullopt;
  }
  const std::string_view word = json[type].kind == JsonKind::string ? json[type].text : "";
  const auto it = std::find(names.begin(), names.end(), word);
  if (it != names.end()) return static_cast<std::size_t>(it - names.begin());
  reading.diagnostics.error_value(type, listed(names) + reading.diagnostics.hints.of(word, names));
  return std::nullopt;
}

std::optional<ShapeWithDensity> read_shape(const Reading& reading, NodeId node,
                                           const ShapeDefaults& otherwise) {
  const auto type = read_type(reading, node, kShapeNames);
  if (!type) return std::nullopt;
  const auto kind = static_cast<ShapeKind>(*type);
  const Reader from(reading.json, reading.diagnostics, node, keys_of(kind));
  refuse_moving(from, kind, otherwise.motion);
  ShapeWithDensity solid;
  solid.shape.kind = kind;
  if (from.accepts("density")) solid.density = from.number("density", otherwise.density);
  solid.shape.material = read_material(reading, from, otherwise.material);
  solid.shape.local.position = from.vec("position");
  if (!traits_of(kind).is_round) solid.shape.local.rotation = from.rotation(kIdentity);
  if (!read_form(reading, from, solid.shape)) return std::nullopt;
  return solid;
}

}  // namespace pantin::detail
