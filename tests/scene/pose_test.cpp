// "poses" of scene files: bodies start there, and nothing else follows from it.
#include "engine/joints/joint.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// A rod on the world, a chain, and these poses from line 9 on.
std::string scene_of(const std::string& poses) {
  return R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [
{"name": "rod", "shape": {"type": "capsule", "radius": 0.1, "length": 0.8}, "position": [1, 0, 0],
 "centre_of_mass": [0, 0.2, 0]},
{"name": "led", "motion": "kinematic", "shape": {"type": "sphere", "radius": 0.1}}],
"joints": [{"name": "pivot", "a": "world", "b": "rod", "anchor": [1, 0.5, 0]}],
"generators": {"chains": [{"name": "rope", "links": 3, "length": 0.2, "start": [2, 2, 0],
 "attach": "world", "shape": {"type": "sphere", "radius": 0.05}}]},
"paths": [{"body": "led", "keyframes": [{"time": 0, "position": [0, 0, 3]}]}], "poses": [
)" + poses +
         "]}";
}

}  // namespace

TEST_CASE("poses: bodies start there, joints stay as the bodies were placed") {
  const Scene before = good(scene_of(""));
  const Scene scene = good(scene_of(
      R"({"body": "rod", "position": [3, 4, 5], "rotation_deg": [0, 0, 90]},
{"body": "rope/2", "position": [7, 8, 9]})"));
  const World &w = scene.world, &old = before.world;
  const Entity rod = w.find("rod"), link = w.find("rope/2");
  // The own frame is there; the mass centre is 0.2 m along its y, which points along -x.
  CHECK(glm::distance(w.origin_pose(rod).position, Vec3(3, 4, 5)) < 1e-15);
  CHECK(glm::distance(w.bodies[rod].pose.position, Vec3(2.8, 4, 5)) < 1e-15);
  CHECK(w.bodies[link].pose.position == Vec3(7, 8, 9));
  CHECK(w.bodies[w.find("rope/1")].pose.position == old.bodies[old.find("rope/1")].pose.position);
  for (std::size_t i = 0; i < w.links.size(); ++i) {
    CHECK(w.links.values()[i].joint.anchor_a == old.links.values()[i].joint.anchor_a);
    CHECK(w.links.values()[i].joint.anchor_b == old.links.values()[i].joint.anchor_b);
  }
  // The pivot was closed where the rod was written; now it is open.
  const Link& pivot = w.links[w.find("pivot")];
  CHECK(glm::length(residual(pivot.joint, w.bodies[pivot.a].pose, w.bodies[pivot.b].pose)) > 1);
}

TEST_CASE("poses: what is refused says where") {
  CHECK(
      diagnostics(scene_of(R"({"body": "rad"})")) ==
      Lines{
          R"(t.json:9:10: /poses/0/body: found "rad", expected the name of a body; nearest is "rod")"});
  CHECK(
      diagnostics(scene_of(R"({"body": "led"})")) ==
      Lines{
          R"(t.json:9:10: /poses/0/body: found "led", expected a body without a path, which determines its pose)"});
  CHECK(diagnostics(scene_of(R"({"body": "rod"}, {"body": "rod"})")) ==
        Lines{R"(t.json:9:27: /poses/1/body: found "rod", expected a body without another pose)"});
  CHECK(diagnostics(scene_of(R"({"position": [0, 0, 0]})")).size() == 1);
}
