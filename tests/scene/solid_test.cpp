// Which bodies are solid, and shapes that need more than three numbers.
#include <filesystem>
#include <fstream>

#include "engine/geometry/surface.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/scene/read/obj.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

const Collision* collision_of(const Scene& s, const char* name) {
  return s.world.collisions.find(s.world.find(name));
}

const Shape& shape_of(const Scene& s, const char* name) {
  return s.world.shapes[s.world.find(name)].list[0];
}

/// A cube of edge 1 about the origin.
const std::string kCubePoints =
    R"("points": [[-0.5, -0.5, -0.5], [0.5, -0.5, -0.5], [0.5, 0.5, -0.5],
[-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5], [0.5, -0.5, 0.5], [0.5, 0.5, 0.5], [-0.5, 0.5, 0.5]])";
const std::string kCubeFaces = "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

}  // namespace

TEST_CASE("Bodies are solid where the scene or they themselves say so") {
  const std::string ball = R"("shape": {"type": "sphere", "radius": 0.1})";
  const Scene s = good(R"({"version": 1, "collision_groups": ["floor", "puppet"],
"collision": {"friction": 0.75, "groups": ["puppet"]}, "bodies": [
{"name": "plain", )" + ball +
                       R"(}, {"name": "off", "collision": false, )" + ball + R"(},
{"name": "own", "collision": {"restitution": 0.5, "with": ["floor", 5], "others": true, "self": true}, )" +
                       ball + R"(},
{"name": "gate", "collision": {"sensor": true}, )" +
                       ball + R"(},
{"name": "bare", "motion": "fixed"}], "generators": {"chains": [
{"name": "c", "links": 2, "length": 0.2, "collision": {"groups": [0, "puppet"]}, )" +
                       ball + "}]}}");
  REQUIRE(collision_of(s, "plain"));
  CHECK(collision_of(s, "plain")->friction == 0.75);
  CHECK(collision_of(s, "plain")->groups == 2);
  CHECK(collision_of(s, "plain")->with == UINT32_MAX);
  CHECK_FALSE(collision_of(s, "off"));
  CHECK_FALSE(collision_of(s, "bare"));
  const Collision& own = *collision_of(s, "own");
  CHECK((own.friction == 0.75 && own.restitution == 0.5 && own.groups == 2 && own.with == 33));
  CHECK((own.others && own.self && !own.sensor));
  CHECK((collision_of(s, "gate")->sensor && collision_of(s, "gate")->groups == 2));
  CHECK((collision_of(s, "c/1") && collision_of(s, "c/1")->groups == 3));
}

TEST_CASE("Without a word in the scene nothing is solid but what says so, prefabs included") {
  const Scene s = good(R"({"version": 1, "prefabs": [{"name": "p", "bodies": [
{"name": "a", "shape": {"type": "sphere", "radius": 0.1}, "collision": true},
{"name": "b", "shape": {"type": "sphere", "radius": 0.1}}]}],
"instances": [{"name": "i", "prefab": "p"}]})");
  CHECK_FALSE(collision_of(s, "i/b"));
  REQUIRE(collision_of(s, "i/a"));
  CHECK((collision_of(s, "i/a")->groups == 1 && collision_of(s, "i/a")->others));
}

TEST_CASE("A hull weighs what it encloses, and all copies of a prefab share it") {
  const Scene s = good(R"({"version": 1, "prefabs": [{"name": "p", "bodies": [{"name": "cube",
"density": 500, "shape": {"type": "hull", "position": [1, 0, 0], )" +
                       kCubePoints + R"(}}]}],
"generators": {"grids": [{"name": "g", "prefab": "p", "count": [2, 1, 1]}]}})");
  const Body& b = s.world.bodies[s.world.find("g/0/cube")];
  CHECK(b.mass == Approx(500));
  CHECK(b.inertia.x == Approx(500.0 / 6));
  const Shape &one = shape_of(s, "g/0/cube"), &two = shape_of(s, "g/1/cube");
  CHECK(one.kind == ShapeKind::hull);
  CHECK(glm::length(one.local.position) < 1e-12);  // about the mass centre
  CHECK(one.surface->points.size() == 8);
  CHECK(one.surface == two.surface);
}

TEST_CASE("Planes and height fields are grounds of fixed and kinematic bodies") {
  const Scene s = good(R"({"version": 1, "bodies": [
{"name": "floor", "motion": "fixed", "shape": {"type": "plane", "size": 8}, "collision": true},
{"name": "lift", "motion": "kinematic", "shape": {"type": "plane", "rotation_deg": [0, 0, 90]}},
{"name": "hills", "motion": "fixed", "shape": {"type": "height_field", "columns": 3, "rows": 2,
 "spacing": [1, 2], "heights": [0, 1, 2, 3, 4, 5]}}]})");
  CHECK(shape_of(s, "floor").kind == ShapeKind::plane);
  CHECK(shape_of(s, "floor").size.x == 4);
  CHECK(shape_of(s, "lift").size.x == 10);
  const Surface& hills = *shape_of(s, "hills").surface;
  CHECK((hills.columns == 3 && hills.rows == 2 && hills.spacing_x == 1 && hills.spacing_z == 2));
  CHECK(hills.points[5] == Vec3(1, 5, 1));
}

TEST_CASE("A mesh may be read from an OBJ file beside the scene") {
  const auto folder = std::filesystem::temp_directory_path() / "pantin_solid_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "cube.obj") << "# a cube\no cube\nv 0 0 0\nv 1 0 0\nv 1 1 0 \nv 0 1 0\r\n"
                                        "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvn 0 0 1\n"
                                     << kCubeFaces;
  std::ofstream(folder / "scene.json") << R"({"version": 1, "bodies": [
{"name": "mesh", "motion": "fixed", "shape": {"type": "mesh", "file": "cube.obj"}},
{"name": "hull", "shape": {"type": "hull", "file": "cube.obj"}}]})";
  const Result<Scene> s = load_scene((folder / "scene.json").string());
  std::filesystem::remove_all(folder);
  REQUIRE(bool(s));
  CHECK(shape_of(*s, "mesh").surface->faces.size() == 12);
  CHECK(s->world.bodies[s->world.find("hull")].mass == Approx(1000));
}

TEST_CASE("OBJ faces may count backwards, name normals, and are cut into fans") {
  const auto mesh =
      parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4/1/1 2//3 3/4 -1 # quad", "m");
  REQUIRE(bool(mesh));
  using Corners = std::array<std::uint32_t, 3>;
  CHECK(mesh->triangles == std::vector<Corners>{Corners{0, 1, 2}, Corners{0, 2, 3}});
}

TEST_CASE("Faults of an OBJ file are told with their lines") {
  const auto mesh = parse_obj("v 0 0\nv 1 0 nan\nv 1 1 x\nf 1 2\nf 1 2 4\nf 1 0 2", "m.obj");
  REQUIRE_FALSE(bool(mesh));
  Lines lines;
  for (const Error& e : mesh.errors()) lines.push_back(e.message);
  CHECK(
      lines ==
      Lines{"m.obj:1: found the end of the line, expected three numbers between -1e9 and 1e9 after "
            "v",
            "m.obj:2: found \"nan\", expected three numbers between -1e9 and 1e9 after v",
            "m.obj:3: found \"x\", expected three numbers between -1e9 and 1e9 after v",
            "m.obj:4: found the end of the line, expected three corners or more after f",
            "m.obj:5: found \"4\", expected the number of one of the 3 points above",
            "m.obj:6: found \"0\", expected the number of one of the 3 points above"});
}

TEST_CASE("What is solid touches everything but its neighbours along joints") {
  // A bent arm whose ends overlap, and two balls that do; the parts of the arm overlap as well.
  const bool touches = GENERATE(true, false);
  const std::string how =
      touches ? GENERATE("true", "{\"friction\": 0.2}") : "{\"others\": false, \"self\": false}";
  const Scene s = good(R"({"version": 1, "gravity": [0, 0, 0], "collision": )" + how +
                       R"(, "bodies": [
{"name": "a", "shape": {"type": "sphere", "radius": 0.25}},
{"name": "b", "shape": {"type": "sphere", "radius": 0.25}, "position": [0.2, 0.2, 0]},
{"name": "c", "shape": {"type": "sphere", "radius": 0.25}, "position": [0.4, 0, 0]},
{"name": "p", "shape": {"type": "sphere", "radius": 0.25}, "position": [5, 0, 0]},
{"name": "q", "shape": {"type": "sphere", "radius": 0.25}, "position": [5.4, 0, 0]}],
"joints": [{"a": "a", "b": "b", "anchor": [0.1, 0.1, 0]}, {"a": "b", "b": "c", "anchor": [0.3, 0.1, 0]}]})");
  Simulation sim = Simulation::copy_of(s.world, {1.0 / 120, 1, 1, true});
  for (int i = 0; i < 360; ++i) sim.step();
  const auto distance = [&](const char* x, const char* y) {
    const World& w = sim.world;
    return glm::length(w.bodies[w.find(x)].pose.position - w.bodies[w.find(y)].pose.position);
  };
  const Real apart = touches ? 0.49 : 0.4;
  if (touches) CHECK(distance("a", "c") > 0.47);
  if (!touches) CHECK(distance("a", "c") == Approx(0.4));
  CHECK(distance("p", "q") >= apart - 1e-9);
  CHECK(distance("a", "b") < 0.3);
  if (!touches) CHECK(distance("p", "q") == Approx(0.4));
}
