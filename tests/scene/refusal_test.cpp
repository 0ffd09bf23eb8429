// One test for each class of bad input: the whole line is checked, place and pointer included.
#include <array>

#include "engine/scene/json/words.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

TEST_CASE("The version is needed and checked") {
  CHECK(diagnostics("{}") ==
        Lines{"t.json:1:1: found no \"version\", expected the version of the format: 1"});
  CHECK(diagnostics("{\"version\": \"1\"}") ==
        Lines{"t.json:1:13: /version: found \"1\", expected 1, the version this program reads"});
  CHECK(diagnostics("[]") == Lines{"t.json:1:1: found an empty array, expected an object (scene)"});
}

TEST_CASE("Unknown keys are refused with the nearest that is known") {
  CHECK(diagnostics("{\"version\": 1, \"gravty\": [0, 0, 0]}") ==
        Lines{"t.json:1:16: /gravty: found key \"gravty\", expected a key of a scene; nearest is "
              "\"gravity\""});
  CHECK(diagnostics("{\"version\": 1, \"ground\": {\"wobbliness\": 1}}") ==
        Lines{"t.json:1:27: /ground/wobbliness: found key \"wobbliness\", expected a key of a "
              "ground: visible or height"});
}

TEST_CASE("Words of other engines are told what they are called here") {
  CHECK(
      diagnostics("{\"version\": 1, \"tendons\": []}") ==
      Lines{"t.json:1:16: /tendons: found key \"tendons\", expected a key of a scene; it is called "
            "\"cables\" here"});
  CHECK(diagnostics("{\"version\": 1, \"bodies\": [{\"name\": \"a\", \"mass\": 1,\n"
                    "\"motion\": \"static\", \"shape\": {\"type\": \"cuboid\"}}]}")
            .at(0) ==
        "t.json:2:11: /bodies/0/motion: found \"static\", expected dynamic, fixed or kinematic; it "
        "is called \"fixed\" here");
  // Names of the scene's own objects are never translated.
  CHECK(called_here("spherical", std::array<std::string_view, 2>{"hinge", "ball"}) == "ball");
  CHECK(hint("spherical", std::array<std::string_view, 2>{"hinge", "ball"}).empty());
  CHECK(called_here("spherical", std::array<std::string_view, 1>{"hinge"}).empty());
}

TEST_CASE("Wrong types are refused") {
  CHECK(diagnostics("{\"version\": 1, \"bodies\": {}, \"title\": 3, \"gravity\": 9.81,\n"
                    "\"camera\": [1], \"ground\": 0, \"substeps\": 1.5}") ==
        Lines{"t.json:1:26: /bodies: found an empty object, expected an array",
              "t.json:1:39: /title: found 3, expected text in double quotes",
              "t.json:1:53: /gravity: found 9.81, expected an array of 3 numbers",
              "t.json:2:11: /camera: found an array of 1, expected an object (camera)",
              "t.json:2:26: /ground: found 0, expected an object (ground)",
              "t.json:2:41: /substeps: found 1.5, expected a whole number from 1 to 1000"});
  CHECK(
      diagnostics(R"({"version": 1, "bodies": [{"name": "rod",
"mass": 1, "inertia": [1, 1, 1], "position": [0, "x", 0], "drag": true, "motion": "fixt"}]})") ==
      Lines{"t.json:2:50: /bodies/0/position/1: found \"x\", expected a number between -1e9 and "
            "1e9",
            "t.json:2:67: /bodies/0/drag: found true, expected a number from 0 to 1e12",
            "t.json:2:83: /bodies/0/motion: found \"fixt\", expected dynamic, fixed or kinematic; "
            "nearest is \"fixed\""});
}

TEST_CASE("Steps and durations out of range are refused") {
  CHECK(diagnostics("{\"version\": 1, \"step\": 0}") ==
        Lines{"t.json:1:24: /step: found 0, expected a step above 0, at most 1 s"});
  CHECK(diagnostics("{\"version\": 1, \"step\": 1.01}") ==
        Lines{"t.json:1:24: /step: found 1.01, expected a step above 0, at most 1 s"});
  CHECK(good("{\"version\": 1, \"step\": 1}").step == 1);
}

TEST_CASE("Sizes and masses that are not positive are refused") {
  CHECK(diagnostics(with_body(R"("shape": {"type": "sphere", "radius": 0})")) ==
        Lines{"t.json:1:81: /bodies/0/shape/radius: found 0, expected a size from 1e-9 to 1e9 m"});
  CHECK(diagnostics(with_body(R"("shape": {"type": "box", "size": [1, -1, 1]})")) ==
        Lines{"t.json:1:80: /bodies/0/shape/size/1: found -1, expected a size from 1e-9 to 1e9 m"});
  CHECK(diagnostics(with_body(R"("mass": -2, "inertia": [1, 1, 1])")) ==
        Lines{"t.json:1:51: /bodies/0/mass: found -2, expected a number from 1e-12 to 1e12"});
  CHECK(
      diagnostics(with_body(R"("shape": {"type": "sphere", "radius": 1e-120})")) ==
      Lines{
          "t.json:1:81: /bodies/0/shape/radius: found 1e-120, expected a size from 1e-9 to 1e9 m"});
  CHECK(diagnostics(with_body(R"("shapes": [])")) ==
        Lines{"t.json:1:27: /bodies/0: found a mass of 0 kg, expected shapes with a finite mass "
              "above 0"});
}

TEST_CASE("Inertia that no body can have is refused") {
  CHECK(
      diagnostics(with_body(R"("mass": 1, "inertia": [1, 1, 2.1])")) ==
      Lines{"t.json:1:65: /bodies/0/inertia: found principal moments 1, 1, 2.1, expected positive "
            "ones, each at most the sum of the others"});
  CHECK(diagnostics(with_body(R"("mass": 1, "inertia": [1, 1, 1, 2, 0, 0])")) ==
        Lines{"t.json:1:65: /bodies/0/inertia: found principal moments -1, 3, 1, expected positive "
              "ones, each at most the sum of the others"});
  CHECK(
      diagnostics(with_body(R"("mass": 1, "inertia": [1, 1])")) ==
      Lines{"t.json:1:65: /bodies/0/inertia: found an array of 2, expected 3 principal moments, or "
            "6 entries xx, yy, zz, xy, xz, yz, in kg m^2"});
}

TEST_CASE("A dynamic body without matter is refused") {
  CHECK(diagnostics(with_body(R"("drag": 1)")) ==
        Lines{"t.json:1:27: /bodies/0: found no \"mass\", expected a mass, or a shape that "
              "determines it"});
  CHECK(diagnostics(R"({"version": 1, "generators": {"chains": [
{"name": "c", "links": 2, "length": 1, "mass": 1}]}})") ==
        Lines{"t.json:2:1: /generators/chains/0: found no \"inertia\", expected an inertia, or a "
              "shape that determines it"});
}

TEST_CASE("Quaternions far from length 1 are refused") {
  CHECK(
      diagnostics(with_body(R"("motion": "fixed", "rotation": [0, 0, 0, 0])")) ==
      Lines{
          "t.json:1:74: /bodies/0/rotation: found a quaternion of length 0, expected [x, y, z, w] "
          "of length 1"});
  CHECK(
      diagnostics(with_body(R"("motion": "fixed", "rotation": [0, 0, 0, 1.002])")) ==
      Lines{"t.json:1:74: /bodies/0/rotation: found a quaternion of length 1.002, expected [x, y, "
            "z, w] of length 1"});
}

TEST_CASE("Names given twice or of a wrong form are refused") {
  CHECK(
      diagnostics(
          with_two(R"("joints": [{"name": "a", "a": "a", "b": "b", "anchor": [0, 0, 0]}])")) ==
      Lines{"t.json:4:21: /joints/0/name: found the name \"a\" again, expected one that /bodies/0 "
            "does not have"});
  CHECK(
      diagnostics(R"({"version": 1, "bodies": [{"motion": "fixed", "name": "world"},
{"motion": "fixed", "name": "a/b"}, {"motion": "fixed", "name": ""}, {"motion": "fixed"}]})") ==
      Lines{"t.json:1:55: /bodies/0/name: found \"world\", expected another name: this one stands "
            "for the fixed world",
            "t.json:2:29: /bodies/1/name: found \"a/b\", expected a name of 1 to 200 bytes without "
            "\"/\"",
            "t.json:2:65: /bodies/2/name: found \"\", expected a name of 1 to 200 bytes without "
            "\"/\"",
            "t.json:2:70: /bodies/3: found no \"name\", expected a name"});
  CHECK(diagnostics(R"({"version": 1, "materials": [{"name": "m"}, {"name": "m"}]})") ==
        Lines{"t.json:1:54: /materials/1/name: found the name \"m\" again, expected one that "
              "/materials/0 does not have"});
}

TEST_CASE("Names that lead nowhere are refused with the nearest that leads somewhere") {
  CHECK(
      diagnostics(R"({"version": 1, "bodies": [
{"name": "shin", "motion": "fixed"}],
"joints": [{"a": "shim", "b": "wurld", "anchor": [0, 0, 0]}],
"pins": [{"body": "world"}], "cables": [{"a": "shin", "b": "nobody"}],
"paths": [{"body": "chin", "keyframes": [{"time": 0}]}],
"instances": [{"name": "i", "prefab": "p"}]})") ==
      Lines{"t.json:3:18: /joints/0/a: found \"shim\", expected the name of a body or \"world\"; "
            "nearest is \"shin\"",
            "t.json:3:31: /joints/0/b: found \"wurld\", expected the name of a body or \"world\"",
            "t.json:4:19: /pins/0/body: found \"world\", expected the name of a body",
            "t.json:4:60: /cables/0/b: found \"nobody\", expected the name of a body or \"world\"",
            "t.json:5:20: /paths/0/body: found \"chin\", expected the name of a body; nearest is "
            "\"shin\"",
            "t.json:6:39: /instances/0/prefab: found \"p\", expected the name of a prefab"});
  CHECK(diagnostics(R"({"version": 1, "materials": [{"name": "wood"}],
"bodies": [{"name": "f", "motion": "fixed", "material": "wod"}]})") ==
        Lines{"t.json:2:57: /bodies/0/material: found \"wod\", expected the name of a material; "
              "nearest is \"wood\""});
}

TEST_CASE("Joints and cables that cannot connect anything are refused") {
  CHECK(diagnostics(with_two(R"("joints": [{"a": "a", "b": "a", "anchor": [0, 0, 0]}])")) ==
        Lines{"t.json:4:12: /joints/0: found \"a\" tied to \"a\", expected two different ones"});
  CHECK(
      diagnostics(R"({"version": 1, "bodies": [{"name": "f", "motion": "fixed"}],
"cables": [{"a": "f", "b": "world", "point_b": [0, 1, 0]}]})") ==
      Lines{"t.json:2:12: /cables/0: found \"f\" tied to \"world\", expected a dynamic body on one "
            "side"});
  CHECK(
      diagnostics(with_two(R"("joints": [{"a": "a", "b": "b"}])")) ==
      Lines{
          "t.json:4:12: /joints/0: found no \"anchor\", expected the point of the scene where the "
          "bodies meet, or \"anchor_a\" and \"anchor_b\" in their own frames"});
  CHECK(diagnostics(with_two(R"("cables": [{"a": "a", "b": "b", "point_b": [0, 0, 0]}])")) ==
        Lines{"t.json:4:12: /cables/0: found a cable whose ends start at one point, expected a "
              "\"length\""});
  CHECK(diagnostics(
            with_two(R"("joints": [{"type": "hing", "a": "a", "b": "b", "anchor": [0, 0, 0]}])")) ==
        Lines{"t.json:4:21: /joints/0/type: found \"hing\", expected ball"});
}

TEST_CASE("Pins and drives on bodies of the wrong motion are refused") {
  CHECK(
      diagnostics(R"({"version": 1, "bodies": [{"name": "f", "motion": "fixed"}],
"pins": [{"body": "f"}],
"paths": [{"body": "f", "lissajous": {}}]})") ==
      Lines{
          "t.json:2:19: /pins/0/body: found \"f\", expected a dynamic body: this one is not moved "
          "by pins",
          "t.json:3:20: /paths/0/body: found \"f\", expected a body whose \"motion\" is "
          "\"kinematic\""});
}

TEST_CASE("Paths that make no sense are refused") {
  const auto drive = [](const std::string& members) {
    return diagnostics(R"({"version": 1, "bodies": [{"name": "d", "motion": "kinematic"}],
"paths": [{"body": "d")" +
                       members + "}]}");
  };
  CHECK(drive("") == Lines{"t.json:2:11: /paths/0: found no \"keyframes\", expected \"keyframes\", "
                           "\"lissajous\" or \"steady\""});
  CHECK(
      drive(R"(, "keyframes": [])") ==
      Lines{
          "t.json:2:38: /paths/0/keyframes: found an empty array, expected one keyframe or more"});
  CHECK(drive(R"(, "keyframes": [{"time": 1}, {"time": 1}])") ==
        Lines{"t.json:2:52: /paths/0/keyframes/1: found time 1 after 1, expected a later one"});
  CHECK(
      drive(R"(, "keyframes": [{"time": 0}, {"time": 1, "position": [0, 2, 0]}], "loop": true)") ==
      Lines{"t.json:2:11: /paths/0: found a loop whose last key is 2 m and 0 degrees from its "
            "first, expected the same pose"});
  CHECK(drive(R"(, "lissajous": {}, "loop": true)") ==
        Lines{"t.json:2:42: /paths/0/loop: found \"loop\" without \"keyframes\", expected it with "
              "them only: other paths are periodic"});
  CHECK(drive(R"(, "lissajous": {}}, {"body": "d", "lissajous": {})") ==
        Lines{"t.json:2:52: /paths/1/body: found \"d\", expected a body without another path"});
}

TEST_CASE("Keys that exclude one another are refused together") {
  CHECK(
      diagnostics(
          with_body(R"("mass": 1, "density": 1, "shape": {"type": "sphere", "radius": 1})")) ==
      Lines{"t.json:1:43: /bodies/0/mass: found \"mass\" beside \"density\", expected only one of "
            "them"});
  CHECK(
      diagnostics(with_two(R"("joints": [
{"a": "a", "b": "b", "anchor": [0, 0, 0], "anchor_a": [0, 0, 0]}])")) ==
      Lines{"t.json:5:43: /joints/0/anchor_a: found \"anchor_a\" beside \"anchor\", expected only "
            "one of them"});
}

TEST_CASE("Prefabs that contain themselves are refused with the way round") {
  CHECK(
      diagnostics(R"({"version": 1, "prefabs": [
{"name": "a", "instances": [{"name": "i", "prefab": "b"}]},
{"name": "b", "instances": [{"name": "i", "prefab": "c"}]},
{"name": "c", "instances": [{"name": "i", "prefab": "a"}]}]})") ==
      Lines{"t.json:4:53: /prefabs/2/instances/0/prefab: found \"a\", expected a prefab that does "
            "not contain itself (a -> b -> c -> a)"});
}

TEST_CASE("Absurd counts are refused before anything is built") {
  const std::string prefab =
      R"({"version": 1, "prefabs": [{"name": "p", "bodies": [{"name": "b", "motion": "fixed"}]}],
)";
  CHECK(diagnostics(prefab + R"("generators": {"grids": [
{"name": "g", "prefab": "p", "count": [1000000, 1000000, 1000000]}]}})") ==
        Lines{"t.json:3:1: /generators/grids/0: found 1e+18 bodies, expected at most 1000000"});
  SceneLimits few;
  few.bodies = 10;
  CHECK(diagnostics(prefab + R"("generators": {"grids": [
{"name": "g", "prefab": "p", "count": [11, 1, 1]}]}})",
                    few) ==
        Lines{"t.json:3:1: /generators/grids/0: found 11 bodies, expected at most 10"});
  CHECK(
      diagnostics(R"({"version": 1, "generators": {"chains": [
{"name": "c", "links": 2000000, "length": 1, "shape": {"type": "sphere", "radius": 1}}]}})") ==
      Lines{
          "t.json:2:24: /generators/chains/0/links: found 2000000, expected a whole number from 1 "
          "to 1000000"});
  few.links = 1;
  CHECK(diagnostics(with_two(R"("joints": [{"a": "a", "b": "b", "anchor": [0, 0, 0]}],
"pins": [{"body": "a"}])"),
                    few) ==
        Lines{"t.json:1:1: found 2 joints, gears, cables and pins, expected at most 1"});
}

TEST_CASE("Prefabs that double themselves over and over are refused early") {
  std::string text =
      R"({"version": 1, "prefabs": [{"name": "p0", "bodies": [{"name": "b", "motion": "fixed"}]})";
  for (int i = 1; i < 60; ++i) {
    const std::string below = "\"prefab\": \"p" + std::to_string(i - 1) + "\"}";
    text += ",\n{\"name\": \"p" + std::to_string(i) + "\", \"instances\": [{\"name\": \"l\", " +
            below + ", {\"name\": \"r\", " + below + "]}";
  }
  const Lines lines = diagnostics(text + "]}");
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].find("bodies, expected at most 1000000") != std::string::npos);
}

TEST_CASE("Prefabs nested too deeply are refused") {
  std::string text = R"({"version": 1, "prefabs": [{"name": "p0"})";
  for (int i = 1; i < 100; ++i)
    text += ", {\"name\": \"p" + std::to_string(i) +
            "\", \"instances\": [{\"name\": \"i\", \"prefab\": \"p" + std::to_string(i - 1) +
            "\"}]}";
  // In this order each prefab is known before it is used; from the top they nest.
  CHECK(good(text + "]}").world.bodies.empty());
  std::string turned = R"({"version": 1, "prefabs": [)";
  for (int i = 0; i < 99; ++i)
    turned += "{\"name\": \"p" + std::to_string(i) +
              "\", \"instances\": [{\"name\": \"i\", \"prefab\": \"p" + std::to_string(i + 1) +
              "\"}]}, ";
  const Lines lines = diagnostics(turned + R"({"name": "p99"}]})");
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].find("expected prefabs nested at most 64 deep") != std::string::npos);
}

TEST_CASE("Chains that cannot be laid out are refused") {
  const auto chain = [](const std::string& members) {
    return diagnostics(R"({"version": 1, "generators": {"chains": [
{"name": "c", "shape": {"type": "sphere", "radius": 0.1}, )" +
                       members + "}]}}");
  };
  CHECK(chain(R"("length": 1)") == Lines{"t.json:2:1: /generators/chains/0: found no \"links\", "
                                         "expected a number of links"});
  CHECK(
      chain(R"("links": 2, "length": 1, "end": [0, -3, 0])") ==
      Lines{"t.json:2:91: /generators/chains/0/end: found an end 3 m from the start, expected one "
            "that 2 m of links can meet"});
  CHECK(chain(R"("links": 2, "length": 1, "direction": [0, 0, 0])") ==
        Lines{"t.json:2:97: /generators/chains/0/direction: found an array of 3, expected a "
              "direction: three numbers, not all 0"});
  CHECK(
      chain(R"("links": 200, "length": 1, "mass_ratio": 1e10)") ==
      Lines{
          "t.json:2:1: /generators/chains/0: found a mass of inf kg at link 31, expected a finite "
          "mass above 0"});
  CHECK(chain(R"("links": 3, "length": 1, "attach": "c/0")") ==
        Lines{"t.json:2:94: /generators/chains/0/attach: found \"c/0\", expected a body other than "
              "the link itself"});
  CHECK(chain(R"("links": 2, "length": 1, "closed": true)") ==
        Lines{"t.json:2:68: /generators/chains/0/links: found 2, expected 3 links or more of a "
              "closed chain"});
  CHECK(chain(R"("links": 3, "length": 1, "closed": true, "end_attach": "world")") ==
        Lines{"t.json:2:100: /generators/chains/0/end_attach: found \"end_attach\" of a closed "
              "chain, expected none: its end is its start"});
  CHECK(chain(R"("links": 3, "path": [[0, 0, 0], [1, 0, 0]])") ==
        Lines{"t.json:2:59: /generators/chains/0/links: found \"links\" beside \"path\", expected "
              "only one of them"});
  CHECK(chain(R"("path": [[0, 0, 0]])") == Lines{"t.json:2:67: /generators/chains/0/path: found "
                                                 "an array of 1, expected two points or more"});
  CHECK(chain(R"("path": [[0, 0, 0], [0, 0, 0], [1, 0, 0]])") ==
        Lines{"t.json:2:79: /generators/chains/0/path/1: found the previous point again, expected "
              "another"});
  CHECK(chain(R"("closed": true, "path": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0]])") ==
        Lines{"t.json:2:117: /generators/chains/0/path/3: found the first point again, expected "
              "another: a closed chain returns by itself"});
}

TEST_CASE("All faults are told at once, in the order of the text") {
  const Lines lines = diagnostics(R"({"version": 1, "step": 2,
"materials": [{"name": "m", "colour": "#12345"}],
"bodies": [{"name": "a", "shape": {"type": "ball", "radius": 1}}],
"joints": [{"a": "a", "b": "c", "anchor": [0, 0, 0]}],
"solver": {"type": "fast"}, "output": {"size": [0, 10]}})");
  CHECK(lines ==
        Lines{"t.json:1:24: /step: found 2, expected a step above 0, at most 1 s",
              "t.json:2:39: /materials/0/colour: found \"#12345\", expected a colour: \"#rrggbb\" "
              "(sRGB) or [r, g, b] (linear)",
              "t.json:3:44: /bodies/0/shape/type: found \"ball\", expected sphere, capsule, "
              "box, hull, plane, mesh, height_field, cylinder, cone, ellipsoid or nurbs; it is "
              "called \"sphere\" here",
              "t.json:4:28: /joints/0/b: found \"c\", expected the name of a body or \"world\"",
              "t.json:5:20: /solver/type: found \"fast\", expected auto, sweep, shake2, "
              "procedural, lagrangian, planar or quasistatic",
              "t.json:5:49: /output/size/0: found 0, expected a whole number of pixels from 16 to "
              "16384",
              "t.json:5:52: /output/size/1: found 10, expected a whole number of pixels from 16 to "
              "16384"});
}

TEST_CASE("Very many faults are counted, not all told") {
  std::string text = "{\"version\": 1, \"bodies\": [1";
  for (int i = 0; i < 149; ++i) text += ", 1";
  const Lines lines = diagnostics(text + "]}");
  REQUIRE(lines.size() == 101);
  CHECK(lines.back() == "t.json: 50 more errors are not shown");
}

TEST_CASE("A fault inside a prefab is told once, and what depends on it is not") {
  CHECK(diagnostics(R"({"version": 1, "prefabs": [
{"name": "p", "bodies": [{"name": "b", "motion": "fixed", "drag": -1}]}],
"instances": [{"name": "i", "prefab": "p"}, {"name": "j", "prefab": "p"}],
"paths": [{"body": "k/b", "lissajous": {}}]})") ==
        Lines{"t.json:2:67: /prefabs/0/bodies/0/drag: found -1, expected a number from 0 to 1e12",
              "t.json:4:20: /paths/0/body: found \"k/b\", expected the name of a body; nearest is "
              "\"i/b\""});
  CHECK(diagnostics(R"({"version": 1,
"instances": [{"name": "i", "prefab": "q"}],
"pins": [{"body": "i/b"}]})") ==
        Lines{"t.json:2:39: /instances/0/prefab: found \"q\", expected the name of a prefab"});
}
