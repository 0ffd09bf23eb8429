// What "auto" does not know it leaves to "lagrangian": as if the scene had named that, and told.
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/takeover.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

struct Beyond {
  const char* name;     // of what "auto" does not know
  const char* members;  // of the scene, besides two bodies a and b at 0 and at (1, 0, 0)
};
constexpr Beyond kBeyond[] = {
    {"gear", R"("joints": [
      {"name": "i", "kind": "hinge", "a": "world", "b": "a", "anchor": [0.2, 0.3, 0], "axis": [0, 0, 1]},
      {"name": "j", "kind": "hinge", "a": "world", "b": "b", "anchor": [1, 0.2, 0], "axis": [0, 0, 1]}],
      "gears": [{"name": "gear", "first": "i", "second": "j", "ratio": 2}])"},
    {"rod", R"("joints": [
      {"name": "i", "kind": "ball", "a": "world", "b": "a", "anchor": [0, 0.3, 0]},
      {"name": "rod", "kind": "distance", "a": "a", "b": "b", "length": 1}])"},
    {"stop", R"("joints": [
      {"name": "stop", "kind": "hinge", "a": "world", "b": "a", "anchor": [0.3, 0, 0],
       "limits": {"angle": [-0.1, 0.1], "restitution": 0.5}},
      {"name": "j", "kind": "ball", "a": "a", "b": "b", "anchor": [0.5, 0, 0]}])"},
    {"string", R"("cables": [
      {"name": "string", "a": "a", "b": "b", "over": [{"body": "world", "point": [0.5, 1, 0]}]}])"},
};

std::string scene_of(const Beyond& of, const char* solver) {
  return R"({"version": 1, "solver": {"type": ")" + std::string(solver) + R"("}, "bodies": [
    {"name": "a", "mass": 1, "inertia": [0.1, 0.1, 0.1]},
    {"name": "b", "mass": 2, "inertia": [0.1, 0.1, 0.1], "position": [1, 0, 0]}],
    )" + of.members +
         "}";
}

}  // namespace

TEST_CASE("auto leaves what it does not know to lagrangian, to the bit, and tells it") {
  const Beyond& of = GENERATE(kBeyond[0], kBeyond[1], kBeyond[2], kBeyond[3]);
  CAPTURE(of.name);
  const auto asked = parse_scene(scene_of(of, "auto"), "t.json");
  const auto named = parse_scene(scene_of(of, "lagrangian"), "t.json");
  REQUIRE(asked);
  REQUIRE(named);
  Simulation one = Simulation::copy_of(asked->world), two = Simulation::copy_of(named->world);
  Real fastest = 0;
  for (int i = 0; i < 60; ++i) {
    REQUIRE(one.step().status == Status::ok);
    REQUIRE(two.step().status == Status::ok);
    for (const Body& b : one.world.bodies.values())
      fastest = std::max(fastest, glm::length(b.velocity));
  }
  for (const Entity e : one.world.bodies.owners()) {
    const Body &a = one.world.bodies[e], &b = two.world.bodies[e];
    CHECK(a.pose.position == b.pose.position);
    CHECK(a.pose.rotation == b.pose.rotation);
  }
  CHECK(fastest > 0.1);
  const auto lines = lines_beyond_auto(one.world);
  REQUIRE(lines.size() == 1);
  CHECK(lines[0] ==
        "a (auto) is stepped by lagrangian, because of \"" + std::string(of.name) + "\"");
  CHECK(lines_beyond_auto(two.world).empty());
  CHECK(check(one.world).empty());
}

TEST_CASE("What stands on an island that auto left is stepped with it, and rests") {
  const auto scene = parse_scene(R"({"version": 1, "solver": {"type": "auto"},
    "collision": {"friction": 0.5}, "bodies": [
    {"name": "ground", "motion": "fixed", "shape": {"type": "box", "size": [4, 0.2, 4]},
     "position": [0, -0.1, 0]},
    {"name": "low", "shape": {"type": "box", "size": [0.4, 0.2, 0.4]}, "position": [0, 0.1, 0]},
    {"name": "high", "shape": {"type": "box", "size": [0.2, 0.2, 0.2]}, "position": [0, 0.3, 0]}],
    "joints": [{"name": "guide", "kind": "prismatic", "a": "world", "b": "low",
                "anchor": [0, 0.1, 0], "axis": [1, 0, 0]}]})",
                                 "t.json");
  REQUIRE(scene);
  Simulation sim = Simulation::copy_of(scene->world);
  for (int i = 0; i < 120; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(lines_beyond_auto(sim.world).size() == 1);
  CHECK(takeover_lines(sim.world).size() == 1);
  const Body& high = sim.world.bodies.values()[2];
  CHECK(glm::length(high.pose.position - Vec3(0, 0.3, 0)) < 1e-3);
}
