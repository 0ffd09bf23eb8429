// Prefabs, grids and chains are written out as if by hand.
#include <chrono>
#include <fstream>
#include <sstream>

#include "engine/base/rotation.hpp"
#include "tests/paths.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

Real distance(Vec3 a, Vec3 b) { return glm::length(a - b); }

/// An arm that hangs from the world, with a kinematic handle, a string and a pin.
const std::string kArmPrefab = R"({"version": 1, "prefabs": [{"name": "arm", "bodies": [
{"name": "upper", "shape": {"type": "sphere", "radius": 0.1}, "position": [0, 1, 0], "velocity": [1, 0, 0]},
{"name": "lower", "shape": {"type": "sphere", "radius": 0.1}, "position": [0.5, 1, 0]},
{"name": "handle", "motion": "kinematic", "position": [0.5, 2, 0]}],
"joints": [{"a": "world", "b": "upper", "anchor": [0, 1.2, 0]},
{"name": "elbow", "a": "upper", "b": "lower", "anchor": [0.25, 1, 0]}],
"cables": [{"name": "line", "a": "handle", "b": "lower"}],
"pins": [{"name": "nail", "body": "lower", "kind": "spring"}],
"paths": [{"body": "handle", "lissajous": {"amplitude": [1, 0, 0], "frequency": 0.25, "rise": 1}}]}]
)";

}  // namespace

TEST_CASE("An instance carries everything of its prefab along") {
  const Scene s = good(kArmPrefab + R"(, "instances": [{"name": "left", "prefab": "arm",
"position": [0, 0, 5], "rotation_deg": [0, 90, 0]}]})");
  const World& w = s.world;
  CHECK(w.bodies.size() == 4);  // three and the world's own
  const Body& upper = w.bodies[w.find("left/upper")];
  const Body& lower = w.bodies[w.find("left/lower")];
  CHECK(distance(upper.pose.position, {0, 1, 5}) < 1e-15);
  CHECK(distance(lower.pose.position, {0, 1, 4.5}) < 1e-15);
  CHECK(distance(upper.velocity, {0, 0, -1}) < 1e-15);
  const Link& hook = w.links.values()[0];
  CHECK(hook.a == w.find("world"));
  CHECK(distance(hook.joint.anchor_a, {0, 1.2, 5}) < 1e-15);
  CHECK(w.name_of(w.links.owners()[0]) == "left/world-upper");
  const Link& elbow = w.links[w.find("left/elbow")];
  CHECK(glm::length(residual(elbow.joint, upper.pose, lower.pose)) < 1e-15);
  CHECK(distance(w.pins.values()[0].target, {0, 1, 4.5}) < 1e-15);
  const KinematicPath& drive = w.paths[w.find("left/handle")];
  CHECK(distance(pose_at(drive, 0).position, {0, 2, 4.5}) < 1e-15);
  CHECK(distance(pose_at(drive, 5).position, {0, 2, 3.5}) < 1e-12);  // x of the arm is -z here
  CHECK(s.warnings.empty());
}

TEST_CASE("An instance without a turn keeps rotations and anchors to the last bit") {
  const Scene a = good(kArmPrefab + R"(, "instances": [{"name": "i", "prefab": "arm"}]})");
  const Scene b = good(
      kArmPrefab + R"(, "instances": [{"name": "i", "prefab": "arm", "position": [3, 0, 0]}]})");
  const Link &x = a.world.links.values()[1], &y = b.world.links.values()[1];
  CHECK(x.joint.anchor_a == y.joint.anchor_a);
  CHECK(x.joint.anchor_b == y.joint.anchor_b);
}

TEST_CASE("Parts of an instance can be tied to, and its solver chosen") {
  const Solver solver = GENERATE(Solver::lagrangian, Solver::sweep);
  std::string prefab = kArmPrefab;
  if (solver == Solver::sweep) {  // which knows neither cables nor springs
    const std::size_t ties = prefab.find("\"cables\"");
    prefab.erase(ties, prefab.find("\"paths\"") - ties);
  }
  const Scene s = good(prefab + R"(, "instances": [
{"name": "i", "prefab": "arm", "solver": {"type": ")" +
                       name_of(solver) + R"("}}],
"bodies": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.1}, "position": [1, 1, 0]}],
"joints": [{"a": "i/lower", "b": "ball", "anchor": [0.75, 1, 0]}]})");
  const World& w = s.world;
  const Link& link = w.links[w.find("i/lower-ball")];
  CHECK(link.a == w.find("i/lower"));
  CHECK(link.joint.anchor_a == Vec3(0.25, 0, 0));
  CHECK(w.settings[w.find("i/upper")].solver == solver);
  CHECK_FALSE(w.settings.find(w.find("ball")));
}

TEST_CASE("Prefabs nest") {
  const Scene s = good(R"({"version": 1, "prefabs": [
{"name": "outer", "instances": [{"name": "in", "prefab": "inner", "position": [1, 0, 0]}],
 "joints": [{"a": "world", "b": "in/ball", "anchor": [1, 0, 0]}]},
{"name": "inner", "bodies": [{"name": "ball", "shape": {"type": "sphere", "radius": 1}}]}],
"instances": [{"name": "out", "prefab": "outer", "position": [0, 2, 0], "rotation_deg": [0, 0, 90]}]})");
  CHECK(distance(s.world.bodies[s.world.find("out/in/ball")].pose.position, {0, 3, 0}) < 1e-15);
  CHECK(distance(s.world.links.values()[0].joint.anchor_a, {0, 3, 0}) < 1e-15);
}

TEST_CASE("A grid lies about its middle, and each copy's drives run ahead of the one before") {
  const Scene s = good(kArmPrefab + R"(, "generators": {"grids": [{"name": "g", "prefab": "arm",
"count": [3, 1, 2], "spacing": [2, 1, 4], "position": [10, 0, 0], "time_offset": 0.5}]}})");
  const World& w = s.world;
  CHECK(w.bodies.size() == 3 * 6 + 1);
  CHECK(distance(w.bodies[w.find("g/0/upper")].pose.position, {8, 1, -2}) < 1e-15);
  CHECK(distance(w.bodies[w.find("g/2/upper")].pose.position, {12, 1, -2}) < 1e-15);
  CHECK(distance(w.bodies[w.find("g/3/upper")].pose.position, {8, 1, 2}) < 1e-15);
  const KinematicPath &first = w.paths[w.find("g/0/handle")],
                      &third = w.paths[w.find("g/2/handle")];
  const Vec3 sway = pose_at(first, 4).position - pose_at(first, 0).position;
  CHECK(distance(pose_at(third, 3).position - pose_at(third, 0).position, sway) < 1e-12);
  // All start from rest in the prefab's own pose.
  CHECK(distance(w.bodies[w.find("g/2/handle")].pose.position, {12.5, 2, -2}) < 1e-15);
  CHECK(s.warnings.empty());
}

TEST_CASE("A chain is links of one kind, jointed end to end") {
  const Scene s = good(R"({"version": 1, "materials": [{"name": "m"}, {"name": "n"}],
"generators": {"chains": [{"name": "c", "links": 3, "length": 0.5, "start": [0, 2, 0],
"direction": [2, 0, 0], "mass": 2, "inertia": [0.2, 0.1, 0.2], "mass_ratio": 3, "tip_mass_factor": 2,
"materials": ["m", "n"], "shape": {"type": "capsule", "radius": 0.05, "length": 0.4},
"attach": "world", "drag": 0.1, "angular_velocity": [0, 0, 2], "velocity": [0, 1, 0]}]}})");
  const World& w = s.world;
  REQUIRE(w.bodies.size() == 4);
  for (int i = 0; i < 3; ++i) {
    const Body& b = w.bodies[w.find("c/" + std::to_string(i))];
    CHECK(distance(b.pose.position, {0.25 + 0.5 * i, 2, 0}) < 1e-15);
    CHECK(distance(b.pose.rotation * Vec3(0, -1, 0), {1, 0, 0}) < 1e-15);
    CHECK(distance(b.velocity, {0, 1 + 2 * (b.pose.position.x - 0.75), 0}) < 1e-14);
    CHECK(b.drag == 0.1);
    CHECK(w.shapes[w.find("c/" + std::to_string(i))].list[0].material == (i == 1 ? 2u : 1u));
  }
  CHECK(w.bodies[w.find("c/0")].mass == 2);
  CHECK(w.bodies[w.find("c/1")].mass == 6);
  CHECK(w.bodies[w.find("c/2")].mass == 36);
  CHECK(w.bodies[w.find("c/2")].inertia.x == Approx(0.2 * 18));
  CHECK(w.links.size() == 3);
  for (const Link& l : w.links.values())
    CHECK(glm::length(residual(l.joint, w.bodies[l.a].pose, w.bodies[l.b].pose)) < 1e-15);
  CHECK(w.links[w.find("c/1-2")].joint.anchor_a == Vec3(0, -0.25, 0));
}

TEST_CASE("A chain between two points lies on an arc of equal links") {
  const Scene s = good(R"({"version": 1, "generators": {"chains": [{"name": "c", "links": 7,
"length": 0.5, "start": [-1, 2, 0], "end": [1, 2, 0.5], "sag": [0, -1, 0],
"shape": {"type": "capsule", "radius": 0.05, "length": 0.4},
"attach": "world", "end_attach": "world"}]}})");
  const World& w = s.world;
  CHECK(s.warnings.empty());
  for (const Link& l : w.links.values())
    CHECK(glm::length(residual(l.joint, w.bodies[l.a].pose, w.bodies[l.b].pose)) < 1e-12);
  CHECK(distance(w.links[w.find("c/top")].joint.anchor_a, {-1, 2, 0}) < 1e-15);
  CHECK(distance(w.links[w.find("c/end")].joint.anchor_a, {1, 2, 0.5}) < 1e-12);
  CHECK(w.bodies[w.find("c/3")].pose.position.y < 1.2);
}

TEST_CASE("A thousand marionettes are loaded in less than a second", "[timed]") {
  std::ifstream file(asset("scenes/crowd.json"));
  std::stringstream all;
  all << file.rdbuf();
  std::string text = all.str();
  const std::string count = "\"count\": [10, 1, 10]";
  const std::size_t at = text.find(count);
  REQUIRE(at != std::string::npos);
  text.replace(at, count.size(), "\"count\": [40, 1, 25]");
  const auto start = std::chrono::steady_clock::now();
  const Scene s = good(text);
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  CHECK(s.world.bodies.size() == 19'000);
  CHECK(passed.count() < 1);
}
