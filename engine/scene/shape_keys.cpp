// Keys of shapes, from the table of their kinds.
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/check.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/scene/keys.hpp"

namespace pantin::detail {
namespace {

using namespace rows;

constexpr int kMostHeights = 1 << 20;
constexpr std::string_view kHeightsNeed = "\"columns\", \"rows\", \"spacing\" and \"heights\"";

constexpr Key kDensity =
    number("density", "kg/m^3", kWeight,
           "Beside a body's mass only the ratios between shapes count. Default: as the body says.");

constexpr Key kPointKeys[] = {
    row("points", ValueType::points, "m", "In the shape's frame. Points inside do no harm."),
    reference("file", "the path of an OBJ file",
              "A Wavefront OBJ file instead, m: its points. The path starts from the scene file's "
              "folder.")};
constexpr Exclusive kPointPairs[] = {{"points", "file"}};
constexpr AnyOf kPointNeeds[] = {
    {"points file", "found no \"points\", expected four points or more, or a \"file\""}};

constexpr Key kTriangleKeys[] = {
    row("points", ValueType::points, "m", "In the shape's frame."),
    row("triangles", ValueType::triples, "", "Three places in points each, counted from 0."),
    reference("file", "the path of an OBJ file",
              "A Wavefront OBJ file instead, m: its lines v and f; faces of more corners become "
              "fans. The path starts from the scene file's folder.")};
constexpr Exclusive kTrianglePairs[] = {{"points", "file"}, {"file", "triangles"}};
constexpr AnyOf kTriangleNeeds[] = {
    {"points file", "found no \"points\", expected \"points\" and \"triangles\", or a \"file\""},
    {"triangles file", "found no \"triangles\", expected three places in \"points\" for each"}};

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
              "The name of one of the scene's surfaces, a surface, or the path of a file of one, "
              "which ends in .json and starts from the scene file's folder.")
        .needed("the name of a surface, or a surface")};

/// What depends on what a surface is made of.
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

/// The keys of a kind, and what its rules refer to.
struct ShapeKeySet {
  std::vector<Key> keys;
  std::vector<Exclusive> exclusive;
  std::vector<AnyOf> any_of;
  std::vector<Beside> beside;
  std::string placed_by, long_by, complaint;
  KeySet set;
};

/// Of a kind with a length along its y axis: its ends may be given instead.
void add_ends(const SizeKey& length, ShapeKeySet& made) {
  for (Key& key : made.keys)
    if (key.name == length.key) key.is_needed = false;
  const std::string name(length.key);
  made.keys.push_back(vector("from", "m",
                             "Where its y axis begins, in the body's own frame: with \"to\" it "
                             "tells length, position and rotation."));
  made.keys.push_back(vector("to", "m", "Where it ends."));
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
  keys.push_back(kPosition);
  if (!kind.is_round) keys.insert(keys.end(), {kRotation, kRotationDeg});
  keys.push_back(kMaterial);
  if (kind.volume || kind.enclosed) keys.push_back(kDensity);
  made.set = {name.front(), kind.about, keys, made.exclusive, made.any_of, made.beside};
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
    auto made = std::make_unique<std::array<ShapeKeySet, kCount>>();  // whose addresses stay
    for (std::size_t i = 0; i < kCount; ++i)
      list_keys(*kShapeTraits[i], std::span(kShapeNames).subspan(i, 1), (*made)[i]);
    return made;
  }();
  return (*all)[static_cast<std::size_t>(kind)].set;
}

const KeySet& keys_of(std::string_view what) {
  for (const KeySet* set : kKeySets)
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
  for (const KeySet* set : kKeySets) {
    all.push_back(set);
    if (set != &keys::output) continue;
    for (const KeySet& event : event_key_sets()) all.push_back(&event);
  }
  for (const KeySet& set : path_key_sets()) all.push_back(&set);
  for (std::size_t i = 0; i < std::size(kShapeNames); ++i)
    all.push_back(&keys_of(static_cast<ShapeKind>(i)));
  return all;
}

}  // namespace pantin::detail
