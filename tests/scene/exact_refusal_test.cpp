// Joints, ratios and settings for the Lagrangian solver that cannot be: the whole line is checked.
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// Complaints about a joint of these members, on line 5, for the Lagrangian solver.
Lines with_joint(const std::string& members) {
  return diagnostics(with_two(
      "\"solver\": {\"type\": \"lagrangian\"}, \"joints\": [{\"a\": \"a\", \"b\": \"b\",\n" +
      members + "}]"));
}
/// The same at a point.
Lines at_point(const std::string& members) {
  return with_joint(R"("anchor": [0, 0, 0], )" + members);
}
/// Complaints about one ratio, on line 8, of the joints "h" (a hinge), "s" (a slider), "f" (fixed).
Lines with_ratio(const std::string& members) {
  return diagnostics(R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [
{"name": "a", "mass": 1, "inertia": [1, 1, 1]}, {"name": "b", "mass": 1, "inertia": [1, 1, 1]}],
"joints": [
{"name": "h", "kind": "hinge", "a": "world", "b": "a", "anchor": [0, 0, 0]},
{"name": "s", "kind": "prismatic", "a": "world", "b": "b", "anchor": [0, 0, 0]},
{"name": "f", "kind": "fixed", "a": "a", "b": "b", "anchor": [0, 0, 0]}],
"gears": [{
)" + members + "}]}");
}
/// A cable led over guides, on line 4.
std::string with_guides(const std::string& guides, const char* solver = "lagrangian") {
  return ("{\"version\": 1, \"solver\": {\"type\": \"" + std::string(solver) + R"("},
"bodies": [{"name": "a", "mass": 1, "inertia": [1, 1, 1]}],
"cables": [{"a": "a", "b": "world", "point_b": [0, 3, 0], "over":
[)" + guides +
          "]}]}");
}
Lines with_solver(const std::string& members) {
  return diagnostics("{\"version\": 1, \"solver\": {\n" + members + "}}");
}
Lines with_masses(const std::string& members) { return diagnostics(with_body("\n" + members)); }

}  // namespace

TEST_CASE("Kinds that a file cannot tell, or that lack their measure, are refused") {
  CHECK(at_point(R"("kind": "custom")") ==
        Lines{"t.json:5:30: /joints/0/kind: found \"custom\", expected a kind that a file can "
              "define: a custom joint is defined in C++, by JointParameters::custom"});
  CHECK(at_point(R"("kind": "screw")") ==
        Lines{"t.json:4:46: /joints/0: found no \"pitch\", "
              "expected the travel per rad of rotation, in m/rad"});
  CHECK(at_point(R"("kind": "screw", "pitch": 0)") ==
        Lines{"t.json:5:48: /joints/0/pitch: found 0, expected a number other than 0: a screw "
              "without pitch is a hinge"});
  CHECK(with_joint(R"("kind": "spring")") ==
        Lines{"t.json:4:46: /joints/0: found no \"stiffness\", expected its stiffness, in N/m"});
}

TEST_CASE("Axes, lengths, stiffnesses, caps and slips that cannot be are refused") {
  CHECK(at_point(R"("kind": "prismatic", "axis": [0, 0, 0])") ==
        Lines{"t.json:5:51: /joints/0/axis: found an array of 3, expected a direction: three "
              "numbers, not all 0"});
  CHECK(with_joint(R"("kind": "distance", "length": -1)") ==
        Lines{"t.json:5:31: /joints/0/length: found -1, expected a size from 1e-9 to 1e9 m"});
  CHECK(with_joint(R"("kind": "spring", "length": -1, "stiffness": -2, "damping": -3)") ==
        Lines{"t.json:5:29: /joints/0/length: found -1, expected a number from 0 to 1e12",
              "t.json:5:46: /joints/0/stiffness: found -2, expected a number from 0 to 1e12",
              "t.json:5:61: /joints/0/damping: found -3, expected a number from 0 to 1e12"});
  CHECK(
      at_point(
          R"("kind": "hinge", "friction": {"dry": -1, "slip": 0}, "spring": {"stiffness": -1})") ==
      Lines{"t.json:5:59: /joints/0/friction/dry: found -1, expected a number from 0 to 1e12",
            "t.json:5:71: /joints/0/friction/slip: found 0, expected a number above 0, at most "
            "1e12",
            "t.json:5:99: /joints/0/spring/stiffness: found -1, expected a number from 0 to 1e12"});
  CHECK(at_point(R"("kind": "hinge", "motor": {"velocity": 1, "gain": 0, "cap": -1})") ==
        Lines{"t.json:5:72: /joints/0/motor/gain: found 0, expected a number above 0, at most 1e12",
              "t.json:5:82: /joints/0/motor/cap: found -1, expected a number from 0 to 1e12"});
}

TEST_CASE("Travel that is reversed and restitution beyond 1 are refused") {
  CHECK(
      at_point(R"("kind": "prismatic", "limits": {"travel": [1, -1], "restitution": 1.5})") ==
      Lines{"t.json:5:64: /joints/0/limits/travel: found travel from 1 to -1 m, expected the lower "
            "one first",
            "t.json:5:88: /joints/0/limits/restitution: found 1.5, expected a number from 0 to 1"});
  CHECK(at_point(R"("kind": "hinge", "limits": {"travel": [0, 1]})") ==
        Lines{"t.json:5:50: /joints/0/limits/travel: found a limit \"travel\", expected those of a "
              "hinge joint: angle"});
  CHECK(at_point(R"("kind": "planar", "limits": {"travel": [0, 1]})") ==
        Lines{"t.json:5:51: /joints/0/limits/travel: found a limit \"travel\", expected those of a "
              "planar joint: angle"});
}

TEST_CASE("What belongs to other kinds of joints is refused") {
  CHECK(
      at_point(R"("kind": "hinge", "pitch": 1, "travel": {})") ==
      Lines{
          "t.json:5:39: /joints/0/pitch: found \"pitch\" of a hinge joint, expected it of these "
          "kinds only: screw",
          "t.json:5:51: /joints/0/travel: found \"travel\" of a hinge joint, expected it of these "
          "kinds only: cylindrical"});
  CHECK(at_point(R"("motor": {})") ==
        Lines{"t.json:5:22: /joints/0/motor: found \"motor\" of a ball joint, expected it of these "
              "kinds only: hinge, universal, cylindrical, prismatic or screw"});
  CHECK(
      at_point(R"("kind": "distance")") ==
      Lines{"t.json:5:1: /joints/0/anchor: found \"anchor\" of a distance joint, expected only its "
            "ends: \"point_a\" and \"point_b\" in the scene, or \"anchor_a\" and \"anchor_b\" in "
            "the bodies"});
  CHECK(
      at_point(R"("kind": "cylindrical", "angle": {}, "motor": {"velocity": 1, "gain": 1})") ==
      Lines{"t.json:5:58: /joints/0/motor: found \"motor\" beside \"angle\", expected only one of "
            "them"});
  CHECK(at_point(R"("kind": "prismatic", "drive": {"stiffness": 1})") ==
        Lines{"t.json:5:43: /joints/0/drive: found a drive of a prismatic joint, expected a "
              "\"motion\" in it, a \"motor\" or a \"spring\": springs of drives rotate joints with "
              "a shared point"});
  CHECK(with_joint(R"("kind": "distance", "point_a": [0, 0, 0], "point_b": [0, 0, 0])") ==
        Lines{"t.json:4:46: /joints/0: found a distance joint whose ends start at one point, "
              "expected a \"length\""});
}

TEST_CASE("Springs, friction and motors that do nothing, or two things at once, are refused") {
  CHECK(
      at_point(R"("kind": "hinge", "spring": {}, "friction": {}, "motor": {}, "rest_deg": 1)") ==
      Lines{"t.json:5:49: /joints/0/spring: found neither \"stiffness\" nor \"damping\", expected "
            "one of them: without them a spring has no effect",
            "t.json:5:65: /joints/0/friction: found neither \"viscous\" nor \"dry\", expected one "
            "of them: without them there is no friction",
            "t.json:5:78: /joints/0/motor: found no \"velocity\", expected a target rate, or a "
            "target \"position\""});
  CHECK(at_point(R"("kind": "hinge", "motor": {"position": 1, "damping": 1})") ==
        Lines{"t.json:5:64: /joints/0/motor/damping: found \"damping\" without \"gain\", expected "
              "both, or neither: they are then chosen"});
  CHECK(at_point(R"("kind": "hinge", "motor": {"velocity": 1, "position": 1, "gain": 1})") ==
        Lines{"t.json:5:64: /joints/0/motor/position: found \"position\" beside \"velocity\", "
              "expected only one of them"});
  CHECK(at_point(R"("kind": "hinge", "motor": {"velocity": 1, "gain": 1, "damping": 1})") ==
        Lines{"t.json:5:75: /joints/0/motor/damping: found \"damping\" of a velocity motor, "
              "expected it with \"position\" only"});
  CHECK(at_point(R"("kind": "prismatic", "motor": {"velocity_deg": 1, "gain": 1})") ==
        Lines{"t.json:5:53: /joints/0/motor/velocity_deg: found \"velocity_deg\" for a travel, "
              "expected \"velocity\" in m or m/s"});
  CHECK(at_point(R"("kind": "hinge", "motor": {"velocity": 2e9, "gain": 1})") ==
        Lines{"t.json:5:61: /joints/0/motor/velocity: found 2e9, expected a number between -1e9 "
              "and 1e9"});
  CHECK(at_point(R"("kind": "hinge", "motor": {"velocity_deg": 2e9, "gain": 1})") ==
        Lines{"t.json:5:65: /joints/0/motor/velocity_deg: found 2e9, expected a rate in "
              "degrees/s, between -1e9 and 1e9"});
}

TEST_CASE("Gears that couple nothing are refused") {
  CHECK(with_ratio(R"("first": "h", "second": "s", "ratio": 0)") ==
        Lines{"t.json:8:39: /gears/0/ratio: found 0, expected a number other than 0"});
  CHECK(with_ratio(R"("first": "h", "second": "h", "ratio": 1)") ==
        Lines{"t.json:8:25: /gears/0/second: found \"h\", expected a joint other than the first"});
  CHECK(
      with_ratio(R"("first": "f", "second": "s", "second_coordinate": "angle", "ratio": 1)") ==
      Lines{"t.json:8:10: /gears/0/first: found the angle of a fixed joint, expected a joint that "
            "rotates about one axis: hinge, cylindrical or screw",
            "t.json:8:25: /gears/0/second: found the angle of a prismatic joint, expected a joint "
            "that rotates about one axis: hinge, cylindrical or screw"});
  CHECK(with_ratio(R"("first": "h", "first_coordinate": "travel", "second": "gear")") ==
        Lines{"t.json:7:11: /gears/0: found no \"ratio\", expected the motion of second per unit "
              "of first",
              "t.json:8:55: /gears/0/second: found \"gear\", expected the name of a joint"});
  CHECK(with_ratio(R"("first": "h", "second": "s", "ratio": 1, "offset_deg": 3)") ==
        Lines{"t.json:7:11: /gears/0: found \"offset_deg\" of a travel, expected \"offset\" in m"});
}

TEST_CASE("Settings that no solver has are refused") {
  CHECK(with_solver(R"("type": "lagrange")") ==
        Lines{"t.json:2:9: /solver/type: found \"lagrange\", expected auto, sweep, shake2, "
              "procedural, "
              "lagrangian, planar or quasistatic"});
  CHECK(
      with_solver(R"("integrator": "rk5", "stabilisation": "some", "step_tolerance": 0)") ==
      Lines{"t.json:2:15: /solver/integrator: found \"rk5\", expected euler, rattle, rk4, "
            "implicit or radau; nearest is \"rk4\"",
            "t.json:2:39: /solver/stabilisation: found \"some\", expected projection, baumgarte or "
            "none; nearest is \"none\"",
            "t.json:2:65: /solver/step_tolerance: found 0, expected a number above 0, at most "
            "1e12"});
  CHECK(with_solver(R"("integrator": "rattle", "step_tolerance": 1e-6)") ==
        Lines{"t.json:2:25: /solver/step_tolerance: found \"step_tolerance\" with the integrator "
              "\"rattle\", expected it with rk4 or radau only: no other subdivides steps"});
  CHECK(with_solver(R"("integrator": "euler", "baumgarte": 2, "damping_ratio": 1.5)") ==
        Lines{"t.json:2:37: /solver/baumgarte: found 2, expected a number from 0 to 1: with "
              "\"euler\" it is the fraction of a gap closed in a step",
              "t.json:2:57: /solver/damping_ratio: found 1.5, expected a number from 0 to 1"});
}

TEST_CASE(
    "Kinds, parameters and gears that the chosen solver does not support are refused, by name") {
  const auto with = [](const std::string& members) {
    return diagnostics(with_two("\"solver\": {\"type\": \"sweep\"}, " + members));
  };
  const auto error_count = [&](const std::string& members) {
    return with("\"joints\": [{\"name\": \"j\", \"a\": \"a\", \"b\": \"b\",\n" + members + "}]");
  };
  CHECK(error_count(R"("kind": "distance")") ==
        Lines{"t.json:5:9: /joints/0/kind: found a distance joint \"j\" solved by \"sweep\", "
              "expected the solver \"lagrangian\", or \"planar\" for motion in the xy plane"});
  CHECK(error_count(R"("anchor": [0, 0, 0], "kind": "hinge",
"limits": {"angle": [0, 1], "restitution": 0.5})") ==
        Lines{"t.json:6:44: /joints/0/limits/restitution: found \"restitution\" of joint \"j\" "
              "solved by \"sweep\", expected the solver \"lagrangian\": no other supports it"});
  CHECK(with(R"("joints": [
{"name": "i", "kind": "hinge", "a": "world", "b": "a", "anchor": [0, 0, 0]},
{"name": "j", "kind": "hinge", "a": "world", "b": "b", "anchor": [1, 0, 0]}],
"gears": [{"name": "gears", "first": "i", "second": "j", "ratio": 2}])") ==
        Lines{"t.json:7:11: /gears/0: found gear \"gears\" of joints solved by \"sweep\", expected "
              "the solver \"lagrangian\", or \"planar\" for motion in the xy plane"});
}

TEST_CASE("Bodies that no matter makes, and joints from a body to itself, are refused") {
  CHECK(with_masses(R"("mass": 1, "inertia": [1, 0, 1])") ==
        Lines{"t.json:2:23: /bodies/0/inertia: found principal moments 1, 0, 1, expected positive "
              "ones, each at most the sum of the others"});
  CHECK(with_masses(R"("mass": 1, "inertia": [-1, 1, 1])") ==
        Lines{"t.json:2:23: /bodies/0/inertia: found principal moments -1, 1, 1, expected positive "
              "ones, each at most the sum of the others"});
  CHECK(with_masses(R"("mass": 1, "inertia": [1, 1, 3])") ==
        Lines{"t.json:2:23: /bodies/0/inertia: found principal moments 1, 1, 3, expected positive "
              "ones, each at most the sum of the others"});
  CHECK(diagnostics(with_two(R"("joints": [{"a": "a", "b": "a", "anchor": [0, 0, 0]}])")) ==
        Lines{"t.json:4:12: /joints/0: found \"a\" tied to \"a\", expected two different ones"});
  CHECK(diagnostics(R"({"version": 1, "step": 0})") ==
        Lines{"t.json:1:24: /step: found 0, expected a step above 0, at most 1 s"});
}

TEST_CASE("Guides that a cable cannot be led over are refused") {
  const std::string ring = R"({"body": "world", "point": [0, 1, 0]})";
  good(with_guides(ring));
  good(with_guides(ring, "auto"));
  CHECK(diagnostics(with_guides(ring, "sweep")).back() ==
        Lines{"t.json:4:1: /cables/0/over: found guides of cable \"a-world\" solved by \"sweep\", "
              "expected the solver \"lagrangian\": no other supports it"}
            .front());
  CHECK(diagnostics(with_guides(R"({"body": "nix"})")) ==
        Lines{"t.json:4:1: /cables/0/over: found \"nix\", expected the name of a body or "
              "\"world\""});
  CHECK(diagnostics(with_guides(R"({"body": "world", "point": [0, 1, 0], "radius": 0.1})")) ==
        Lines{"t.json:4:2: /cables/0/over/0: found an object, expected the \"axis\" of a pulley, a "
              "vector that is not zero"});
  const auto one = [](const char* at, const char* axis) {
    return R"({"body": "world", "radius": 0.1, "point": )" + std::string(at) + R"(, "axis": )" +
           axis + "}";
  };
  CHECK(diagnostics(with_guides(one("[0, 3, 0]", "[0, 0, 1]"))).size() ==
        1);  // holds the end at its centre
  good(with_guides(one("[0, 1, 0]", "[0, 0, 1]") + "," + one("[0.5, 2, 0]", "[0, 0, 1]")));
  const Lines askew = diagnostics(
      with_guides(one("[0, 1, 0]", "[0, 0, 1]") + "," + one("[0.5, 2, 0]", "[0, 1, 1]")));
  REQUIRE(askew.size() == 1);
  CHECK(askew[0].find("two pulleys in different planes, expected them in one plane") !=
        std::string::npos);
}

TEST_CASE("More joints between two bodies than can be solved for are refused at the first") {
  const auto joined = [](int count, const char* solver) {
    std::string joints = "\"solver\": {\"type\": \"" + std::string(solver) + "\"}, \"joints\": [";
    for (int i = 0; i < count; ++i)
      joints += std::string(i > 0 ? ",\n" : "\n") + R"({"a": ")" + (i % 2 > 0 ? "a" : "b") +
                R"(", "b": ")" + (i % 2 > 0 ? "b" : "a") + R"(", "anchor": [0, 0, 0]})";
    return with_two(joints + "]");
  };
  const Lines refused = diagnostics(joined(129, "lagrangian"));
  REQUIRE(refused.size() == 1);
  CHECK(refused[0].find("/joints/0: found 129 joints between the bodies \"b\" and \"a\" solved by "
                        "\"lagrangian\", expected at most 128") != std::string::npos);
  good(joined(128, "lagrangian"));
  good(joined(129, "auto"));
}
