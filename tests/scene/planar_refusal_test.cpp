// What a plane cannot have is refused by name.
#include <catch2/catch.hpp>
#include <cstring>

#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

using Lines = std::vector<std::string>;

const std::string kNeeds = ", expected motion in the xy plane, as \"planar\" requires";

/// A scene of one box, `body` its other members, `more` those of the scene.
Lines told(const std::string& body, const std::string& more = "") {
  const Result<Scene> scene =
      parse_scene(R"({"version": 1, "solver": {"type": "planar"}, "bodies": [{"name": "a", )" +
                      body + R"("shape": {"type": "box", "size": [1, 1, 1]}}])" + more + "}",
                  "t.json");
  Lines lines;
  if (!scene)
    for (const Error& e : scene.errors()) lines.push_back(e.message);
  return lines;
}

}  // namespace

TEST_CASE("a body that leaves the plane of its solver is refused") {
  CHECK(told(R"("velocity": [1, 2, 0], "angular_velocity": [0, 0, 3], )") == Lines{});
  const Lines out = told(R"("velocity": [0, 0, 1], )");
  REQUIRE(out.size() == 1);
  CHECK(out[0].find("/bodies/0: found body \"a\", which moves along z") != std::string::npos);
  CHECK(out[0].find(kNeeds) != std::string::npos);
  CHECK(told(R"("angular_velocity": [1, 0, 0], )").size() == 1);
  CHECK(told("", R"(, "gravity": [0, -9, 1])").size() == 1);
}

TEST_CASE("a joint that a plane does not have is refused") {
  const auto joint = [](const std::string& members) {
    return told("",
                R"(, "joints": [{"a": "world", "b": "a", "anchor": [0, 0, 0], )" + members + "}]");
  };
  CHECK(joint(R"("kind": "hinge", "axis": [0, 0, 1])") == Lines{});
  CHECK(joint(R"("kind": "ball")") == Lines{});
  const Lines universal = joint(R"("kind": "universal")");
  REQUIRE(universal.size() == 1);
  CHECK(universal[0].find(
            "/joints/0: found joint \"world-a\", which is of a kind that has no planar form") !=
        std::string::npos);
  CHECK(joint(R"("kind": "hinge", "axis": [0, 1, 1])").size() == 1);
  CHECK(joint(R"("kind": "prismatic", "axis": [0, 0, 1])").size() == 1);
}

namespace {

/// A scene of three wheels of 0.2 m at x = 0, 1 and 2, and a belt.
Lines belt(const std::string& pulleys, const std::string& more = "",
           const char* solver = "planar") {
  std::string bodies, joints;
  for (int i = 0; i < 3; ++i) {
    const std::string n(1, static_cast<char>('a' + i)), x = std::to_string(i);
    bodies += (i ? ", " : "") + std::string(R"({"name": ")") + n + R"(", "position": [)" + x +
              R"(, 0, 0], "shape": {"type": "cylinder", "radius": 0.2, "length": 0.1, )" +
              R"("rotation_deg": [90, 0, 0]}})";
    joints += (i ? ", " : "") + std::string(R"({"kind": "hinge", "a": "world", "b": ")") + n +
              R"(", "anchor": [)" + x + R"(, 0, 0], "axis": [0, 0, 1]})";
  }
  const Result<Scene> scene = parse_scene(
      R"({"version": 1, "solver": {"type": ")" + std::string(solver) + R"("}, "bodies": [)" +
          bodies + R"(, {"name": "wall", "motion": "fixed", "position": [1, 3, 0]}], "joints": [)" +
          joints + R"(], "belts": [{"pulleys": [)" + pulleys + "]" + more + "}]}",
      "t.json");
  Lines lines;
  if (!scene)
    for (const Error& e : scene.errors()) lines.push_back(e.message);
  return lines;
}

std::string on(const std::string& body, const std::string& radius, const std::string& more = "") {
  return R"({"body": ")" + body + R"(", "radius": )" + radius + more + "}";
}

/// Whether there is one line, which tells of this place and in these words.
bool says(const Lines& lines, const std::string& words, const std::string& place = "pulleys") {
  INFO((lines.empty() ? "nothing" : lines[0]));
  CHECK(lines.size() == 1);
  return lines.size() == 1 && lines[0].find("/belts/0/" + place) != std::string::npos &&
         lines[0].find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("belts that close are taken, by both solvers that know them") {
  for (const char* solver : {"planar", "lagrangian"}) {
    CHECK(belt(on("a", "0.2") + ", " + on("c", "0.3"), "", solver) == Lines{});
    CHECK(belt(on("a", "0.2") + ", " + on("c", "0.3"), R"(, "crossed": true)", solver) == Lines{});
    CHECK(belt(on("a", "0.3") + ", " + on("c", "0.3") + ", " +
                   R"({"body": "b", "anchor": [0, 0.3, 0], "radius": 0.1, "side": "outside"})",
               "", solver) == Lines{});
  }
  CHECK(belt(R"({"body": "a", "half_axes": [0.3, 0.2]}, )" + on("c", "0.3")) == Lines{});
  CHECK(belt(R"({"body": "a", "outline": [[0.2, 0.2], [-0.3, 0], [0.2, -0.2], [0, 0]]}, )" +
             on("c", "0.3")) == Lines{});
}

TEST_CASE("belts that cannot be are refused, each with its reason") {
  CHECK(says(belt(on("a", "0.6") + ", " + on("b", "0.5")), "they overlap"));
  CHECK(says(belt(on("a", "3") + ", " + on("b", "0.5")), "consecutive pulleys that overlap"));
  CHECK(says(belt(on("a", "0.3") + ", " + on("c", "0.3") + ", " +
                  R"({"body": "b", "anchor": [0, 0.6, 0], "radius": 0.1, "side": "outside"})"),
             "cross"));
  CHECK(says(belt(on("a", "0.3") + ", " + on("c", "0.3", R"(, "side": "outside")")), "cross"));
  CHECK(says(belt(on("a", "0.2") + ", " + on("c", "0.2") + ", " + on("b", "0.2")),
             "does not touch pulley"));
  CHECK(says(belt(on("a", "0.2")), "found 1 pulleys, expected 2 to 16"));
  CHECK(says(belt(on("a", "0.2") + ", " + on("a", "0.2")), "two pulleys on \"a\""));
  CHECK(says(belt(on("a", "0.2") + ", " + on("wall", "0.2")), "which is fixed"));
  CHECK(says(belt(on("a", "0.2") + ", " + on("nobody", "0.2")), "found \"nobody\""));
  CHECK(says(belt(R"({"body": "a"}, )" + on("c", "0.2")), "found no \"radius\"", "pulleys/0"));
  CHECK(says(belt(R"({"body": "a", "outline": [[0, 0], [1, 1], [2, 2]]}, )" + on("c", "0.3")),
             "do not lie on one line", "pulleys/0/outline"));
  CHECK(says(belt(on("a", "0.2") + ", " + on("c", "0.2"), R"(, "friction": 0.3)"),
             "without a \"pretension\"", "friction"));
  CHECK(says(belt(on("a", "0.2") + ", " + on("c", "0.2"), R"(, "level": "links")"),
             "which does not collide"));
  const Lines unknown = belt(on("a", "0.2") + ", " + on("c", "0.2"), "", "sweep");
  REQUIRE(!unknown.empty());
  CHECK(unknown[0].find("expected the solver \"planar\" or \"lagrangian\"") != std::string::npos);
}

TEST_CASE("links of a belt are as many as fit in, however wide it is") {
  const auto solid = [](const std::string& x, const std::string& name) {
    return R"({"name": ")" + name + R"(", "position": [)" + x + R"(, 0, 0], "collision": true,
      "shape": {"type": "cylinder", "radius": 0.2, "length": 0.1, "rotation_deg": [90, 0, 0]}})";
  };
  const auto scene = [&](const std::string& width, const std::string& more = "") {
    return parse_scene(R"({"version": 1, "solver": {"type": "planar"}, "bodies": [)" +
                           solid("0", "a") + ", " + solid("1", "b") +
                           R"(], "belts": [{"level": "links", "width": )" + width + more +
                           R"(, "pulleys": [{"body": "a", "radius": 0.2},
                                            {"body": "b", "radius": 0.2}]}]})",
                       "t.json");
  };
  const auto refused = [&](const std::string& width, const std::string& more = "") {
    const Result<Scene> made = scene(width, more);
    return made || made.errors().size() != 1 ? "" : made.errors()[0].message;
  };
  const Real length = 2 + 0.4 * kPi;  // m, of the belt
  const auto links = [](const Result<Scene>& made) { return made ? made->world.links.size() : 0; };
  CHECK(links(scene("1e-9")) == 2000);
  CHECK(links(scene("1e-9", R"(, "links": 60)")) == 60);
  CHECK(links(scene("0.1")) == static_cast<std::size_t>(length / (1.2 * 0.025)) / 2);
  CHECK(links(scene("1.8")) == 6);
  CHECK(refused("2").find("/belts/0/width: found a width of 2 m on a belt 3.256") !=
        std::string::npos);
  CHECK(refused("2").find("m long, expected at most 1.809") != std::string::npos);
  CHECK(refused("1e9", R"(, "links": 60)").find("/belts/0/width: ") != std::string::npos);
  CHECK(refused("0.5", R"(, "links": 60)").find("/belts/0/links: found 60 links of a belt ") !=
        std::string::npos);
  CHECK(refused("0.5", R"(, "links": 60)").ends_with("expected 6 to 21"));
}

TEST_CASE("what stays in the plane is solved there where a scene asks for it") {
  const auto scene = [](const std::string& more) {
    return parse_scene(R"({"version": 1, "plane": true, "bodies": [
{"name": "flat", "mass": 1, "inertia": [1, 1, 1], "position": [1, 0, 0]},
{"name": "deep", "mass": 1, "inertia": [1, 1, 1], "position": [3, 0, 0], "velocity": [0, 0, 1]}],
"joints": [{"kind": "hinge", "a": "world", "b": "flat", "anchor": [0, 0, 0], "axis": [0, 0, 1]}])" +
                           more + "}",
                       "t.json");
  };
  const Result<Scene> mixed = scene("");
  REQUIRE(mixed);
  const World& w = mixed->world;
  REQUIRE(w.settings.find(w.find("flat")));
  CHECK(w.settings[w.find("flat")].solver == Solver::planar);
  CHECK(!w.settings.find(w.find("deep")));
  int told = 0;
  for (const std::string& warning : mixed->warnings)
    told +=
        warning.find("\"deep\" is not solved by \"planar\": moves along z") != std::string::npos;
  CHECK(told == 1);
}

namespace {

/// A scene that accepts an error, with a loop of three bars on the ground, and more.
std::string four_bar(const std::string& coupler, const std::string& more = "") {
  return R"({"version": 1, "error": 0.01, "bodies": [
    {"name": "crank", "mass": 1, "inertia": [1, 1, 1], "position": [0, 0.5, 0]},
    {"name": "coupler", "mass": 1, "inertia": [1, 1, 1], "position": [0.5, 1, 0])" +
         coupler +
         R"(}, {"name": "rocker", "mass": 1, "inertia": [1, 1, 1], "position": [1, 0.5, 0]}],
    "joints": [
    {"kind": "hinge", "a": "world", "b": "crank", "anchor": [0, 0, 0], "axis": [0, 0, 1]},
    {"kind": "hinge", "a": "crank", "b": "coupler", "anchor": [0, 1, 0], "axis": [0, 0, 1]},
    {"kind": "hinge", "a": "coupler", "b": "rocker", "anchor": [1, 1, 0], "axis": [0, 0, 1]},
    {"kind": "hinge", "a": "world", "b": "rocker", "anchor": [1, 0, 0], "axis": [0, 0, 1]}])" +
         more + "}";
}

Solver solver_of(const Scene& scene, const char* body) {
  const SolverSettings* own = scene.world.settings.find(scene.world.find(body));
  return own ? own->solver : scene.world.default_settings.solver;
}

/// Two free boxes above a floor, with these members of each and of the scene.
std::string boxes(const std::string& members, const std::string& more, const char* z = "0") {
  return R"({"version": 1, )" + more + R"("bodies": [
    {"name": "floor", "motion": "fixed", "shape": {"type": "plane"}, "collision": true},
    {"name": "a", "position": [0, 1, 0], "shape": {"type": "sphere", "radius": 0.1})" +
         members + R"(}, {"name": "b", "position": [0.1, 3, )" + z +
         R"(], "shape": {"type": "sphere", "radius": 0.1})" + members + "}]}";
}

}  // namespace

TEST_CASE("a scene that accepts an error is solved by the cheapest model that keeps its motion") {
  const Scene flat = good(four_bar(""));
  CHECK(flat.world.default_settings.solver == Solver::planar);
  CHECK(flat.warnings.empty());
  // A tree of joints is cheaper under "auto".
  std::string open = four_bar("");
  const std::size_t last = open.rfind(",\n    {\"kind\"");
  open.erase(last, open.find("}]", last) + 1 - last);
  CHECK(solver_of(good(open), "crank") == Solver::articulated);
  // Out of the plane: a mass centre, an event.
  CHECK(solver_of(good(four_bar(R"(, "angular_velocity": [1, 0, 0])")), "crank") != Solver::planar);
  const std::string push = R"(, "events": [{"type": "push", "body": "crank", "force": [1, 0, Z]}])";
  const auto pushed = [&](const char* z) {
    std::string text = four_bar("", push);
    return text.replace(text.find('Z'), 1, z);
  };
  CHECK(solver_of(good(pushed("0")), "crank") == Solver::planar);
  CHECK(solver_of(good(pushed("1")), "crank") == Solver::articulated);
  // Another solver is no choice, and the command line has the last word.
  const auto told = diagnostics(four_bar("", R"(, "solver": {"type": "sweep"})"));
  REQUIRE(told.size() == 1);
  CHECK(told[0].find("found \"error\" with the solver \"sweep\"") != std::string::npos);
  SolverChoices asked;
  asked.solver = Solver::lagrangian;
  const Result<Scene> exact = parse_scene(four_bar(""), "t.json", {}, asked);
  REQUIRE(exact);
  CHECK(solver_of(*exact, "crank") == Solver::lagrangian);
}

TEST_CASE("a mechanism with an exact drive is solved in the plane where an error is accepted") {
  const auto driven = [](const std::string& more, const char* axis = "[0, 0, 1]") {
    return R"({"version": 1, )" + more + R"("bodies": [
{"name": "arm", "mass": 1, "inertia": [1, 1, 1], "position": [1, 0, 0]}],
"joints": [
{"name": "axle", "kind": "cylindrical", "a": "world", "b": "arm", "anchor": [0, 0, 0], "axis": )" +
           axis + R"(, "drive": {"motion": {"along": "angle", "speed": 2}}}]})";
  };
  CHECK(solver_of(good(driven(R"("error": 0.01, )")), "arm") == Solver::planar);
  CHECK(solver_of(good(driven(R"("error": 0.01, )", "[1, 0, 0]")), "arm") != Solver::planar);
  CHECK(solver_of(good(driven("")), "arm") != Solver::planar);
  const Lines told = diagnostics(driven(R"("solver": {"type": "planar"}, )", "[1, 0, 0]"));
  REQUIRE(told.size() == 1);
  CHECK(told[0].find("is driven about its axis, which lies in the xy plane") != std::string::npos);
}

TEST_CASE("a loop in the plane beside bodies in space is solved there alone") {
  std::string text = four_bar("");
  text.replace(text.find("\"bodies\": [") + 11, 0,
               R"({"name": "top", "mass": 1, "inertia": [1, 2, 3], "position": [5, 0, 0],
                   "angular_velocity": [1, 2, 3]},)");
  const Scene mixed = good(text);
  CHECK(solver_of(mixed, "crank") == Solver::planar);
  CHECK(solver_of(mixed, "top") == Solver::articulated);
}

TEST_CASE("each group of bodies that cannot meet has the cheapest model of its own") {
  const auto with = [](std::string text, const char* key, const std::string& what) {
    const std::size_t at = text.find(key);
    REQUIRE(at != std::string::npos);
    return text.replace(at + std::strlen(key), 0, what);
  };
  const auto arm = [](const std::string& members) {
    return R"({"name": "arm", "mass": 1, "inertia": [1, 2, 3], "position": [5, 0, 0],
               "shape": {"type": "sphere", "radius": 0.1})" +
           members +
           R"(}, {"name": "hand", "mass": 1, "inertia": [1, 2, 3], "position": [6, 0, 0]},)";
  };
  const auto stack = [&](const std::string& members, const std::string& more = "") {
    const std::string text = boxes(R"(, "collision": true)", R"("error": 0.01, )" + more);
    return good(with(text, "\"bodies\": [", arm(members)));
  };
  const std::string joint = R"("joints": [{"a": "arm", "b": "hand", "anchor": [5.5, 0, 0]}], )";
  // Boxes that collide in the plane, beside a tree of joints that touches nothing.
  const Scene apart = stack("", joint);
  CHECK(solver_of(apart, "a") == Solver::planar);
  CHECK(solver_of(apart, "b") == Solver::planar);
  CHECK(solver_of(apart, "arm") == Solver::articulated);
  // Where the tree collides, too, they can meet, unless their filters keep them apart.
  CHECK(solver_of(stack(R"(, "collision": true)", joint), "a") == Solver::articulated);
  const Scene filtered = stack(R"(, "collision": {"groups": [2], "with": [2]})", joint);
  CHECK(solver_of(filtered, "a") == Solver::planar);
  CHECK(solver_of(filtered, "arm") == Solver::articulated);
  // An event drives only what it acts on out of the plane.
  const auto pushed = [&](const char* on) {
    return stack("", joint + R"("events": [{"type": "push", "force": [0, 0, 1], "body": ")" + on +
                         R"("}], )");
  };
  CHECK(solver_of(pushed("arm"), "a") == Solver::planar);
  CHECK(solver_of(pushed("b"), "a") == Solver::articulated);
}

TEST_CASE("what the plane does not support keeps its group out of it, and the scene loads") {
  const auto with = [](const std::string& more) { return good(four_bar("", more)); };
  const Scene sprung = with(
      R"(, "events": [{"type": "pull", "body": "crank", "target": [1, 1, 0], "stiffness": 100}])");
  CHECK(solver_of(sprung, "crank") == Solver::articulated);
  const Scene raised =
      with(R"(, "events": [{"type": "pull", "body": "crank", "target": [1, 1, 0.5]}])");
  CHECK(solver_of(raised, "crank") == Solver::articulated);
  // Gravity moves what has a share of it alone.
  const Scene top =
      with(R"(, "defaults": {"body": {"gravity_scale": 0}}, "gravity": [0, 0, -9.81])");
  CHECK(solver_of(top, "crank") == Solver::planar);
}

TEST_CASE("bodies with a solver of their own do not get that of the rest of the scene") {
  std::string text = four_bar("");
  text.replace(text.find("\"bodies\": [") + 11, 0,
               R"({"name": "own", "mass": 1, "inertia": [1, 2, 3], "position": [9, 0, 0],
                   "shape": {"type": "sphere", "radius": 0.1}, "collision": true,
                   "solver": {"type": "lagrangian"}},
                  {"name": "near", "mass": 1, "inertia": [1, 2, 3], "position": [9, 2, 3],
                   "shape": {"type": "sphere", "radius": 0.1}, "collision": true},)");
  const Scene mixed = good(text);
  CHECK(solver_of(mixed, "crank") == Solver::planar);
  CHECK(solver_of(mixed, "own") == Solver::lagrangian);
  CHECK(solver_of(mixed, "near") == Solver::articulated);
}

TEST_CASE("free bodies that collide are solved in the plane only where that is accurate enough") {
  const std::string collides = R"(, "collision": true)";
  const auto chosen = [](const std::string& text) {
    return good(text).world.default_settings.solver;
  };
  CHECK(chosen(boxes(collides, R"("error": 0.01, )")) == Solver::planar);
  CHECK(chosen(boxes(collides, R"("error": 0.001, )")) == Solver::articulated);
  CHECK(chosen(boxes(R"(, "collision": {"restitution": 0.5})", R"("error": 0.01, )")) ==
        Solver::articulated);
  // One ball passes in front of the other.
  CHECK(chosen(boxes(collides, R"("error": 0.01, )", "0.05")) == Solver::articulated);
}

TEST_CASE("a belt that slips is refused by the exact solver, by name") {
  const auto told_by = [](const std::string& solver) {
    const Result<Scene> scene =
        parse_scene(R"({"version": 1, "solver": {"type": ")" + solver + R"("}, "bodies": [
          {"name": "a", "mass": 1, "inertia": [1, 1, 1]},
          {"name": "b", "position": [1, 0, 0], "mass": 1, "inertia": [1, 1, 1]}],
        "joints": [{"kind": "hinge", "a": "world", "b": "a", "anchor": [0, 0, 0], "axis": [0, 0, 1]},
                   {"kind": "hinge", "a": "world", "b": "b", "anchor": [1, 0, 0], "axis": [0, 0, 1]}],
        "belts": [{"name": "loose", "friction": 0.3, "pretension": 100,
                   "pulleys": [{"body": "a", "radius": 0.2}, {"body": "b", "radius": 0.2}]}]})",
                    "t.json");
    Lines lines;
    if (!scene)
      for (const Error& e : scene.errors()) lines.push_back(e.message);
    return lines;
  };
  CHECK(told_by("planar") == Lines{});
  const Lines out = told_by("lagrangian");
  REQUIRE(out.size() == 1);
  CHECK(out[0].find("/belts/0/friction: found belt \"loose\" solved by \"lagrangian\", expected "
                    "the solver \"planar\": no other supports it") != std::string::npos);
}
