#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/scene/json/json.hpp"
#include "tests/paths.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

bool is_good(const std::string& text) { return parse_json(text).faults.empty(); }

/// The same value as another reader sees it.
nlohmann::json rebuilt(const JsonDocument& d, NodeId id) {
  const JsonNode& n = d[id];
  switch (n.kind) {
    case JsonKind::boolean:
      return n.boolean;
    case JsonKind::number:
      return n.number;
    case JsonKind::string:
      return std::string(n.text);
    case JsonKind::array: {
      auto list = nlohmann::json::array();
      for (NodeId c = n.first_child; c != kNoNode; c = d[c].next) list.push_back(rebuilt(d, c));
      return list;
    }
    case JsonKind::object: {
      auto object = nlohmann::json::object();
      for (NodeId c = n.first_child; c != kNoNode; c = d[c].next)
        object[std::string(d[c].key)] = rebuilt(d, c);
      return object;
    }
    default:
      return nullptr;
  }
}

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream all;
  all << file.rdbuf();
  return all.str();
}

}  // namespace

TEST_CASE("JSON is accepted and refused as by another reader") {
  const char* texts[] = {"{}",
                         "[]",
                         "null",
                         " true ",
                         "[1,2.5,-0,1e3,1E+3,0.5e-2]",
                         "\"a\\u00e9\\ud83d\\ude00\\n\"",
                         "{\"a\":{\"b\":[[],{}]}}",
                         "1",
                         "-",
                         "01",
                         "1.",
                         ".5",
                         "+1",
                         "1e",
                         "[1,]",
                         "{\"a\":1,}",
                         "[,1]",
                         "{a:1}",
                         "{\"a\" 1}",
                         "\"a",
                         "\"\\x\"",
                         "\"\\u12\"",
                         "\"\\ud800\"",
                         "\"\\ud800\\u0041\"",
                         "tru",
                         "nul",
                         "[1 2]",
                         "{\"a\":1 \"b\":2}",
                         "[1]]",
                         "\"\t\"",
                         "// no",
                         "",
                         "  ",
                         "[",
                         "{",
                         "{\"a\":",
                         "0x10",
                         "1e5",
                         "--1",
                         "\"\\ude00\"",
                         "'a'",
                         "[1,2",
                         "\xC3\xA9",
                         "\"\xC3\xA9\"",
                         "\"\xFF\"",
                         "\"\xED\xA0\x80\"",
                         "\"\xC0\x80\"",
                         "\"\xF4\x90\x80\x80\"",
                         "1e-999",
                         "0e999"};
  for (const char* text : texts) {
    CAPTURE(text);
    const JsonDocument mine = parse_json(text);
    REQUIRE(mine.faults.empty() == nlohmann::json::accept(text));
    if (mine.faults.empty()) {
      CHECK(rebuilt(mine, 0) == nlohmann::json::parse(text));
    }
  }
}

TEST_CASE("JSON5 is read where it is asked for, and nowhere else") {
  const JsonLimits json5{.style = JsonStyle::json5};
  // After the example of json5.org.
  const std::string text = R"(/* a whole
  block */ {
  // comments
  unquoted: 'and you can quote me on that',
  singleQuotes: 'I can use "double quotes" here', $_x1: '\'', "\u00e9t": 'a\x41\v\0',
  lineBreaks: "Look, Mom! \
No \\n's!",
  hexadecimal: 0xdecaf, negative: -0xF,
  leadingDecimalPoint: .8675309, andTrailing: 8675309.,
  positiveSign: +1,
  trailingComma: 'in objects', andIn: ['arrays',],
  "backwardsCompatible": "with JSON",
} // the end)";
  const JsonDocument mine = parse_json(text, json5);
  CAPTURE(mine.faults.empty() ? "" : mine.faults[0].message);
  REQUIRE(mine.faults.empty());
  const nlohmann::json expected = {{"unquoted", "and you can quote me on that"},
                                   {"singleQuotes", "I can use \"double quotes\" here"},
                                   {"$_x1", "'"},
                                   {"\xC3\xA9t", std::string("aA\v\0", 4)},
                                   {"lineBreaks", "Look, Mom! No \\n's!"},
                                   {"hexadecimal", 0xdecaf},
                                   {"negative", -15},
                                   {"leadingDecimalPoint", 0.8675309},
                                   {"andTrailing", 8675309.0},
                                   {"positiveSign", 1},
                                   {"trailingComma", "in objects"},
                                   {"andIn", {"arrays"}},
                                   {"backwardsCompatible", "with JSON"}};
  CHECK(rebuilt(mine, 0) == expected);
  CHECK_FALSE(is_good(text));
  for (const char* part :
       {"[1,]", "{a: 1}", "// x\n1", "/**/1", "'a'", "+1", ".5", "5.", "0x1F", "\"\\x41\"", "\f1",
        "\xC2\xA0"
        "1"}) {
    CAPTURE(part);
    CHECK(parse_json(part, json5).faults.empty());
    CHECK_FALSE(is_good(part));
  }
  for (const char* part : {"[,]",
                           "[1,,]",
                           "{,}",
                           "{a 1}",
                           "{1: 2}",
                           "/* x",
                           "/",
                           "'a\"",
                           "++1",
                           ".",
                           "0x",
                           "0xG",
                           "0x11112222333344445",
                           "01",
                           "1.2.3",
                           "\"\\x4\"",
                           "\"\\u12\"",
                           "\"a\nb\"",
                           "\"\\1\"",
                           "NaN",
                           "+Infinity",
                           "-NaN",
                           "+-1",
                           "1 // x\n2"}) {
    CAPTURE(part);
    CHECK_FALSE(parse_json(part, json5).faults.empty());
  }
}

TEST_CASE("Whatever another reader takes, the reader of JSON5 takes too, and a scene by its name") {
  const std::string text = text_of(asset("scenes/marionette.json"));
  CHECK(rebuilt(parse_json(text, {.style = JsonStyle::json5}), 0) == nlohmann::json::parse(text));
  const char* loose = "{version: 1, /* nothing */ bodies: [],}";
  CHECK(parse_scene(loose, "t.json5"));
  CHECK(parse_scene(loose, "t.jsonc"));
  const Result<Scene> strict = parse_scene(loose, "t.json");
  REQUIRE_FALSE(strict);
  CHECK(strict.errors().size() == 1);
}

TEST_CASE("A large scene is read as by another reader") {
  const std::string text = text_of(asset("scenes/marionette.json"));
  REQUIRE_FALSE(text.empty());
  CHECK(rebuilt(parse_json(text), 0) == nlohmann::json::parse(text));
}

TEST_CASE("Every beginning of a scene is refused, and none is mistaken") {
  const std::string text = text_of(asset("scenes/pendulum.json"));
  const std::size_t end = text.find_last_of('}');
  for (std::size_t length = 0; length <= end; ++length) {
    const Result<Scene> scene = parse_scene(text.substr(0, length), "t.json");
    REQUIRE_FALSE(bool(scene));
    REQUIRE(scene.errors().size() == 1);
  }
}

TEST_CASE("A scene with any one byte changed is read or refused with a place") {
  const std::string text = text_of(asset("scenes/pendulum.json"));
  for (std::size_t i = 0; i < text.size(); ++i)
    for (char c : {'\0', '"', '{', ']', ',', '-', '9', '\xFF', 'e', ' '}) {
      std::string changed = text;
      changed[i] = c;
      const Result<Scene> scene = parse_scene(changed, "t.json");
      if (scene) continue;
      for (const Error& e : scene.errors()) {
        CAPTURE(e.message);
        REQUIRE(e.message.rfind("t.json:", 0) == 0);
        REQUIRE(e.message.find("expected") != std::string::npos);
      }
    }
}

TEST_CASE("Syntax errors name line, column, what was found and what was expected") {
  CHECK(diagnostics("{\n  \"version\": 1,\n}") ==
        Lines{"t.json:3:1: found \"}\", expected another key after the comma"});
  CHECK(diagnostics("{\"version\" 1}") ==
        Lines{"t.json:1:12: found \"1\", expected \":\" after the key"});
  CHECK(diagnostics("{\"version\": 01}") ==
        Lines{"t.json:1:13: found \"01\", expected a number as JSON writes it, like -1.5e3"});
  CHECK(diagnostics("{\"version\": 1 // one\n}") ==
        Lines{"t.json:1:15: found \"/\", expected \",\" or \"}\""});
  CHECK(diagnostics("{\"title\": \"a\nb\"}") ==
        Lines{"t.json:1:13: found the end of the line, expected the closing quote of a string"});
  CHECK(diagnostics("{\"version\": 1} {") ==
        Lines{"t.json:1:16: found \"{\", expected nothing after the end of the JSON value"});
  CHECK(diagnostics("{\"version\": 1,") ==
        Lines{"t.json:1:15: found the end of the file, expected a key in double quotes"});
}

TEST_CASE("Columns count characters, not bytes") {
  CHECK(diagnostics("{\"title\": \"\xC3\xA9\xC3\xA9\" x}") ==
        Lines{"t.json:1:16: found \"x\", expected \",\" or \"}\""});
}

TEST_CASE("Files that are empty, not UTF-8 or nested too deeply are refused") {
  CHECK(diagnostics("") == Lines{"t.json:1:1: found an empty file, expected a JSON object"});
  CHECK(diagnostics(" \n ") == Lines{"t.json:2:2: found an empty file, expected a JSON object"});
  CHECK(diagnostics("{\"title\": \"\xE9\"}") ==
        Lines{"t.json:1:12: found byte 0xE9, expected text in UTF-8"});
  CHECK(diagnostics("{\"a\": " + std::string(65, '[') + "1") ==
        Lines{"t.json:1:71: found a value nested 65 deep, expected at most 64"});
  CHECK(diagnostics(std::string("{\0}", 3)) ==
        Lines{"t.json:1:2: found byte 0x00, expected a key in double quotes"});
  SceneLimits few;
  few.values = 3;
  CHECK(diagnostics("[1, 2, 3]", few) ==
        Lines{"t.json:1:8: found more than 3 values, expected fewer"});
  few.bytes = 4;
  CHECK(diagnostics("[1, 2, 3]", few) ==
        Lines{"t.json: found more than 4 bytes, expected a scene file"});
}

TEST_CASE("A byte order mark is allowed and not counted") {
  CHECK(good("\xEF\xBB\xBF{\"version\": 1}").world.bodies.empty());
  CHECK(diagnostics("\xEF\xBB\xBF{\"version\": 2}") ==
        Lines{"t.json:1:13: /version: found 2, expected 1, the version this program reads"});
}

TEST_CASE("Keys given twice are refused at the second") {
  CHECK(diagnostics("{\"version\": 1,\n \"step\": 0.1, \"step\": 0.2}") ==
        Lines{"t.json:2:15: /step: found key \"step\" twice, expected each key once"});
}

TEST_CASE("Numbers that are not finite are refused, and the reading goes on") {
  CHECK(diagnostics("{\"version\": 1, \"step\": 1e999, \"gravity\": [NaN, 0, -Infinity],\n"
                    "\"duration\": -1}") ==
        Lines{"t.json:1:24: /step: found 1e999, expected a finite number",
              "t.json:1:43: /gravity/0: found NaN, expected a finite number",
              "t.json:1:51: /gravity/2: found -Infinity, expected a finite number",
              "t.json:2:13: /duration: found -1, expected a duration above 0, at most 1e6 s"});
  CHECK(is_good("[1e-400, 0.0000000000e-999999999999999999999, 0e99999999999999999999]"));
  CHECK_FALSE(is_good("[1e99999999999999999999]"));
  CHECK_FALSE(is_good("[1" + std::string(400, '0') + "]"));
  CHECK(is_good("[0." + std::string(400, '0') + "1]"));
}

TEST_CASE("Files that cannot be read are refused with the reason") {
  const auto refusal = [](const char* path) {
    const Result<Scene> scene = load_scene(path);
    REQUIRE_FALSE(bool(scene));
    REQUIRE(scene.errors().size() == 1);
    return scene.errors()[0].message;
  };
  CHECK(refusal("no/such.json") ==
        "no/such.json: found no file to read (No such file or directory), expected a scene file");
  CHECK(refusal("/") == "/: found a directory, expected a scene file");
  SceneLimits small;
  small.bytes = 1000;
  const Result<Scene> endless = load_scene("/dev/zero", small);
  REQUIRE_FALSE(bool(endless));
  CHECK(endless.errors()[0].message ==
        "/dev/zero: found more than 1000 bytes, expected a scene file");
}
