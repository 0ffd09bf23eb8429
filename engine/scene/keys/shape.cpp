// Keys of shapes, from the table of their kinds, and how shapes are read.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "engine/base/check.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/scene/json/text_file.hpp"
#include "engine/scene/read/obj.hpp"
#include "engine/scene/read/read.hpp"

namespace pantin::detail {
namespace {

using namespace rows;
using S = ShapeWithDensity;

constexpr int kMostHeights = 1 << 20;
constexpr std::string_view kHeightsNeed = "\"columns\", \"rows\", \"spacing\" and \"heights\"";

constexpr Key kDensity = number<&S::density>(
    "density", "kg/m^3", kWeight,
    "Beside a body's mass only the ratios between shapes matter. Default: that of the body.");

constexpr Key kPointKeys[] = {
    row("points", ValueType::points, "m", "In the shape's frame. Interior points are allowed."),
    reference("file", "the path of an OBJ file",
              "A Wavefront OBJ file instead, m: its points. The path is relative to the scene "
              "file's folder.")};
constexpr Exclusive kPointPairs[] = {{"points", "file"}};
constexpr AnyOf kPointNeeds[] = {
    {"points file", "found no \"points\", expected four points or more, or a \"file\""}};

constexpr Key kTriangleKeys[] = {
    row("points", ValueType::points, "m", "In the shape's frame."),
    row("triangles", ValueType::triples, "", "Three indices into points each, from 0."),
    reference("file", "the path of an OBJ file",
              "A Wavefront OBJ file instead, m: its lines v and f; faces of more corners become "
              "fans. The path is relative to the scene file's folder.")};
constexpr Exclusive kTrianglePairs[] = {{"points", "file"}, {"file", "triangles"}};
constexpr AnyOf kTriangleNeeds[] = {
    {"points file", "found no \"points\", expected \"points\" and \"triangles\", or a \"file\""},
    {"triangles file", "found no \"triangles\", expected three indices into \"points\" for each"}};

constexpr Key kHeightKeys[] = {
    whole("columns", 2, kMostHeights, "Heights along x.").needed(kHeightsNeed),
    whole("rows", 2, kMostHeights, "Heights along z.").needed(kHeightsNeed),
    row("spacing", ValueType::number_or_pair, "m",
        "Between neighbours: one number, or along x and along z.")
        .within(kSize)
        .needed(kHeightsNeed),
    row("heights", ValueType::number_list, "m", "Row after row from low z on, each from low x on.")
        .needed(kHeightsNeed)};

constexpr Key kSkinKeys[] = {
    of_object("surface", ValueType::object_or_reference, "surface",
              "The name of one of the scene's surfaces, a surface, or the path of a surface file, "
              "which ends in .json and is relative to the scene file's folder.")
        .needed("the name of a surface, or a surface")};

/// The keys of a shape that depend on the source of its surface.
KeySet surface_keys(SurfaceSource source) {
  switch (source) {
    case SurfaceSource::points:
      return {"", "", kPointKeys, kPointPairs, kPointNeeds};
    case SurfaceSource::triangles:
      return {"", "", kTriangleKeys, kTrianglePairs, kTriangleNeeds};
    case SurfaceSource::heights:
      return {"", "", kHeightKeys};
    case SurfaceSource::skin:
      return {"", "", kSkinKeys};
    case SurfaceSource::none:
      break;
  }
  return {};
}

Key size_key(const SizeKey& size) {
  Key key = size.count == 3 ? vector(size.key, "m", size.about)
                            : number(size.key, "m", kSize, size.about);
  key.range = kSize;
  if (size.otherwise > 0) return key.or_else(size.otherwise);
  return key.needed(size.expected.empty() ? kSize.words : size.expected);
}

/// The keys of a kind, with storage for the text that its rules refer to.
struct ShapeKeySet {
  std::vector<Key> keys;
  std::vector<Exclusive> exclusive;
  std::vector<AnyOf> any_of;
  std::vector<Beside> beside;
  std::string placed_by, long_by, complaint;
  KeySet set;
};

/// Adds the ends as an alternative to the length along y.
void add_ends(const SizeKey& length, ShapeKeySet& made) {
  for (Key& key : made.keys)
    if (key.name == length.key) key.is_needed = false;
  const std::string name(length.key);
  made.keys.push_back(vector("from", "m",
                             "Start of its y axis, in the body's own frame: with \"to\" it "
                             "determines length, position and rotation."));
  made.keys.push_back(vector("to", "m", "End of its y axis."));
  made.placed_by = name + " position rotation rotation_deg";
  made.long_by = name + " from to";
  made.complaint =
      "found no \"" + name + "\", expected a length in m, or the ends \"from\" and \"to\"";
  made.exclusive.insert(made.exclusive.end(), {{"from", made.placed_by}, {"to", made.placed_by}});
  made.any_of.push_back({made.long_by, made.complaint});
  made.beside.push_back({"from", "to", "found \"from\" without \"to\", expected both ends"});
  made.beside.push_back({"to", "from", "found \"to\" without \"from\", expected both ends"});
}

void list_keys(const ShapeTraits& kind, Words name, ShapeKeySet& made) {
  const KeySet surface = surface_keys(kind.source);
  std::vector<Key>& keys = made.keys;
  keys = {word("type", name, "The kind of shape.")};
  keys.front().is_needed = true;
  for (const SizeKey& size : kind.sizes) keys.push_back(size_key(size));
  keys.insert(keys.end(), surface.keys.begin(), surface.keys.end());
  made.exclusive.assign(surface.exclusive.begin(), surface.exclusive.end());
  made.any_of.assign(surface.any_of.begin(), surface.any_of.end());
  if (const SizeKey* length = length_of(kind)) add_ends(*length, made);
  keys.push_back(kPosition.to<&S::shape, &Shape::local, &Pose::position>());
  if (!kind.is_round) keys.insert(keys.end(), {kRotation, kRotationDeg});
  keys.push_back(kMaterial.to<&S::shape, &Shape::material>());
  if (kind.volume || kind.enclosed) keys.push_back(kDensity);
  made.set = {name.front(), kind.about, keys, made.exclusive, made.any_of, made.beside};
}

using Triangle = std::array<std::uint32_t, 3>;
using SurfacePointer = std::shared_ptr<const Surface>;

std::vector<Triangle> read_triangles(const Reader& from, std::size_t points) {
  const Range corner{0, static_cast<Real>(points) - 1,
                     "the index of a point in \"points\", from 0"};
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
  return from.kept(std::move(made)).value_or(nullptr);
}

/// Makes a surface of an OBJ file's contents; null after an error at `node`.
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
  auto mesh = parse_obj(*text, path);
  if (mesh && reading.length_unit != 1)
    for (Vec3& p : mesh->points) p *= reading.length_unit;
  if (mesh)
    return kept(from, kind == ShapeKind::hull ? make_hull(mesh->points)
                                              : make_mesh(mesh->points, mesh->triangles));
  for (const Error& e : mesh.errors()) from.diagnostics.error(node, e.message);
  return nullptr;
}

/// The surface of the OBJ file under "file"; null after an error. Each file is read once, however
/// many shapes name it.
SurfacePointer read_obj(const Reading& reading, const Reader& from, ShapeKind kind) {
  const NodeId node = from.find("file");
  const std::string name = from.text("file", "");
  if (name.empty()) {
    if (reading.json[node].kind == JsonKind::string)
      from.diagnostics.error_value(node, "the path of an OBJ file");
    return nullptr;
  }
  const std::string path = (std::filesystem::path(reading.folder) / name).string();
  const auto [known, is_new] = reading.surfaces.try_emplace({kind, path, reading.length_unit});
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
  const std::vector<Vec3> points = from.points();
  return from.diagnostics.error_count() == refused_before ? kept(from, make_hull(points)) : nullptr;
}

SurfacePointer read_mesh(const Reading& reading, const Reader& from) {
  if (from.has("file")) return read_obj(reading, from, ShapeKind::mesh);
  const std::size_t refused_before = from.diagnostics.error_count();
  const std::vector<Vec3> points = from.points();
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

/// Length and pose from the two ends; returns false if these do not determine them.
bool read_ends(const Reader& from, const SizeKey& length, Shape& shape) {
  if (!from.has("to")) return false;  // reported already
  const std::size_t refused_before = from.diagnostics.error_count();
  const Vec3 begin = from.vec("from", Vec3(0)), end = from.vec("to", Vec3(0));
  if (from.diagnostics.error_count() != refused_before) return false;
  const Vec3 way = end - begin;
  const Real distance = glm::length(way);
  if (!kSize.holds(distance)) {
    from.error("to", "found an end " + written(distance) + " m from the other, expected " +
                         std::string(kSize.words));
    return false;
  }
  shape.size[length.first] = length.scale * distance;
  shape.local.position = begin + 0.5 * way;
  shape.local.rotation = from_y_to(way / distance);
  return true;
}

/// Reads the sizes of the kind; returns false if one is missing.
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

/// Rejects grounds and hollow shapes on moving bodies: their contacts are one-sided.
void refuse_moving(const Reader& from, ShapeKind kind, Motion motion) {
  if (motion != Motion::dynamic || can_move(kind)) return;
  const bool closed = traits_of(kind).shape_class == ShapeClass::mesh;
  from.error("type", "found a " + std::string(name_of(kind)) +
                         " on a dynamic body, expected it on a fixed or kinematic one" +
                         (closed ? "; use one or several hulls for a dynamic body" : ""));
}

}  // namespace

const SizeKey* length_of(const ShapeTraits& kind) {
  for (const SizeKey& size : kind.sizes)
    if (size.key == "length" || size.key == "height") return &size;
  return nullptr;
}

const KeySet& keys_of(ShapeKind kind) {
  constexpr std::size_t kCount = std::size(kShapeNames);
  static const auto all = [] {
    auto made = std::make_unique<std::array<ShapeKeySet, kCount>>();  // at stable addresses
    for (std::size_t i = 0; i < kCount; ++i)
      list_keys(*kShapeTraits[i], std::span(kShapeNames).subspan(i, 1), (*made)[i]);
    return made;
  }();
  return (*all)[static_cast<std::size_t>(kind)].set;
}

const KeySet& keys_of(std::string_view what) {
  for (const KeySet* set : keys::kAll)
    if (set->what == what) return *set;
  for (const KeySet& set : path_key_sets())
    if (set.what == what) return set;
  for (const KeySet& set : event_key_sets())
    if (set.what == what) return set;
  PANTIN_ASSERT(false);
  return keys::scene;
}

std::vector<const KeySet*> all_key_sets() {
  std::vector<const KeySet*> all;
  for (const KeySet* set : keys::kAll) {
    all.push_back(set);
    if (set != &keys::output) continue;
    for (const KeySet& event : event_key_sets()) all.push_back(&event);
  }
  for (const KeySet& set : path_key_sets()) all.push_back(&set);
  for (std::size_t i = 0; i < std::size(kShapeNames); ++i)
    all.push_back(&keys_of(static_cast<ShapeKind>(i)));
  return all;
}

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
  reading.diagnostics.error_value(type,
                                  listed(names) + reading.diagnostics.hints.of_word(word, names));
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
  solid.shape.kind = kind, solid.shape.material = otherwise.material;
  if (from.accepts("density")) solid.density = otherwise.density;
  read_rows(reading, from, solid);
  if (!traits_of(kind).is_round) solid.shape.local.rotation = from.rotation(kIdentity);
  if (!read_form(reading, from, solid.shape)) return std::nullopt;
  return solid;
}

}  // namespace pantin::detail
