// Surface joints in scene files and programs: what is made of them, and what is refused.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/geometry/shape_skin.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

std::string scene_of(const std::string& joint,
                     const std::string& ball = R"("type": "sphere", "radius": 0.1)",
                     const std::string& more = "") {
  return R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [
    {"name": "table", "motion": "fixed", "shape": {"type": "plane"}},
    {"name": "ball", "position": [0, 0.1, 0], "shape": {)" +
         ball + R"(}}], "surface_joints": [)" + joint + "]" + more + "}";
}
constexpr const char* kPlain = R"({"a": {"body": "ball"}, "b": {"body": "table"}})";

std::string all_errors(const std::string& text) {
  const Result<Scene> scene = parse_scene(text, "s.json");
  REQUIRE_FALSE(scene);
  std::string all;
  for (const Error& e : scene.errors()) all += e.message + "\n";
  return all;
}

}  // namespace

TEST_CASE("a surface joint of a scene file starts where the surfaces are nearest") {
  const Result<Scene> scene = parse_scene(
      scene_of(R"({"name": "c", "a": {"body": "ball"}, "b": {"body": "table"}, "motion": "rolling",
                   "unilateral": true, "on_rim": "release"})"),
      "s.json");
  REQUIRE(scene);
  const World& w = scene->world;
  REQUIRE(w.surface_contacts.size() == 1);
  const detail::SurfaceContact& c = w.surface_contacts[w.find("c")];
  CHECK(c.a == w.find("ball"));
  CHECK(c.motion == SurfaceMotion::rolling);
  CHECK(c.lifts);
  CHECK(c.on_rim == OnRim::release);
  CHECK(c.known);
  CHECK(c.on_a.skin->half_axes().has_value());
  Simulation sim(w, {0.01});
  REQUIRE(sim.step().status == Status::ok);
  const SurfaceTouch touch = surface_touch(sim.world, sim.world.find("c")).value();
  CHECK(touch.touches);
  CHECK(glm::length(touch.point) <= 1e-9);
  CHECK(touch.normal.y == Approx(1));
  CHECK(touch.force.y == Approx(-w.bodies[c.a].mass * 9.81));
  CHECK_FALSE(surface_touch(sim.world, sim.world.find("ball")));
}

TEST_CASE("surface joints that cannot be are refused, by name") {
  CHECK(all_errors(scene_of(R"({"a": {"body": "ball"}, "b": {"body": "ball"}})"))
            .find("expected two bodies, a dynamic one among them") != std::string::npos);
  CHECK(all_errors(scene_of(kPlain, R"("type": "box", "size": [0.2, 0.2, 0.2])"))
            .find("/surface_joints/0/a: found no smooth shape of \"ball\"") != std::string::npos);
  CHECK(all_errors(scene_of(R"({"a": {"body": "ball"}, "b": {"body": "floor"}})"))
            .find("/surface_joints/0/b/body: found \"floor\"") != std::string::npos);
  CHECK(all_errors(scene_of(R"({"a": {"body": "ball"}, "b": {"body": "world", "surface":
            {"faces": [{"type": "plane", "size": [1, 1]}], "position": [9, 0, 0]}}})"))
            .find("m apart") != std::string::npos);
  CHECK(all_errors(scene_of(R"({"a": {"body": "ball"}, "b": {"body": "table"}, "motion": "skid"})"))
            .find("motion") != std::string::npos);
  CHECK(all_errors(scene_of(R"({"a": {"body": "ball", "position": [0, 1, 0]},
            "b": {"body": "table"}})"))
            .find("without a \"surface\"") != std::string::npos);
  CHECK(all_errors(scene_of(kPlain, R"("type": "cylinder", "radius": 0.1, "length": 0.3,
            "rotation_deg": [90, 0, 0])"))
            .find("ContactDegenerate") != std::string::npos);
  std::string text = scene_of(kPlain);
  text.replace(text.find("lagrangian"), 10, "auto");
  CHECK(all_errors(text).find("surface joint \"ball-table\" solved by \"auto\"") !=
        std::string::npos);
}

TEST_CASE("a surface with a crease is refused for a joint, with its knot") {
  const std::string errors = all_errors(scene_of(
      R"({"a": {"body": "ball"}, "b": {"body": "world", "surface": {"faces": [{"type": "nurbs",
          "degrees": [1, 1], "knots_u": [0, 0, 0.5, 1, 1], "knots_v": [0, 0, 1, 1],
          "points": [[-1, 0, 1], [-1, 0, -1], [0, 0.05, 1], [0, 0.05, -1], [1, 0, 1], [1, 0, -1]]}]}}})"));
  INFO(errors);
  CHECK(errors.find("surface b, face 0") != std::string::npos);
  CHECK(errors.find("0.5") != std::string::npos);
  CHECK(errors.find("expected a smooth surface") != std::string::npos);
}

TEST_CASE("copies of a prefab have surface joints of their own; mirror images are refused") {
  const auto text = [](const std::string& instance) {
    return R"({"version": 1, "solver": {"type": "lagrangian"}, "prefabs": [{"name": "p", "bodies": [
      {"name": "ball", "position": [0, 0.1, 0], "shape": {"type": "sphere", "radius": 0.1}}],
      "surface_joints": [{"name": "c", "a": {"body": "ball"}, "b": {"body": "world", "surface":
      {"faces": [{"type": "plane", "size": [1, 1], "rotation_deg": [-90, 0, 0]}]}}}]}],
      "instances": [)" +
           instance + "]}";
  };
  const Result<Scene> scene = parse_scene(
      text(R"({"name": "i", "prefab": "p", "position": [3, 0, 0], "rotation_deg": [0, 0, 30]})"),
      "s.json");
  REQUIRE(scene);
  Simulation sim(scene->world, {0.01});
  REQUIRE(sim.step().status == Status::ok);
  const SurfaceTouch touch = surface_touch(sim.world, sim.world.find("i/c")).value();
  CHECK(touch.normal.x == Approx(-0.5));
  CHECK(glm::distance(touch.point, {3, 0, 0}) <= 0.01);
  CHECK(all_errors(text(R"({"name": "i", "prefab": "p", "mirror": "x"})")).find("surface joints") !=
        std::string::npos);
}

TEST_CASE("programs add surface joints of the bodies' shapes or of others") {
  World w;
  w.default_settings.solver = Solver::lagrangian;
  Body fixed;
  fixed.motion = Motion::fixed;
  const Entity ground = w.add_body(fixed);
  Body body;
  body.inertia = Vec3(0.004), body.pose.position = {0, 0.1, 0};
  const Entity ball = w.add_body(body);
  SurfaceJoint joint{.a = ball, .b = ground, .name = "c"};
  CHECK_FALSE(w.add(joint));
  Shape sphere, plane;
  sphere.kind = ShapeKind::sphere, sphere.size = {0.1, 0, 0};
  plane.kind = ShapeKind::plane;
  joint.surface_a = sphere, joint.surface_b = plane;
  const Result<Entity> made = w.add(joint);
  REQUIRE(made);
  CHECK(w.surface_contacts[*made].known);
  Simulation sim(w, {0.01});
  REQUIRE(sim.step().status == Status::ok);
  CHECK(surface_touch(sim.world, *made)->force.y == Approx(-9.81));
  w.default_settings.solver = Solver::articulated;
  CHECK_FALSE(w.add(joint));
}

TEST_CASE("shapes are smooth surfaces with their normals outwards") {
  const auto check = [](Shape shape, Vec3 near, Vec3 normal) {
    const auto skin = detail::skin_of(shape);
    REQUIRE(skin);
    Real least = 1e300;
    Vec3 found(0);
    for (const auto& face : skin->faces()) {
      const auto at = detail::nurbs::closest_point(face, near);
      if (at.distance >= least) continue;
      least = at.distance;
      const auto jet = face.at(at.u, at.v);
      found = glm::normalize(glm::cross(jet.u, jet.v));
    }
    CHECK(least <= 1e-9);
    CHECK(glm::distance(found, normal) <= 1e-6);
  };
  Shape shape;
  shape.kind = ShapeKind::sphere, shape.size = {0.3, 0, 0};
  check(shape, {0, 0, 0.3}, {0, 0, 1});
  shape.kind = ShapeKind::ellipsoid, shape.size = {0.3, 0.2, 0.1};
  check(shape, {0, -0.2, 0}, {0, -1, 0});
  shape.kind = ShapeKind::cylinder, shape.size = {0.3, 0.5, 0};
  check(shape, {0.3, 0.45, 0}, {1, 0, 0});
  check(shape, {0, -0.45, 0.3}, {0, 0, 1});
  shape.kind = ShapeKind::plane;
  check(shape, {7, 0, -3}, {0, 1, 0});
  shape.kind = ShapeKind::box;
  CHECK_FALSE(detail::skin_of(shape));
}
