// Prefabs that stand in files of their own, and events of prefabs.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "engine/base/rotation.hpp"
#include "engine/runtime/simulation.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

namespace fs = std::filesystem;

/// A folder that goes away with the test, and the scene in it.
struct Folder {
  fs::path path;

  Folder() {
    std::string name = (fs::temp_directory_path() / "pantin-prefab-XXXXXX").string();
    REQUIRE(mkdtemp(name.data()));
    path = name;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  void write(const char* name, const std::string& text) const {
    std::ofstream(path / name, std::ios::binary) << text;
  }
  Result<Scene> load(const SceneLimits& limits = {}) const {
    return load_scene((path / "scene.json").string(), limits);
  }
  /// The lines without the folder.
  Lines shortened(Lines lines) const {
    for (std::string& line : lines)
      for (std::size_t at; (at = line.find(path.string() + "/")) != line.npos;)
        line.erase(at, path.string().size() + 1);
    return lines;
  }
  Lines errors(const SceneLimits& limits = {}) const {
    const auto scene = load(limits);
    REQUIRE_FALSE(bool(scene));
    Lines lines;
    for (const Error& e : scene.errors()) lines.push_back(e.message);
    return shortened(lines);
  }
};

const std::string kLeg = R"({"version": 1, "gravity": [0, 5, 0], "title": "A leg",
"materials": [{"name": "skin", "colour": "#ff0000"}], "collision_groups": ["prop", "puppet"],
"defaults": {"body": {"drag": 0.25}},
"classes": [{"name": "limb", "body": {"material": "skin", "collision": {"groups": ["puppet"]}}}],
"prefabs": [{"name": "foot", "bodies": [{"name": "toe", "mass": 1}]}],
"instances": [{"name": "foot", "prefab": "foot"}],
"bodies": [{"name": "shin", "class": "limb", "shape": {"type": "sphere", "radius": 0.1}}]})";

}  // namespace

TEST_CASE("A prefab may be a scene file with its own materials, classes, groups and prefabs") {
  const Folder folder;
  fs::create_directory(folder.path / "parts");
  folder.write("parts/leg.json", kLeg);
  folder.write("scene.json", R"({"version": 1, "gravity": [0, 0, 0], "collision": true,
"materials": [{"name": "skin", "colour": "#00ff00"}], "collision_groups": ["ground", "puppet"],
"prefabs": [{"name": "leg", "file": "parts/leg.json"}, {"name": "again", "file": "parts/../parts/leg.json"},
 {"name": "foot", "bodies": [{"name": "own", "mass": 1}]}],
"instances": [{"name": "a", "prefab": "leg"}, {"name": "b", "prefab": "again"}, {"name": "c", "prefab": "foot"}],
"bodies": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.1, "material": "skin"}}]})");
  const auto scene = folder.load();
  REQUIRE(bool(scene));
  const World& w = scene->world;
  CHECK(w.gravity == Vec3(0));
  for (const char* name : {"a/shin", "a/foot/toe", "b/shin", "c/own", "ball"}) {
    CAPTURE(name);
    CHECK(w.bodies.find(w.find(name)));
  }
  CHECK(w.bodies[w.find("a/shin")].drag == 0.25);
  CHECK(w.bodies[w.find("a/foot/toe")].drag == 0.25);
  CHECK(w.bodies[w.find("ball")].drag == 0);
  const auto colour = [&](const char* name) {
    return w.materials[w.shapes[w.find(name)].list[0].material].colour;
  };
  CHECK(colour("a/shin") == Vec3(1, 0, 0));
  CHECK(colour("ball") == Vec3(0, 1, 0));
  // "puppet" is one group in both files, though it has another place in them.
  CHECK(w.collisions[w.find("a/shin")].groups == 2);
  CHECK(scene->files == Lines{(folder.path / "parts/leg.json").string()});
}

TEST_CASE("Mistakes in a prefab's file are told with both files") {
  const Folder folder;
  folder.write("scene.json", R"({"version": 1,
"prefabs": [{"name": "leg", "file": "leg.json"}],
"instances": [{"name": "a", "prefab": "leg"}], "joints": [{"a": "world", "b": "a/x", "anchor": [0, 0, 0]}]})");
  folder.write("leg.json", R"({"version": 1, "bodies": [{"name": "shin", "mass": -1}]})");
  CHECK(folder.errors().at(0) ==
        "scene.json:2:37: /prefabs/0/file: found errors in \"leg.json\", expected a valid file");
  CHECK(folder.errors().back() ==
        "leg.json:1:52: /bodies/0/mass: found -1, expected a number from 1e-12 to 1e12");
  folder.write("leg.json", R"({"version": 1, "bodies": [{"name": "shin", "mass": 1}],
"joints": [{"a": "shin", "b": "shim", "anchor": [0, 0, 0]}]})");
  CHECK(
      folder.errors() ==
      Lines{"scene.json:2:37: /prefabs/0/file: found errors in \"leg.json\", expected a valid file",
            "leg.json:2:31: /joints/0/b: found \"shim\", expected the name of a body or "
            "\"world\"; nearest is \"shin\""});
  folder.write("leg.json", R"({"version": 1, )");
  CHECK(folder.errors().size() == 2);
  fs::remove(folder.path / "leg.json");
  const Lines missing = folder.errors();
  CHECK(missing.at(0).find("scene.json:2:37: /prefabs/0/file: leg.json: found no file to read") ==
        0);
  CHECK(missing.size() == 1);
  CHECK(diagnostics(R"({"version": 1, "prefabs": [{"name": "a", "file": "/dev/zero"}]})").size() ==
        1);
  CHECK(diagnostics(R"({"version": 1, "prefabs": [{"name": "a", "file": "b.json", "bodies": []}]})")
            .size() == 2);
}

TEST_CASE("Files that take themselves in are refused with the way round") {
  const Folder folder;
  folder.write("scene.json", R"({"version": 1, "prefabs": [{"name": "a", "file": "a.json"}]})");
  folder.write("a.json", R"({"version": 1, "prefabs": [{"name": "b", "file": "b.json"}]})");
  folder.write("b.json", R"({"version": 1, "prefabs": [{"name": "c", "file": "./a.json"}]})");
  CHECK(folder.errors().back() ==
        "b.json:1:50: /prefabs/0/file: found \"./a.json\", expected a file that does not include "
        "itself (a.json -> b.json -> a.json)");
  folder.write("b.json", R"({"version": 1, "prefabs": [{"name": "c", "file": "scene.json"}]})");
  CHECK(folder.errors().back().find("(scene.json -> a.json -> b.json -> scene.json)") !=
        std::string::npos);
}

TEST_CASE("All files of a scene share its limits") {
  const Folder folder;
  std::string prefabs;
  for (const char* name : {"a", "b", "c"}) {
    prefabs += std::string(prefabs.empty() ? "" : ", ") + R"({"name": ")" + name +
               R"(", "file": ")" + name + ".json\"}";
    folder.write((std::string(name) + ".json").c_str(),
                 R"({"version": 1, "title": ")" + std::string(400, 'x') + "\"}");
  }
  folder.write("scene.json", R"({"version": 1, "prefabs": [)" + prefabs + "]}");
  SceneLimits limits;
  CHECK(bool(folder.load(limits)));
  limits.bytes = 1000;
  CHECK(folder.errors(limits).at(0).find("c.json: found more than") != std::string::npos);
  limits = {};
  limits.depth = 8;
  for (int i = 0; i < 9; ++i)
    folder.write(("d" + std::to_string(i) + ".json").c_str(),
                 R"({"version": 1, "prefabs": [{"name": "n", "file": "d)" + std::to_string(i + 1) +
                     ".json\"}]}");
  folder.write("scene.json", R"({"version": 1, "prefabs": [{"name": "d", "file": "d0.json"}]})");
  CHECK(folder.errors(limits).back().find("expected files nested at most 8 deep") !=
        std::string::npos);
}

TEST_CASE("The events of a prefab happen to each copy, in its own frame") {
  Scene s = good(R"({"version": 1, "gravity": [0, 0, 0], "prefabs": [{"name": "p",
"bodies": [{"name": "ball", "mass": 2, "position": [0, 1, 0]}, {"name": "other", "mass": 1}],
"cables": [{"name": "line", "a": "ball", "b": "other"}],
"events": [{"type": "push", "body": "ball", "force": [4, 0, 0], "to": 0.5},
 {"type": "cut", "cable": "line", "at": 0}]}],
"instances": [{"name": "a", "prefab": "p"}, {"name": "b", "prefab": "p", "rotation_deg": [0, 90, 0]},
 {"name": "c", "prefab": "p", "mirror": "x"}]})");
  CHECK(s.warnings.empty());
  Simulation sim = Simulation::copy_of(s.world, {0.01, 1, 1, true});
  for (int i = 0; i < 100; ++i) sim.step();
  const auto velocity = [&](const char* name) {
    return sim.world.bodies[sim.world.find(name)].velocity;
  };
  CHECK(glm::length(velocity("a/ball") - Vec3(1, 0, 0)) < 1e-12);
  CHECK(glm::length(velocity("b/ball") - Vec3(0, 0, -1)) < 1e-12);
  CHECK(glm::length(velocity("c/ball") - Vec3(-1, 0, 0)) < 1e-12);
  CHECK(sim.world.cables.size() == 0);
}

TEST_CASE("Events of the whole scene are no prefab's, and left out of a file that is both") {
  CHECK(diagnostics(R"({"version": 1, "prefabs": [{"name": "p",
"events": [{"type": "gravity", "gravity": [0, 0, 0], "at": 1}]}]})") ==
        Lines{"t.json:2:21: /prefabs/0/events/0/type: found \"gravity\", expected an event on "
              "objects of the prefab: push, impulse, pull, cut, motor, drive or winch"});
  CHECK(diagnostics(R"({"version": 1, "prefabs": [{"name": "p",
"events": [{"type": "cut", "joint": "j", "at": 1}]}]})")
            .size() == 1);
  const Folder folder;
  folder.write("scene.json", R"({"version": 1, "prefabs": [{"name": "p", "file": "p.json"}]})");
  folder.write("p.json", R"({"version": 1, "events": [{"type": "wind", "velocity": [1, 0, 0]}]})");
  const auto scene = folder.load();
  REQUIRE(bool(scene));
  CHECK(folder.shortened(scene->warnings) ==
        Lines{"p.json:1:27: /events/0: the event \"wind\" applies to the whole scene; in a prefab "
              "it is ignored"});
}
