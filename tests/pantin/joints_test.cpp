// Joints as they are described: they start closed, and what is wrong is told by name.
#include <catch2/catch.hpp>
#include <limits>
#include <pantin/pantin.hpp>

#include "engine/base/rotation.hpp"
#include "engine/joints/rows.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

constexpr Real kNaN = std::numeric_limits<Real>::quiet_NaN();

struct Two {
  World world;
  Entity wall, arm;
};

/// A fixed body and a dynamic one, both turned and placed askew.
Two two_bodies() {
  Two t;
  t.world.default_settings.solver = Solver::lagrangian;
  RigidBody wall{.motion = Motion::fixed, .position = {0.3, 1, -0.2}, .name = "wall"};
  wall.rotation = from_rotation_vector(Vec3(0.3, -0.2, 0.9));
  t.wall = t.world.add(wall).value();
  RigidBody arm{.shape = BoxShape{.half_extents = {0.5, 0.1, 0.2}, .at = {{0.1, 0, 0}}}};
  arm.position = {1, 0.8, 0}, arm.rotation = from_rotation_vector(Vec3(-0.5, 0.4, 0.2));
  arm.name = "arm", arm.drag = 0;
  t.arm = t.world.add(arm).value();
  return t;
}

/// What a joint lacks as the bodies stand.
Real gap(const World& world, Entity e) {
  const Link& link = world.links[e];
  const auto placed = [&](Entity body) {
    const Body& b = world.bodies[body];
    return BodyState{b.pose.position, b.pose.rotation, glm::mat3_cast(b.pose.rotation), {}, {}};
  };
  Real c[6] = {}, sum = 0;
  write_rows({link.joint, placed(link.a), placed(link.b)}, {c, nullptr, nullptr});
  for (const Real x : c) sum += x * x;
  return std::sqrt(sum);
}

template <class T>
std::string complaint(World& world, const T& described) {
  const std::size_t before = world.entities.alive();
  const Result<Entity> made = world.add(described);
  CHECK(world.entities.alive() == before + (made ? 1 : 0));
  return made ? "" : made.errors().front().message;
}

}  // namespace

TEST_CASE("every joint added in world space starts closed, and stays so while it moves") {
  Two t = two_bodies();
  const Vec3 anchor{0.4, 1.1, 0.1}, axis{0.2, 2, -0.4};
  const auto add = [&](int kind) -> Entity {
    World& w = t.world;
    const Entity a = t.wall, b = t.arm;
    switch (kind) {
      case 0:
        return w.add(BallJoint{.a = a, .b = b, .anchor = anchor}).value();
      case 1:
        return w.add(HingeJoint{.a = a, .b = b, .anchor = anchor, .axis = axis}).value();
      case 2:
        return w.add(FixedJoint{.a = a, .b = b, .anchor = anchor}).value();
      case 3:
        return w
            .add(UniversalJoint{
                .a = a, .b = b, .anchor = anchor, .axis_a = {0, 3, 0}, .axis_b = {2, 0, 1}})
            .value();
      case 4:
        return w.add(PrismaticJoint{.a = a, .b = b, .anchor = anchor, .axis = axis}).value();
      case 5:
        return w.add(CylindricalJoint{.a = a, .b = b, .anchor = anchor, .axis = axis}).value();
      case 6:
        return w.add(ScrewJoint{.a = a, .b = b, .anchor = anchor, .axis = axis, .pitch = 0.1})
            .value();
      case 7:
        return w.add(PlanarJoint{.a = a, .b = b, .anchor = anchor, .normal = axis}).value();
      default:
        return w.add(DistanceJoint{.a = a, .b = b, .anchor_a = anchor, .anchor_b = {1.5, 0.5, 0}})
            .value();
    }
  };
  const int kind = GENERATE(range(0, 9));
  const Entity joint = add(kind);
  CAPTURE(kind);
  CHECK(gap(t.world, joint) < 1e-14);
  Simulation simulation = Simulation::copy_of(t.world, {.h = 1e-3});
  for (int i = 0; i < 100; ++i) REQUIRE(simulation.step().status == Status::ok);
  CHECK(gap(simulation.world, joint) < 1e-9);
  const Vec3 moved =
      simulation.world.bodies[t.arm].pose.position - t.world.bodies[t.arm].pose.position;
  CHECK((glm::length(moved) > 1e-3) == (kind != 2));
}

TEST_CASE("a hinge's angle grows as b turns anticlockwise about the axis") {
  Two t = two_bodies();
  const Entity hinge =
      t.world.add(HingeJoint{.a = t.wall, .b = t.arm, .anchor = {0, 1, 0}, .axis = {0, 5, 0}})
          .value();
  CHECK(joint_angle(t.world, hinge) == Approx(0).margin(1e-12));
  Body& arm = t.world.bodies[t.arm];
  arm.pose.rotation = from_rotation_vector(Vec3(0, 0.4, 0)) * arm.pose.rotation;
  arm.angular_velocity = {0, 1.5, 0};
  CHECK(joint_angle(t.world, hinge) == Approx(0.4));
  CHECK(joint_angular_speed(t.world, hinge) == Approx(1.5));
  CHECK(std::isnan(joint_travel(t.world, hinge)));
  CHECK(std::isnan(joint_angle(t.world, t.arm)));
}

TEST_CASE("frames given in the bodies make the same joint as the world's") {
  Two t = two_bodies();
  const Pose frame{{0.4, 1.1, 0.1}, from_rotation_vector(Vec3(0.1, 0.7, -0.3))};
  const auto in = [&](Entity e) { return compose(inverse(t.world.origin_pose(e)), frame); };
  const Entity hinge =
      t.world.add(HingeJoint{.a = t.wall, .b = t.arm, .frames = LocalFrames{in(t.wall), in(t.arm)}})
          .value();
  const Link& link = t.world.links[hinge];
  CHECK(gap(t.world, hinge) < 1e-14);
  const Pose& on_arm = t.world.bodies[t.arm].pose;
  CHECK(glm::length(to_world(on_arm, link.joint.anchor_b) - frame.position) < 1e-14);
  const Vec3 axis = on_arm.rotation * link.joint.frames.b() * Vec3(1, 0, 0);
  CHECK(glm::length(axis - frame.rotation * Vec3(1, 0, 0)) < 1e-14);
}

TEST_CASE("a description that cannot be meant is refused by name, and nothing is added") {
  Two t = two_bodies();
  const Entity a = t.wall, b = t.arm;
  const Vec3 up{0, 1, 0};
  using Catch::Matchers::Equals;
  CHECK(complaint(t.world, HingeJoint{.a = a, .b = b, .name = "knee"}) ==
        "HingeJoint 'knee': axis: found (0, 0, 0), expected a direction that is not zero");
  CHECK(complaint(t.world, HingeJoint{.a = a, .b = b, .anchor = {0, kNaN, 0}, .axis = up}) ==
        "HingeJoint: anchor: found (0, nan, 0), expected finite numbers");
  CHECK(complaint(t.world, BallJoint{.a = b, .b = b}) ==
        "BallJoint: b: found the same body as a, expected another one");
  CHECK(complaint(t.world, BallJoint{.a = a}) == "BallJoint: b: found no entity, expected a body");
  CHECK(complaint(t.world, HingeJoint{.a = a, .b = b, .axis = up, .limits = Interval{1, -1}}) ==
        "HingeJoint: limits: found 1 to -1, expected two finite numbers, the lower one first");
  CHECK(complaint(
            t.world,
            HingeJoint{
                .a = a, .b = b, .axis = up, .motor = {.kind = MotorKind::velocity, .gain = -1}}) ==
        "HingeJoint: motor.gain: found -1, expected 0 or a number above it");
  CHECK(complaint(t.world, UniversalJoint{.a = a, .b = b, .axis_a = up, .axis_b = {1, 1, 0}}) ==
        "UniversalJoint: axis_b: found (1, 1, 0), expected a direction perpendicular to axis_a");
  CHECK(complaint(t.world, ScrewJoint{.a = a, .b = b, .axis = up}) ==
        "ScrewJoint: pitch: found 0, expected metres per radian, not 0");
  CHECK(complaint(t.world, SpringJoint{.a = a, .b = b, .anchor_b = up}) ==
        "SpringJoint: stiffness: found 0, and no damping, expected one of them above 0");
  CHECK(complaint(t.world, CableJoint{.a = a, .b = b}) ==
        "CableJoint: length: found 0, expected a number above 0");
  CHECK(complaint(t.world, PinConstraint{.body = a}) ==
        "PinConstraint: body: found a fixed or kinematic body, expected a dynamic one");
  CHECK(complaint(t.world, BallJoint{.a = a, .b = b, .cone = ConeLimit{4, 1}}) ==
        "BallJoint: cone.y: found 4, expected a number from 0 to 3.14159");
  const Entity other = t.world.add(RigidBody{.motion = Motion::fixed}).value();
  CHECK(complaint(t.world, BallJoint{.a = a, .b = other}) ==
        "BallJoint: a and b: found two bodies that joints do not move, expected at least one that "
        "is dynamic");
  t.world.destroy(other);
  CHECK(complaint(t.world, BallJoint{.a = other, .b = b}) ==
        "BallJoint: a: found an entity that was destroyed or is of another World (#" +
            std::to_string(other.index) + "), expected a body");
  const Entity ball = t.world.add(BallJoint{.a = a, .b = b}).value();
  CHECK(complaint(t.world, GearJoint{.first = ball, .second = b}) ==
        "GearJoint: first: found a joint of kind ball, expected one with an angle: hinge, "
        "cylindrical or screw");
}

namespace {

/// Keeps b's mass centre a metre from a's.
struct Rod final : CustomJoint {
  int count;
  explicit Rod(int n) : count(n) {}
  int rows() const override { return count; }
  void residual(const Pose& a, const Pose& b, std::span<Real> c) const override {
    const Vec3 d = b.position - a.position;
    for (Real& row : c) row = (glm::dot(d, d) - 1) / 2;
  }
};

}  // namespace

TEST_CASE("equations of one's own hold like a joint of ours") {
  World world;
  world.default_settings.solver = Solver::lagrangian;
  const Entity hook = world.add(RigidBody{.motion = Motion::fixed}).value();
  const Entity bob =
      world.add(RigidBody{.shape = SphereShape{.radius = 0.1}, .position = {1, 0, 0}, .drag = 0})
          .value();
  CHECK(complaint(world, CustomConstraint{.a = hook, .b = bob}) ==
        "CustomConstraint: equations: found none, expected a CustomJoint");
  CHECK(complaint(world,
                  CustomConstraint{.a = hook, .b = bob, .equations = std::make_shared<Rod>(7)}) ==
        "CustomConstraint: equations: found 7 rows, expected one to six");
  world.add(CustomConstraint{.a = hook, .b = bob, .equations = std::make_shared<Rod>(1)}).value();
  Simulation simulation = Simulation::copy_of(world, {.h = 1e-3});
  for (int i = 0; i < 500; ++i) REQUIRE(simulation.step().status == Status::ok);
  const Vec3 at = simulation.world.bodies[bob].pose.position;
  CHECK(at.y < -0.7);
  CHECK(std::abs(glm::length(at) - 1) < 1e-9);
}

TEST_CASE("asking a refused description for its value throws what is wrong with it") {
  World world;
  CHECK_THROWS_WITH(world.add(RigidBody{}).value(),
                    "RigidBody: shape: found none, and no mass, expected a shape, or mass and "
                    "inertia");
}
