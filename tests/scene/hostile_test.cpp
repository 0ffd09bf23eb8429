// Files that ask for more than there is, and small ones that once crashed, hung or lied.
#include <cmath>
#include <ctime>
#include <functional>
#include <string>

#include "engine/base/utf8.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// CPU time, the best of three, so that whatever else the machine does counts little.
double seconds_of(const std::string& text) {
  double best = 1e300;
  for (int i = 0; i < 3; ++i) {
    const std::clock_t start = std::clock();
    parse_scene(text, "t.json");
    best = std::min(best, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return best;
}

/// `n` items made from their numbers, between commas.
template <class F>
std::string listed(int n, F item) {
  std::string text;
  for (int i = 0; i < n; ++i) text += (i > 0 ? ",\n" : "") + item(i);
  return text;
}

std::string chain(const std::string& members) {
  return R"({"version": 1, "generators": {"chains": [{"name": "c", "mass": 1, "inertia": [1, 1, 1],
)" + members +
         "}]}}";
}

std::string grid(const std::string& bodies, const std::string& count) {
  return R"({"version": 1, "prefabs": [{"name": "p", "bodies": [)" + bodies +
         R"(]}], "generators": {"grids": [
{"name": "g", "prefab": "p", "count": )" +
         count + "}]}}";
}

}  // namespace

TEST_CASE("A closed chain of points that are none is refused") {
  CHECK(diagnostics(chain(R"("closed": true, "path": [1, 2, 3])")) ==
        Lines{"t.json:2:26: /generators/chains/0/path/0: found 1, expected an array of 3 numbers",
              "t.json:2:29: /generators/chains/0/path/1: found 2, expected an array of 3 numbers",
              "t.json:2:32: /generators/chains/0/path/2: found 3, expected an array of 3 numbers"});
  CHECK(diagnostics(chain(R"("closed": true, "path": [[1, 2], [2, 3], [3, 4]])")).size() == 3);
}

TEST_CASE("Chains of one name are refused without looking into one another") {
  const auto links = [](int n) {
    return R"({"name": "c", "mass": 1, "inertia": [1, 1, 1], "length": 1, "links": )" +
           std::to_string(n) + "}";
  };
  CHECK(diagnostics(R"({"version": 1, "generators": {"chains": [)" + links(1) + ",\n" + links(50) +
                    "]}}") == Lines{"t.json:2:10: /generators/chains/1/name: found the name \"c\" "
                                    "again, expected one that /generators/chains/0 does not have"});
}

TEST_CASE("Copies are counted before they are made") {
  CHECK(diagnostics(grid("", "[1000000, 1000000, 1000000]")) ==
        Lines{"t.json:2:1: /generators/grids/0: found 1e+18 copies of prefabs, expected at most "
              "1000000"});
  CHECK(diagnostics(grid("", "[1000001, 1, 1]")).size() == 1);
  CHECK(diagnostics(grid(R"({"name": "b", "motion": "fixed"})", "[101, 100, 100]")) ==
        Lines{"t.json:2:1: /generators/grids/0: found 1010000 bodies, expected at most 1000000"});
  SceneLimits few;
  few.copies = 10;
  CHECK(diagnostics(grid("", "[11, 1, 1]"), few) ==
        Lines{"t.json:2:1: /generators/grids/0: found 11 copies of prefabs, expected at most 10"});
  CHECK(good(grid("", "[10, 1, 1]")).world.bodies.empty());
}

TEST_CASE("Names that grow with every copy are counted") {
  SceneLimits few;
  few.name_bytes = 100;
  const auto lines = diagnostics(grid(R"({"name": "b", "motion": "fixed"})", "[100, 1, 1]"), few);
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].find("bytes of names, expected at most 100") != std::string::npos);
}

TEST_CASE("Numbers with any exponent are read, refused or 0") {
  for (const char* huge : {"10e9223372036854775807", "0.0001e9223372036854775807", "1e999",
                           "-1e999", "10e99999999999999999999"}) {
    const auto lines = diagnostics(std::string("{\"version\": 1, \"drift_bound\": ") + huge + "}");
    REQUIRE(lines.size() == 1);
    CHECK(lines[0].find("expected a finite number") != std::string::npos);
  }
  for (const char* tiny : {"1e-999", "100e-9223372036854775808", "0e9223372036854775807"})
    CHECK(good(std::string("{\"version\": 1, \"gravity\": [0, ") + tiny + ", 0]}").world.gravity ==
          Vec3(0));
}

TEST_CASE("Keys of paths and drives beyond all numbers are refused at their place") {
  const std::string body = R"({"version": 1, "bodies": [{"name": "b", "motion": "kinematic"}],
"paths": [{"body": "b", "keyframes": [)";
  CHECK(diagnostics(body + R"({"time": 1e999}]}]})") ==
        Lines{"t.json:2:48: /paths/0/keyframes/0/time: found 1e999, expected a finite number"});
  CHECK(diagnostics(body + R"({"time": 0, "position": [0, 1e400, 0]}]}]})") ==
        Lines{"t.json:2:67: /paths/0/keyframes/0/position/1: found 1e400, expected a finite "
              "number"});
  CHECK(diagnostics(body + R"({"time": 0, "rotation": [0, 0, NaN, 1]}]}]})") ==
        Lines{"t.json:2:70: /paths/0/keyframes/0/rotation/2: found NaN, expected a finite number"});
}

TEST_CASE("Text of a file reaches no terminal as it is") {
  const std::string attack = "\\u001b]0;x\\u0007\\u009b31m\\u007f\\u202e";
  const auto is_safe = [](const std::string& line) { return line == printable(line); };
  const std::string texts[] = {
      "{\"version\": 1, \"" + attack + "\": 1}",
      "{\"version\": 1, \"solver\": {\"type\": \"" + attack + "\"}}",
      "{\"version\": 1, \"bodies\": [{\"name\": \"\\u009b1m\", \"motion\": \"fixed\"},"
      "{\"name\": \"\\u009b1m\", \"motion\": \"fixed\"}]}",
      "{\"version\": 1, \"bodies\": [{\"name\": \"a\", \"motion\": \"fixed\", \"shape\": "
      "{\"type\": \"mesh\", \"file\": \"" +
          attack + "\"}}]}"};
  for (const std::string& text : texts) {
    const auto lines = diagnostics(text);
    REQUIRE_FALSE(lines.empty());
    for (const std::string& line : lines) {
      CAPTURE(printable(line));
      CHECK(is_safe(line));
      CHECK(line.find("\\u") != std::string::npos);
    }
  }
  CHECK(printable("\x1b[31m\n\xC2\x9B\x7F\xFF h\xC3\xA9") ==
        "\\u001b[31m\\u000a\\u009b\\u007f\\xff h\xC3\xA9");
  CHECK(printable(printable("\x1b")) == "\\u001b");
}

TEST_CASE("Reading can be called off") {
  SceneLimits limits;
  int asked = 0;
  limits.is_cancelled = [&] { return ++asked > 2; };
  CHECK(diagnostics(grid(R"({"name": "b", "motion": "fixed"})", "[100, 100, 100]"), limits) ==
        Lines{"t.json: reading was cancelled"});
  CHECK(asked == 3);
}

// Each of these took time with the square of its length. A hundred times a file whose time nothing
// can tell from 0 would take minutes.
TEST_CASE("The time of reading grows no faster than the file", "[timed]") {
  const std::string two = R"({"name": "a", "mass": 1, "inertia": [1, 1, 1]},
{"name": "b", "mass": 1, "inertia": [1, 1, 1], "position": [1, 0, 0]})";
  const auto scene = [&](const std::string& rest) {
    return "{\"version\": 1, \"bodies\": [" + two + "],\n" + rest + "}";
  };
  const auto repeat = [&](const char* list, const char* item) {
    return [=](int n) {
      return scene("\"" + std::string(list) + "\": [" +
                   listed(n, [&](int) { return std::string(item); }) + "]");
    };
  };
  const auto name = [](const char* stem, int i) {
    return "\"" + std::string(stem) + std::to_string(i) + "\"";
  };
  using Make = std::function<std::string(int)>;
  const std::pair<const char*, Make> cases[] = {
      {"joints without names", repeat("joints", R"({"a": "a", "b": "b", "anchor": [0, 0, 0]})")},
      {"cables without names", repeat("cables", R"({"a": "a", "b": "b"})")},
      {"pins without names", repeat("pins", R"({"body": "a"})")},
      {"names of prefabs",
       [&](int n) {
         return "{\"version\": 1, \"prefabs\": [" +
                listed(n, [&](int i) { return "{\"name\": " + name("p", i) + "}"; }) +
                "], \"instances\": [" +
                listed(n,
                       [&](int i) {
                         return "{\"name\": " + name("i", i) + ", \"prefab\": " + name("p", i) +
                                "}";
                       }) +
                "]}";
       }},
      {"warnings",
       [&](int n) {
         return "{\"version\": 1, \"bodies\": [" +
                listed(n,
                       [&](int i) {
                         return "{\"name\": " + name("b", i) +
                                ", \"motion\": \"fixed\", \"rotation\": [0, 0, 0, 1.0001]}";
                       }) +
                "]}";
       }},
      {"names that lead nowhere",
       [&](int n) {
         return scene("\"pins\": [" +
                      listed(n,
                             [&](int i) {
                               return "{\"body\": " + name("no_such_body_as_this_one_", i) + "}";
                             }) +
                      "]");
       }},
      {"chains that are broken",
       [&](int n) {
         return scene(
             "\"generators\": {\"chains\": [" +
             listed(n, [&](int i) { return "{\"name\": " + name("c", i) + "}"; }) +
             "]}, \"pins\": [" +
             listed(n, [&](int i) { return "{\"body\": \"c" + std::to_string(i) + "/0\"}"; }) +
             "]");
       }},
  };
  for (const auto& [what, make] : cases) {
    CAPTURE(what);
    const std::string few = make(1000), many = make(20'000);
    // Twenty times as much, with room for what grows a little faster and for a busy machine.
    CHECK(seconds_of(many) < 0.2 + 100 * seconds_of(few));
  }
}

TEST_CASE("Warnings beyond a hundred are counted") {
  const std::string text =
      "{\"version\": 1, \"bodies\": [" +
      listed(150,
             [](int i) {
               return "{\"name\": \"b" + std::to_string(i) +
                      "\", \"motion\": \"fixed\", \"rotation\": [0, 0, 0, 1.0001]}";
             }) +
      "]}";
  const auto warnings = good(text).warnings;
  REQUIRE(warnings.size() == 101);
  CHECK(warnings[99].rfind("t.json:100:", 0) == 0);
  CHECK(warnings[100] == "t.json: 50 more warnings are not shown");
}

TEST_CASE("A hull of far too many corners is refused soon") {
  const std::string text =
      R"({"version": 1, "bodies": [{"name": "b", "motion": "fixed", "shape": {"type": "hull", "points": [)" +
      listed(8000,
             [](int i) {
               const double z = 1 - 2 * (i + 0.5) / 8000, r = std::sqrt(1 - z * z),
                            a = 2.399963 * i;
               return "[" + std::to_string(r * std::cos(a)) + "," +
                      std::to_string(r * std::sin(a)) + "," + std::to_string(z) + "]";
             }) +
      "]}}]}";
  const auto lines = diagnostics(text);
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].find("hull has more than 4096 corners, expected at most 256") !=
        std::string::npos);
}
