// Lines of draw_debug: where joints, limits, contacts, cables, pins and bounds are.
#include <catch2/catch.hpp>
#include <cmath>
#include <pantin/pantin.hpp>
#include <vector>

#include "engine/base/rotation.hpp"

using namespace pantin;

namespace {

constexpr Vec3 kWhite{1, 1, 1};
constexpr DebugDraw kNothing{.joints = false,
                             .limits = false,
                             .contacts = false,
                             .forces = false,
                             .cables = false,
                             .pins = false};

std::vector<DebugLine> lines_of(const World& world, const DebugDraw& what) {
  std::vector<DebugLine> lines;
  draw_debug(world, what, [&](const DebugLine& line) { lines.push_back(line); });
  return lines;
}

/// Those that show where a joint stands.
std::vector<DebugLine> white(const std::vector<DebugLine>& lines) {
  std::vector<DebugLine> found;
  for (const DebugLine& line : lines)
    if (line.colour == kWhite) found.push_back(line);
  return found;
}

struct Two {
  World world;
  Entity wall, arm;

  explicit Two(Solver solver = Solver::articulated) {
    world.default_settings.solver = solver;
    wall = world.add(RigidBody{.motion = Motion::fixed}).value();
    arm = world.add(RigidBody{.shape = BoxShape{{0.5, 0.1, 0.1}}, .position = {0.5, 0, 0}}).value();
  }
  void turn_arm(Quat by) { world.bodies[arm].pose = {by * Vec3(0.5, 0, 0), by}; }
};

}  // namespace

TEST_CASE("Nothing asked, nothing drawn") {
  Two t;
  REQUIRE(t.world.add(BallJoint{.a = t.wall, .b = t.arm}));
  CHECK(lines_of(t.world, kNothing).empty());
}

TEST_CASE("A joint is drawn by its axes in both bodies, and by a line where it is open") {
  Two t;
  REQUIRE(t.world.add(BallJoint{.a = t.wall, .b = t.arm}));
  DebugDraw what = kNothing;
  what.joints = true, what.size = 0.25;
  std::vector<DebugLine> lines = lines_of(t.world, what);
  REQUIRE(lines.size() == 6);
  for (const DebugLine& line : lines) {
    CHECK(glm::length(line.from) < 1e-12);
    CHECK(glm::length(line.to) == Approx(0.25));
  }
  t.world.bodies[t.arm].pose.position.y += 0.1;
  lines = lines_of(t.world, what);
  REQUIRE(lines.size() == 7);
  CHECK(glm::length(lines.back().to - lines.back().from) == Approx(0.1));
}

TEST_CASE("The range of a hinge is a sector that the joint's own line lies in at its angle") {
  Two t;
  const Entity hinge =
      t.world
          .add(HingeJoint{.a = t.wall, .b = t.arm, .axis = {0, 0, 1}, .limits = Interval{-0.5, 1}})
          .value();
  DebugDraw what = kNothing;
  what.limits = true, what.size = 1;
  const auto angle_between = [](const DebugLine& a, const DebugLine& b) {
    const Vec3 x = a.to - a.from, y = b.to - b.from;
    return std::atan2(glm::cross(x, y).z, glm::dot(x, y));
  };
  const std::vector<DebugLine> before = lines_of(t.world, what);
  t.turn_arm(from_rotation_vector({0, 0, 0.3}));
  CHECK(joint_angle(t.world, hinge) == Approx(0.3));
  const std::vector<DebugLine> lines = lines_of(t.world, what);
  REQUIRE(white(lines).size() == 1);
  CHECK(angle_between(white(before)[0], white(lines)[0]) == Approx(0.3));
  // From the first edge of the sector to the last.
  CHECK(angle_between(lines.front(), white(lines)[0]) == Approx(0.8));
  for (const DebugLine& line : lines) CHECK(std::abs(line.to.z) < 1e-12);
}

TEST_CASE("The two ranges of a universal joint hold where its bodies are") {
  Two t;
  const Entity joint = t.world
                           .add(UniversalJoint{.a = t.wall,
                                               .b = t.arm,
                                               .axis_a = {0, 1, 0},
                                               .axis_b = {0, 0, 1},
                                               .limits = Interval{0, 1},
                                               .second_limits = Interval{0, 1}})
                           .value();
  t.turn_arm(from_rotation_vector({0, 0.4, 0}) * from_rotation_vector({0, 0, 0.7}));
  CHECK(joint_angle(t.world, joint) == Approx(0.4));
  CHECK(joint_second_angle(t.world, joint) == Approx(0.7));
  DebugDraw what = kNothing;
  what.limits = true, what.size = 1;
  const std::vector<DebugLine> now = white(lines_of(t.world, what));
  REQUIRE(now.size() == 2);
  const Quat arm = t.world.bodies[t.arm].pose.rotation;
  CHECK(glm::length(now[0].to - arm * Vec3(0, 0, 1)) < 1e-9);  // z of b, about y of a
  CHECK(glm::length(now[1].to - Vec3(0, 1, 0)) < 1e-9);        // y of a, about z of b
}

TEST_CASE("A cone holds the axis, a travel its carriage") {
  Two t;
  REQUIRE(t.world.add(BallJoint{.a = t.wall, .b = t.arm, .cone = ConeLimit{0.5, 0.3}}));
  t.turn_arm(from_rotation_vector({0, 0.2, 0}));
  DebugDraw what = kNothing;
  what.limits = true, what.size = 1;
  const std::vector<DebugLine> lines = lines_of(t.world, what);
  CHECK(glm::length(white(lines)[0].to - Vec3(std::cos(0.2), 0, -std::sin(0.2))) < 1e-9);
  for (const DebugLine& line : lines)
    if (line.colour != kWhite) CHECK(line.to.x > std::cos(0.5) - 1e-9);

  Two slide(Solver::lagrangian);
  REQUIRE(slide.world.add(PrismaticJoint{
      .a = slide.wall, .b = slide.arm, .axis = {1, 0, 0}, .travel = Interval{-1, 2}}));
  const std::vector<DebugLine> rail = lines_of(slide.world, what);
  CHECK(glm::length(rail[0].to - rail[0].from) == Approx(3));
}

TEST_CASE("Contacts are drawn with their forces, which bear the weight") {
  World world;
  world.add(RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}})
      .value();
  world
      .add(RigidBody{.shape = BoxShape{{0.1, 0.1, 0.1}},
                     .mass = 3,
                     .position = {0, 0.1, 0},
                     .collision = Collision{}})
      .value();
  Simulation simulation(std::move(world));
  for (int i = 0; i < 30; ++i) simulation.step();
  DebugDraw what = kNothing;
  what.forces = true, what.force_scale = 0.01;
  Vec3 sum(0);
  const std::vector<DebugLine> forces = lines_of(simulation.world, what);
  for (const DebugLine& line : forces) sum += line.to - line.from;
  CHECK(forces.size() >= 3);
  CHECK(sum.y == Approx(0.01 * 3 * 9.81).epsilon(1e-3));
  what.contacts = true;
  CHECK(lines_of(simulation.world, what).size() == 5 * forces.size());  // cross, normal, force
}

TEST_CASE("Cables run over their guides, pins to their targets, boxes about shapes") {
  Two t(Solver::lagrangian);
  REQUIRE(t.world.add(CableJoint{.a = t.wall,
                                 .b = t.arm,
                                 .anchor_a = {-1, 0, 0},
                                 .anchor_b = {1, 0, 0},
                                 .over = {{.body = t.wall, .point = {0, 2, 0}}}}));
  DebugDraw what = kNothing;
  what.cables = true;
  const std::vector<DebugLine> cable = lines_of(t.world, what);
  REQUIRE(cable.size() == 2);
  CHECK(cable[0].from == Vec3(-1, 0, 0));
  CHECK(glm::length(cable[1].from - Vec3(0, 2, 0)) < 1e-12);
  CHECK(glm::length(cable[1].to - Vec3(1, 0, 0)) < 1e-12);

  REQUIRE(t.world.add(
      PinConstraint{.body = t.arm, .point = {1, 0, 0}, .target = Vec3(1, 1, 0), .stiffness = 5}));
  what.cables = false, what.pins = true;
  const std::vector<DebugLine> pin = lines_of(t.world, what);
  CHECK(glm::length(pin.back().to - Vec3(1, 1, 0)) < 1e-12);

  what.pins = false, what.bounds = true;
  t.turn_arm(from_rotation_vector({0, 0, kPi / 2}));
  const std::vector<DebugLine> box = lines_of(t.world, what);
  REQUIRE(box.size() == 12);
  Vec3 low(1e9), high(-1e9);
  for (const DebugLine& line : box)
    low = glm::min(low, glm::min(line.from, line.to)),
    high = glm::max(high, glm::max(line.from, line.to));
  CHECK(glm::length(high - low - Vec3(0.2, 1, 0.2)) < 1e-9);
}
