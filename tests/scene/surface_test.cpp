// Surfaces in scene files: by makers, by control points, by name, by file; what is refused.
#include "engine/geometry/surface.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "engine/geometry/skin_model.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/runtime/save.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/scene/read/surface_file.hpp"
#include "tests/base/random.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

std::string with_faces(const std::string& faces, const std::string& more = "") {
  return R"({"version": 1, "bodies": [{"name": "a", "motion": "fixed", "shape": {"type": "nurbs",
            "surface": {"faces": [)" +
         faces + "]" + more + "}}}]}";
}

const Shape& first_shape(const Scene& scene) { return scene.world.shapes.values()[0].list[0]; }

struct Folder {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("pantin_surface_" + std::to_string(getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path / name) << text;
    return (path / name).string();
  }
};

constexpr const char* kPatch =
    R"({"type": "nurbs", "degrees": [1, 1], "knots_u": [0, 0, 1, 1], "knots_v": [0, 0, 1, 1],
        "points": [[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]])";

}  // namespace

TEST_CASE("every maker of faces makes the surface that it names", "[surfaces]") {
  struct Made {
    const char* face;
    Vec3 low, high;
    Real area;
  };
  const Real pi = kPi;
  const Made all[] = {
      {R"({"type": "plane", "size": [2, 1]})", {-1, -0.5, 0}, {1, 0.5, 0}, 2},
      {R"({"type": "cylinder", "radius": 0.5, "height": 2})",
       {-0.5, -0.5, 0},
       {0.5, 0.5, 2},
       2 * pi},
      {R"({"type": "cone", "radii": [3, 0], "height": 4})", {-3, -3, 0}, {3, 3, 4}, 15 * pi},
      {R"({"type": "sphere", "radius": 0.5})", Vec3(-0.5), Vec3(0.5), pi},
      {R"({"type": "sphere", "radius": 0.5, "position": [1, 0, 0]})",
       {0.5, -0.5, -0.5},
       {1.5, 0.5, 0.5},
       pi},
      {R"({"type": "ellipsoid", "radii": [0.5, 0.5, 0.5]})", Vec3(-0.5), Vec3(0.5), pi},
      {R"({"type": "torus", "radius": 1, "tube": 0.25})",
       {-1.25, -1.25, -0.25},
       {1.25, 1.25, 0.25},
       pi * pi},
      {R"({"type": "revolution", "profile": {"type": "line", "from": [1, 0, 0], "to": [1, 0, 2]},
           "angle_deg": 90})",
       {0, 0, 0},
       {1, 1, 2},
       pi},
      {R"({"type": "extrusion", "profile": {"type": "arc", "radius": 1, "angles_deg": [0, 180]},
           "way": [0, 0, 3]})",
       {-1, 0, 0},
       {1, 1, 3},
       3 * pi},
      {R"({"type": "sweep", "section": {"type": "line", "from": [0, 0, 0], "to": [0, 0, 1]},
           "path": {"type": "line", "from": [0, 0, 0], "to": [2, 0, 0]}})",
       {0, 0, 0},
       {2, 0, 1},
       2},
      {R"({"type": "interpolation", "columns": 4, "degrees": [3, 3], "points":
           [[0,0,0],[0,1,0],[0,2,0],[0,3,0],[1,0,0],[1,1,0],[1,2,0],[1,3,0],
            [2,0,0],[2,1,0],[2,2,0],[2,3,0],[3,0,0],[3,1,0],[3,2,0],[3,3,0]]})",
       {0, 0, 0},
       {3, 3, 0},
       9},
  };
  for (const Made& made : all) {
    INFO(made.face);
    const Scene scene = good(with_faces(made.face));
    const Shape& shape = first_shape(scene);
    REQUIRE(shape.kind == ShapeKind::nurbs);
    CHECK(glm::distance(shape.surface->low, made.low) < 1e-9);
    CHECK(glm::distance(shape.surface->high, made.high) < 1e-9);
    CHECK(nurbs::area_of(*shape.surface->skin) == Approx(made.area).epsilon(1e-9));
  }
}

TEST_CASE("surfaces by name and inline are placed and turned inside out", "[surfaces]") {
  const Scene scene = good(R"({"version": 1,
    "surfaces": [{"name": "shell", "faces": [{"type": "torus", "radius": 1, "tube": 0.25}],
                  "scale": 2, "position": [0, 0, 3], "rotation_deg": [90, 0, 0]}],
    "bodies": [{"name": "a", "motion": "fixed", "shape": {"type": "nurbs", "surface": "shell"}},
               {"name": "b", "shape": {"type": "nurbs", "surface": "shell", "density": 100}}]})");
  const auto shapes = scene.world.shapes.values();
  CHECK(shapes[0].list[0].surface == shapes[1].list[0].surface);
  CHECK(glm::distance(shapes[0].list[0].surface->low, {-2.5, -0.5, 0.5}) < 1e-9);
  CHECK(scene.world.bodies.values()[1].mass ==
        Approx(100 * 8 * 2 * kPi * kPi * 0.0625).epsilon(1e-9));
}

TEST_CASE("the wall of a cavity is a patch: it has no mass, and no poles if it is a sphere",
          "[surfaces]") {
  for (const std::string face :
       {R"({"type": "torus", "radius": 1, "tube": 0.25})", R"({"type": "sphere", "radius": 2})"}) {
    const std::string fixed = with_faces(face, R"(, "inside_out": true)");
    const Scene scene = good(fixed);
    const Surface& surface = *first_shape(scene).surface;
    CHECK_FALSE(surface.model->is_closed);
    CHECK(surface.model->enclosed.mass == 0);
    std::string dynamic = fixed;
    dynamic.replace(dynamic.find("fixed"), 5, "dynamic");
    const Lines told = diagnostics(dynamic);
    REQUIRE(told.size() == 1);
    CHECK(told[0].find("outer side faces inwards") != std::string::npos);
  }
  const std::string cavity = R"({"type": "sphere", "radius": 2, "inside_out": true})";
  CHECK(first_shape(good(with_faces(cavity))).surface->skin->is_ellipsoid_cavity());
  const Scene twice = good(with_faces(cavity, R"(, "inside_out": true)"));
  CHECK(first_shape(twice).surface->skin->is_solid_ellipsoid());
}

TEST_CASE("bad surfaces are refused with surface, knot and place", "[surfaces]") {
  const std::pair<std::string, std::string> wrong[] = {
      {R"({"type": "nurbs", "degrees": [1, 1], "knots_u": [0, 0, 1, 0.5], "knots_v": [0, 0, 1, 1],
           "points": [[0,0,0],[0,1,0],[1,0,0],[1,1,0]]})",
       "the surface, face 0, u: knot 3 is 0.5 after 1"},
      {R"({"type": "nurbs", "degrees": [2, 1], "knots_u": [0, 0, 1, 1], "knots_v": [0, 0, 1, 1],
           "points": [[0,0,0],[0,1,0],[1,0,0],[1,1,0]]})",
       "knots for"},
      {kPatch + std::string(R"(, "weights": [1, 1, 0, 1]})"),
       "control point 2 has weight 0, expected one above 0"},
      {kPatch + std::string(R"(, "weights": [1, 1, 1]})"), "found 3 weights, expected 4"},
      {kPatch + std::string(R"(, "periodic_u": true})"), "is periodic along u, but its ends are"},
      {R"({"type": "nurbs", "degrees": [1, 1], "knots_u": [0, 0, 1, 1], "knots_v": [0, 0, 1, 1],
           "points": [[0,0,0],[0,0,0],[1,0,0],[1,0,0]]})",
       "is a curve or a point, expected a surface"},
      {R"({"type": "nurbs", "degrees": [1, 1], "knots_u": [0, 0, 1, 1], "knots_v": [0, 0, 1, 1],
           "homogeneous": [1, 2, 3]})",
       "found 3 numbers, expected four a point"},
      {R"({"type": "torus", "radius": 1})", "/faces/0: found no \"tube\""},
      {R"({"type": "pretzel"})", "/faces/0/type"},
      {R"({"type": "cone", "radii": [0, 0], "height": 1})", "one of the radii above 0"},
      {R"({"type": "revolution", "profile": {"type": "arc", "radius": 1, "angles_deg": [90, 0]}})",
       "the second angle above the first"},
      {R"({"type": "interpolation", "columns": 3, "points": [[0,0,0],[1,0,0]]})",
       "expected whole rows of 3"},
  };
  for (const auto& [face, expected] : wrong) {
    INFO(face);
    const Lines told = diagnostics(with_faces(face));
    REQUIRE_FALSE(told.empty());
    CHECK_THAT(told[0], Catch::Contains(expected));
    CHECK_THAT(told[0], Catch::Contains("/bodies/0/shape/surface"));
  }
  const auto of_surface = [](const std::string& value) {
    return diagnostics(R"({"version": 1, "surfaces": [{"name": "cup", "faces": [{"type": "plane",
      "size": [1, 1]}]}], "bodies": [{"name": "a", "motion": "fixed", "shape": {"type": "nurbs",
      "surface": )" + value +
                       "}}]}");
  };
  CHECK_THAT(of_surface("\"cap\"").at(0), Catch::Contains("nearest is \"cup\""));
  CHECK_THAT(of_surface("7").at(0), Catch::Contains("the name of a surface"));
  CHECK_THAT(of_surface("\"nowhere.json\"").at(0), Catch::Contains("nowhere.json"));
}

TEST_CASE("a face without points or knots is refused, inside out too", "[surfaces]") {
  const auto refused = [](const std::string& of_face, const std::string& of_surface) {
    return diagnostics(R"({"version": 1, "surfaces": [{"name": "s", "faces": [{"type": "nurbs")" +
                       of_face + "}]" + of_surface + "}]}");
  };
  const Lines plain = refused("", "");
  CHECK(plain.size() >= 4);
  CHECK(refused(R"(, "inside_out": true)", "") == plain);
  CHECK(refused("", R"(, "inside_out": true)") == plain);
}

TEST_CASE("creases and places without a normal are warned of", "[surfaces]") {
  const Scene scene = good(with_faces(
      R"({"type": "extrusion", "way": [0, 0, 1], "profile": {"type": "nurbs", "degree": 1,
          "knots": [0, 0, 0.5, 1, 1], "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0]]}})"));
  REQUIRE(scene.warnings.size() == 1);
  CHECK_THAT(scene.warnings[0], Catch::Contains("face 0, u, knot 0.5"));
  const Scene tip = good(with_faces(R"({"type": "cone", "radii": [1, 0], "height": 1})"));
  REQUIRE(tip.warnings.size() == 1);
  CHECK_THAT(tip.warnings[0], Catch::Contains("edge v = 1 is one point"));
}

TEST_CASE("a surface that is written and read again has the same bits", "[surfaces]") {
  const Folder folder;
  const nurbs::Frame odd{{0.1, 0.2, 0.3}};
  const nurbs::Skin skins[] = {
      nurbs::Skin({nurbs::torus(odd, 1.0 / 3, 0.1)}, 1e-7),
      nurbs::Skin({nurbs::plane({}, 1, 0.7), nurbs::cylinder(odd, 0.3, 0.7)}, 1e-9),
      nurbs::Skin::ellipsoid({0.3, 1.0 / 7, 0.1})};
  for (const nurbs::Skin& skin : skins) {
    const std::string file = folder.write("skin.json", surface_text(skin));
    const auto loaded = load_surface(file);
    REQUIRE(loaded);
    CHECK(loaded->surface->skin->fingerprint() == skin.fingerprint());
    CHECK(surface_text(*loaded->surface->skin) == surface_text(skin));
  }
  const std::string broken = folder.write("broken.json", R"({"faces": [{"type": "torus"}]})");
  const auto refused = load_surface(broken);
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.errors()[0].message, Catch::Contains("broken.json:1"));
  CHECK_THAT(refused.errors()[0].message, Catch::Contains("/faces/0"));
}

TEST_CASE("a scene takes surfaces from files, and tells of mistakes there", "[surfaces]") {
  const Folder folder;
  folder.write("ring.json", surface_text(nurbs::Skin({nurbs::torus({}, 1, 0.25)}, 1e-7)));
  const std::string scene_file = folder.write("scene.json", R"({"version": 1,
    "surfaces": [{"name": "big", "file": "ring.json", "scale": 2}],
    "bodies": [{"name": "a", "shape": {"type": "nurbs", "surface": "ring.json"}},
               {"name": "b", "shape": {"type": "nurbs", "surface": "big"}}]})");
  const auto scene = load_scene(scene_file);
  REQUIRE(scene);
  const auto bodies = scene->world.bodies.values();
  CHECK(bodies[1].mass == Approx(8 * bodies[0].mass).epsilon(1e-9));
  CHECK(scene->files.size() == 1);
  folder.write("ring.json", R"({"faces": [{"type": "torus", "radius": -1, "tube": 0.25}]})");
  const auto refused = load_scene(scene_file);
  REQUIRE_FALSE(refused);
  bool is_told = false;
  for (const Error& e : refused.errors())
    is_told = is_told || e.message.find("/faces/0/radius") != std::string::npos;
  CHECK(is_told);
}

TEST_CASE("skins fall, roll and rest, and a World with them is saved with the same bits",
          "[surfaces]") {
  const Scene scene = good(R"({"version": 1, "collision": {"others": true},
    "surfaces": [{"name": "ring", "faces": [{"type": "torus", "radius": 0.3, "tube": 0.1}]}],
    "bodies": [
      {"name": "ground", "motion": "fixed", "shape": {"type": "plane"}},
      {"name": "ring", "position": [0, 0.5, 0], "rotation_deg": [-80, 0, 0],
       "shape": {"type": "nurbs", "surface": "ring"}},
      {"name": "egg", "position": [2, 0.5, 0], "shape": {"type": "nurbs",
       "surface": {"faces": [{"type": "ellipsoid", "radii": [0.3, 0.2, 0.2]}]}}}]})");
  Simulation sim = Simulation::copy_of(scene.world, {scene.step, scene.substeps, 1, true});
  for (int i = 0; i < 40; ++i) REQUIRE(sim.step().status == Status::ok);
  const auto bytes = world_to_bytes(sim.world);
  REQUIRE(bytes);
  const auto loaded = world_from_bytes(*bytes);
  REQUIRE(loaded);
  CHECK(state_hash(*loaded) == state_hash(sim.world));
  Simulation again = Simulation::copy_of(*loaded, {scene.step, scene.substeps, 1, true});
  for (int i = 0; i < 200; ++i) sim.step(), again.step();
  CHECK(state_hash(again.world) == state_hash(sim.world));
  const auto height = [&](const char* name) {
    return sim.world.bodies[sim.world.find(name)].pose.position.y;
  };
  CHECK(height("ring") == Approx(0.1).margin(1e-3));
  CHECK(height("egg") == Approx(0.2).margin(1e-3));
}

TEST_CASE("of a surface too wild to be measured the volume is told to be doubtful", "[surfaces]") {
  const auto revolved = [](Real least_weight) {
    constexpr int kCount = 200;
    Random dice(3);
    std::string points = "[0, 0, -1]", weights = "1", knots = "0, 0, 0";
    for (int i = 1; i < kCount; ++i) {
      const Real radius = i + 1 < kCount ? dice.between(0.2, 1) : 0, share = dice.between(0, 1);
      points += ", [" + std::to_string(radius) + ", 0, " +
                std::to_string(-1 + 2.0 * i / (kCount - 1)) + "]";
      weights += ", " + std::to_string(std::pow(least_weight, share));
    }
    for (int i = 0; i < kCount - 2; ++i) knots += ", " + std::to_string(i);
    for (int i = 0; i < 3; ++i) knots += ", " + std::to_string(kCount - 3);
    return good(with_faces(R"({"type": "revolution", "profile": {"type": "nurbs", "degree": 3,
      "points": [)" + points +
                           R"(], "weights": [)" + weights + R"(], "knots": [)" + knots + "]}}"));
  };
  const auto tells = [](const Scene& scene) {
    return std::any_of(scene.warnings.begin(), scene.warnings.end(), [](const std::string& line) {
      return line.find("its volume is known only to a fraction of 0.") != line.npos;
    });
  };
  CHECK_FALSE(tells(revolved(0.5)));
  CHECK(tells(revolved(1e-6)));
}

TEST_CASE("trims of a face are read, written and read again, and follow inside_out", "[surfaces]") {
  const char* kDisc = R"({"type": "plane", "size": [2, 2], "trims": [
      {"type": "circle", "radius": 0.35, "position": [0.5, 0.5, 0]},
      {"type": "circle", "radius": 0.1, "position": [0.6, 0.5, 0]}]})";
  const Scene scene = good(with_faces(kDisc));
  const nurbs::Skin& skin = *first_shape(scene).surface->skin;
  const nurbs::Face& face = skin.face(0);
  REQUIRE(face.trim());
  CHECK(nurbs::area_of(skin) == Approx(kPi * (0.49 - 0.04)).epsilon(1e-12));
  CHECK(face.holds(0.5, 0.8));
  CHECK_FALSE(face.holds(0.6, 0.5));
  CHECK_FALSE(face.holds(0.05, 0.05));
  // A trimmed sphere is no sphere of six charts.
  const Scene cap = good(with_faces(R"({"type": "sphere", "radius": 1, "trims": [
      {"type": "outline", "points": [[0, 0.5, 0], [1, 0.5, 0], [1, 1, 0], [0, 1, 0]]}]})"));
  CHECK(nurbs::area_of(*first_shape(cap).surface->skin) == Approx(2 * kPi).epsilon(1e-9));
  const Folder folder;
  const auto once = load_surface(folder.write("disc.json", surface_text(skin)));
  REQUIRE(once);
  CHECK(surface_text(*once->surface->skin) == surface_text(skin));
  const Scene turned = good(with_faces(kDisc, R"(, "inside_out": true)"));
  const nurbs::Face& back = first_shape(turned).surface->skin->face(0);
  CHECK(back.holds(0.5, 0.8));
  CHECK_FALSE(back.holds(0.4, 0.5));
  CHECK(back.holds(0.65, 0.5));
}

TEST_CASE("a trim that cannot be one is refused in one line, at its face", "[surfaces]") {
  const auto told = [](const std::string& loop) {
    const Result<Scene> scene = parse_scene(
        with_faces(R"({"type": "plane", "size": [2, 2], "trims": [)" + loop + "]}"), "t.json");
    REQUIRE_FALSE(scene);
    REQUIRE(scene.errors().size() == 1);
    return scene.errors().front().message;
  };
  const std::string open = told(R"({"type": "line", "from": [0.2, 0.2, 0], "to": [0.8, 0.2, 0]})");
  CHECK(open.starts_with("t.json:2:"));
  CHECK(open.find("/faces/0") != std::string::npos);
  CHECK(open.find("the surface, face 0, trim 0: is open by") != std::string::npos);
  CHECK(told(R"({"type": "circle", "radius": 0.6, "position": [0.5, 0.5, 0]})")
            .find("leaves the domain at u = ") != std::string::npos);
  CHECK(told(R"({"type": "circle", "radius": 0.3, "position": [0.5, 0.5, 1]})")
            .find("off the plane of (u, v)") != std::string::npos);
  CHECK(told(R"({"type": "circle", "radius": -1})").find("/trims/0/radius") != std::string::npos);
}
