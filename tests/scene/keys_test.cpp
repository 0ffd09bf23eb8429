// The loader and the JSON Schema know the same keys.
#include "engine/scene/keys.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/geometry/kinds.hpp"
#include "engine/scene/shape_keys.hpp"
#include "tests/scene/scenes.hpp"
#include "tests/paths.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

nlohmann::json schema() {
  std::ifstream file(asset("schema/scene.schema.json"));
  return nlohmann::json::parse(file);
}

/// A scene in which an object of this kind stands, with a key added to it.
std::string scene_with(std::string_view what, const std::string& key) {
  const std::string extra = "\"" + key + "\": 1";
  const auto body = [](const std::string& members) {
    return R"({"version": 1, "bodies": [{"name": "a", )" + members + "}]}";
  };
  const auto part = [](const std::string& name, const std::string& members) {
    return R"({"version": 1, ")" + name + "\": " + members + "}";
  };
  if (what == "scene") return "{\"version\": 1, " + extra + "}";
  if (what == "body") return body(extra);
  for (std::size_t i = 0; i < std::size(kShapeNames); ++i)
    if (what == kShapeNames[i]) {
      std::string members = R"("shape": {"type": ")" + std::string(what) + "\", ";
      for (const SizeKey& size : kShapeTraits[i]->sizes)
        members += "\"" + std::string(size.key) + (size.count == 3 ? "\": [1, 1, 1], " : "\": 1, ");
      return body(members + extra + "}");
    }
  const auto joint = [&](const std::string& members) {
    return part("joints", R"([{"a": "a", "b": "b", "anchor": [0, 0, 0], )" + members + "}]");
  };
  if (what == "limits") return joint("\"limits\": {" + extra + "}");
  if (what == "soft") return joint("\"limits\": {\"soft\": {" + extra + "}}");
  for (std::string_view part_of : {"spring", "friction", "motor"})
    if (what == part_of)
      return joint("\"kind\": \"hinge\", \"" + std::string(what) + "\": {" + extra + "}");
  if (what == "freedom") return joint("\"kind\": \"cylindrical\", \"turn\": {" + extra + "}");
  if (what == "pose_drive") return joint("\"drive\": {" + extra + "}");
  if (what == "pose_key") return joint("\"drive\": {\"keys\": [{\"time\": 0, " + extra + "}]}");
  if (what == "keyframe")
    return part("drives", R"([{"body": "a", "keyframes": [{"time": 0, )" + extra + "}]}]");
  if (what == "lissajous")
    return part("drives", R"([{"body": "a", "lissajous": {)" + extra + "}}]");
  if (what == "stairs") return part("generators", R"({"stairs": [{)" + extra + "}]}");
  if (what == "chain" || what == "grid")
    return part("generators", "{\"" + std::string(what) + "s\": [{" + extra + "}]}");
  for (std::string_view one : {"solver", "generators", "camera", "light", "ground", "output",
                               "collision"})
    if (what == one) return part(std::string(what), "{" + extra + "}");
  return part(std::string(what) + "s", "[{" + extra + "}]");
}

/// All kinds of objects, shapes too.
std::vector<KeySet> all_kinds() {
  std::vector<KeySet> all(kKeySets.begin(), kKeySets.end());
  for (std::size_t i = 0; i < std::size(kShapeNames); ++i)
    all.push_back(keys_of(static_cast<ShapeKind>(i)));
  return all;
}

}  // namespace

TEST_CASE("The schema describes shapes as the table of their kinds does") {
  const nlohmann::json defs = schema().at("$defs");
  nlohmann::json kinds = nlohmann::json::array();
  for (std::size_t i = 0; i < std::size(kShapeNames); ++i) {
    const std::string name(kShapeNames[i]);
    CAPTURE(name);
    kinds.push_back({{"$ref", "#/$defs/" + name}});
    CHECK(defs.at(name) == nlohmann::json::parse(schema_of(static_cast<ShapeKind>(i))));
  }
  CHECK(defs.at("shape").at("oneOf") == kinds);
}

TEST_CASE("Loader and schema have the same kinds of objects with the same keys") {
  const nlohmann::json defs = schema().at("$defs");
  std::set<std::string> with_keys;
  for (const auto& [name, value] : defs.items())
    if (value.contains("properties")) with_keys.insert(name);
  for (const KeySet& set : all_kinds()) {
    CAPTURE(set.what);
    REQUIRE(with_keys.erase(std::string(set.what)) == 1);
    const nlohmann::json& kind = defs.at(std::string(set.what));
    CHECK(kind.at("additionalProperties") == false);
    std::set<std::string> mine, theirs;
    for (std::string_view key : set.keys) mine.insert(std::string(key));
    for (const auto& [key, value] : kind.at("properties").items()) theirs.insert(key);
    CHECK(mine == theirs);
    CHECK(mine.size() == set.keys.size());
  }
  CHECK(with_keys.empty());
}

TEST_CASE("Every kind of object refuses a key it does not know") {
  for (const KeySet& set : all_kinds()) {
    const std::string text = scene_with(set.what, "frobnicate");
    CAPTURE(text);
    const Lines lines = complaints(text);
    const std::string expected =
        "found key \"frobnicate\", expected a key of a " + std::string(set.what);
    CHECK(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
      return line.find(expected) != std::string::npos;
    }));
  }
}

TEST_CASE("Every key of every kind of object is read") {
  // An object as the value fits no key but those of objects; a key that nobody reads would pass.
  for (const KeySet& set : all_kinds())
    for (std::string_view key : set.keys) {
      std::string text = scene_with(set.what, std::string(key));
      const std::size_t at = text.rfind("\": 1");
      text.replace(at, 4, "\": {\"frobnicate\": [[]]}");
      CAPTURE(text);
      const Lines lines = complaints(text);
      std::string place("/");
      place += key;
      CHECK(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
        return line.find(place) != std::string::npos;
      }));
    }
}
