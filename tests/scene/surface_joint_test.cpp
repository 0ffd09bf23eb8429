// Surface joints in scene files and programs: what is made of them, and what is refused.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/geometry/shape_skin.hpp"
#include "tests/scene/scenes.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

std::string scene_of(const std::string& joint,
                     const std::string& ball = R"("type": "sphere", "radius": 0.1)",
                     const std::string& more = "") {
  return R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [
    {"name": "table", "motion": "fixed", "shape": {"type": "plane"}},
    {"name": "ball", "position": [0, 0.1, 0], "shape": {)" +
         ball + R"(}}], "surface_joints": [)" + joint + "]" + more + "}";
}
constexpr const char* kPlain = R"({"a": {"body": "ball"}, "b": {"body": "table"}})";

std::string all_errors(const std::string& text) {
  const Result<Scene> scene = parse_scene(text, "s.json");
  REQUIRE_FALSE(scene);
  std::string all;
  for (const Error& e : scene.errors()) all += e.message + "\n";
  return all;
}

}  // namespace

TEST_CASE("a surface joint of a scene file starts where the surfaces are nearest") {
  const Result<Scene> scene = parse_scene(
      scene_of(R"({"name": "c", "a": {"body": "ball"}, "b": {"body": "table"}, "motion": "rolling",
                   "unilateral": true, "on_rim": "release"})"),
      "s.json");
  REQUIRE(scene);
  const World& w = scene->world;
  REQUIRE(w.surface_contacts.size() == 1);
  const detail::SurfaceContact& c = w.surface_contacts[w.find("c")];
  CHECK(c.a == w.find("ball"));
  CHECK(c.motion == SurfaceMotion::rolling);
  CHECK(c.lifts);
  CHECK(c.on_rim == OnRim::release);
  CHECK(c.known);
  CHECK(c.on_a.skin->half_axes().has_value());
  Simulation sim = Simulation::copy_of(w, {0.01});
  REQUIRE(sim.step().status == Status::ok);
  const SurfaceTouch touch = surface_touch(sim.world, sim.world.find("c")).value();
  CHECK(touch.touches);
  CHECK(glm::length(touch.point) <= 1e-9);
  CHECK(touch.normal.y == Approx(1));
  CHECK(touch.force.y == Approx(-w.bodies[c.a].mass * 9.81));
  CHECK_FALSE(surface_touch(sim.world, sim.world.find("ball")));
}

TEST_CASE("surface joints that cannot be are refused, by name") {
  CHECK(all_errors(scene_of(R"({"a": {"body": "ball"}, "b": {"body": "ball"}})"))
            .find("expected two bodies, at least one of them dynamic") != std::string::npos);
  CHECK(all_errors(scene_of(kPlain, R"("type": "box", "size": [0.2, 0.2, 0.2])"))
            .find("/surface_joints/0/a: found no smooth shape of \"ball\"") != std::string::npos);
  CHECK(all_errors(scene_of(R"({"a": {"body": "ball"}, "b": {"body": "floor"}})"))
            .find("/surface_joints/0/b/body: found \"floor\"") != std::string::npos);
  CHECK(all_errors(scene_of(R"({"a": {"body": "ball"}, "b": {"body": "world", "surface":
            {"faces": [{"type": "plane", "size": [1, 1]}], "position": [9, 0, 0]}}})"))
            .find("m apart") != std::string::npos);
  CHECK(all_errors(scene_of(R"({"a": {"body": "ball"}, "b": {"body": "table"}, "motion": "skid"})"))
            .find("motion") != std::string::npos);
  CHECK(all_errors(scene_of(R"({"a": {"body": "ball", "position": [0, 1, 0]},
            "b": {"body": "table"}})"))
            .find("without a \"surface\"") != std::string::npos);
  CHECK(all_errors(scene_of(kPlain, R"("type": "cylinder", "radius": 0.1, "length": 0.3,
            "rotation_deg": [90, 0, 0])"))
            .find("ContactDegenerate), expected them to touch in a point; shapes with these "
                  "surfaces") != std::string::npos);
  std::string text = scene_of(kPlain);
  text.replace(text.find("lagrangian"), 10, "sweep");
  CHECK(all_errors(text).find("surface joint \"ball-table\" solved by \"sweep\"") !=
        std::string::npos);
}

TEST_CASE("a surface with a crease is refused for a joint, with its knot") {
  const std::string errors = all_errors(scene_of(
      R"({"a": {"body": "ball"}, "b": {"body": "world", "surface": {"faces": [{"type": "nurbs",
          "degrees": [1, 1], "knots_u": [0, 0, 0.5, 1, 1], "knots_v": [0, 0, 1, 1],
          "points": [[-1, 0, 1], [-1, 0, -1], [0, 0.05, 1], [0, 0.05, -1], [1, 0, 1], [1, 0, -1]]}]}}})"));
  INFO(errors);
  CHECK(errors.find("surface b, face 0") != std::string::npos);
  CHECK(errors.find("0.5") != std::string::npos);
  CHECK(errors.find("expected a smooth surface") != std::string::npos);
}

TEST_CASE("faces of a joint that meet at an angle are warned of, by their numbers and place") {
  // A ball of radius 0.1 on the left one of two plates, of which the right one rises by `rise`.
  const auto warnings = [](const std::string& rise) {
    return good(R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [
      {"name": "ball", "position": [-0.5, 0.1, 0], "shape": {"type": "sphere", "radius": 0.1}}],
      "surface_joints": [{"name": "c", "a": {"body": "ball"}, "b": {"body": "world", "surface":
      {"faces": [{"type": "nurbs", "degrees": [1, 1], "knots_u": [0, 0, 1, 1],
          "knots_v": [0, 0, 1, 1],
          "points": [[-1, 0, 1], [-1, 0, -1], [0, 0, 1], [0, 0, -1]]},
        {"type": "nurbs", "degrees": [1, 1], "knots_u": [0, 0, 1, 1], "knots_v": [0, 0, 1, 1],
          "points": [[0, 0, 1], [0, 0, -1], [1, )" +
                rise + ", 1], [1, " + rise + R"(, -1]]}]}}}]})")
        .warnings;
  };
  const Lines found = warnings("0.2");
  REQUIRE(found.size() == 1);
  INFO(found[0]);
  for (const char* part : {"t.json", "/surface_joints/0",
                           "surface b: faces 0 and 1 meet at an angle of 11.31 degrees, at u 1",
                           "a contact that reaches it is lost"})
    CHECK(found[0].find(part) != std::string::npos);
  CHECK(warnings("0").empty());
  CHECK(warnings("0.0005").empty());  // 0.03 degrees
  CHECK(warnings("0.002").size() == 1);
}

TEST_CASE("copies of a prefab have surface joints of their own") {
  const auto text = [](const std::string& instance) {
    return R"({"version": 1, "solver": {"type": "lagrangian"}, "prefabs": [{"name": "p", "bodies": [
      {"name": "ball", "position": [0, 0.1, 0], "shape": {"type": "sphere", "radius": 0.1}}],
      "surface_joints": [{"name": "c", "a": {"body": "ball"}, "b": {"body": "world", "surface":
      {"faces": [{"type": "plane", "size": [1, 1], "rotation_deg": [-90, 0, 0]}]}}}]}],
      "instances": [)" +
           instance + "]}";
  };
  const Result<Scene> scene = parse_scene(
      text(R"({"name": "i", "prefab": "p", "position": [3, 0, 0], "rotation_deg": [0, 0, 30]})"),
      "s.json");
  REQUIRE(scene);
  Simulation sim = Simulation::copy_of(scene->world, {0.01});
  REQUIRE(sim.step().status == Status::ok);
  const SurfaceTouch touch = surface_touch(sim.world, sim.world.find("i/c")).value();
  CHECK(touch.normal.x == Approx(-0.5));
  CHECK(glm::distance(touch.point, {3, 0, 0}) <= 0.01);
}

namespace {

/// A boat with a keel of its own, which has no symmetry, on a torus of the world beside it.
constexpr const char* kBoat = R"("bodies": [{"name": "boat_l", "position": [0.6, 0.33, 0.05],
    "rotation_deg": [10, 20, 5], "angular_velocity": [0.3, 0.5, -0.4],
    "mass": 2, "inertia": [0.02, 0.03, 0.04]}],
  "surface_joints": [{"name": "keel_l", "motion": "rolling", "friction": 0.3, "unilateral": true,
    "a": {"body": "boat_l", "position": [0.02, 0, 0.01], "surface": {"faces": [{"type": "ellipsoid",
      "radii": [0.2, 0.1, 0.15], "rotation_deg": [7, 0, 12]}]}},
    "b": {"body": "world", "position": [-0.6, 0, 0], "rotation_deg": [80, 0, 0], "surface": {"faces":
      [{"type": "torus", "radius": 1.2, "tube": 0.2}]}}}])";

/// Both sides of a scene, after 0.5 s.
void check_images(const std::string& text) {
  const Result<Scene> scene = parse_scene(text, "s.json");
  if (!scene)
    for (const Error& e : scene.errors()) UNSCOPED_INFO(e.message);
  REQUIRE(scene);
  Simulation sim = Simulation::copy_of(scene->world, {1.0 / 240});
  const auto named = [&](const char* side, const char* prefix) {
    return sim.world.find(std::string(prefix) + side);
  };
  const bool in_instances = static_cast<bool>(sim.world.find("one/boat_l"));
  const Entity one = in_instances ? sim.world.find("one/boat_l") : named("_l", "boat");
  const Entity two = in_instances ? sim.world.find("two/boat_r") : named("_r", "boat");
  const Entity keel = in_instances ? sim.world.find("one/keel_l") : named("_l", "keel");
  const Entity other = in_instances ? sim.world.find("two/keel_r") : named("_r", "keel");
  REQUIRE(sim.world.surface_contacts.find(other));
  bool touched = false, slipped = false;
  for (int i = 0; i < 120; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const Vec3 left = sim.world.bodies[one].pose.position,
               right = sim.world.bodies[two].pose.position;
    CHECK(glm::distance(right, {-left.x, left.y, left.z}) <= 1e-9);
    const SurfaceTouch l = surface_touch(sim.world, keel).value(),
                       r = surface_touch(sim.world, other).value();
    CHECK(l.touches == r.touches);
    // The time at which it lands or a slip ends is known to 1e-9 of a gap or speed.
    CHECK(glm::distance(r.force, {-l.force.x, l.force.y, l.force.z}) <= (i < 2 ? 1e-3 : 1e-6));
    CHECK(l.slips == r.slips);
    touched = touched || l.touches, slipped = slipped || l.slips;
  }
  CHECK(touched);
  CHECK(slipped);
}

}  // namespace

TEST_CASE("mirror images of surface joints move as the originals in a mirror") {
  check_images(std::string(R"({"version": 1, "solver": {"type": "lagrangian"}, "prefabs": [
    {"name": "p", )") +
               kBoat + R"(}], "instances": [{"name": "one", "prefab": "p"},
    {"name": "two", "prefab": "p", "mirror": "x"}]})");
  check_images(std::string(R"({"version": 1, "solver": {"type": "lagrangian"}, )") + kBoat +
               R"(, "generators": {"mirrors": [{"axis": "x", "bodies": ["boat_l"]}]}})");
}

TEST_CASE(
    "friction and contacts of a surface joint are read, and refused where they mean nothing") {
  const auto joint = [](const std::string& more) {
    return scene_of(R"({"a": {"body": "ball"}, "b": {"body": "table"}, )" + more + "}");
  };
  const auto read = [&](const std::string& more) {
    const Result<Scene> scene = parse_scene(joint(more), "s.json");
    REQUIRE(scene);
    return scene->world.surface_contacts.values()[0];
  };
  CHECK(read(R"("motion": "sliding")").friction < 0);
  CHECK(read(R"("friction": 0.25)").friction == 0.25);
  CHECK(read(R"("unilateral": true)").spots == 1);
  CHECK(read(R"("unilateral": true, "contacts": 3)").spots == 3);
  const auto refused = [&](const std::string& more, const char* what) {
    INFO(more);
    CHECK(all_errors(joint(more)).find(what) != std::string::npos);
  };
  refused(R"("friction": -0.1)", "/surface_joints/0/friction");
  refused(R"("motion": "rolling_without_spin", "friction": 1)", "/surface_joints/0/friction");
  refused(R"("contacts": 2)",
          "/surface_joints/0/contacts: found several contacts of a bilateral joint");
  refused(R"("unilateral": true, "contacts": 9)", "/surface_joints/0/contacts");
  refused(R"("unilateral": true, "contacts": 0)", "/surface_joints/0/contacts");
}

TEST_CASE("programs make bodies of NURBS faces, weighed as their solids, that touch by them") {
  // A cube by six faces of degree 1.
  NurbsShape cube;
  const auto add = [&](Vec3 corner, Vec3 u, Vec3 v) {
    NurbsShape::Face f;
    f.degree_u = f.degree_v = 1, f.knots_u = f.knots_v = {0, 0, 1, 1};
    f.points = {corner, corner + v, corner + u, corner + u + v};
    cube.faces.push_back(f);
  };
  const Real s = 0.2;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 x(0), y(0), z(0);
    x[axis] = y[(axis + 1) % 3] = z[(axis + 2) % 3] = s;
    add(-0.5 * (x + y + z), z, y), add(-0.5 * (x + y + z) + x, y, z);
  }
  World w;
  const Result<Entity> body = w.add(RigidBody{.shape = cube, .density = 500});
  if (!body)
    for (const Error& e : body.errors()) UNSCOPED_INFO(e.message);
  REQUIRE(body);
  CHECK(w.bodies[*body].mass == Approx(500 * s * s * s).epsilon(1e-9));
  CHECK(w.bodies[*body].inertia.x == Approx(500 * s * s * s * s * s / 6).epsilon(1e-9));

  const auto refused = [&](NurbsShape shape, const char* what) {
    const Result<Entity> made = w.add(RigidBody{.shape = std::move(shape), .name = "n"});
    REQUIRE_FALSE(made);
    INFO(made.errors().front().message << " " << what);
    CHECK(made.errors().front().message.find(what) != std::string::npos);
  };
  refused({}, "at least one face");
  NurbsShape bad = cube;
  bad.faces[1].points.pop_back();
  refused(bad, "face 1");
  bad = cube;
  bad.faces[2].weights = {1, 1, 1};
  refused(bad, "one for each point");
  bad = cube;
  bad.faces[3].weights = {1, 1, 0, 1};
  refused(bad, "face 3");
  bad = cube;
  bad.faces[0].knots_u = {0, 1, 0, 1};
  refused(bad, "face 0");
  bad = cube;
  bad.tolerance = -1;
  refused(bad, "shape.tolerance");

  NurbsShape floor;
  floor.faces = {{.degree_u = 1,
                  .degree_v = 1,
                  .knots_u = {0, 0, 1, 1},
                  .knots_v = {0, 0, 1, 1},
                  .points = {{-1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, {1, 0, 1}}}};
  World t;
  t.default_settings.solver = Solver::lagrangian;
  const Entity ground = t.add(RigidBody{.motion = Motion::fixed, .shape = floor}).value();
  const Entity ball =
      t.add(RigidBody{.shape = SphereShape{.radius = 0.1}, .position = {0, 0.1, 0}}).value();
  const Entity joint =
      t.add(SurfaceJoint{.a = ball, .b = ground, .may_lift = true, .friction = 0.3}).value();
  Simulation sim = Simulation::copy_of(t, {0.01});
  REQUIRE(sim.step().status == Status::ok);
  REQUIRE(surface_touches(sim.world, joint).size() == 1);
  CHECK(surface_touches(sim.world, joint)[0].force.y ==
        Approx(-9.81 * sim.world.bodies[ball].mass).epsilon(1e-9));
  CHECK_FALSE(t.add(SurfaceJoint{.a = ball, .b = ground, .friction = -1}));
  CHECK_FALSE(t.add(SurfaceJoint{.a = ball, .b = ground, .contacts = 2}));
  CHECK_FALSE(t.add(SurfaceJoint{.a = ball, .b = ground, .may_lift = true, .contacts = 9}));
  CHECK_FALSE(t.add(SurfaceJoint{
      .a = ball, .b = ground, .motion = SurfaceMotion::rolling_without_spin, .friction = 1}));
}

TEST_CASE("programs add surface joints of the bodies' shapes or of others") {
  World w;
  w.default_settings.solver = Solver::lagrangian;
  Body fixed;
  fixed.motion = Motion::fixed;
  const Entity ground = w.add_body(fixed);
  Body body;
  body.inertia = Vec3(0.004), body.pose.position = {0, 0.1, 0};
  const Entity ball = w.add_body(body);
  SurfaceJoint joint{.a = ball, .b = ground, .name = "c"};
  CHECK_FALSE(w.add(joint));
  Shape sphere, plane;
  sphere.kind = ShapeKind::sphere, sphere.size = {0.1, 0, 0};
  plane.kind = ShapeKind::plane;
  joint.surface_a = sphere, joint.surface_b = plane;
  const Result<Entity> made = w.add(joint);
  REQUIRE(made);
  CHECK(w.surface_contacts[*made].known);
  Simulation sim = Simulation::copy_of(w, {0.01});
  REQUIRE(sim.step().status == Status::ok);
  CHECK(surface_touch(sim.world, *made)->force.y == Approx(-9.81));
  w.default_settings.solver = Solver::sweep;
  CHECK_FALSE(w.add(joint));
}

TEST_CASE("shapes are smooth surfaces with their normals outwards") {
  const auto check = [](Shape shape, Vec3 near, Vec3 normal) {
    const auto skin = detail::skin_of(shape);
    REQUIRE(skin);
    Real least = 1e300;
    Vec3 found(0);
    for (const auto& face : skin->faces()) {
      const auto at = detail::nurbs::closest_point(face, near);
      if (at.distance >= least) continue;
      least = at.distance;
      const auto jet = face.at(at.u, at.v);
      found = glm::normalize(glm::cross(jet.u, jet.v));
    }
    CHECK(least <= 1e-9);
    CHECK(glm::distance(found, normal) <= 1e-6);
  };
  Shape shape;
  shape.kind = ShapeKind::sphere, shape.size = {0.3, 0, 0};
  check(shape, {0, 0, 0.3}, {0, 0, 1});
  shape.kind = ShapeKind::ellipsoid, shape.size = {0.3, 0.2, 0.1};
  check(shape, {0, -0.2, 0}, {0, -1, 0});
  shape.kind = ShapeKind::cylinder, shape.size = {0.3, 0.5, 0};
  check(shape, {0.3, 0.45, 0}, {1, 0, 0});
  check(shape, {0, -0.45, 0.3}, {0, 0, 1});
  shape.kind = ShapeKind::plane;
  check(shape, {7, 0, -3}, {0, 1, 0});
  shape.kind = ShapeKind::box;
  CHECK_FALSE(detail::skin_of(shape));
}

TEST_CASE("surfaces that may lift off and never touch in one point are warned of") {
  const auto warnings = [](const std::string& face, const std::string& more) {
    return good(R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [
      {"name": "block", "position": [0, 0.15, 0], "mass": 1, "inertia": [0.01, 0.01, 0.01]}],
      "surface_joints": [{"name": "stands", "a": {"body": "block", "surface": {"faces": [)" +
                face + R"(]}}, "b": {"body": "world", "surface": {"faces": [
        {"type": "plane", "size": [2, 2], "rotation_deg": [-90, 0, 0]}]}})" +
                more + "}]}")
        .warnings;
  };
  const char* const kLifts = R"(, "unilateral": true)";
  const Lines flat =
      warnings(R"({"type": "plane", "size": [0.2, 0.2], "rotation_deg": [90, 0, 0]})", kLifts);
  REQUIRE(flat.size() == 1);
  INFO(flat[0]);
  for (const char* part :
       {"/surface_joints/0", "surface joint \"stands\" of \"block\" and \"world\"",
        "both surfaces are flat", "shapes with these surfaces"})
    CHECK(flat[0].find(part) != std::string::npos);
  // A cylinder lies there along a line; a torus on its side touches in a point.
  const Lines line = warnings(
      R"({"type": "cylinder", "radius": 0.1, "height": 0.3, "position": [0, 0, -0.15]})", kLifts);
  REQUIRE(line.size() == 1);
  CHECK(line[0].find("the surfaces conform") != std::string::npos);
  CHECK(warnings(R"({"type": "torus", "radius": 0.1, "tube": 0.04})", kLifts).empty());
}

TEST_CASE("a run reports that a place of contact is uncertain") {
  const auto uncertain_in = [](const char* radius) {
    Scene scene = good(std::string(R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [
      {"name": "bowl", "motion": "fixed"},
      {"name": "ball", "position": [0, -)") +
                       std::to_string(0.3 - std::stod(radius)) +
                       R"(, 0], "shape": {"type": "sphere", "radius": )" + radius +
                       R"(}}], "surface_joints": [{"name": "touch", "a": {"body": "ball"}, "b":
      {"body": "bowl", "surface": {"faces": [{"type": "sphere", "radius": 0.3}],
      "inside_out": true}}, "unilateral": true}]})");
    Simulation sim = Simulation::copy_of(scene.world, {1.0 / 240});
    StepReport report;
    for (int i = 0; i < 4; ++i) report = sim.step();
    if (report.uncertain > 0) CHECK(report.uncertain_at == sim.world.find("touch"));
    return report.uncertain;
  };
  CHECK(uncertain_in("0.29999") == 1);
  CHECK(uncertain_in("0.2") == 0);
}

TEST_CASE("an uncertain place of contact is warned about") {
  const auto warnings_of = [](const std::string& text) {
    const Result<Scene> scene = parse_scene(text, "s.json");
    REQUIRE(scene);
    std::string all;
    for (const std::string& line : scene->warnings) all += line + "\n";
    return all;
  };
  const auto in_ring = [](const char* radius, const char* at) {
    return std::string(R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [
      {"name": "egg", "motion": "fixed", "position": [0, )") +
           at + R"(, 0], "shape": {"type": "ellipsoid", "radii": [0.3, 0.1, 0.2]}},
      {"name": "ring", "mass": 1, "inertia": [1, 1, 1]}], "surface_joints": [{"name": "touch",
      "a": {"body": "egg"}, "b": {"body": "ring", "surface": {"faces": [{"type": "sphere",
      "radius": )" +
           radius + R"(}], "inside_out": true}}}]})";
  };
  // Both ends of the egg are as near to the ring.
  CHECK(warnings_of(in_ring("0.31", "0"))
            .find("two pairs of points 0.62 m apart have the same gap") != std::string::npos);
  CHECK(warnings_of(scene_of(kPlain)).find("uncertain") == std::string::npos);
  const auto bowl = [](const char* radius, const char* drop) {
    return std::string(R"({"version": 1, "solver": {"type": "lagrangian"}, "bodies": [
      {"name": "bowl", "motion": "fixed"},
      {"name": "ball", "position": [0, -)") +
           drop +
           R"(, 0], "shape": {"type": "sphere", "radius": 0.1}}],
      "surface_joints": [{"name": "touch", "a": {"body": "ball"}, "b": {"body": "bowl",
      "surface": {"faces": [{"type": "revolution", "angle_deg": 140, "rotation_deg": [0, 0, -160],
      "profile": {"type": "arc", "radius": )" +
           radius + R"(, "angles_deg": [-72, 72], "rotation_deg": [90, 0, 0]}}],
      "inside_out": true}}}]})";
  };
  CHECK(warnings_of(bowl("0.10005", "0.00005")).find("nearly conform where they touch") !=
        std::string::npos);
  // Near the centre of the hollow, too, where the gap is the same all round.
  CHECK(warnings_of(bowl("0.11", "0.000005")).find("nearly conform") != std::string::npos);
  CHECK(warnings_of(bowl("0.11", "0.01")).find("nearly conform") == std::string::npos);
}
