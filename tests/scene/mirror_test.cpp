// Left and right: mirror images of prefabs and of bodies with what ties them move as the mirrored
// originals do.
#include "engine/scene/build/mirror.hpp"

#include "engine/base/rotation.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/runtime/simulation.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

Real distance(Vec3 a, Vec3 b) { return glm::length(a - b); }

/// An arm of two crooked parts on a shoulder, with limits, a drive, a cable and a pin, all askew.
const std::string kArm = R"("bodies": [
{"name": "upper_left", "position": [0.3, 1, 0.1], "rotation_deg": [10, 20, 30], "angular_velocity": [1, 2, 3],
 "velocity": [0.1, 0.2, 0.3], "shapes": [{"type": "box", "size": [0.1, 0.3, 0.2]},
 {"type": "sphere", "radius": 0.1, "position": [0.1, 0.1, 0.05]}]},
{"name": "lower_left", "position": [0.5, 0.6, 0.2], "rotation_deg": [-30, 40, 5],
 "shapes": [{"type": "hull", "points": [[0, 0, 0], [0.2, 0, 0], [0, 0.3, 0], [0, 0, 0.4]]}]}],
"joints": [{"name": "elbow_left", "kind": "hinge", "a": "upper_left", "b": "lower_left",
 "anchor": [0.4, 0.8, 0.15], "axis": [1, 2, 3], "limits": {"angle_deg": [-5, 20]},
 "motor": {"velocity": 2, "gain": 0.5}}],
"cables": [{"name": "line_left", "a": "world", "b": "lower_left", "point_a": [1, 2, 0.5],
 "anchor_b": [0.1, 0, 0]}],
"pins": [{"name": "pin_left", "body": "upper_left", "kind": "spring", "anchor": [0, 0.1, 0]}])";

/// Steps a scene and checks that `right` is the image of `left` by x = `offset` all the time.
void check_images(Scene& s, const std::vector<std::pair<std::string, std::string>>& pairs,
                  Real offset) {
  Simulation sim = Simulation::copy_of(s.world, {1.0 / 240, 1, 1, true});
  // Later the articulated solver's active sets may differ by the last bit of a cable's length.
  const bool is_exact = s.world.default_settings.solver == Solver::lagrangian;
  for (int i = 0; i < (is_exact ? 240 : 40); ++i) sim.step();
  for (const auto& [left, right] : pairs) {
    CAPTURE(left, right);
    const Body &a = sim.world.bodies[sim.world.find(left)],
               &b = sim.world.bodies[sim.world.find(right)];
    const Vec3 p = a.pose.position, w = a.angular_velocity;
    CHECK(distance(b.pose.position, {2 * offset - p.x, p.y, p.z}) < 1e-7);
    CHECK(distance(b.angular_velocity, {w.x, -w.y, -w.z}) < 1e-6);
    const Quat q = a.pose.rotation, image(q.w, q.x, -q.y, -q.z);
    CHECK(std::abs(glm::dot(b.pose.rotation, image)) == Approx(1).epsilon(1e-9));
    CHECK(distance(p, {0, 0, 0}) > 0.1);
  }
}

}  // namespace

TEST_CASE("Names change sides") {
  CHECK(mirrored_name("left_arm") == "right_arm");
  CHECK(mirrored_name("RightArm/l") == "LeftArm/r");
  CHECK(mirrored_name("torso-upper_arm_l") == "torso-upper_arm_r");
  CHECK(mirrored_name("R.wheel 2") == "L.wheel 2");
  CHECK(mirrored_name("roller") == "roller");
  CHECK(mirrored_name("l2") == "l2");
}

TEST_CASE("The mirror image of an instance moves as the mirrored original does") {
  const std::string solver = GENERATE("auto", "lagrangian");
  Scene s = good(R"({"version": 1, "solver": {"type": ")" + solver +
                 R"("}, "prefabs": [{"name": "arm", )" + kArm + R"(}], "instances": [
{"name": "a", "prefab": "arm"}, {"name": "b", "prefab": "arm", "mirror": "x"}]})");
  CHECK(s.warnings.empty());
  const Joint& elbow = s.world.links[s.world.find("b/elbow_right")].joint;
  CHECK(elbow.limits->angle.low == Approx(-5 * kPi / 180));
  check_images(s, {{"a/upper_left", "b/upper_right"}, {"a/lower_left", "b/lower_right"}}, 0);
}

TEST_CASE("Bodies are mirrored with what ties them, to the world and to what stays") {
  const std::string solver = GENERATE("auto", "lagrangian");
  // The chest is symmetric, so that the whole scene is its own image.
  std::string arm = kArm;
  arm.insert(
      arm.find("{\"name\": \"upper_left\""),
      R"({"name": "chest", "position": [0.25, 1.5, 0], "motion": "fixed", "rotation_deg": [0, 25, 0]},
)");
  arm.insert(arm.find("{\"name\": \"elbow_left\""),
             R"({"name": "shoulder_left", "a": "chest", "b": "upper_left", "anchor": [0.35, 1.2, 0],
"axis": [1, 1, 0], "across": [0, 0, 1], "limits": {"twist_deg": [-10, 40], "swing_deg": [30, 50]}},
)");
  Scene s = good(R"({"version": 1, "solver": {"type": ")" + solver + R"("}, )" + arm +
                 R"(, "generators": {"mirrors": [
{"bodies": ["upper_left", "lower_left"], "axis": "x", "offset": 0.25}]}})");
  CHECK(s.warnings.empty());
  CHECK(s.world.links.size() == 4);
  CHECK(s.world.cables.size() == 2);
  CHECK(s.world.pins.size() == 2);
  CHECK(s.world.links[s.world.find("shoulder_right")].b == s.world.find("upper_right"));
  check_images(s, {{"upper_left", "upper_right"}, {"lower_left", "lower_right"}}, 0.25);
}

TEST_CASE("Travels, screws and gears keep their meaning in a mirror") {
  Scene s =
      good(R"({"version": 1, "solver": {"type": "lagrangian"}, "gravity": [0, -9.81, 2], "bodies": [
{"name": "nut_l", "mass": 1, "inertia": [1, 2, 2.5], "position": [0.5, 0, 0]},
{"name": "sledge_l", "mass": 2, "inertia": [1, 2, 2.5], "position": [1, 0, 0]},
{"name": "wheel_l", "mass": 2, "inertia": [1, 2, 2.5], "position": [2, 0, 0]}],
"joints": [
{"name": "thread_l", "kind": "screw", "pitch": 0.3, "a": "world", "b": "nut_l", "anchor": [0.5, 0, 0], "axis": [1, 1, 0]},
{"name": "rail_l", "kind": "prismatic", "a": "world", "b": "sledge_l", "anchor": [1, 0, 0], "axis": [1, 2, 0.5],
 "limits": {"travel": [-0.2, 3]}, "spring": {"stiffness": 20, "rest": 0.1}},
{"name": "axle_l", "kind": "hinge", "a": "world", "b": "wheel_l", "anchor": [2, 0.2, 0], "axis": [0, 1, 1]}],
"gears": [{"name": "rack_l", "first": "axle_l", "second": "rail_l", "ratio": 0.2}],
"generators": {"mirrors": [{"bodies": ["nut_l", "sledge_l", "wheel_l"]}]}})");
  CHECK(s.warnings.empty());
  CHECK(s.world.gears.size() == 2);
  check_images(s, {{"nut_l", "nut_r"}, {"sledge_l", "sledge_r"}, {"wheel_l", "wheel_r"}}, 0);
}

TEST_CASE("Cables over pulleys are mirrored, in scenes and in instances") {
  const std::string weights = R"("bodies": [
{"name": "heavy_l", "mass": 3, "inertia": [1, 1, 1], "position": [0.3, 0, 0], "velocity": [0.2, 0, 0]},
{"name": "light_l", "mass": 2, "inertia": [1, 1, 1], "position": [0.9, 0.2, 0]}],
"cables": [{"name": "line_l", "a": "heavy_l", "b": "light_l",
 "over": [{"body": "world", "point": [0.6, 2, 0], "radius": 0.3, "axis": [0, 0, -1]}]}])";
  const std::string head = R"({"version": 1, "solver": {"type": "lagrangian"}, )";
  Scene s = good(head + weights +
                 R"(, "generators": {"mirrors": [{"bodies": ["heavy_l", "light_l"]}]}})");
  CHECK(s.world.cables.size() == 2);
  check_images(s, {{"heavy_l", "heavy_r"}, {"light_l", "light_r"}}, 0);
  Scene t = good(head + R"("prefabs": [{"name": "w", )" + weights + R"(}], "instances": [
{"name": "a", "prefab": "w"}, {"name": "b", "prefab": "w", "mirror": "x"}]})");
  check_images(t, {{"a/heavy_l", "b/heavy_r"}, {"a/light_l", "b/light_r"}}, 0);
}

TEST_CASE("Turns of a cable on its pulley count into its length, in images too") {
  const auto length = [](const std::string& turns) {
    const Scene s = good(R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [
{"name": "heavy_l", "mass": 3, "inertia": [1, 1, 1], "position": [0.3, 0, 0]},
{"name": "light_l", "mass": 2, "inertia": [1, 1, 1], "position": [0.9, 0, 0]}],
"cables": [{"name": "line_l", "a": "heavy_l", "b": "light_l", "over": [{"body": "world",
 "point": [0.6, 2, 0], "radius": 0.3, "axis": [0, 0, -1])" +
                         turns + R"(}]}], "generators": {"mirrors": [{"bodies": ["heavy_l",
 "light_l"]}]}})");
    REQUIRE(s.world.cables.size() == 2);
    CHECK(s.world.cables.values()[0].guides[0].wrap == s.world.cables.values()[1].guides[0].wrap);
    CHECK(s.world.cables.values()[0].joint.length == s.world.cables.values()[1].joint.length);
    return s.world.cables.values()[0].joint.length;
  };
  CHECK(length("") == Approx(4 + 0.3 * kPi).epsilon(1e-14));
  CHECK(length(", \"turns\": 2") == Approx(4 + 5 * 0.3 * kPi).epsilon(1e-14));
}

TEST_CASE("Shapes are mirrored, whatever the axis") {
  const std::string axis = GENERATE("x", "y", "z");
  const int i = axis[0] - 'x';
  const Scene s = good(R"({"version": 1, "gravity": [0, 0, 0], "bodies": [
{"name": "wall left", "motion": "fixed", "rotation_deg": [10, 20, 30],
 "shapes": [{"type": "plane", "position": [1, 2, 3], "rotation_deg": [40, 0, 20]}]},
{"name": "left", "rotation_deg": [10, 20, 30], "shapes": [{"type": "hull", "position": [0, 1, 0],
 "points": [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], "rotation_deg": [5, 6, 7]}]}],
"generators": {"mirrors": [{"bodies": ["wall left", "left"], "axis": ")" +
                       axis + "\"}]}}");
  const auto placed = [&](const char* name) {
    const Entity e = s.world.find(name);
    return std::pair(compose(s.world.bodies[e].pose, s.world.shapes[e].list[0].local),
                     s.world.shapes[e].list[0]);
  };
  const auto image = [&](Vec3 v) {
    v[i] = -v[i];
    return v;
  };
  const auto [wall, plane] = placed("wall left");
  const auto [other_wall, other_plane] = placed("wall right");
  CHECK(distance(other_wall.rotation * Vec3(0, 1, 0), image(wall.rotation * Vec3(0, 1, 0))) <
        1e-12);
  CHECK(distance(other_wall.position, image(wall.position)) < 1e-12);
  const auto [at, hull] = placed("left");
  const auto [other_at, other_hull] = placed("right");
  for (const Vec3 p : hull.surface->points) {
    Real nearest = 1;
    for (const Vec3 q : other_hull.surface->points)
      nearest = std::min(nearest, distance(to_world(other_at, q), image(to_world(at, p))));
    CHECK(nearest < 1e-12);
  }
}

TEST_CASE("What has no side, no image or one already is refused by name") {
  const auto told = [](const std::string& members) {
    return diagnostics(R"({"version": 1, "bodies": [
{"name": "hat", "motion": "fixed"}, {"name": "a_l", "mass": 1}, {"name": "b_r", "mass": 1},
{"name": "b_l", "mass": 1}, {"name": "hill_l", "motion": "fixed", "shape": {"type": "height_field",
"columns": 2, "rows": 2, "spacing": 1, "heights": [0, 0, 0, 0]}}],
)" + members + "}");
  };
  CHECK(told(R"("generators": {"mirrors": [{"bodies": ["hat"]}]})") ==
        Lines{"t.json:5:39: /generators/mirrors/0/bodies: found \"hat\", expected a name with a "
              "side: \"left\" or \"right\" in it, or \"l\" or \"r\" as in \"arm_l\""});
  CHECK(told(R"("generators": {"mirrors": [{"bodies": ["b_l"]}]})") ==
        Lines{"t.json:5:39: /generators/mirrors/0/bodies: found \"b_l\", whose mirror image would "
              "be \"b_r\", expected that name to be free"});
  CHECK(told(R"("generators": {"mirrors": [{"bodies": ["a_l", "a_l"]}]})").size() == 1);
  CHECK(told(R"("generators": {"mirrors": [{"bodies": ["hill_l"]}]})") ==
        Lines{"t.json:5:39: /generators/mirrors/0/bodies: found \"hill_l\", which has a "
              "height_field, expected a body without one: it cannot be mirrored"});
  CHECK(told(R"("generators": {"mirrors": [{"bodies": ["a_x"]}]})").at(0).find("nearest") !=
        std::string::npos);
  CHECK(told(R"("joints": [{"name": "hook", "a": "hat", "b": "a_l", "anchor": [0, 0, 0]}],
"generators": {"mirrors": [{"bodies": ["a_l"]}]})") ==
        Lines{"t.json:5:21: /joints/0/name: found \"hook\", which ties bodies that are mirrored, "
              "expected a name with a side, as \"knee_left\""});
  CHECK(diagnostics(R"({"version": 1, "prefabs": [{"name": "p", "bodies": [{"name": "h",
"motion": "kinematic"}], "paths": [{"body": "h", "keyframes": [{"time": 0}]}]}],
"instances": [{"name": "i", "prefab": "p", "mirror": "x"}]})") ==
        Lines{"t.json:3:54: /instances/0/mirror: found a mirror image of \"p\", which has paths, "
              "expected a prefab without paths, which cannot be mirrored"});
}

TEST_CASE("The image of a skin is the skin on the other side, its outer side outside") {
  const Scene s = good(R"({"version": 1,
"surfaces": [{"name": "wedge", "faces": [{"type": "torus", "radius": 0.3, "tube": 0.1,
                                          "position": [0.5, 0.2, 0]}]}],
"bodies": [{"name": "arm_l", "position": [1, 0, 0],
            "shape": {"type": "nurbs", "surface": "wedge"}}],
"generators": {"mirrors": [{"bodies": ["arm_l"], "axis": "x"}]}})");
  const Entity left = s.world.find("arm_l"), right = s.world.find("arm_r");
  const Shape &one = s.world.shapes[left].list[0], &other = s.world.shapes[right].list[0];
  CHECK(s.world.bodies[right].mass == Approx(s.world.bodies[left].mass).epsilon(1e-9));
  CHECK(other.surface->low.x == Approx(-one.surface->high.x).margin(1e-9));
  CHECK(volume(other) == Approx(volume(one)).epsilon(1e-9));
}

TEST_CASE("The mirror image of a prefab with a wheel rolls the mirrored way") {
  Scene s = good(R"({"version": 1, "solver": {"type": "lagrangian"}, "prefabs": [{"name": "side",
"bodies": [{"name": "frame_left", "mass": 3, "inertia": [0.1, 0.2, 0.1], "position": [0.8, 0.15, 0.1],
  "velocity": [0.9, 0, 0.3], "angular_velocity": [0, 1.3, 0]},
 {"name": "wheel_left", "mass": 1, "inertia": [0.005, 0.005, 0.01], "position": [1, 0.15, 0.4],
  "rotation_deg": [0, 20, 0], "velocity": [0.9, 0, 0.3], "angular_velocity": [0, 1.3, -6]}],
"joints": [
 {"name": "floor_left", "kind": "planar", "a": "world", "b": "frame_left", "anchor": [0.8, 0.15, 0.1],
  "axis": [0, 1, 0]},
 {"name": "axle_left", "kind": "hinge", "a": "frame_left", "b": "wheel_left", "anchor": [1, 0.15, 0.4],
  "axis": [0.34202014, 0, 0.93969262]},
 {"name": "grip_left", "kind": "wheel", "a": "world", "b": "wheel_left", "anchor": [1, 0.15, 0.4],
  "axis": [0.34202014, 0, 0.93969262], "across": [0, 1, 0], "radius": 0.15}]}],
"instances": [{"name": "a", "prefab": "side"}, {"name": "b", "prefab": "side", "mirror": "x"}]})");
  CHECK(s.warnings.empty());
  CHECK(s.world.links[s.world.find("b/grip_right")].joint.parameters->length == 0.15);
  const Vec3 start = s.world.bodies[s.world.find("a/wheel_left")].pose.position;
  Simulation sim = Simulation::copy_of(s.world, {1.0 / 240});
  for (int i = 0; i < 240; ++i) sim.step();
  // It rolls without slip, along a bend.
  const auto slip = [&](const char* wheel, const char* joint) {
    const Body& b = sim.world.bodies[sim.world.find(wheel)];
    const Joint& j = sim.world.links[sim.world.find(joint)].joint;
    const Vec3 axle = b.pose.rotation * j.frames.b() * Vec3(1, 0, 0);
    const Vec3 along = glm::normalize(glm::cross(axle, Vec3(0, 1, 0)));
    const Vec3 foot = b.velocity + glm::cross(b.angular_velocity, Vec3(0, -0.15, 0));
    return std::max(std::abs(glm::dot(foot, along)), std::abs(glm::dot(foot, axle)));
  };
  CHECK(slip("a/wheel_left", "a/grip_left") < 1e-9);
  CHECK(slip("b/wheel_right", "b/grip_right") < 1e-9);
  const Body& left = sim.world.bodies[sim.world.find("a/wheel_left")];
  CHECK(distance(left.pose.position, start) > 0.3);
  CHECK(std::abs(left.angular_velocity.y) > 0.3);
  check_images(s, {{"a/wheel_left", "b/wheel_right"}, {"a/frame_left", "b/frame_right"}}, 0);
}
