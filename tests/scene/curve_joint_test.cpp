// Curves that touch, in scene files and programs: what is made of them, and what is refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

std::string scene_of(const std::string& a, const std::string& b, const std::string& more = "",
                     const std::string& solver = "lagrangian") {
  return R"({"version": 1, "solver": {"type": ")" + solver + R"("}, "bodies": [
    {"name": "cam", "mass": 1, "inertia": [0.1, 0.1, 0.1]},
    {"name": "arm", "position": [0, 0.3, 0], "mass": 1, "inertia": [0.1, 0.1, 0.1]}],
    "surface_joints": [{"name": "c", "a": {"body": "cam", )" +
         a + R"(}, "b": {"body": "arm", )" + b + "}" + more + "}]}";
}
const std::string kRound = R"("curve": {"type": "circle", "radius": 0.1})";
const std::string kFace = R"("curve": {"type": "line", "from": [-1, -0.2, 0], "to": [1, -0.2, 0]})";

std::string all_errors(const std::string& text) {
  const Result<Scene> scene = parse_scene(text, "s.json");
  INFO(text);
  REQUIRE_FALSE(scene);
  std::string all;
  for (const Error& e : scene.errors()) all += e.message + "\n";
  return all;
}
void check_told(const std::string& text, const std::string& wanted) {
  const std::string all = all_errors(text);
  INFO(all);
  CHECK(all.find(wanted) != std::string::npos);
}

}  // namespace

TEST_CASE("curves of a scene start where they are nearest") {
  const Result<Scene> scene = parse_scene(scene_of(kRound, kFace), "s.json");
  REQUIRE(scene);
  const detail::SurfaceContact& c = scene->world.surface_contacts.values()[0];
  REQUIRE(c.known);
  REQUIRE(c.on_a.curve);
  CHECK(c.on_b.curve->knots().degree == 1);
  const Vec3 at = detail::nurbs::evaluate(c.on_a.curve->curve(), c.at.a.u, 0)[0];
  CHECK(glm::distance(at, {0, 0.1, 0}) < 1e-9);
  CHECK(c.at.b.u == Approx(0.5));
}

TEST_CASE("curves are shared by name, turned inside out, and joined head to tail") {
  const std::string text =
      scene_of(R"("curve": "slot", "inside_out": true)",
               R"("curve": "pin", "position": [0, -0.29, 0])", R"(, "unilateral": true)");
  const std::string curves = R"({"curves": [{"name": "pin", "type": "circle", "radius": 0.05},
    {"name": "slot", "type": "joined", "curves": [
      {"type": "line", "from": [-0.2, -0.06, 0], "to": [0.2, -0.06, 0]},
      {"type": "arc", "radius": 0.06, "angles_deg": [-90, 90], "position": [0.2, 0, 0]},
      {"type": "line", "from": [-0.2, 0.06, 0], "to": [0.2, 0.06, 0]},
      {"type": "arc", "radius": 0.06, "angles_deg": [90, 270], "position": [-0.2, 0, 0]}]}], )";
  const Result<Scene> scene = parse_scene(curves + text.substr(1), "s.json");
  REQUIRE(scene);
  const detail::SurfaceContact& c = scene->world.surface_contacts.values()[0];
  REQUIRE(c.known);
  CHECK(c.on_a.curve->knots().is_periodic);
  // The pin stands in the slot, nearest to the wall above it.
  const Vec3 at = detail::nurbs::evaluate(c.on_a.curve->curve(), c.at.a.u, 0)[0];
  CHECK(glm::distance(at, {0, 0.06, 0}) < 1e-9);
  check_told(scene_of(R"("curve": "slit")", kFace), "/surface_joints/0/a/curve: found \"slit\"");
}

TEST_CASE("curves that cannot touch are refused, with the pointer and what was found") {
  const auto outline = [](const std::string& points, const std::string& more = "") {
    return R"("curve": {"type": "outline", "points": [)" + points + "]" + more + "}";
  };
  const std::string square = "[-0.1,-0.1,0],[0.1,-0.1,0],[0.1,0.1,0],[-0.1,0.1,0]";
  check_told(scene_of(outline(square), kFace), "/a/curve: found a corner of 90 degrees");
  CHECK(parse_scene(scene_of(outline(square, R"(, "rounding": 0.02)"), kRound), "s.json"));
  check_told(scene_of(outline(square, R"(, "rounding": 0.2)"), kFace), "found a side of 0.2 m");
  check_told(scene_of(outline("[-0.1,-0.1,0],[0.1,0.1,0],[0.1,-0.1,0],[-0.1,0.1,0]",
                              R"(, "rounding": 0.01)"),
                      kFace),
             "found a curve that crosses itself");
  check_told(scene_of(outline("[-0.1,-0.1,0],[0.1,0.1,0.1],[0.1,-0.1,0]"), kFace),
             "found point 1 off the plane");
  check_told(scene_of(R"("curve": {"type": "interpolation", "closed": true, "points":
             [[0.1,0,0],[0,0.1,0.05],[-0.1,0,0],[0,-0.1,0]]})",
                      kFace),
             "that leaves its plane");
  check_told(scene_of(kRound + R"(, "rotation_deg": [20, 0, 0])", kFace), "tilted by 20 degrees");
  check_told(scene_of(kRound + R"(, "position": [0, 0, 0.01])", kFace), "planes 0.01 m apart");
  check_told(scene_of(kRound + R"(, "position": [5, 0, 0])", kFace),
             "not facing it or conforming with it");
  check_told(scene_of(kRound + R"(, "surface": "x")", kFace), "found \"curve\" beside \"surface\"");
  check_told(scene_of(R"("surface": {"faces": [{"type": "sphere", "radius": 0.1}]})", kFace),
             "a curve on b but none on a");
  check_told(scene_of(R"("inside_out": true)", kFace), "without a \"curve\"");
  check_told(scene_of(R"("curve": {"type": "joined", "curves": [
               {"type": "line", "from": [0, 0, 0], "to": [1, 0, 0]},
               {"type": "line", "from": [3, 0, 0], "to": [4, 0, 0]}]})",
                      kFace),
             "curve 1 to begin 2 m from the end");
  check_told(scene_of(kRound, kFace, "", "sweep"), "solved by \"sweep\"");
}

TEST_CASE("a number that is none is told once, whatever is made of it") {
  const auto told = [](const std::string& a) {
    const std::string all = all_errors(scene_of(a, kFace));
    INFO(all);
    CHECK(std::count(all.begin(), all.end(), '\n') == 1);
    CHECK(all.find(", expected a finite number") != std::string::npos);
  };
  const auto nurbs = [](const std::string& knot, const std::string& x, const std::string& weight) {
    return R"("curve": {"type": "nurbs", "degree": 2, "knots": [0, 0, 0, )" + knot +
           R"(, 1, 1], "points": [[1, 0, 0], [)" + x +
           R"(, 0.1, 0], [-1, 0, 0]], "weights": [1, )" + weight + ", 1]}";
  };
  CHECK(parse_scene(scene_of(nurbs("1", "0", "1"), kFace), "s.json"));
  told(nurbs("1e999", "0", "1"));
  told(nurbs("1", "NaN", "1"));
  told(nurbs("1", "0", "1e999"));
  told(R"("curve": {"type": "joined", "curves": [{"type": "circle", "radius": Infinity}]})");
  told(R"("curve": {"type": "interpolation", "points": [[0, 0, 0], [1, NaN, 0], [2, 0, 0]]})");
  told(R"("surface": {"faces": [{"type": "plane", "size": [1e999, 1]}]})");
  told(R"("surface": {"faces": [{"type": "extrusion", "way": [0, 0, NaN],
          "profile": {"type": "circle", "radius": 1}}]})");
}

TEST_CASE("the plane takes curves of its own plane alone") {
  CHECK(parse_scene(scene_of(kRound, kFace, "", "planar"), "s.json"));
  check_told(scene_of(kRound, kFace, R"(, "friction": 0.2)", "planar"),
             "/surface_joints/0/friction: found the friction of surface joint \"c\" solved by "
             "\"planar\", expected the solver \"lagrangian\"");
  const std::string turned = R"(, "rotation_deg": [0, 20, 0])";
  check_told(scene_of(kRound + turned, kFace + turned, "", "planar"),
             "which has a curve of \"a\" that does not lie in the xy plane");
  check_told(R"({"version": 1, "solver": {"type": "planar"}, "bodies": [
    {"name": "ball", "position": [0, 0.1, 0], "shape": {"type": "sphere", "radius": 0.1}}],
    "surface_joints": [{"a": {"body": "ball"}, "b": {"body": "world", "surface":
    {"faces": [{"type": "sphere", "radius": 0.5, "position": [0, -0.5, 0]}]}}}]})",
             "solved by \"planar\"");
}

TEST_CASE("programs add joints of curves") {
  World w;
  w.default_settings.solver = Solver::lagrangian;
  const auto body = [&](const char* name, Vec3 at) {
    return w.add(RigidBody{.mass = 1, .inertia = Mat3(0.1), .position = at, .name = name}).value();
  };
  const Entity cam = body("cam", Vec3(0)), arm = body("arm", {0, 0.3, 0});
  const NurbsCurve face = NurbsCurve::line({-1, -0.2, 0}, {1, -0.2, 0});
  SurfaceJoint joint{.a = cam, .b = arm, .curve_a = NurbsCurve::ellipse(0.1, 0.1), .curve_b = face};
  joint.motion = SurfaceMotion::sliding;
  const Result<Entity> made = w.add(joint);
  REQUIRE(made);
  CHECK(w.surface_contacts[*made].known);
  const auto told = [&](const NurbsCurve& curve) {
    SurfaceJoint other = joint;
    other.curve_a = curve;
    const Result<Entity> refused = w.add(other);
    REQUIRE_FALSE(refused);
    return refused.errors()[0].message;
  };
  const std::vector<Vec3> square = {{-0.1, -0.1, 0}, {0.1, -0.1, 0}, {0.1, 0.1, 0}, {-0.1, 0.1, 0}};
  CHECK(told(NurbsCurve::outline(square, 0).value()).find("found a corner of 90 degrees") !=
        std::string::npos);
  NurbsCurve broken = NurbsCurve::circle(0.1);
  broken.weights.pop_back();
  CHECK(told(broken).find("found 8 weights") != std::string::npos);
  CHECK_FALSE(NurbsCurve::outline(square, 1));
  CHECK(w.surface_contacts.size() == 1);
  CHECK(NurbsCurve::around(square)->periodic);
  CHECK_FALSE(NurbsCurve::through({{0, 0, 0}}));
}
