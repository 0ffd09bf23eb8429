// Design variables beyond joints and cables: gears, belts, control points and weights.
#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/nurbs/net.hpp"
#include "engine/scene/scene.hpp"
#include "engine/world/belt.hpp"
#include "tests/assembly/mechanisms.hpp"
#include "tests/assembly/slopes.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

World world_of(const std::string& text) {
  auto scene = parse_scene(text, "test.json");
  for (const Error& e : scene ? std::vector<Error>{} : scene.errors()) FAIL(e.message);
  return std::move(scene->world);
}

/// Rotates a body about a point of the world and z.
void rotate(World& w, const char* name, Vec3 about, Real angle) {
  Pose& pose = w.bodies[w.find(name)].pose;
  const Quat by = from_rotation_vector({0, 0, angle});
  pose = {about + by * (pose.position - about), by * pose.rotation};
}

/// Keeps a wheel at its present angle by a rod to the ground.
void hold(World& w, const char* name, Vec3 far) {
  const Entity body = w.find(name);
  const Vec3 at(0.1, 0, 0);
  add_rod(w, body, at, w.find("frame"), far, glm::distance(to_world(w.bodies[body].pose, at), far),
          "rod");
}

constexpr const char* kWheels = R"({"version": 1, "gravity": [0, 0, 0],
  "solver": {"type": "lagrangian"}, "bodies": [
    {"name": "frame", "motion": "fixed"},
    {"name": "a", "position": [0, 0, 0], "mass": 1, "inertia": [0.1, 0.1, 0.1]},
    {"name": "b", "position": [1, 0, 0], "mass": 1, "inertia": [0.1, 0.1, 0.1]}],
  "joints": [
    {"name": "A", "kind": "hinge", "a": "frame", "b": "a", "anchor": [0, 0, 0], "axis": [0, 0, 1]},
    {"name": "B", "kind": "hinge", "a": "frame", "b": "b", "anchor": [1, 0, 0], "axis": [0, 0, 1]}],
  %s})";

std::string wheels_with(const std::string& more) {
  std::string text = kWheels;
  return text.replace(text.find("%s"), 2, more);
}

AssemblyReport assemble_with(World& w, const DesignVariable& free) {
  AssemblyChoices choices;
  choices.free = {free};
  return assemble(w, choices);
}

/// A patch of 4 by 4 control points over a square of 1 m, hilly; a ball of radius 0.05 m in contact
/// with it at (u, v), held there by a fixed joint.
struct Hill {
  World world;
  Entity contact;

  explicit Hill(std::uint64_t seed, const char* motion = "sliding") {
    Random random(seed);
    std::string points, weights;
    for (int i = 0; i < 16; ++i) {
      const Real height = 0.05 * random.signed_unit();
      points += (i ? ", [" : "[") + std::to_string(i / 4 / 3.0 - 0.5) + ", " +
                std::to_string(i % 4 / 3.0 - 0.5) + ", " + std::to_string(height) + "]";
      weights += (i ? ", " : "") + std::to_string(1.2 + 0.5 * random.signed_unit());
    }
    world = world_of(R"({"version": 1, "gravity": [0, 0, 0], "solver": {"type": "lagrangian"},
      "surfaces": [{"name": "hill", "faces": [{"type": "nurbs", "degrees": [3, 3],
        "knots_u": [0, 0, 0, 0, 1, 1, 1, 1], "knots_v": [0, 0, 0, 0, 1, 1, 1, 1], "points": [)" +
                     points + "], \"weights\": [" + weights + R"(]}]}],
      "bodies": [{"name": "frame", "motion": "fixed", "position": [0.1, 0.2, 0.3],
                  "rotation_deg": [10, 20, 30]},
                 {"name": "ball", "position": [0.12, 0.18, 0.36],
                  "shape": {"type": "sphere", "radius": 0.05}}],
      "surface_joints": [{"name": "touch", "a": {"body": "ball"},
        "b": {"body": "frame", "surface": "hill"}, "motion": ")" +
                     motion + "\"}]}");
    contact = world.find("touch");
    const ContactSurface& on = world.surface_contacts[contact].on_b;
    const Real u = 0.35 + 0.1 * random.signed_unit(), v = 0.55 + 0.1 * random.signed_unit();
    const nurbs::Jet jet = on.skin->face(0).at(u, v);
    const Pose frame = compose(world.bodies[world.find("frame")].pose, on.pose);
    const Vec3 normal = glm::normalize(glm::cross(jet.u, jet.v));
    Pose& ball = world.bodies[world.find("ball")].pose;
    ball.position = to_world(frame, jet.s + 0.05 * normal);
    join(world, {world.find("frame"), world.find("ball"), JointKind::fixed, ball.position}, "held");
  }
  DesignVariable of(Quantity q, std::uint32_t point) const { return {contact, q, point}; }
};

constexpr const char* kCam = R"({"version": 1, "gravity": [0, 0, 0],
  "solver": {"type": "lagrangian"},
  "curves": [{"name": "cam", "type": "nurbs", "degree": 2,
    "knots": [0, 0, 0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1, 1, 1],
    "points": [[1, 0, 0], [1, 1, 0], [0, 1, 0], [-1, 1, 0], [-1, 0, 0],
               [-1, -1, 0], [0, -1, 0], [1, -1, 0], [1, 0, 0]],
    "weights": [1, 0.7071067811865476, 1, 0.7071067811865476, 1, 0.7071067811865476, 1,
                0.7071067811865476, 1]}],
  "bodies": [{"name": "frame", "motion": "fixed"},
    {"name": "wheel", "position": [1.51, 0.2, 0], "mass": 1, "inertia": [0.1, 0.1, 0.1]}],
  "surface_joints": [{"name": "touch", "motion": "%s",
    "a": {"body": "wheel", "curve": {"type": "circle", "radius": 0.5}},
    "b": {"body": "frame", "curve": "cam"}}]})";

std::string cam_with(const char* motion) {
  std::string text = kCam;
  return text.replace(text.find("%s"), 2, motion);
}

}  // namespace

TEST_CASE("design: a gear gets the ratio between two held angles") {
  const Vec3 a(0), b(1, 0, 0);
  World w = world_of(wheels_with(
      R"("gears": [{"name": "gear", "first": "A", "second": "B", "ratio": 2, "offset": 0.1}])"));
  rotate(w, "a", a, 0.5), rotate(w, "b", b, 0.85);
  hold(w, "a", {0, 3, 0}), hold(w, "b", {1, 3, 0});
  const DesignVariable ratio{w.find("gear"), Quantity::ratio};
  CHECK(error_of_slopes(w, ratio) < 1e-9);
  World stays = w;
  CHECK_FALSE(assemble(stays, AssemblyChoices{}).assembled);
  REQUIRE(assemble_with(w, ratio).assembled);
  CHECK(std::abs(w.gears.values()[0].ratio - (0.85 - 0.1) / 0.5) < 1e-11);
  // Bounds hold for a ratio, too.
  DesignVariable bounded = ratio;
  bounded.least = 1.9, bounded.most = 2.05;
  CHECK_FALSE(assemble_with(stays, bounded).assembled);
  CHECK(stays.gears.values()[0].ratio >= bounded.least);
  CHECK(stays.gears.values()[0].ratio <= bounded.most);
}

TEST_CASE("design: a gear without an offset has no free ratio") {
  const World w = world_of(
      wheels_with(R"("gears": [{"name": "gear", "first": "A", "second": "B", "ratio": 2}])"));
  CHECK(fault_of(w, {w.find("gear"), Quantity::ratio}).find("\"offset\"") !=
        std::string_view::npos);
  CHECK_FALSE(fault_of(w, {w.find("gear"), Quantity::length}).empty());
}

TEST_CASE("design: pulleys of a belt get the radii between two held angles") {
  // A belt that does not slip: R_a q_a = R_b q_b, or with crossed spans R_a q_a = -R_b q_b.
  for (const bool crossed : {false, true})
    for (const std::uint32_t pulley : {0u, 1u}) {
      World w = world_of(wheels_with(
          R"("belts": [{"name": "belt", "pulleys": [{"body": "a", "radius": 0.2},
             {"body": "b", "radius": 0.1}], "crossed": )" +
          std::string(crossed ? "true" : "false") + "}]"));
      const Real q_a = 0.3, q_b = (crossed ? -1 : 1) * 0.66;
      rotate(w, "a", Vec3(0), q_a), rotate(w, "b", {1, 0, 0}, q_b);
      hold(w, "a", {0, 3, 0}), hold(w, "b", {1, 3, 0});
      const DesignVariable radius{w.find("belt"), Quantity::radius, pulley};
      CHECK(error_of_slopes(w, radius) < 1e-8);
      World stays = w;
      CHECK_FALSE(assemble(stays, AssemblyChoices{}).assembled);
      REQUIRE(assemble_with(w, radius).assembled);
      const std::vector<BeltPulley>& p = w.belts.values()[0].pulleys;
      CHECK(std::abs(p[0].outline.radius * q_a - std::abs(p[1].outline.radius * q_b)) < 1e-11);
      CHECK(p[1 - pulley].outline.radius == (pulley == 0 ? 0.1 : 0.2));
    }
}

TEST_CASE("design: radii of a belt do not grow until its pulleys overlap") {
  for (const bool both : {false, true}) {
    World w = world_of(wheels_with(R"("belts": [{"name": "belt", "pulleys":
        [{"body": "a", "radius": 0.2}, {"body": "b", "radius": 0.1}]}])"));
    // R_b would have to be 1.2 m beside a pulley 1 m away.
    rotate(w, "a", Vec3(0), 0.9), rotate(w, "b", {1, 0, 0}, 0.15);
    for (const Vec3 far : {Vec3(0, 3, 0), Vec3(3, -1, 0)}) hold(w, "a", far), hold(w, "b", far);
    AssemblyChoices choices;
    choices.free = {{w.find("belt"), Quantity::radius, 1}};
    if (both) choices.free.push_back({w.find("belt"), Quantity::radius, 0});
    const bool is_assembled = assemble(w, choices).assembled;
    const std::vector<BeltPulley>& p = w.belts.values()[0].pulleys;
    const Real sum = p[0].outline.radius + p[1].outline.radius;
    CHECK(sum <= 1 + 1e-12);
    if (!both) CHECK_FALSE(is_assembled);
    if (!both) CHECK(sum > 0.9);  // as far as it may
    if (is_assembled)
      CHECK(std::abs(p[0].outline.radius * 0.9 - p[1].outline.radius * 0.15) < 1e-11);
  }
}

TEST_CASE("design: slopes of control points and weights are those of the gap") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Hill hill(seed);
    for (const std::uint32_t point : {5u, 6u, 9u, 0u}) {
      // Far from a point its basis function is small.
      const SlopeTest shares{point == 0 ? 1e-5 : 0.03}, weights{1e-6};
      CHECK(error_of_slopes(hill.world, hill.of(Quantity::point_b, point), shares) < 1e-8);
      CHECK(error_of_slopes(hill.world, hill.of(Quantity::weight_b, point), weights) < 1e-8);
    }
  }
  // A closed curve near its ends, which are one point.
  World w = world_of(cam_with("sliding"));
  for (const std::uint32_t point : {0u, 1u})
    CHECK(error_of_slopes(w, {w.find("touch"), Quantity::point_b, point}, {0.03, 0.1, true}) <
          1e-8);
  CHECK(error_of_slopes(w, {w.find("touch"), Quantity::weight_b, 1}, {0.01, 0.1}) < 1e-8);
}

TEST_CASE("design: a weight that was altered comes back, a control point closes the gap") {
  int assembled = 0, back = 0, closed = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Hill hill(seed);
    const std::uint32_t point = std::array{5u, 6u, 9u, 10u}[seed % 4];
    const DesignVariable weight = hill.of(Quantity::weight_b, point);
    const Real fit = value_of(hill.world, weight).numbers.x;
    World w = hill.world;
    set_value(w, weight, {Vec3(fit * (seed % 2 ? 1.02 : 0.98), 0, 0)});
    World stays = w;
    assembled += assemble(stays, AssemblyChoices{}).assembled;
    CHECK(assemble_with(w, weight).assembled);
    // The gap determines a weight to its tolerance by the slope.
    back += std::abs(value_of(w, weight).numbers.x - fit) < 1e-8;

    const DesignVariable net = hill.of(Quantity::point_b, point);
    const Vec3 from = value_of(hill.world, net).numbers;
    w = hill.world;
    const Vec3 off(0.01, -0.01, 0.02);
    set_value(w, net, {from + off});
    const AssemblyReport r = assemble_with(w, net);
    // The least change is not larger than the way back.
    closed += r.assembled && r.residual < 1e-9 &&
              glm::distance(value_of(w, net).numbers, from + off) <= glm::length(off) + 1e-9;
  }
  CHECK(assembled == 0);
  CHECK(back == 20);
  CHECK(closed == 20);
}

TEST_CASE(
    "design: control points of surfaces that roll are free, of curves that roll they are not") {
  const Hill hill(3, "rolling");
  const DesignVariable net = hill.of(Quantity::point_b, 5);
  CHECK(fault_of(hill.world, net).empty());
  World w = hill.world;
  set_value(w, net, {value_of(w, net).numbers + Vec3(0, 0, 0.02)});
  CHECK(assemble_with(w, net).assembled);
  const World rolls = world_of(cam_with("rolling"));
  const DesignVariable point{rolls.find("touch"), Quantity::point_b, 1};
  CHECK(fault_of(rolls, point).find("a curve that slides") != std::string_view::npos);
  // The ball of the hill is an ellipsoid by charts.
  CHECK_FALSE(fault_of(hill.world, hill.of(Quantity::point_a, 0)).empty());
  CHECK_FALSE(fault_of(hill.world, hill.of(Quantity::point_b, 16)).empty());
}

TEST_CASE("nurbs: shares of control points sum to 1, and are derivatives of the point") {
  const Hill hill(7);
  const nurbs::Surface face =
      hill.world.surface_contacts[hill.contact].on_b.skin->face(0).surface();
  const std::array<Real, 2> at = {0.3, 0.8};
  Real sum = 0;
  for (std::uint32_t i = 0; i < 16; ++i) {
    const auto images = nurbs::images_of(face, i);
    CHECK(images == std::vector<std::uint32_t>{i});
    const Real share = nurbs::share_of(face, images, at);
    sum += share;
    const nurbs::Weighted w = face.points[i];
    const Vec3 by(0.1, 0.2, -0.3);
    const nurbs::Surface moved =
        nurbs::with_point(face, images, nurbs::Weighted(w.point() + by, w.w));
    const Vec3 change = nurbs::evaluate(moved, at[0], at[1], 0)[0][0] -
                        nurbs::evaluate(face, at[0], at[1], 0)[0][0];
    CHECK(glm::distance(change, share * by) < 1e-15);
  }
  CHECK(std::abs(sum - 1) < 1e-15);
}
