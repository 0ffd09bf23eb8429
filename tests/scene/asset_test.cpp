// The scenes that are shipped are good scenes.
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/solver.hpp"
#include "tests/paths.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

Scene shipped(const std::string& name) {
  Result<Scene> scene = load_scene(asset("scenes/" + name + ".json"));
  if (!scene)
    for (const Error& e : scene.errors()) UNSCOPED_INFO(e.message);
  REQUIRE(bool(scene));
  return std::move(*scene);
}

nlohmann::json text_of(const std::string& name) {
  std::ifstream file(asset("scenes/" + name + ".json"));
  return nlohmann::json::parse(file);
}

}  // namespace

TEST_CASE("Every shipped scene loads, and only those with reason to warn") {
  // Out of reach; 5 t on links of half a kilogram.
  const std::set<std::string> warn{"unreachable", "wrecking_ball"};
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(asset("scenes"))) {
    if (file.is_directory()) continue;  // of references
    const std::string name = file.path().stem().string();
    CAPTURE(name);
    Scene scene = shipped(name);
    CHECK(scene.world.bodies.size() > 1);
    CHECK(scene.warnings.size() == warn.count(name));
    compile_if_changed(scene.world);
    CHECK(partition_of(scene.world).faults.empty());
    ++count;
  }
  CHECK(count >= 12);
}

TEST_CASE("Every shipped scene starts with its joints closed") {
  for (const auto& file : std::filesystem::directory_iterator(asset("scenes"))) {
    if (file.is_directory()) continue;  // of references
    const Scene scene = shipped(file.path().stem().string());
    const World& w = scene.world;
    for (const Link& l : w.links.values()) {
      if (l.joint.kind == JointKind::spring) continue;  // it closes nothing
      const Real gap =
          detail::info_of(l.joint.kind).gap(l.joint, w.bodies[l.a].pose, w.bodies[l.b].pose);
      CHECK(gap < 1e-6);
    }
  }
}

TEST_CASE(
    "The marionette has a body of fifteen parts, and strings to head, hands, knees and back") {
  const Scene s = shipped("marionette");
  int dynamic = 0;
  for (const Body& b : s.world.bodies.values()) dynamic += b.motion == Motion::dynamic;
  CHECK(dynamic == 15);
  for (const char* part : {"head_string_l", "head_string_r", "shoulder_string_l", "hand_string_r",
                           "knee_string_l", "knee_string_r", "back_string"})
    CHECK(s.world.cables.find(s.world.find(std::string("pantin/") + part)));
}

TEST_CASE("The crowd's marionette is the marionette, moved otherwise") {
  nlohmann::json one = text_of("marionette")["prefabs"][0], many = text_of("crowd")["prefabs"][0];
  one.erase("paths"), many.erase("paths");
  CHECK(one == many);
  CHECK(shipped("crowd").world.bodies.size() == 100 * shipped("marionette").world.bodies.size());
}

TEST_CASE("The ten rods are 1 m together and hang at 30 degrees") {
  const Scene s = shipped("chain10");
  const World& w = s.world;
  const Vec3 top = w.links[w.find("chain/top")].joint.anchor_a;
  const Vec3 tip = to_world(w.bodies[w.find("chain/9")].pose, {0, -0.05, 0});
  CHECK(glm::length(tip - top) == Approx(1));
  CHECK((tip - top).x == Approx(0.5));
  for (int i = 0; i < 10; ++i) {
    const Body& b = w.bodies[w.find("chain/" + std::to_string(i))];
    CHECK((b.mass == 0.1 && b.drag == 0));
    CHECK(b.inertia.z == Approx(0.1 * 0.1 * 0.1 / 12));
  }
}
