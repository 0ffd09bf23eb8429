// What runs but hardly as meant is said before the run, with the name of the joint, string or pin.
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// A chain of ten links of 0.1 m that hangs from (0, 2, 0), and more.
std::string with_chain(const std::string& members) {
  return R"({"version": 1, "generators": {"chains": [{"name": "c", "links": 10, "length": 0.1,
"start": [0, 2, 0], "shape": {"type": "sphere", "radius": 0.04}, "attach": "world"}]},
)" + members +
         "}";
}

}  // namespace

TEST_CASE("Mass ratios above 100 across a joint are told with the ratio") {
  const std::string text = R"({"version": 1, "gravity": [0, 0, 0], "bodies": [
{"name": "a", "mass": 0.01, "inertia": [1, 1, 1]},
{"name": "b", "mass": MASS, "inertia": [1, 1, 1]}],
"joints": [{"name": "knee", "a": "a", "b": "b", "anchor": [0, 0, 0]}]})";
  const auto warnings = [&](const char* mass) {
    std::string changed = text;
    return good(changed.replace(changed.find("MASS"), 4, mass)).warnings;
  };
  CHECK(warnings("0.99").empty());
  CHECK(warnings("5") == Lines{"t.json:4:12: /joints/0: joint \"knee\" has a mass ratio of 500:1 "
                               "(b 5 kg, a 0.01 kg); above 100:1 the motion is less accurate"});
}

TEST_CASE("A fault of a prefab is told once, with the number of its copies") {
  const Scene s = good(R"({"version": 1, "gravity": [0, 0, 0], "prefabs": [{"name": "p", "bodies": [
{"name": "a", "mass": 1, "inertia": [1, 1, 1]}, {"name": "b", "mass": 1000, "inertia": [1, 1, 1]}],
"joints": [{"a": "a", "b": "b", "anchor": [0, 0, 0]}]}],
"generators": {"grids": [{"name": "g", "prefab": "p", "count": [5, 1, 1]}]}})");
  CHECK(
      s.warnings ==
      Lines{"t.json:3:12: /prefabs/0/joints/0: joint \"g/0/a-b\" has a mass ratio of 1000:1 (g/0/b "
            "1000 kg, g/0/a 1 kg); above 100:1 the motion is less accurate (and 4 more like it)"});
}

TEST_CASE("Pins out of reach are told with distance and reach") {
  CHECK(good(with_chain(
                 R"("pins": [{"body": "c/9", "anchor": [0, -0.05, 0], "target": [0.9, 1.6, 0]}])"))
            .warnings.empty());
  CHECK(good(with_chain(R"("pins": [{"name": "pull", "body": "c/9", "anchor": [0, -0.05, 0],
"target": [3, 2, 0]}])"))
            .warnings ==
        Lines{"t.json:3:10: /pins/0: pin \"pull\" is held 3 m from joint \"c/top\", but the "
              "linkage between them reaches only 1 m; it stays out of reach"});
  // A spring need not arrive.
  CHECK(good(with_chain(R"("pins": [{"body": "c/9", "target": [3, 2, 0], "kind": "spring"}])"))
            .warnings.empty());
}

TEST_CASE("Two pins farther apart than the way between them are told") {
  const Scene s = good(with_chain(R"("pins": [
{"name": "p", "body": "c/4", "target": [0.4, 2, 0]},
{"name": "q", "body": "c/6", "target": [-0.4, 2, 0]}])"));
  CHECK(s.warnings == Lines{"t.json:5:1: /pins/1: pin \"q\" is held 0.8 m from pin \"p\", but the "
                            "linkage between them reaches only 0.2 m; it stays out of reach"});
}

TEST_CASE("A pin too near for a long link is told") {
  const Scene s = good(R"({"version": 1, "bodies": [
{"name": "long", "shape": {"type": "capsule", "radius": 0.1, "length": 2}},
{"name": "short", "shape": {"type": "sphere", "radius": 0.1}, "position": [0, -1.2, 0]}],
"joints": [{"name": "top", "a": "world", "b": "long", "anchor": [0, 1, 0]},
{"a": "long", "b": "short", "anchor": [0, -1, 0]}],
"pins": [{"name": "p", "body": "short", "target": [0, 0.5, 0]}]})");
  CHECK(s.warnings ==
        Lines{"t.json:6:10: /pins/0: pin \"p\" is held 0.5 m from joint \"top\", but the linkage "
              "between them cannot fold below 1.8 m; it stays out of reach"});
}

TEST_CASE("Cables that start too short are told") {
  const Scene s = good(with_two(R"("cables": [{"name": "line", "a": "a", "b": "b", "length": 0.75},
{"a": "a", "b": "b", "length": 1}])"));
  CHECK(s.warnings == Lines{"t.json:4:12: /cables/0: cable \"line\" of 0.75 m starts 0.25 m too "
                            "short; its initial pull is large"});
}

TEST_CASE("A path that starts elsewhere than the body it drives is seen in what is tied to it") {
  const Scene s = good(R"({"version": 1, "bodies": [{"name": "hand", "motion": "kinematic"},
{"name": "ball", "shape": {"type": "sphere", "radius": 0.1}, "position": [0, -1, 0]}],
"paths": [{"body": "hand", "keyframes": [{"time": 0, "position": [0, 2, 0]}]}],
"joints": [{"name": "j", "a": "hand", "b": "ball", "anchor_a": [0, 0, 0], "anchor_b": [0, 1, 0]}]})");
  CHECK(s.warnings ==
        Lines{"t.json:4:12: /joints/0: joint \"j\" starts 2 m open; the first step closes it"});
}

TEST_CASE("Bodies that fall for ever are told by name") {
  const auto falls = [](const std::string& members) {
    return good(R"({"version": 1, "bodies": [
{"name": "a", "shape": {"type": "sphere", "radius": 0.1}, "position": [0, 1, 0]},
{"name": "b", "shape": {"type": "sphere", "radius": 0.1}, "position": [1, 1, 0]},
{"name": "floor", "motion": "fixed", "shape": {"type": "plane"}}],
)" + members + "}")
        .warnings;
  };
  const std::string why =
      " forever: no joint, cable or pin leads to a fixed body, and no collider that stays in place "
      "can stop ";
  CHECK(falls(R"("ground": true)") ==
        Lines{"t.json:2:1: /bodies/0: body \"a\" and 1 more fall" + why + "them"});
  CHECK(falls(R"("cables": [{"a": "world", "b": "a"}])") ==
        Lines{"t.json:3:1: /bodies/1: body \"b\" falls" + why + "it"});
  CHECK(
      falls(
          R"("cables": [{"a": "world", "b": "a"}], "joints": [{"a": "a", "b": "b", "anchor": [0.5, 1, 0]}])")
          .empty());
  CHECK(falls(R"("collision": true)").empty());
  CHECK(falls(R"("gravity": [0, 0, 0])").empty());
  CHECK(falls(R"("pins": [{"body": "a"}, {"body": "b"}])").empty());
  // Balls that touch one another fall together; one of them on a cable would stop the other.
  const std::string balls = R"({"version": 1, "collision": true, "bodies": [
{"name": "a", "shape": {"type": "sphere", "radius": 0.1}},
{"name": "b", "shape": {"type": "sphere", "radius": 0.1}, "position": [1, 1, 0]}])";
  CHECK(good(balls + "}").warnings.size() == 1);
  CHECK(good(balls + R"(, "cables": [{"a": "world", "b": "a", "point_a": [0, 2, 0]}]})")
            .warnings.empty());
}

TEST_CASE("Filters that agree with nobody are told by name") {
  const auto told = [](const std::string& crate, const std::string& floor) {
    return good(R"({"version": 1, "collision_groups": ["ground", "prop"], "bodies": [
{"name": "crate", "shape": {"type": "sphere", "radius": 0.1}, "collision": )" +
                crate + R"(},
{"name": "floor", "motion": "fixed", "shape": {"type": "plane"}, "collision": )" +
                floor + R"(}], "gravity": [0, 0, 0]})")
        .warnings;
  };
  CHECK(told(R"({"groups": ["prop"], "with": ["ground"]})", R"({"groups": ["ground"]})").empty());
  CHECK(told(R"({"groups": ["prop"], "with": ["ground"]})",
             R"({"groups": ["ground"], "with": ["ground"]})") ==
        Lines{"t.json:2:1: /bodies/0: body \"crate\" collides with nothing: its \"with\" includes "
              "body \"floor\", whose own \"with\" excludes it",
              "t.json:3:1: /bodies/1: body \"floor\" collides with nothing: no other body is in a "
              "group that its \"with\" names"});
  CHECK(told(R"({"groups": ["prop"], "with": ["prop"]})", R"({"groups": ["ground"]})") ==
        Lines{"t.json:2:1: /bodies/0: body \"crate\" collides with nothing: no other body is in a "
              "group that its \"with\" names"});
}

TEST_CASE("Ranges beyond a turn are told, of joints that do not count turns") {
  const auto told = [](const std::string& limits, const std::string& kind) {
    return good(
               R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [{"name": "a", "mass": 1, "inertia": [1, 1, 1]}],
"joints": [{"a": "world", "b": "a", "anchor": [0, 0, 0], "kind": ")" +
               kind + R"(", "limits": )" + limits + "}]}")
        .warnings;
  };
  CHECK(told(R"({"angle": [0, 90]})", "hinge") ==
        Lines{"t.json:2:95: /joints/0/limits/angle: limits from 0 to 90 rad reach beyond a turn; "
              "degrees stand under \"angle_deg\""});
  CHECK(
      told(R"({"angle_deg": [-200, 200]})", "hinge") ==
      Lines{"t.json:2:99: /joints/0/limits/angle_deg: limits from -200 to 200 degrees reach beyond "
            "a turn, and whole turns are not counted"});
  CHECK(told(R"({"angle_deg": [-180, 180]})", "hinge").empty());
  CHECK(told(R"({"angle_deg": [0, 3600]})", "screw\", \"pitch\": 0.1, \"name\": \"s").empty());
}

TEST_CASE("Quaternions nearly of length 1 are brought there, within reason silently") {
  const auto warnings = [](const char* w) {
    const Scene s =
        good(with_body(std::string("\"motion\": \"fixed\", \"rotation\": [0, 0, 0, ") + w + "]"));
    CHECK(s.world.bodies.values()[0].pose.rotation == Quat(1, 0, 0, 0));
    return s.warnings;
  };
  CHECK(warnings("1.0000009").empty());
  CHECK(warnings("1.0005") ==
        Lines{"t.json:1:74: /bodies/0/rotation: quaternion of length 1.0005 was normalised"});
}
