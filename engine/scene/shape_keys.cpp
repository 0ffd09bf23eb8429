// Keys of shapes, from the table of their kinds.
#include <array>
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

/// What depends on what a surface is made of.
KeySet surface_keys(SurfaceSource source) {
  switch (source) {
    case SurfaceSource::points:
      return {"", "", kPointKeys, kPointPairs, kPointNeeds};
    case SurfaceSource::triangles:
      return {"", "", kTriangleKeys, kTrianglePairs, kTriangleNeeds};
    case SurfaceSource::heights:
      return {"", "", kHeightKeys};
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

std::vector<Key> list_keys(const ShapeTraits& kind, Words name, const KeySet& surface) {
  std::vector<Key> keys{word("type", name, "The kind of shape.")};
  keys.front().is_needed = true;
  for (const SizeKey& size : kind.sizes) keys.push_back(size_key(size));
  keys.insert(keys.end(), surface.keys.begin(), surface.keys.end());
  keys.push_back(kPosition);
  if (!kind.is_round) keys.insert(keys.end(), {kRotation, kRotationDeg});
  keys.push_back(kMaterial);
  if (kind.volume || kind.enclosed) keys.push_back(kDensity);
  return keys;
}

}  // namespace

const KeySet& keys_of(ShapeKind kind) {
  constexpr std::size_t kCount = std::size(kShapeNames);
  struct Sets {
    std::array<std::vector<Key>, kCount> keys;
    std::array<KeySet, kCount> sets;
  };
  static const Sets all = [] {
    Sets made;
    for (std::size_t i = 0; i < kCount; ++i) {
      const ShapeTraits& traits = *kShapeTraits[i];
      made.sets[i] = surface_keys(traits.source);
      made.keys[i] = list_keys(traits, std::span(kShapeNames).subspan(i, 1), made.sets[i]);
      made.sets[i].what = kShapeNames[i];
      made.sets[i].about = traits.about;
      made.sets[i].keys = made.keys[i];
    }
    return made;
  }();
  return all.sets[static_cast<std::size_t>(kind)];
}

const KeySet& keys_of(std::string_view what) {
  for (const KeySet* set : kKeySets)
    if (set->what == what) return *set;
  for (const KeySet& set : path_key_sets())
    if (set.what == what) return set;
  PANTIN_ASSERT(false);
  return keys::scene;
}

std::vector<const KeySet*> all_key_sets() {
  std::vector<const KeySet*> all(std::begin(kKeySets), std::end(kKeySets));
  for (const KeySet& set : path_key_sets()) all.push_back(&set);
  for (std::size_t i = 0; i < std::size(kShapeNames); ++i)
    all.push_back(&keys_of(static_cast<ShapeKind>(i)));
  return all;
}

}  // namespace pantin::detail
