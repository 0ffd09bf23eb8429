// Chains with joints that turn only so far, rings, chains along a path, stairs.
#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

Real distance(Vec3 a, Vec3 b) { return glm::length(a - b); }

Scene with_chain(const std::string& members) {
  return good(R"({"version": 1, "gravity": [0, 0, 0], "generators": {"chains": [{"name": "c",
"shape": {"type": "capsule", "radius": 0.05, "length": 0.4}, )" +
              members + "}]}}");
}

Quat start_of(const World& w, const Link& l) {
  return relative_rotation(l.joint, w.bodies[l.a].pose.rotation, w.bodies[l.b].pose.rotation);
}

Real gap(const World& w, const Link& l) {
  return glm::length(residual(l.joint, w.bodies[l.a].pose, w.bodies[l.b].pose));
}

}  // namespace

TEST_CASE("The hinges of a straight chain start at zero about the axis it is given") {
  const Scene s = with_chain(R"("links": 4, "length": 0.5, "direction": [1, 1, 0], "kind": "hinge",
"axis": [1, 1, 2], "limits": {"angle_deg": [-30, 30]}, "drive": {"damping": 1}, "attach": "world")");
  CHECK(s.world.links.size() == 4);
  CHECK(s.world.joint_drives.size() == 4);
  for (const Link& l : s.world.links.values()) {
    CHECK((l.joint.kind == JointKind::hinge && l.joint.limits->angle.high == Approx(kPi / 6)));
    const Quat axes = s.world.bodies[l.b].pose.rotation * l.joint.frames.b();
    CHECK(distance(axes * Vec3(1, 0, 0), {0, 0, 1}) < 1e-12);
    CHECK(glm::length(rotation_vector(start_of(s.world, l))) < 1e-12);
  }
  CHECK(s.warnings.empty());
}

TEST_CASE("The balls of a chain twist about its links") {
  const Scene s = with_chain(R"("links": 3, "length": 0.5, "direction": [1, 0, 0],
"limits": {"cone_deg": 20, "twist_deg": [-5, 5]})");
  for (const Link& l : s.world.links.values()) {
    const Quat axes = s.world.bodies[l.a].pose.rotation * l.joint.frames.a();
    CHECK(distance(axes * Vec3(1, 0, 0), {1, 0, 0}) < 1e-12);
  }
}

TEST_CASE("A ring of equal links closes, bent alike at every joint") {
  const Scene s = with_chain(
      R"("links": 12, "length": 0.5, "closed": true, "direction": [0, 0, 1], "sag": [0, -1, 0],
"kind": "hinge")");
  const World& w = s.world;
  REQUIRE(w.links.size() == 12);
  CHECK(w.links[w.find("c/11-0")].joint.kind == JointKind::ball);
  for (const Link& l : w.links.values()) {
    CHECK(gap(w, l) < 1e-12);
    CHECK(l.joint.anchor_a == Vec3(0, -0.25, 0));
    if (l.joint.kind != JointKind::hinge) continue;
    const Vec3 turn = rotation_vector(start_of(w, l));
    CHECK(distance(turn, {kPi / 6, 0, 0}) < 1e-12);
  }
  CHECK(s.warnings.empty());
}

TEST_CASE("A chain along a path has links as long as its parts") {
  const Scene s = with_chain(R"("path": [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]],
"closed": true, "kind": "hinge", "mass": 1)");
  const World& w = s.world;
  REQUIRE((w.bodies.size() == 4 && w.links.size() == 4));
  for (const Link& l : w.links.values()) CHECK(gap(w, l) < 1e-12);
  CHECK(distance(w.bodies[w.find("c/1")].pose.position, {1, 1, 0}) < 1e-15);
  CHECK(w.links[w.find("c/0-1")].joint.anchor_a == Vec3(0, -0.5, 0));
  CHECK(w.links[w.find("c/0-1")].joint.anchor_b == Vec3(0, 1, 0));
  CHECK(distance(rotation_vector(start_of(w, w.links[w.find("c/2-3")])), {kPi / 2, 0, 0}) < 1e-12);
  CHECK(s.warnings.empty());
  const Scene open = with_chain(R"("path": [[0, 0, 0], [1, 0, 0], [1, 2, 0]], "attach": "world")");
  CHECK((open.world.links.size() == 2 && open.warnings.empty()));
}

TEST_CASE("Stairs are a fixed body of a solid box a step") {
  const Scene s =
      good(R"({"version": 1, "materials": [{"name": "stone"}], "generators": {"stairs": [
{"name": "up", "count": 3, "width": 2, "rise": 0.25, "run": 0.5, "position": [1, 0, 0],
 "material": "stone", "collision": {"friction": 0.75}},
{"name": "drawn", "count": 1, "width": 2, "rise": 0.25, "run": 0.5, "collision": false}]}})");
  const World& w = s.world;
  const Entity up = w.find("up");
  CHECK(w.bodies[up].motion == Motion::fixed);
  CHECK(w.collisions[up].friction == 0.75);
  CHECK_FALSE(w.collisions.find(w.find("drawn")));
  const auto& steps = w.shapes[up].list;
  REQUIRE(steps.size() == 3);
  CHECK(steps[2].material == 1);
  CHECK(steps[2].size == Vec3(0.25, 0.375, 1));
  CHECK(w.bodies[up].pose.position == Vec3(1, 0, 0));
  CHECK(steps[2].local.position == Vec3(1.25, 0.375, 0));
}
