// Joints, drives, pins, collision and shapes that cannot be: the whole line is checked.
#include "engine/joints/kinds.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// Complaints about these members, which stand on a line of their own: of a joint on line 5 ...
Lines with_joint(const std::string& members) {
  return diagnostics(with_two("\"joints\": [{\"a\": \"a\", \"b\": \"b\", \"anchor\": [0, 0, 0],\n" +
                              members + "}]"));
}
/// ... of a fixed body, of a dynamic one and of the scene on line 2.
Lines with_fixed(const std::string& members) {
  return diagnostics(with_body("\"motion\": \"fixed\",\n" + members));
}
Lines with_moving(const std::string& members) { return diagnostics(with_body("\n" + members)); }
Lines with_scene(const std::string& members) {
  return diagnostics("{\"version\": 1,\n" + members + "}");
}

}  // namespace

TEST_CASE("Kinds and limits that a joint cannot have are refused by name") {
  CHECK(with_joint(R"("kind": "hinj")") ==
        Lines{"t.json:5:9: /joints/0/kind: found \"hinj\", expected ball, hinge, universal, "
              "fixed, cylindrical, prismatic, screw, planar, distance, spring, skate or wheel; "
              "nearest is \"hinge\""});
  CHECK(with_joint(R"("kind": "ball", "type": "ball")") ==
        Lines{"t.json:5:17: /joints/0/type: found \"type\" beside \"kind\", expected only one of "
              "them"});
  CHECK(with_joint(R"("kind": "hinge", "limits": {"twist": [0, 1], "cone_deg": 5})") ==
        Lines{"t.json:5:29: /joints/0/limits/twist: found a limit \"twist\", expected those of a "
              "hinge joint: angle",
              "t.json:5:46: /joints/0/limits/cone_deg: found a limit \"cone_deg\", expected "
              "those of a hinge joint: angle"});
  CHECK(with_joint(R"("limits": {"angle": [0, 1]})") ==
        Lines{"t.json:5:12: /joints/0/limits/angle: found a limit \"angle\", expected those of a "
              "ball joint: twist, cone or swing"});
  CHECK(with_joint(R"("kind": "fixed", "limits": {"first": [0, 1]})") ==
        Lines{"t.json:5:29: /joints/0/limits/first: found a limit \"first\", expected none: a "
              "fixed joint has no rotation"});
}

TEST_CASE("Limits that leave nothing, or that no joint reaches, are refused") {
  CHECK(with_joint(R"("kind": "hinge", "limits": {"angle": [1, -1]})") ==
        Lines{"t.json:5:38: /joints/0/limits/angle: found limits from 1 to -1, expected the "
              "lower one first"});
  CHECK(with_joint(R"("kind": "hinge", "limits": {"angle_deg": [90, -90]})") ==
        Lines{"t.json:5:42: /joints/0/limits/angle_deg: found limits from 90 to -90, expected "
              "the lower one first"});
  CHECK(with_joint(R"("kind": "hinge", "limits": {"angle": [0, 1e999]})") ==
        Lines{"t.json:5:42: /joints/0/limits/angle/1: found 1e999, expected a finite number"});
  CHECK(with_joint(R"("kind": "hinge", "limits": {"angle": [0, 1], "angle_deg": [0, 1]})") ==
        Lines{"t.json:5:46: /joints/0/limits/angle_deg: found \"angle_deg\" beside \"angle\", "
              "expected only one of them"});
  CHECK(with_joint(R"("limits": {"cone_deg": 181})") ==
        Lines{"t.json:5:24: /joints/0/limits/cone_deg: found a swing of 3.15905 rad (181 "
              "degrees), expected 0 to pi rad (180 degrees)"});
  CHECK(with_joint(R"("limits": {"swing": [-0.1, 1]})") ==
        Lines{"t.json:5:21: /joints/0/limits/swing: found a swing of -0.1 rad (-5.72958 "
              "degrees), expected 0 to pi rad (180 degrees)"});
  CHECK(with_joint(R"("limits": {"swing": [1, 1], "cone": 1})") ==
        Lines{"t.json:5:12: /joints/0/limits/swing: found \"swing\" beside \"cone\", expected "
              "only one of them"});
  CHECK(with_joint(R"("limits": {"soft": {"zone": 0.1, "stiffness": 1}})") ==
        Lines{"t.json:5:12: /joints/0/limits/soft: found \"soft\" without a limit, expected a "
              "limit beside it"});
  CHECK(with_joint(R"("limits": {"cone": 1, "soft": {"stiffness": -1}})") ==
        Lines{"t.json:5:31: /joints/0/limits/soft: found no \"zone\", expected how far before "
              "the stop the spring begins, in rad, or \"zone_deg\"",
              "t.json:5:45: /joints/0/limits/soft/stiffness: found -1, expected a number from 0 "
              "to 1e12"});
  CHECK(with_joint(R"("kind": "hinge", "limits": {"angle": 1, "soft": {"zone": 0}})") ==
        Lines{"t.json:5:38: /joints/0/limits/angle: found 1, expected an array of 2 numbers",
              "t.json:5:58: /joints/0/limits/soft/zone: found 0, expected an angle above 0"});
}

TEST_CASE("Joint axes that are zero, or told twice, are refused") {
  CHECK(with_joint(R"("axis": [0, 0, 0])") ==
        Lines{"t.json:5:9: /joints/0/axis: found an array of 3, expected a direction: three "
              "numbers, not all 0"});
  CHECK(with_joint(R"("axis": [0, 1, 0], "across": [0, -2, 0])") ==
        Lines{"t.json:5:30: /joints/0/across: found an array of 3, expected a direction not "
              "parallel to \"axis\""});
  CHECK(with_joint(R"("axis": [0, 1, 0], "axis_a": [1, 0, 0])") ==
        Lines{"t.json:5:20: /joints/0/axis_a: found \"axis_a\" beside \"axis\", expected only "
              "one of them"});
  CHECK(with_joint(R"("axis_a": [0, 1, 0], "axis_b": [1, 0, 0], "rest_deg": [0, 0, 0])") ==
        Lines{"t.json:4:12: /joints/0: found \"axis_a\" and \"axis_b\", expected \"across_a\" and "
              "\"across_b\" beside them: they define the zero of the joint",
              "t.json:5:43: /joints/0/rest_deg: found \"rest_deg\" beside the axes in both bodies, "
              "expected only one of them: the axes determine it"});
}

TEST_CASE("Turns that a kind of joint cannot make are refused") {
  CHECK(with_joint(R"("kind": "hinge", "rest_deg": [0, 10, 0])") ==
        Lines{"t.json:5:30: /joints/0/rest_deg: found a rotation 10 degrees from what a hinge "
              "joint allows, expected one that it allows"});
  CHECK(with_joint(R"("kind": "fixed", "rest_deg": [0, 10, 0])") ==
        Lines{"t.json:5:30: /joints/0/rest_deg: found a rotation 10 degrees from what a fixed "
              "joint allows, expected one that it allows"});
  CHECK(with_joint(R"("kind": "hinge", "rest": "far")") ==
        Lines{"t.json:5:26: /joints/0/rest: found \"far\", expected an angle, or a quaternion "
              "[x, y, z, w]"});
  CHECK(with_joint(R"("kind": "universal", "rest_deg": [1, 2, 3, 4])") ==
        Lines{"t.json:5:34: /joints/0/rest_deg: found an array of 4, expected two angles, or "
              "three angles in degrees"});
}

TEST_CASE("Motions of drives that make no sense are refused") {
  const auto says = [](const std::string& joint, const std::string& what) {
    const Lines lines = with_joint(joint);
    CAPTURE(joint, lines);
    return lines.size() == 1 && lines.front().find(what) != std::string::npos;
  };
  const std::string hinge = R"("kind": "hinge", "drive": {"motion": )";
  CHECK(says(R"("drive": {"motion": {"speed": 1}})",
             "/joints/0/drive/motion: found a motion of a ball joint, expected "
             "one of these kinds: hinge, universal, cylindrical, prismatic or screw"));
  CHECK(says(hinge + R"({"speed": 1}, "stiffness": 1})",
             "/joints/0/drive/stiffness: found \"stiffness\" beside \"motion\""));
  CHECK(says(hinge + R"({"amplitude": 1}})", "found \"amplitude\" without \"frequency\""));
  CHECK(says(hinge + R"({"law": "spline"}})", "found \"law\" without \"table\""));
  CHECK(says(hinge + R"({"law": "step", "table": [[0, 0], [1, 1]]}})",
             "expected linear, spline, cycloidal or 3-4-5"));
  CHECK(says(hinge + R"({"table": [[0, 0]]}})", "expected two rows or more"));
  CHECK(says(hinge + R"({"table": [[0, 0], [1, 1], [1, 2]]}})",
             "/joints/0/drive/motion/table/2: found time 1 after 1, expected a later one"));
  CHECK(says(hinge + R"({"along": "travel", "speed": 1}})",
             "found a motion along the travel of a hinge joint"));
}

TEST_CASE("Drives of joints that make no sense are refused") {
  CHECK(with_joint(R"("drive": {})") ==
        Lines{"t.json:5:10: /joints/0/drive: found neither \"stiffness\" nor \"damping\", expected "
              "one of them, or an exact \"motion\": without them a drive has no effect"});
  CHECK(with_joint(R"("drive": {"stiffness": -1, "damping": -2, "max_torque": -3})") ==
        Lines{"t.json:5:24: /joints/0/drive/stiffness: found -1, expected a number from 0 to 1e12",
              "t.json:5:39: /joints/0/drive/damping: found -2, expected a number from 0 to 1e12",
              "t.json:5:57: /joints/0/drive/max_torque: found -3, expected a number from 0 to "
              "1e12"});
  CHECK(with_joint(R"("drive": {"stiffness": 1, "angle": 1})") ==
        Lines{"t.json:5:27: /joints/0/drive/angle: found the angle of a ball joint, expected "
              "\"target\": only a hinge has a single angle"});
  CHECK(with_joint(R"("kind": "fixed", "drive": {"stiffness": 1})") ==
        Lines{"t.json:5:18: /joints/0/drive: found a drive of a fixed joint, expected none: it has "
              "no rotation"});
  CHECK(with_joint(R"("kind": "hinge", "drive": {"stiffness": 1, "angle": 1, "target": 1})") ==
        Lines{"t.json:5:44: /joints/0/drive/angle: found \"angle\" beside \"target\", expected "
              "only one of them"});
  CHECK(with_joint(R"("kind": "hinge", "drive": {"stiffness": 1, "angle": 1, "keys": [{"time": 0, )"
                   R"("angle": 0}]})") ==
        Lines{"t.json:5:56: /joints/0/drive/keys: found \"keys\" beside \"angle\", expected only "
              "one of them"});
}

TEST_CASE("Keys of a joint's drive that lead nowhere are refused") {
  CHECK(
      with_joint(R"("kind": "hinge", "drive": {"stiffness": 1, "keys": [{"time": 1, "angle": 0}, )"
                 R"({"time": 1, "angle": 1}]})") ==
      Lines{"t.json:5:78: /joints/0/drive/keys/1: found time 1 after 1, expected a later one"});
  CHECK(with_joint(
            R"("kind": "hinge", "drive": {"stiffness": 1, "keys": [{"time": 1}], "loop": true})") ==
        Lines{"t.json:5:52: /joints/0/drive/keys: found an array of 1, expected two keys or more "
              "for a loop",
              "t.json:5:53: /joints/0/drive/keys/0: found no \"target\", expected the rotation at "
              "that time"});
  CHECK(
      with_joint(R"("kind": "hinge", "drive": {"stiffness": 1, "keys": [{"time": 0, "angle": 0}, )"
                 R"({"time": 1, "angle": 1}], "loop": true})") ==
      Lines{"t.json:5:52: /joints/0/drive/keys: found a loop whose last key is 57.2958 degrees "
            "from its first, expected the same"});
  CHECK(with_joint(R"("kind": "hinge", "drive": {"stiffness": 1, "loop": true})") ==
        Lines{"t.json:5:44: /joints/0/drive/loop: found \"loop\" without \"keys\", expected it "
              "with them"});
  CHECK(with_joint(R"("kind": "hinge", "drive": {"stiffness": 1, "keys": {}})") ==
        Lines{"t.json:5:52: /joints/0/drive/keys: found an empty object, expected an array"});
  CHECK(with_joint(R"("kind": "hinge", "drive": {"stiffness": 1, "keys": []})") ==
        Lines{"t.json:5:52: /joints/0/drive/keys: found an empty array, expected one key or more"});
}

TEST_CASE("Pins that hold on to nothing are refused") {
  CHECK(with_scene(R"("pins": [{"body": "a", "anchor_to": [0, 0, 0]}])") ==
        Lines{"t.json:2:19: /pins/0/body: found \"a\", expected the name of a body",
              "t.json:2:24: /pins/0/anchor_to: found \"anchor_to\" without \"to\", expected the "
              "body it lies in"});
  CHECK(with_scene(
            R"("bodies": [{"name": "a", "shape": {"type": "sphere", "radius": 0.1}}], "pins": )"
            R"([{"body": "a", "to": "a"}, {"body": "a", "to": "world"}, {"body": "a", "to": )"
            R"("b", "target": [0, 0, 0], "anchor_to": [0, 0, 0]}])") ==
        Lines{"t.json:2:101: /pins/0/to: found \"a\", expected a body other than the pinned one",
              "t.json:2:127: /pins/1/to: found \"world\", expected the name of a body",
              "t.json:2:157: /pins/2/to: found \"b\", expected the name of a body",
              "t.json:2:183: /pins/2/anchor_to: found \"anchor_to\" beside \"target\", expected "
              "only one of them"});
}

TEST_CASE("Collision that says nothing sensible is refused") {
  CHECK(with_fixed(R"("collision": true)") ==
        Lines{"t.json:2:1: /bodies/0/collision: found \"collision\" of a body without a shape, "
              "expected a shape to collide"});
  CHECK(with_fixed(R"("shape": {"type": "plane"}, "collision": 1)") ==
        Lines{"t.json:2:42: /bodies/0/collision: found 1, expected true, false or an object "
              "(collision)"});
  CHECK(
      with_fixed(R"("shape": {"type": "plane"}, "collision": {"friction": -1, "restitution": 1.5, )"
                 R"("groups": ["flor", 32, 0.5], "self": 1, "sensor": "no"})") ==
      Lines{"t.json:2:55: /bodies/0/collision/friction: found -1, expected a number from 0 to "
            "1e12",
            "t.json:2:74: /bodies/0/collision/restitution: found 1.5, expected a number from 0 "
            "to 1",
            "t.json:2:90: /bodies/0/collision/groups/0: found \"flor\", expected a name of "
            "\"collision_groups\", or a number from 0 to 31",
            "t.json:2:98: /bodies/0/collision/groups/1: found 32, expected a name of "
            "\"collision_groups\", or a number from 0 to 31",
            "t.json:2:102: /bodies/0/collision/groups/2: found 0.5, expected a name of "
            "\"collision_groups\", or a number from 0 to 31",
            "t.json:2:116: /bodies/0/collision/self: found 1, expected true or false",
            "t.json:2:129: /bodies/0/collision/sensor: found \"no\", expected true or false"});
}

TEST_CASE("Names of collision groups differ") {
  CHECK(with_scene(R"("collision_groups": ["a", "", "a", 3])") ==
        Lines{"t.json:2:27: /collision_groups/1: found \"\", expected the name of a group",
              "t.json:2:31: /collision_groups/2: found \"a\", expected a name that no earlier "
              "group has",
              "t.json:2:36: /collision_groups/3: found 3, expected the name of a group"});
}

TEST_CASE("Grounds and hollow shapes are refused on bodies that move") {
  CHECK(with_moving(R"("shape": {"type": "plane"})") ==
        Lines{"t.json:2:19: /bodies/0/shape/type: found a plane on a dynamic body, expected it "
              "on a fixed or kinematic one"});
  CHECK(
      with_moving(R"("shape": {"type": "mesh", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, )"
                  R"(1]], "triangles": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]})") ==
      Lines{"t.json:2:19: /bodies/0/shape/type: found a mesh on a dynamic body, expected it on a "
            "fixed or kinematic one; use one or several hulls for a dynamic body"});
  CHECK(with_moving(R"("shape": {"type": "height_field", "columns": 2, "rows": 2, "spacing": 1, )"
                    R"("heights": [0, 0, 0, 0]})") ==
        Lines{"t.json:2:19: /bodies/0/shape/type: found a height_field on a dynamic body, "
              "expected it on a fixed or kinematic one"});
}

TEST_CASE("Shapes without volume are refused") {
  CHECK(with_moving(R"("shape": {"type": "box", "size": [1, 0, 1]})") ==
        Lines{"t.json:2:38: /bodies/0/shape/size/1: found 0, expected a size from 1e-9 to 1e9 m"});
  CHECK(
      with_moving(R"("shape": {"type": "hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, )"
                  R"(0]]})") == Lines{"t.json:2:10: /bodies/0/shape: hull has no volume: its "
                                      "points are coplanar, collinear or coincident"});
  CHECK(with_moving(R"("shape": {"type": "hull"})") ==
        Lines{"t.json:2:10: /bodies/0/shape: found no \"points\", expected four points or more, "
              "or a \"file\""});
  CHECK(with_moving(
            R"("shape": {"type": "hull", "points": [[0, 0, 0], [1, 0, 1e999], [0, 1], [1, 1, )"
            R"(0]]})") ==
        Lines{"t.json:2:56: /bodies/0/shape/points/1/2: found 1e999, expected a finite number",
              "t.json:2:64: /bodies/0/shape/points/2: found an array of 2, expected an array of "
              "3 numbers"});
}

TEST_CASE("Meshes that are not closed surfaces are refused") {
  CHECK(
      with_fixed(R"("shape": {"type": "mesh", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, )"
                 R"(1]], "triangles": [[0, 2, 1], [0, 1, 3], [1, 2, 3]]})") ==
      Lines{"t.json:2:10: /bodies/0/shape: mesh is not closed: edge 0-2 of triangle 0 belongs "
            "to no other triangle, expected two",
            "t.json:2:10: /bodies/0/shape: mesh is not closed: edge 0-3 of triangle 1 belongs "
            "to no other triangle, expected two",
            "t.json:2:10: /bodies/0/shape: mesh is not closed: edge 2-3 of triangle 2 belongs "
            "to no other triangle, expected two"});
  CHECK(
      with_fixed(R"("shape": {"type": "mesh", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, )"
                 R"(1]], "triangles": [[0, 2, 4], [0, 1, 0.5], [1, 2]]})") ==
      Lines{"t.json:2:104: /bodies/0/shape/triangles/0/2: found 4, expected the index of a point "
            "in \"points\", from 0",
            "t.json:2:108: /bodies/0/shape/triangles/1: found an array of 3, expected three "
            "whole numbers",
            "t.json:2:121: /bodies/0/shape/triangles/2: found an array of 2, expected an array "
            "of 3 numbers"});
  CHECK(with_fixed(R"("shape": {"type": "mesh", "points": [[0, 0, 0]]})") ==
        Lines{"t.json:2:10: /bodies/0/shape: found no \"triangles\", expected three indices into "
              "\"points\" for each"});
  CHECK(with_fixed(R"("shape": {"type": "mesh", "file": "no.obj", "triangles": []})") ==
        Lines{"t.json:2:35: /bodies/0/shape/file: no.obj: found no file to read (No such file or "
              "directory), expected an OBJ file",
              "t.json:2:45: /bodies/0/shape/triangles: found \"triangles\" beside \"file\", "
              "expected only one of them"});
  CHECK(with_fixed(R"("shape": {"type": "mesh", "file": ""})") ==
        Lines{"t.json:2:35: /bodies/0/shape/file: found \"\", expected the path of an OBJ file"});
}

TEST_CASE("Height fields that are too small or not whole are refused") {
  CHECK(with_fixed(R"("shape": {"type": "height_field", "columns": 1, "rows": 2, "spacing": 0, )"
                   R"("heights": [0, 0]})") ==
        Lines{"t.json:2:46: /bodies/0/shape/columns: found 1, expected a whole number from 2 to "
              "1048576",
              "t.json:2:71: /bodies/0/shape/spacing: found 0, expected a size from 1e-9 to 1e9 m"});
  CHECK(with_fixed(R"("shape": {"type": "height_field", "columns": 2, "rows": 2, "spacing": 1, )"
                   R"("heights": [0, 0, 0]})") ==
        Lines{"t.json:2:10: /bodies/0/shape: height field has 3 heights, expected columns times "
              "rows, 4"});
}

TEST_CASE("Stairs without steps, and chains bent by limits of other joints, are refused") {
  CHECK(with_scene(
            R"("generators": {"stairs": [{"name": "s", "count": 0, "width": 1, "rise": 0}]})") ==
        Lines{"t.json:2:27: /generators/stairs/0: found no \"run\", expected a size from 1e-9 to "
              "1e9 m",
              "t.json:2:50: /generators/stairs/0/count: found 0, expected a whole number from 1 "
              "to 10000",
              "t.json:2:73: /generators/stairs/0/rise: found 0, expected a size from 1e-9 to 1e9 "
              "m"});
  CHECK(
      with_scene(R"("generators": {"chains": [{"name": "c", "shape": {"type": "sphere", "radius": )"
                 R"(1}, "links": 4, "length": 1, "closed": true, "end": [1, 0, 0]}]})") ==
      Lines{"t.json:2:124: /generators/chains/0/end: found \"end\" beside \"closed\", expected "
            "only one of them"});
  CHECK(
      with_scene(R"("generators": {"chains": [{"name": "c", "shape": {"type": "sphere", "radius": )"
                 R"(1}, "links": 4, "length": 1, "kind": "hinge", "limits": {"cone": 1}}]})") ==
      Lines{"t.json:2:136: /generators/chains/0/limits/cone: found a limit \"cone\", expected "
            "those of a hinge joint: angle"});
  CHECK(with_scene(R"("solver": {"sweeps": 0})") ==
        Lines{"t.json:2:22: /solver/sweeps: found 0, expected a whole number from 1 to 10000"});
  CHECK(with_scene(R"("solver": {"sleep_speed": -0.001})") ==
        Lines{"t.json:2:27: /solver/sleep_speed: found -0.001, expected a number from 0 to 1e12"});
  CHECK(with_scene(R"("solver": {"sleep_speed": 1e999})") ==
        Lines{"t.json:2:27: /solver/sleep_speed: found 1e999, expected a finite number"});
}
