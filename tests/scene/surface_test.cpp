// What scene files say of surfaces: belts, rolling friction, pairs of materials.
#include "engine/contact/contact.hpp"
#include "engine/runtime/simulation.hpp"
#include "tests/paths.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// A scene of two materials, and more.
std::string with_materials(const std::string& members) {
  return R"({"version": 1, "materials": [{"name": "steel"}, {"name": "rubber"}],
)" + members +
         "}";
}

/// Complaints about what stands under "material_pairs".
Lines diagnostics_of_pairs(const std::string& pairs) {
  return diagnostics(with_materials("\"material_pairs\": [" + pairs + "]"));
}

}  // namespace

TEST_CASE("Surfaces move, resist rolling and spinning as the file says") {
  const Scene s = good(R"({"version": 1, "collision": {"rolling": 0.25}, "bodies": [
{"name": "belt", "motion": "fixed", "shape": {"type": "box", "size": [1, 1, 1]},
 "collision": {"surface_velocity": [1, 0, 2], "spinning": 0.5}},
{"name": "ball", "shape": {"type": "sphere", "radius": 0.1}}]})");
  const Collision& belt = s.world.collisions[s.world.find("belt")];
  CHECK(belt.surface_velocity == Vec3(1, 0, 2));
  CHECK((belt.rolling == 0.25 && belt.spinning == 0.5));
  const Collision& ball = s.world.collisions[s.world.find("ball")];
  CHECK((ball.rolling == 0.25 && ball.spinning == 0 && ball.surface_velocity == Vec3(0)));
}

TEST_CASE("A belt runs in the frame that its body is placed by, wherever its mass lies") {
  // Standing upright, the longest way of the hull is none of its own axes.
  const Scene s = good(R"({"version": 1, "collision": {"friction": 1}, "bodies": [
{"name": "floor", "motion": "fixed", "shape": {"type": "plane"}, "collision": {"friction": 0}},
{"name": "cart", "drag": 0, "density": 1e6, "shapes": [
  {"type": "box", "size": [4, 0.2, 1], "position": [1, 0.1, 0]},
  {"type": "box", "size": [1, 0.2, 0.4], "position": [-1.5, 0.1, 0.3]}],
 "collision": {"surface_velocity": [0, 0, 0.2], "others": true}},
{"name": "load", "drag": 0, "shape": {"type": "box", "size": [0.2, 0.2, 0.2]},
 "position": [1, 0.3, 0]}]})");
  Simulation sim(s.world, {1.0 / 60});
  for (int i = 0; i < 60; ++i) sim.step();
  const World& w = sim.world;
  const Vec3 v = w.bodies[w.find("load")].velocity;
  CHECK(glm::length(v - Vec3(0, 0, 0.2)) < 1e-3);
}

TEST_CASE("What a pair of materials says holds where their shapes touch; the rest is combined") {
  const Scene s = good(with_materials(R"("material_pairs": [
 {"a": "rubber", "b": "steel", "friction": 0.9, "rolling": 0.01},
 {"a": "steel", "b": "steel", "restitution": 0.5, "spinning": 0.02}],
"collision": {"friction": 0.25, "restitution": 0.125, "rolling": 0.001, "others": true},
"bodies": [
{"name": "plate", "motion": "fixed", "material": "steel", "shape": {"type": "box", "size": [4, 1, 4]},
 "position": [0, -0.5, 0]},
{"name": "tyre", "material": "rubber", "shape": {"type": "sphere", "radius": 0.1},
 "position": [0, 0.1, 0]},
{"name": "bearing", "material": "steel", "shape": {"type": "sphere", "radius": 0.1},
 "position": [1, 0.1, 0]},
{"name": "pebble", "shape": {"type": "sphere", "radius": 0.1}, "position": [-1, 0.1, 0]},
{"name": "mixed", "position": [0, 0, 1], "shapes": [
 {"type": "sphere", "radius": 0.1, "position": [-0.3, 0.1, 0], "material": "rubber"},
 {"type": "sphere", "radius": 0.1, "position": [0.3, 0.1, 0], "material": "steel"}]}])"));
  REQUIRE(s.world.material_pairs.size() == 2);
  Simulation sim(s.world, {1.0 / 60});
  sim.step();
  const World& w = sim.world;
  const auto contact = [&](const char* name, Real x) {
    for (const Contact& c : contacts_of(w))
      if (c.slot_a == w.bodies.slot(w.find(name)) &&
          std::abs(to_world(w.bodies.values()[c.slot_a].pose, c.point_a).x - x) < 0.1)
        return c;
    FAIL("no contact of " << name);
    return Contact{};
  };
  for (const Contact& c : {contact("tyre", 0), contact("mixed", -0.3)})
    CHECK((c.friction == 0.9 && c.restitution == 0.125 && c.rolling == 0.01 && c.spinning == 0));
  for (const Contact& c : {contact("bearing", 1), contact("mixed", 0.3)})
    CHECK((c.friction == 0.25 && c.restitution == 0.5 && c.rolling == 0.001 && c.spinning == 0.02));
  const Contact pebble = contact("pebble", -1);
  CHECK((pebble.friction == 0.25 && pebble.restitution == 0.125 && pebble.rolling == 0.001));
  CHECK(pebble.spinning == 0);
}

TEST_CASE("The conveyor carries everything off its first belt, boxes up the slope to the last") {
  const Result<Scene> scene = load_scene(asset("scenes/conveyor.json"));
  REQUIRE(scene);
  Simulation sim(scene->world, {scene->step});
  const World& w = sim.world;
  bool arrived[3] = {};
  const char* const boxes[] = {"crate", "parcel", "on_parcel"};
  for (int i = 0; i < 720; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    for (int k = 0; k < 3; ++k) {
      const Vec3 x = w.bodies[w.find(boxes[k])].pose.position;
      arrived[k] = arrived[k] || (x.x > 2.7 && x.z < -1 && x.y > 0.95);
    }
  }
  CHECK((arrived[0] && arrived[1] && arrived[2]));
  for (std::size_t i = 0; i < w.bodies.size(); ++i)
    if (const Body& b = w.bodies.values()[i]; b.motion == Motion::dynamic) {
      CHECK_FALSE((b.pose.position.x < -0.1 && b.pose.position.y > 1.6));
      CHECK(b.pose.position.y > -0.01);
    }
}

TEST_CASE("Of the two capstans one holds, the other slips") {
  const Result<Scene> scene = load_scene(asset("scenes/capstan.json"));
  REQUIRE(scene);
  Simulation sim(scene->world, {.h = scene->step, .substeps = scene->substeps});
  const auto height = [&](const char* name) {
    return sim.world.bodies[sim.world.find(name)].pose.position.y;
  };
  const Real held = height("holds_heavy"), slipped = height("slips_heavy");
  for (int i = 0; i < 84; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(std::abs(height("holds_heavy") - held) < 2e-3);
  CHECK(slipped - height("slips_heavy") > 0.2);
}

TEST_CASE("Pairs of materials that cannot be meant are refused") {
  CHECK(diagnostics_of_pairs(R"({"a": "steel", "b": "ruber", "friction": 1})") ==
        Lines{"t.json:2:40: /material_pairs/0/b: found \"ruber\", expected the name of a material; "
              "nearest is \"rubber\""});
  CHECK(diagnostics_of_pairs(R"({"a": "steel", "friction": 1})") ==
        Lines{"t.json:2:20: /material_pairs/0: found no \"b\", expected the name of a material"});
  CHECK(diagnostics_of_pairs(R"({"a": "steel", "b": "rubber"})") ==
        Lines{"t.json:2:20: /material_pairs/0: found nothing about the two, expected friction, "
              "restitution, rolling or spinning"});
  CHECK(diagnostics_of_pairs(R"({"a": "steel", "b": "rubber", "friction": 1},
{"a": "rubber", "b": "steel", "rolling": 1})") ==
        Lines{"t.json:3:1: /material_pairs/1: found a pair of the same materials again, expected "
              "one that /material_pairs/0 is not"});
  CHECK(diagnostics_of_pairs(R"({"a": "steel", "b": "steel", "friction": -1, "rolling": "much",
"restitution": 1.5, "spinning": -0.1})") ==
        Lines{"t.json:2:61: /material_pairs/0/friction: found -1, expected a number from 0 to 1e12",
              "t.json:2:76: /material_pairs/0/rolling: found \"much\", expected a number from 0 to "
              "1e12",
              "t.json:3:16: /material_pairs/0/restitution: found 1.5, expected a number from 0 to "
              "1",
              "t.json:3:33: /material_pairs/0/spinning: found -0.1, expected a number from 0 to "
              "1e12"});
}

TEST_CASE("Surfaces that cannot be meant are refused") {
  CHECK(diagnostics(R"({"version": 1,
"collision": {"rolling": -1, "spinning": true, "surface_velocity": 2}})") ==
        Lines{"t.json:2:26: /collision/rolling: found -1, expected a number from 0 to 1e12",
              "t.json:2:42: /collision/spinning: found true, expected a number from 0 to 1e12",
              "t.json:2:68: /collision/surface_velocity: found 2, expected an array of 3 numbers"});
}
