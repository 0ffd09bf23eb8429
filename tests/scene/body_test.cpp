// What a file says of bodies, joints, strings and pins is what the World holds.
#include "engine/base/rotation.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

const Body& body_of(const Scene& s, const char* name) { return s.world.bodies[s.world.find(name)]; }

Real distance(Vec3 a, Vec3 b) { return glm::length(a - b); }

}  // namespace

TEST_CASE("The head of a scene is read, and what is absent is as documented") {
  const Scene s = good(R"({"version": 1, "title": "T", "gravity": [0, -1, 0.5], "step": 0.01,
"substeps": 3, "duration": 2, "drift_bound": 1e-6, "output": {"size": [640, 360], "fps": 30},
"solver": {"type": "shake2", "stall_drop": 0.25, "sweeps": 5, "limiter": false},
"camera": {"eye": [1, 2, 3], "target": [0, 1, 0], "field_of_view_deg": 90},
"ground": {"height": -1}, "light": {"strength": 2, "direction": [0, -2, 0]},
"materials": [{"name": "m", "colour": "#ff8000", "roughness": 0.1, "metallic": 1}]})");
  CHECK(s.title == "T");
  CHECK(s.world.gravity == Vec3(0, -1, 0.5));
  CHECK((s.step == 0.01 && s.substeps == 3 && s.duration == 2 && s.drift_bound == 1e-6));
  CHECK((s.output.width == 640 && s.output.height == 360 && s.output.fps == 30));
  CHECK(s.world.default_settings.solver == Solver::shake2);
  CHECK(s.world.default_settings.stall_drop == 0.25);
  CHECK(s.world.default_settings.sweeps == 5);
  CHECK_FALSE(s.world.default_settings.limiter);
  CHECK(s.world.default_settings.rotation_stiffness == 1);
  CHECK(s.view.camera.eye == Vec3(1, 2, 3));
  CHECK(s.view.camera.field_of_view == Approx(kPi / 2));
  CHECK_FALSE(s.view.camera.automatic);
  CHECK((s.view.ground && s.view.ground_height == -1));
  CHECK((s.view.light.strength == 2 && s.view.light.direction == Vec3(0, -1, 0)));
  REQUIRE(s.world.materials.size() == 2);
  const Material& m = s.world.materials[1];
  CHECK((m.name == "m" && m.roughness == 0.1 && m.metallic == 1));
  CHECK(m.colour.x == 1);
  CHECK(m.colour.y == Approx(0.2158605).epsilon(1e-6));
  CHECK(m.colour.z == 0);

  const Scene plain = good("{\"version\": 1, \"ground\": false}");
  CHECK(plain.title == "t");
  CHECK((plain.step == 1.0 / 60 && plain.substeps == 1 && plain.duration == 5));
  CHECK(plain.world.gravity == Vec3(0, -9.81, 0));
  CHECK((plain.view.camera.automatic && !plain.view.ground));
}

TEST_CASE("A body whose frame is its mass-centre frame keeps its numbers to the last bit") {
  const Scene s = good(with_body(R"("position": [0.1, 0.2, 0.3], "rotation": [0.5, 0.5, 0.5, 0.5],
"velocity": [1, 2, 3], "angular_velocity": [4, 5, 6], "drag": 0.7, "gravity_scale": -1,
"density": 500, "shape": {"type": "box", "size": [0.2, 0.4, 0.6]})"));
  const Body& b = body_of(s, "rod");
  CHECK(s.world.origins.empty());
  CHECK(b.pose.position == Vec3(0.1, 0.2, 0.3));
  CHECK(b.pose.rotation == Quat(0.5, 0.5, 0.5, 0.5));
  CHECK((b.velocity == Vec3(1, 2, 3) && b.angular_velocity == Vec3(4, 5, 6)));
  CHECK((b.drag == 0.7 && b.gravity_scale == -1 && b.motion == Motion::dynamic));
  CHECK(b.mass == Approx(500 * 0.2 * 0.4 * 0.6));
  CHECK(b.inertia.x == Approx(b.mass / 12 * (0.4 * 0.4 + 0.6 * 0.6)));
  CHECK(b.inertia.y == Approx(b.mass / 12 * (0.2 * 0.2 + 0.6 * 0.6)));
  CHECK(b.inertia.z == Approx(b.mass / 12 * (0.2 * 0.2 + 0.4 * 0.4)));
}

TEST_CASE("A body that is not symmetric is moved to its mass centre and principal axes") {
  // A hammer: a ball of 2 kg at the end of a rod, lying across the frame.
  const Scene s = good(R"({"version": 1, "bodies": [{"name": "hammer",
"shapes": [{"type": "sphere", "radius": 0.1, "position": [0.3, 0.4, 0], "density": 2000},
{"type": "capsule", "radius": 0.02, "length": 0.5, "rotation_deg": [0, 0, -36.8698976458440],
"density": 600}],
"position": [1, 2, 3], "rotation_deg": [0, 90, 0]}],
"joints": [{"a": "world", "b": "hammer", "anchor_b": [-0.15, -0.2, 0]}]})");
  const Entity e = s.world.find("hammer");
  const Body& b = s.world.bodies[e];
  const Real ball = 2000 * 4.0 / 3 * kPi * 1e-3;
  const Real rod = 600 * kPi * 4e-4 * (0.5 + 4.0 / 3 * 0.02);
  CHECK(b.mass == Approx(ball + rod));
  const Vec3 centre = ball / b.mass * Vec3(0.3, 0.4, 0);
  const Pose frame{{1, 2, 3}, from_rotation_vector({0, kPi / 2, 0})};
  CHECK(distance(b.pose.position, to_world(frame, centre)) < 1e-12);
  // One principal axis points along the handle, with the smallest moment.
  const Vec3 along = frame.rotation * Vec3(0.6, 0.8, 0);
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (b.inertia[i] < b.inertia[least]) least = i;
  Vec3 axis(0);
  axis[least] = 1;
  CHECK(std::abs(glm::dot(b.pose.rotation * axis, along)) == Approx(1));

  // The user's frame is where it was put; shapes and anchors are where the user meant them.
  const Pose own = s.world.origin_pose(e);
  CHECK(distance(own.position, {1, 2, 3}) < 1e-12);
  CHECK(std::abs(glm::dot(own.rotation, frame.rotation)) == Approx(1));
  const Shapes& shapes = s.world.shapes[e];
  CHECK(distance(to_world(b.pose, shapes.list[0].local.position), to_world(frame, {0.3, 0.4, 0})) <
        1e-12);
  const Link& link = s.world.links.values()[0];
  CHECK(distance(to_world(b.pose, link.joint.anchor_b), to_world(frame, {-0.15, -0.2, 0})) < 1e-12);
  CHECK(distance(link.joint.anchor_a, to_world(frame, {-0.15, -0.2, 0})) < 1e-12);
}

TEST_CASE("Mass, inertia and mass centre may be given") {
  const Scene s = good(R"({"version": 1, "bodies": [
{"name": "moments", "mass": 2, "inertia": [1, 2, 2.5]},
{"name": "tensor", "mass": 2, "inertia": [2, 2, 1, 0.5, 0, 0], "centre_of_mass": [0, 0.1, 0]},
{"name": "scaled", "mass": 3, "shape": {"type": "sphere", "radius": 0.5}},
{"name": "water", "shape": {"type": "sphere", "radius": 0.5}}]})");
  CHECK(body_of(s, "moments").inertia == Vec3(1, 2, 2.5));
  const Body& t = body_of(s, "tensor");
  CHECK(distance(t.pose.position, {0, 0.1, 0}) < 1e-15);
  const Mat3 back = world_inertia(t.pose.rotation, t.inertia);
  CHECK(back[0][0] == Approx(2));
  CHECK(back[0][1] == Approx(0.5));
  CHECK(back[2][2] == Approx(1));
  CHECK(body_of(s, "scaled").mass == 3);
  CHECK(body_of(s, "scaled").inertia.x == Approx(0.4 * 3 * 0.25));
  CHECK(body_of(s, "water").mass == Approx(1000 * 4.0 / 3 * kPi * 0.125));
}

TEST_CASE("Angles turn about the fixed x axis first, then y, then z") {
  const Scene s = good(with_body(R"("motion": "fixed", "rotation_deg": [90, 90, 0])"));
  // x stays under the first turn and goes to -z under the second; y goes to z, then to x.
  const Quat q = body_of(s, "rod").pose.rotation;
  CHECK(distance(q * Vec3(1, 0, 0), {0, 0, -1}) < 1e-15);
  CHECK(distance(q * Vec3(0, 1, 0), {1, 0, 0}) < 1e-15);
}

TEST_CASE("Joints take their anchors from a point, from one body or from both") {
  const Scene s = good(R"({"version": 1, "gravity": [0, 0, 0], "bodies": [
{"name": "a", "shape": {"type": "sphere", "radius": 0.1}, "position": [0, 1, 0]},
{"name": "b", "shape": {"type": "sphere", "radius": 0.1}, "position": [1, 1, 0],
 "rotation_deg": [0, 0, 90]},
{"name": "c", "shape": {"type": "sphere", "radius": 0.1}, "position": [2, 1, 0]},
{"name": "d", "shape": {"type": "sphere", "radius": 0.1}, "position": [3, 1, 0]}],
"joints": [{"a": "a", "b": "b", "anchor": [0.5, 1, 0]},
{"a": "b", "b": "c", "anchor_a": [0, -0.5, 0]},
{"name": "open", "a": "c", "b": "d", "anchor_a": [0.5, 0, 0], "anchor_b": [-0.25, 0, 0]}]})");
  const auto& links = s.world.links;
  CHECK(distance(links.values()[0].joint.anchor_a, {0.5, 0, 0}) < 1e-15);
  CHECK(distance(links.values()[0].joint.anchor_b, {0, 0.5, 0}) < 1e-15);
  CHECK(distance(links.values()[1].joint.anchor_b, {-0.5, 0, 0}) < 1e-15);
  CHECK(links.values()[2].joint.anchor_b == Vec3(-0.25, 0, 0));
  CHECK(s.world.name_of(links.owners()[0]) == "a-b");
  CHECK(s.world.name_of(links.owners()[2]) == "open");
  CHECK(
      s.warnings ==
      Lines{"t.json:9:1: /joints/2: joint \"open\" starts 0.25 m open; the first step closes it"});
}

TEST_CASE("What is tied to the world is tied to one fixed body without a shape") {
  const Scene s = good(with_two(R"("joints": [{"a": "world", "b": "a", "anchor": [0, 0.3, 0]},
{"a": "b", "b": "world", "anchor": [1, 0.3, 0]}])"));
  CHECK(s.world.bodies.size() == 3);
  const Entity world = s.world.find("world");
  CHECK(s.world.bodies[world].motion == Motion::fixed);
  CHECK_FALSE(s.world.shapes.find(world));
  CHECK(s.world.links.values()[0].a == world);
  CHECK(s.world.links.values()[1].b == world);
  CHECK(s.world.links.values()[1].joint.anchor_b == Vec3(1, 0.3, 0));
}

TEST_CASE("Strings are as long as told, or as the way between their ends") {
  const Scene s = good(with_two(R"("cables": [{"a": "a", "b": "b"},
{"a": "a", "b": "b", "slack": 1.5, "compliance": 0.01},
{"a": "a", "b": "b", "length": 2, "point_a": [0, 3, 0], "anchor_b": [0, 0.1, 0]}])"));
  const auto cables = s.world.cables.values();
  CHECK(cables[0].joint.length == 1);
  CHECK(cables[1].joint.length == 1.5);
  CHECK(cables[1].joint.compliance == 0.01);
  CHECK(cables[2].joint.length == 2);
  CHECK(cables[2].joint.anchor_a == Vec3(0, 3, 0));
  CHECK(cables[2].joint.anchor_b == Vec3(0, 0.1, 0));
  const auto owners = s.world.cables.owners();
  CHECK(s.world.name_of(owners[0]) == "a-b");
  CHECK(s.world.name_of(owners[1]) == "a-b#2");
}

TEST_CASE("Pins hold a point where it is unless told otherwise") {
  const Scene s = good(with_two(R"("pins": [{"body": "b"},
{"name": "hand", "body": "b", "anchor": [0, 0.1, 0], "target": [1, 1, 0], "priority": 3,
 "kind": "spring", "stiffness": 50, "damping": 3}, {"body": "a", "point": [0, 0.05, 0]}])"));
  const auto pins = s.world.pins.values();
  CHECK((pins[0].target == Vec3(1, 0, 0) && pins[0].kind == PinKind::exact));
  CHECK((pins[1].anchor == Vec3(0, 0.1, 0) && pins[1].target == Vec3(1, 1, 0)));
  CHECK((pins[1].priority == 3 && pins[1].kind == PinKind::spring && pins[1].stiffness == 50));
  CHECK((pins[0].damping == 0 && pins[1].damping == 3));
  CHECK((pins[2].anchor == Vec3(0, 0.05, 0) && pins[2].target == Vec3(0, 0.05, 0)));
}

TEST_CASE("Settings of a body change only what they name") {
  const Scene s = good(R"({"version": 1, "solver": {"sweeps": 7}, "bodies": [{"name": "a",
"mass": 1, "inertia": [1, 1, 1], "solver": {"type": "procedural", "procedural_reluctance": "literal_step"}}]})");
  const SolverSettings& own = s.world.settings[s.world.find("a")];
  CHECK((own.solver == Solver::procedural && own.sweeps == 7));
  CHECK(own.procedural_reluctance == ProceduralReluctance::literal_step);
  CHECK(own.stall_drop == SolverSettings{}.stall_drop);
}

TEST_CASE("Kinematic bodies start where their path does") {
  const Scene s = good(R"({"version": 1, "bodies": [{"name": "k", "motion": "kinematic"},
{"name": "l", "motion": "kinematic", "position": [0, 1, 0], "rotation_deg": [0, 30, 0]},
{"name": "c", "motion": "kinematic"}],
"paths": [{"body": "k", "keyframes": [{"time": 0, "position": [0, 2, 0]}, {"time": 1, "rotation_deg": [0, 0, 90]}]},
{"body": "l", "lissajous": {"amplitude": [1, 0, 0], "frequency": 1, "phase_deg": 90,
 "rotation_deg": [0, 30, 0], "rotation_phase_deg": 90}},
{"body": "c", "lissajous": {"centre": [5, 0, 0], "amplitude": [1, 0, 0], "frequency": 1, "phase_deg": 90}}]})");
  CHECK(body_of(s, "k").pose.position == Vec3(0, 2, 0));
  const KinematicPath& k = s.world.paths[s.world.find("k")];
  CHECK(distance(pose_at(k, 1).position, {0, 0, 0}) < 1e-15);
  CHECK(distance(pose_at(k, 1).rotation * Vec3(1, 0, 0), {0, 1, 0}) < 1e-12);

  CHECK(distance(body_of(s, "l").pose.position, {0, 1, 0}) < 1e-15);
  const KinematicPath& l = s.world.paths[s.world.find("l")];
  CHECK(distance(pose_at(l, 0.5).position, {-2, 1, 0}) < 1e-12);
  CHECK(glm::length(rotation_vector(pose_at(l, 0).rotation)) == Approx(kPi / 6));
  CHECK(distance(rotation_vector(pose_at(l, 0.5).rotation), {0, -kPi / 6, 0}) < 1e-12);
  CHECK(distance(body_of(s, "c").pose.position, {6, 0, 0}) < 1e-12);
}
