// The loader and the JSON Schema know the same keys.
#include "engine/scene/keys.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/geometry/kinds.hpp"
#include "engine/scene/shape_keys.hpp"
#include "tests/paths.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
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
  if (what == "dof") return joint("\"kind\": \"cylindrical\", \"angle\": {" + extra + "}");
  if (what == "joint_drive") return joint("\"drive\": {" + extra + "}");
  if (what == "pose_key") return joint("\"drive\": {\"keys\": [{\"time\": 0, " + extra + "}]}");
  if (what == "keyframe")
    return part("paths", R"([{"body": "a", "keyframes": [{"time": 0, )" + extra + "}]}]");
  if (what == "lissajous") return part("paths", R"([{"body": "a", "lissajous": {)" + extra + "}}]");
  if (what == "stairs") return part("generators", R"({"stairs": [{)" + extra + "}]}");
  if (what == "chain" || what == "grid")
    return part("generators", "{\"" + std::string(what) + "s\": [{" + extra + "}]}");
  for (std::string_view one :
       {"solver", "generators", "camera", "light", "ground", "output", "collision"})
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
    const Lines lines = diagnostics(text);
    const std::string expected =
        "found key \"frobnicate\", expected a key of a " + std::string(set.what);
    CHECK(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
      return line.find(expected) != std::string::npos;
    }));
  }
}

TEST_CASE("Every old key is read as today's, with a warning that names it") {
  for (const OldKey& old : kOldKeys) {
    CAPTURE(old.what, old.old);
    CHECK_FALSE(std::ranges::count(keys_of(old.what).keys, old.old));
    CHECK(std::ranges::count(keys_of(old.what).keys, old.today) == 1);
    // What is wrong with the value shows that somebody read it; errors hide warnings.
    std::string text = scene_with(old.what, std::string(old.old));
    text.replace(text.rfind("\": 1"), 4, "\": {\"frobnicate\": [[]]}");
    const Lines lines = diagnostics(text);
    const std::string place = "/" + std::string(old.old);
    CHECK(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
      return line.find(place) != std::string::npos && line.find("found key") == std::string::npos;
    }));
  }
  const Scene s = good(R"({"version": 1, "solver": {"type": "lagrangian", "passes": 9},
"bodies": [{"name": "l", "mass": 1, "inertia": [1, 1, 1]}, {"name": "r", "mass": 1, "inertia": [1, 1, 1]}],
"joints": [{"name": "i", "a": "world", "b": "l", "kind": "cylindrical", "anchor": [0, 0, 0],
"slide": {"friction": {"dry": 3}}},
{"name": "j", "a": "world", "b": "r", "kind": "hinge", "anchor": [0, 0, 0]}],
"ratios": [{"name": "g", "first": "i", "first_moves": "slide", "second": "j", "ratio": 2}]})");
  CHECK(s.warnings ==
        Lines{"t.json:1:59: /solver/passes: the key \"passes\" is called "
              "\"active_set_iterations\" today",
              "t.json:4:10: /joints/0/slide: the key \"slide\" is called \"travel\" today",
              "t.json:6:11: /ratios: the key \"ratios\" is called \"gears\" today",
              "t.json:6:55: /ratios/0/first_moves: the key \"first_moves\" is called "
              "\"first_coordinate\" today",
              "t.json:6:55: /ratios/0/first_moves: \"slide\" is called \"travel\" today"});
  CHECK(s.world.gears[s.world.find("g")].first_travels);
  CHECK(s.world.links[s.world.find("i")].joint.parameters->translation.friction.dry == 3);
  CHECK(s.world.default_settings.active_set_iterations == 9);
}

TEST_CASE("A key beside its old name is refused") {
  CHECK(diagnostics(R"({"version": 1, "strings": [], "cables": []})") ==
        Lines{"t.json:1:16: /strings: found \"strings\" beside \"cables\", expected only the "
              "latter, its name today"});
}

TEST_CASE("Every key of every kind of object is read") {
  // An object as the value fits no key but those of objects; a key that nobody reads would pass.
  for (const KeySet& set : all_kinds())
    for (std::string_view key : set.keys) {
      std::string text = scene_with(set.what, std::string(key));
      const std::size_t at = text.rfind("\": 1");
      text.replace(at, 4, "\": {\"frobnicate\": [[]]}");
      CAPTURE(text);
      const Lines lines = diagnostics(text);
      std::string place("/");
      place += key;
      CHECK(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
        return line.find(place) != std::string::npos;
      }));
    }
}
