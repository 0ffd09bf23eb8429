// The tables of keys: the loader reads every key as they say, and the shipped JSON Schema is the
// one that is printed from them.
#include "engine/scene/keys/keys.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/geometry/kinds.hpp"
#include "engine/scene/json/json.hpp"
#include "engine/scene/keys/schema.hpp"
#include "tests/paths.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// A scene in which an object of this kind stands, with a member added to it. Joints are of `kind`.
std::string scene_with(std::string_view what, const std::string& extra,
                       std::string_view kind = "ball") {
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
  // What tells the kind stands alone.
  const bool tells_kind = extra.starts_with("\"kind\"") || extra.starts_with("\"type\"");
  const std::string of_kind = tells_kind ? "" : "\"kind\": \"" + std::string(kind) + "\", ";
  const auto joint = [&](const std::string& members) {
    return part("joints", R"([{"a": "a", "b": "b", )" + of_kind + members + "}]");
  };
  if (what == "joint") return joint(extra);
  if (what == "limits") return joint("\"limits\": {" + extra + "}");
  if (what == "soft") return joint("\"limits\": {\"soft\": {" + extra + "}}");
  for (std::string_view part_of : {"spring", "friction", "motor"})
    if (what == part_of) return joint("\"" + std::string(what) + "\": {" + extra + "}");
  if (what == "dof") return joint("\"angle\": {" + extra + "}");
  if (what == "joint_drive") return joint("\"drive\": {" + extra + "}");
  if (what == "drive_motion") return joint("\"drive\": {\"motion\": {" + extra + "}}");
  if (what == "pose_key") return joint("\"drive\": {\"keys\": [{\"time\": 0, " + extra + "}]}");
  if (what == "cable_guide")
    return part("cables", R"([{"a": "a", "b": "b", "over": [{"body": "a", )" + extra + "}]}]");
  if (what == "keyframe")
    return part("paths", R"([{"body": "a", "keyframes": [{"time": 0, )" + extra + "}]}]");
  for (const KeySet& set : path_key_sets().subspan(1))
    if (what == set.what)
      return part("paths", R"([{"body": "a", ")" + std::string(what) + "\": {" + extra + "}}]");
  if (what.ends_with("_event")) {
    const bool is_type = extra.starts_with("\"type\"");
    const std::string type = "\"type\": \"" + std::string(what.substr(0, what.find('_'))) + "\", ";
    return part("events", "[{" + (is_type ? "" : type) + extra + "}]");
  }
  const auto typed = [&](std::string_view suffix) {
    if (extra.starts_with("\"type\"")) return extra;
    return "\"type\": \"" + std::string(what.substr(0, what.size() - suffix.size())) + "\", " +
           extra;
  };
  const auto face = [&](const std::string& members) {
    return part("surfaces", R"([{"name": "s", "faces": [{)" + members + "}]}]");
  };
  if (what.ends_with("_face")) return face(typed("_face"));
  if (what.ends_with("_curve")) return part("curves", "[{" + typed("_curve") + "}]");
  if (what == "surface_joint")
    return part("surface_joints", R"([{"a": {"body": "a"}, "b": {"body": "b"}, )" + extra + "}]");
  if (what == "belt") return part("belts", R"([{"pulleys": [{"body": "a"}], )" + extra + "}]");
  if (what == "belt_pulley")
    return part("belts", R"([{"pulleys": [{"body": "b", )" + extra + "}]}]");
  if (what == "surface_side")
    return part("surface_joints",
                R"([{"b": {"body": "b"}, "a": {"body": "a", "surface": "s", )" + extra +
                    "}}], \"surfaces\": [{\"name\": \"s\", \"faces\": [{\"type\": \"sphere\", "
                    "\"radius\": 1}]}]");
  if (what == "free_number") return part("free", "[{" + extra + "}]");
  if (what == "class") return part("classes", "[{" + extra + "}]");
  if (what == "defaults") return part("defaults", "{" + extra + "}");
  const auto of_class = [&](const std::string& key, const std::string& user) {
    return part("classes", R"([{"name": "c", ")" + key + "\": {" + extra + "}}], " + user);
  };
  if (what == "body_class") return of_class("body", R"("bodies": [{"name": "a", "class": "c"}])");
  if (what == "joint_class")
    return of_class("joint", R"("joints": [{"a": "a", "b": "b", )" + of_kind + R"("class": "c"}])");
  if (what == "cable_class")
    return of_class("cable", R"("cables": [{"a": "a", "b": "b", "class": "c"}])");
  if (what == "pin_class") return of_class("pin", R"("pins": [{"body": "a", "class": "c"}])");
  if (what == "finger") return part("laminas", R"([{"name": "l", "fingers": [{)" + extra + "}]}]");
  if (what == "mirror") return part("generators", R"({"mirrors": [{)" + extra + "}]}");
  if (what == "stairs") return part("generators", R"({"stairs": [{)" + extra + "}]}");
  if (what == "chain" || what == "grid" || what == "ring")
    return part("generators", "{\"" + std::string(what) + "s\": [{" +
                                  (what == "chain" ? of_kind : "") + extra + "}]}");
  for (std::string_view one :
       {"solver", "generators", "camera", "light", "ground", "output", "collision"})
    if (what == one) return part(std::string(what), "{" + extra + "}");
  return part(std::string(what) + "s", "[{" + extra + "}]");
}

/// Complaints about a value under a key, of whatever kind of joint; not those that it belongs to
/// other kinds.
Lines told_of(std::string_view what, std::string_view key, const std::string& value) {
  const std::string place = "/" + std::string(key),
                    member = "\"" + std::string(key) + "\": " + value;
  Lines told;
  for (const JointKindInfo& kind : kJointKindInfos) {
    if (!kind.in_files) continue;
    const std::string text = scene_with(what, member, kind.name);
    for (const std::string& line : diagnostics(text)) {
      const bool is_there =
          line.find(place + ":") != line.npos || line.find(place + "/") != line.npos;
      const bool is_of_others = line.find("of these kinds only") != line.npos ||
                                line.find("found a limit") != line.npos ||
                                line.find("only its ends") != line.npos;
      if (is_there && !is_of_others) told.push_back(line);
    }
    if (!told.empty() || text == scene_with(what, member, "none")) break;
  }
  return told;
}

bool takes(const Key& key, JsonKind kind) {
  switch (key.type) {
    case ValueType::number:
    case ValueType::whole:
      return kind == JsonKind::number;
    case ValueType::flag:
      return kind == JsonKind::boolean;
    case ValueType::text:
    case ValueType::name:
    case ValueType::reference:
    case ValueType::word:
      return kind == JsonKind::string;
    case ValueType::vector_or_number:
    case ValueType::number_or_pair:
    case ValueType::joint_turn:
    case ValueType::joint_turn_deg:
      return kind == JsonKind::number || kind == JsonKind::array;
    case ValueType::colour:
      return kind == JsonKind::string || kind == JsonKind::array;
    case ValueType::object:
      return kind == JsonKind::object;
    case ValueType::object_or_reference:
      return kind == JsonKind::object || kind == JsonKind::string;
    case ValueType::object_or_flag:
      return kind == JsonKind::object || kind == JsonKind::boolean;
    default:
      return kind == JsonKind::array;
  }
}

/// Values that do not fit the key: of every other type, and such as are out of its bounds.
std::vector<std::string> misfits_of(const Key& key) {
  constexpr std::pair<JsonKind, const char*> kSamples[] = {
      {JsonKind::null, "null"},      {JsonKind::boolean, "true"},
      {JsonKind::number, "1"},       {JsonKind::string, "\"\\u0007\""},
      {JsonKind::array, "[[[[]]]]"}, {JsonKind::object, "{\"frobnicate\": 1}"}};
  std::vector<std::string> values;
  for (const auto& [kind, text] : kSamples)
    if (!takes(key, kind) || kind == JsonKind::object || kind == JsonKind::array)
      values.emplace_back(text);
  if (key.type == ValueType::word || key.type == ValueType::colour)
    values.push_back("\"frobnicate\"");
  if (key.type == ValueType::reference || key.type == ValueType::name) values.push_back("\"\"");
  std::string least = std::to_string(key.range.least - 1), most = "1e13";
  const auto times = [](const std::string& item, int count) {
    std::string text = "[" + item;
    for (int i = 1; i < count; ++i) text += ", " + item;
    return text + "]";
  };
  if (key.type == ValueType::number) values.insert(values.end(), {least, most});
  if (key.type == ValueType::number && key.range.open) values.push_back("0");
  if (key.is_never_zero) values.push_back("0");
  if (key.type == ValueType::whole) values.insert(values.end(), {least, most, "1.5"});
  if (key.type == ValueType::vector || key.type == ValueType::direction)
    values.insert(values.end(), {times("1", 2), times("1", 4), times("1e13", 3)});
  if (key.type == ValueType::direction) values.push_back("[0, 0, 0]");
  if (key.type == ValueType::wholes) values.push_back(times("17.5", key.count));
  if (key.count > 0)
    values.insert(values.end(), {times("20", key.count + 1), times("1e13", key.count)});
  return values;
}

}  // namespace

TEST_CASE("The shipped schema is the one that is printed from the tables") {
  std::ifstream file(asset("schema/scene.schema.json"));
  const nlohmann::json shipped = nlohmann::json::parse(file);
  const bool is_the_same = shipped == nlohmann::json::parse(scene_schema());
  INFO("pantin schema --out assets/schema/scene.schema.json");
  CHECK(is_the_same);
}

TEST_CASE("Every row of the tables says what its key means, and is the only one of its name") {
  for (const KeySet* set : all_key_sets())
    for (const Key& key : set->keys) {
      CAPTURE(set->what, key.name);
      CHECK_FALSE(key.about.empty());
      CHECK(std::ranges::count(set->keys, key.name, &Key::name) == 1);
      CHECK((!key.is_needed || !key.expected.empty() || key.name == "type"));
      CHECK((key.old_words.empty() || key.old_words.size() == key.words.size()));
      const auto is_there = [&](std::string_view name) { CHECK(set->find(name)); };
      for (const Exclusive& pair : set->exclusive)
        is_there(pair.one), each_word(pair.others, is_there);
      for (const AnyOf& any : set->any_of) each_word(any.keys, is_there);
      for (const Beside& beside : set->beside)
        is_there(beside.key), each_word(beside.with, is_there);
    }
}

TEST_CASE("Every kind of object refuses a key it does not know") {
  for (const KeySet* set : all_key_sets()) {
    CAPTURE(set->what);
    const std::string expected =
        "found key \"frobnicate\", expected a key of a " + std::string(set->what);
    const Lines lines = told_of(set->what, "frobnicate", "1");
    CHECK(std::ranges::any_of(
        lines, [&](const std::string& line) { return line.find(expected) != line.npos; }));
  }
}

TEST_CASE("Every old key is read as today's, with a warning that names it") {
  for (const KeySet* set : all_key_sets())
    for (const Key& key : set->keys) {
      if (key.old.empty()) continue;
      CAPTURE(set->what, key.old);
      CHECK_FALSE(set->find(key.old));
      // What is wrong with the value shows that somebody read it; errors hide warnings.
      const Lines lines = told_of(set->what, key.old, "{\"frobnicate\": [[]]}");
      CHECK(std::ranges::any_of(lines, [&](const std::string& line) {
        return line.find("found key \"" + std::string(key.old)) == std::string::npos;
      }));
    }
  const Scene s = good(R"({"version": 1, "solver": {"type": "lagrangian", "rounds": 9},
"bodies": [{"name": "l", "mass": 1, "inertia": [1, 1, 1]}, {"name": "r", "mass": 1, "inertia": [1, 1, 1]}],
"joints": [{"name": "i", "a": "world", "b": "l", "kind": "cylindrical", "anchor": [0, 0, 0],
"slide": {"friction": {"dry": 3}}},
{"name": "j", "a": "world", "b": "r", "kind": "hinge", "anchor": [0, 0, 0]}],
"ratios": [{"name": "g", "first": "i", "first_moves": "slide", "second": "j", "ratio": 2}]})");
  CHECK(s.warnings ==
        Lines{"t.json:1:59: /solver/rounds: the key \"rounds\" is now called \"sweeps\"",
              "t.json:4:10: /joints/0/slide: the key \"slide\" is now called \"travel\"",
              "t.json:6:11: /ratios: the key \"ratios\" is now called \"gears\"",
              "t.json:6:55: /ratios/0/first_moves: the key \"first_moves\" is now called "
              "\"first_coordinate\"",
              "t.json:6:55: /ratios/0/first_moves: \"slide\" is now called \"travel\""});
  CHECK(s.world.gears[s.world.find("g")].first_travels);
  CHECK(s.world.links[s.world.find("i")].joint.parameters->translation.friction.dry == 3);
  CHECK(s.world.default_settings.sweeps == 9);
}

TEST_CASE("A key that nothing reads any more is told of, and left") {
  const Scene s = good(R"({"version": 1, "solver": {"calm_angle_deg": 20, "sweeps": 9}})");
  CHECK(s.warnings == Lines{"t.json:1:45: /solver/calm_angle_deg: the key \"calm_angle_deg\" no "
                            "longer has any effect"});
  CHECK(s.world.default_settings.sweeps == 9);
}

TEST_CASE("Old words for solvers and motions are read as today's, with warnings") {
  const Scene s = good(R"({"version": 1,
"solver": {"type": "paper", "paper_reluctance": "literal_step"},
"bodies": [{"name": "hand", "motion": "driven"}]})");
  CHECK(s.warnings ==
        Lines{"t.json:2:20: /solver/type: \"paper\" is now called \"procedural\"",
              "t.json:2:49: /solver/paper_reluctance: the key \"paper_reluctance\" is now called "
              "\"procedural_reluctance\"",
              "t.json:3:39: /bodies/0/motion: \"driven\" is now called \"kinematic\""});
  CHECK(s.world.default_settings.solver == Solver::procedural);
  CHECK(s.world.default_settings.procedural_reluctance == ProceduralReluctance::literal_step);
  CHECK(s.world.bodies[s.world.find("hand")].motion == Motion::kinematic);
  // A word that never had another name has "" in that place of the table.
  CHECK_FALSE(diagnostics(R"({"version": 1, "solver": {"type": ""}})").empty());
}

TEST_CASE("The American spelling of a colour is read, with a word about the key's name") {
  const Scene s = good(R"({"version": 1, "materials": [{"name": "red", "color": "#ff0000"}]})");
  CHECK(s.warnings ==
        Lines{"t.json:1:55: /materials/0/color: the key \"color\" is now called \"colour\""});
  REQUIRE_FALSE(s.world.materials.empty());
  CHECK(s.world.materials.back().colour.x == 1);
  CHECK(s.world.materials.back().colour.y == 0);
}

TEST_CASE("A key beside its old name is refused") {
  CHECK(diagnostics(R"({"version": 1, "strings": [], "cables": []})") ==
        Lines{"t.json:1:16: /strings: found \"strings\" beside \"cables\", expected only the "
              "latter, its current name"});
}

TEST_CASE("Every key of every kind of object is read as its row says") {
  // A key that nobody reads, or not by its bounds, would pass.
  for (const KeySet* set : all_key_sets())
    for (const Key& key : set->keys) {
      const bool is_unread = key.name == "type" && set->what == key.words.front();  // of shapes
      for (const std::string& value : misfits_of(key)) {
        if (is_unread) continue;
        CAPTURE(set->what, key.name, value);
        CHECK_FALSE(told_of(set->what, key.name, value).empty());
      }
    }
}
