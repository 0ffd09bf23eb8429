// Classes and defaults: what an object does not say itself is as its class says, then as the
// defaults of the file say.
#include "engine/joints/kinds.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

const Body& body_of(const Scene& s, const char* name) { return s.world.bodies[s.world.find(name)]; }

const std::string kClasses = R"({"version": 1, "gravity": [0, 0, 0],
"materials": [{"name": "wood"}, {"name": "steel"}],
"defaults": {"body": {"drag": 0.5, "density": 700, "collision": true}, "joint": {"friction": {"viscous": 3}}},
"classes": [
{"name": "limb", "body": {"drag": 0.25, "material": "wood", "shape": {"type": "sphere", "radius": 0.1}},
 "joint": {"kind": "hinge", "axis": [0, 0, 1], "limits": {"angle_deg": [0, 90]}},
 "cable": {"compliance": 0.5}, "pin": {"priority": 7}},
{"name": "heavy", "class": "limb", "body": {"mass": 40, "material": "steel"}}]
)";

}  // namespace

TEST_CASE("A body's own word wins over its class, the class over the defaults") {
  const Scene s = good(kClasses + R"(, "bodies": [
{"name": "plain", "shape": {"type": "sphere", "radius": 0.1}},
{"name": "limb", "class": "limb"},
{"name": "own", "class": "limb", "drag": 0.125, "material": "steel"},
{"name": "heavy", "class": "heavy"},
{"name": "dense", "class": "heavy", "density": 100}]})");
  const Real volume = 4.0 / 3 * kPi * 1e-3;
  CHECK(body_of(s, "plain").drag == 0.5);
  CHECK(body_of(s, "plain").mass == Approx(700 * volume));
  CHECK(body_of(s, "limb").drag == 0.25);
  CHECK(body_of(s, "limb").mass == Approx(700 * volume));
  CHECK(body_of(s, "own").drag == 0.125);
  CHECK(body_of(s, "heavy").drag == 0.25);
  CHECK(body_of(s, "heavy").mass == 40);  // which excludes the density of the defaults
  CHECK(body_of(s, "dense").mass == Approx(100 * volume));
  const auto material = [&](const char* name) {
    return s.world.shapes[s.world.find(name)].list[0].material;
  };
  CHECK((material("plain") == 0 && material("limb") == 1));
  CHECK((material("own") == 2 && material("heavy") == 2));
  CHECK(s.world.collisions.find(s.world.find("plain")));
  CHECK(s.warnings.empty());
}

TEST_CASE("Joints, cables and pins take after classes, and leave out what their kind cannot have") {
  const Scene s = good(kClasses + R"(, "bodies": [{"name": "a", "class": "limb"},
{"name": "b", "class": "limb", "position": [1, 0, 0]}],
"joints": [{"name": "knee", "class": "limb", "a": "a", "b": "b", "anchor": [0.5, 0, 0]},
{"name": "hook", "a": "world", "b": "a", "anchor": [0, 0, 0]}],
"cables": [{"name": "line", "class": "limb", "a": "a", "b": "b"}],
"pins": [{"name": "nail", "class": "limb", "body": "b", "kind": "spring"}]})");
  const Joint& knee = s.world.links[s.world.find("knee")].joint;
  CHECK(knee.kind == JointKind::hinge);
  CHECK(knee.limits->angle.high == Approx(kPi / 2));
  CHECK(knee.parameters->rotation.friction.viscous == 3);
  const Joint& hook = s.world.links[s.world.find("hook")].joint;
  CHECK(hook.kind == JointKind::ball);
  CHECK_FALSE(hook.parameters.any());
  CHECK(s.world.cables.values()[0].joint.compliance == 0.5);
  CHECK(s.world.pins.values()[0].priority == 7);
  CHECK(s.warnings.empty());
}

TEST_CASE("Chains and prefabs take after classes too") {
  const Scene s = good(kClasses + R"(, "generators": {"chains": [{"name": "c", "class": "limb",
"links": 3, "length": 0.3, "attach": "world"}]},
"prefabs": [{"name": "p", "bodies": [{"name": "x", "class": "heavy"}]}],
"instances": [{"name": "i", "prefab": "p"}]})");
  CHECK(body_of(s, "c/1").drag == 0.25);
  CHECK(s.world.links[s.world.find("c/0-1")].joint.kind == JointKind::hinge);
  CHECK(s.world.shapes[s.world.find("c/2")].list[0].material == 1);
  CHECK(body_of(s, "i/x").mass == 40);
}

TEST_CASE("A class that is not there is refused with the nearest that is") {
  CHECK(diagnostics(kClasses + R"(, "bodies": [{"name": "a", "class": "limp"}]})").at(0) ==
        "t.json:9:37: /bodies/0/class: found \"limp\", expected the name of a class; nearest is "
        "\"limb\"");
  CHECK(diagnostics(R"({"version": 1, "classes": [{"name": "a", "class": "b"}, {"name": "b"}]})") ==
        Lines{"t.json:1:51: /classes/0/class: found \"b\", expected the name of a class"});
  CHECK(diagnostics(R"({"version": 1, "classes": [{"name": "a"}, {"name": "a"}]})") ==
        Lines{"t.json:1:52: /classes/1/name: found the name \"a\" again, expected one that no "
              "earlier class has"});
}

TEST_CASE("What is wrong in a class is told once, used or not") {
  const std::string text =
      R"({"version": 1, "classes": [{"name": "c", "body": {"drag": -1, "sahpe": 1}}]
)";
  const Lines expected{
      "t.json:1:59: /classes/0/body/drag: found -1, expected a number from 0 to 1e12",
      "t.json:1:63: /classes/0/body/sahpe: found key \"sahpe\", expected a key of a body_class; "
      "nearest is \"shape\""};
  CHECK(diagnostics(text + "}") == expected);
  CHECK(diagnostics(text + R"(, "bodies": [
{"name": "a", "class": "c", "shape": {"type": "sphere", "radius": 1}},
{"name": "b", "class": "c", "shape": {"type": "sphere", "radius": 1}}]})") == expected);
  CHECK(diagnostics(R"({"version": 1, "defaults": {"joint": {"kind": "hinge"}}})") ==
        Lines{"t.json:1:39: /defaults/joint/kind: found a \"kind\" for all joints, expected it in "
              "a class or a joint"});
}

TEST_CASE("Classes take after one another seven times at most") {
  std::string text = R"({"version": 1, "classes": [{"name": "c0", "body": {"drag": 2}})";
  for (int i = 1; i < 9; ++i) {
    const std::string before = text;
    text += ", {\"name\": \"c" + std::to_string(i) + "\", \"class\": \"c" + std::to_string(i - 1) +
            "\"}";
    const auto scene = parse_scene(text + R"(], "bodies": [{"name": "a", "class": "c)" +
                                       std::to_string(i) + R"(", "mass": 1}]})",
                                   "t.json");
    CAPTURE(i);
    CHECK(bool(scene) == (i < 8));
    if (scene) CHECK(scene->world.bodies.values()[0].drag == 2);
  }
}
