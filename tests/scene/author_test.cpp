// Ends of capsules, parents, point masses: short ways to say where things are.
#include "engine/base/rotation.hpp"
#include "engine/runtime/simulation.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

Real distance(Vec3 a, Vec3 b) { return glm::length(a - b); }

/// Complaints of a body with this shape.
Lines of_capsule(const std::string& members) {
  return diagnostics(with_body(R"("shape": {"type": "capsule", "radius": 0.1, )" + members + "}"));
}

}  // namespace

TEST_CASE("The two ends of a capsule tell its length and pose") {
  const Vec3 to = GENERATE(Vec3(1, 2, 3), Vec3(0, 4, 0), Vec3(0, -4, 0), Vec3(-2, 0, 1e-9));
  const auto text = [](Vec3 v) {
    return "[" + std::to_string(v.x) + "," + std::to_string(v.y) + "," + std::to_string(v.z) + "]";
  };
  const Scene s = good(with_body(R"("shape": {"type": "capsule", "radius": 0.1, "from": [1, 0, 0],
"to": )" + text(to + Vec3(1, 0, 0)) +
                                 "}"));
  const Entity rod = s.world.find("rod");
  const Shape& shape = s.world.shapes[rod].list[0];
  const Body& body = s.world.bodies[rod];
  CHECK(shape.size.y == Approx(glm::length(to) / 2));
  CHECK(distance(body.pose.position, Vec3(1, 0, 0) + 0.5 * to) < 1e-6);
  const Pose at = compose(body.pose, shape.local);
  CHECK(distance(to_world(at, {0, shape.size.y, 0}), to + Vec3(1, 0, 0)) < 1e-6);
  CHECK(distance(to_world(at, {0, -shape.size.y, 0}), Vec3(1, 0, 0)) < 1e-6);
}

TEST_CASE("Ends that contradict a length or a pose, or tell none, are refused") {
  CHECK(
      of_capsule(R"("from": [0, 0, 0], "to": [0, 1, 0], "length": 1)") ==
      Lines{"t.json:1:123: /bodies/0/shape/length: found \"length\" beside \"from\", expected only "
            "one of them"});
  CHECK(of_capsule(R"("from": [0, 0, 0], "to": [0, 1, 0], "position": [0, 0, 0])").size() == 1);
  CHECK(of_capsule(R"("from": [0, 0, 0], "to": [0, 1, 0], "rotation_deg": [0, 0, 0])").size() == 1);
  CHECK(
      of_capsule(R"("to": [0, 1, 0])") ==
      Lines{"t.json:1:87: /bodies/0/shape/to: found \"to\" without \"from\", expected both ends"});
  CHECK(of_capsule(R"("from": [0, 0, 0], "to": [0, 0, 0])") ==
        Lines{"t.json:1:112: /bodies/0/shape/to: found an end 0 m from the other, expected a size "
              "from 1e-9 to 1e9 m"});
  CHECK(of_capsule(R"("density": 1)") ==
        Lines{"t.json:1:52: /bodies/0/shape: found no \"length\", expected a length in m, or the "
              "ends \"from\" and \"to\""});
}

TEST_CASE("A body stands in the own frame of its parent, whatever the order in the file") {
  const Scene s = good(R"({"version": 1, "gravity": [0, 0, 0], "bodies": [
{"name": "hand", "parent": "arm", "position": [0, -1, 0], "mass": 1, "inertia": [1, 1, 1]},
{"name": "arm", "parent": "chest", "position": [2, 0, 0], "rotation_deg": [0, 0, 90],
 "shape": {"type": "sphere", "radius": 0.1, "position": [5, 0, 0]}},
{"name": "chest", "position": [0, 10, 0], "rotation_deg": [0, 90, 0], "mass": 1, "inertia": [1, 1, 1]}],
"prefabs": [{"name": "hat", "bodies": [{"name": "rim", "parent": "top", "position": [0, -1, 0],
 "mass": 1, "inertia": [1, 1, 1]}, {"name": "top", "position": [0, 3, 0], "mass": 1}]}],
"instances": [{"name": "worn", "prefab": "hat", "parent": "arm", "position": [0, -2, 0]}]})");
  const auto at = [&](const char* name) {
    return s.world.origin_pose(s.world.find(name)).position;
  };
  CHECK(distance(at("arm"), {0, 10, -2}) < 1e-12);
  CHECK(distance(at("hand"), {0, 10, -3}) < 1e-12);
  // The hat's y axis is the arm's, which points against the chest's x: 2 m down it, 3 m up again.
  CHECK(distance(at("worn/top"), {0, 10, -1}) < 1e-12);
  CHECK(distance(at("worn/rim"), {0, 10, -2}) < 1e-12);
}

TEST_CASE("Parents that are not there or go round in a circle are refused by name") {
  CHECK(diagnostics(R"({"version": 1, "bodies": [
{"name": "a", "parent": "c", "mass": 1}, {"name": "b", "parent": "a", "mass": 1},
{"name": "c", "parent": "b", "mass": 1}, {"name": "d", "parent": "c", "mass": 1}]})") ==
        Lines{"t.json:2:25: /bodies/0/parent: found \"c\", expected a parent that is not itself "
              "placed relative to this body (a -> c -> b -> a)"});
  CHECK(diagnostics(R"({"version": 1, "bodies": [
{"name": "chest", "mass": 1}, {"name": "arm", "parent": "chets", "mass": 1}]})") ==
        Lines{"t.json:2:57: /bodies/1/parent: found \"chets\", expected the name of one of the "
              "\"bodies\"; nearest is \"chest\""});
  CHECK(diagnostics(R"({"version": 1, "prefabs": [{"name": "p"}],
"instances": [{"name": "i", "prefab": "p", "parent": "q"}]})") ==
        Lines{"t.json:2:54: /instances/0/parent: found \"q\", expected the name of a body"});
}

TEST_CASE("A point mass on a cable swings as the pendulum of the textbooks does") {
  const char* tie =
      GENERATE(R"("solver": {"type": "lagrangian"}, "joints": [{"kind": "distance", )",
               R"("cables": [{)", R"("solver": {"type": "lagrangian"}, "cables": [{)");
  Scene s = good(R"({"version": 1, "step": 0.001, "bodies": [
{"name": "bob", "mass": 2, "position": [0.1, -0.99498743710662, 0]}], )" +
                 std::string(tie) + R"("a": "world", "b": "bob"}]})");
  CHECK(s.warnings.empty());
  // Half a period at an amplitude of asin(0.1).
  const Real amplitude = std::asin(0.1),
             half = kPi * std::sqrt(1 / 9.81) * (1 + amplitude * amplitude / 16);
  Simulation sim = Simulation::copy_of(s.world, {s.step, 1, 1, true});
  for (int i = 0; i < static_cast<int>(std::lround(half / s.step)); ++i) sim.step();
  CHECK(sim.world.bodies[sim.world.find("bob")].pose.position.x == Approx(-0.1).margin(2e-4));
}

TEST_CASE("What would turn a point mass is refused") {
  const auto with_bob = [](const std::string& members) {
    return diagnostics(R"({"version": 1, "bodies": [{"name": "bob", "mass": 1}],
)" + members + "}");
  };
  CHECK(
      with_bob(R"("joints": [{"a": "world", "b": "bob", "kind": "hinge", "anchor": [0, 0, 0]}])") ==
      Lines{"t.json:2:47: /joints/0/kind: found a hinge joint at the point mass \"bob\", expected "
            "a ball, a distance or a spring, or a body with a \"shape\" or an \"inertia\""});
  CHECK(with_bob(R"("joints": [{"a": "world", "b": "bob", "anchor": [0, 1, 0]}])") ==
        Lines{"t.json:2:12: /joints/0: found a point 1 m from the point mass \"bob\", expected its "
              "centre, or a body with a \"shape\" or an \"inertia\""});
  CHECK(with_bob(R"("joints": [{"a": "world", "b": "bob", "anchor": [0, 0, 0],
"limits": {"cone_deg": 20}}])")
            .size() == 1);
  CHECK(with_bob(R"("cables": [{"a": "world", "b": "bob", "anchor_b": [0, 1, 0]}])").size() == 1);
  CHECK(with_bob(R"("pins": [{"body": "bob", "anchor": [0, 1, 0]}])").size() == 1);
  CHECK(with_bob(R"("events": [{"type": "push", "body": "bob", "torque": [1, 0, 0]}])").size() ==
        1);
  CHECK(with_bob(R"("events": [{"type": "impulse", "body": "bob", "impulse": [1, 0, 0], "at": 0,
"anchor": [0, 1, 0]}])")
            .size() == 1);
  CHECK(diagnostics(with_body(R"("mass": 1, "angular_velocity": [1, 0, 0])")).size() == 1);
}
