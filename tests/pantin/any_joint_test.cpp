// Joints by the name of their kind: the same as by the builders of one kind, and refused by name.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <pantin/pantin.hpp>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"

using namespace pantin;

namespace {

struct Two {
  World world;
  Entity wall, arm;

  explicit Two(Solver solver = Solver::lagrangian) {
    world.default_settings.solver = solver;
    RigidBody fixed{.motion = Motion::fixed, .position = {0.3, 1, -0.2}, .name = "wall"};
    fixed.rotation = from_rotation_vector(Vec3(0.3, -0.2, 0.9));
    wall = world.add(fixed).value();
    RigidBody moves{.shape = BoxShape{.half_extents = {0.5, 0.1, 0.2}, .at = {{0.1, 0, 0}}}};
    moves.position = {1, 0.8, 0}, moves.rotation = from_rotation_vector(Vec3(-0.5, 0.4, 0.2));
    moves.name = "arm", moves.drag = 0;
    arm = world.add(moves).value();
  }
};

const Vec3 kAnchor{0.4, 1.1, 0.1}, kAxis{0.2, 2, -0.4};
const JointMotor kMotor{.kind = MotorKind::velocity, .target = 2, .gain = 5};
const SpringDamper kSpring{.stiffness = 3, .damping = 0.2, .rest = 0.1};

/// Both descriptions, each in a World of its own, are the same World, also after steps.
template <class Named>
void check_same(const Named& named, const AnyJoint& any, Solver solver = Solver::lagrangian) {
  INFO(any.kind);
  Two one(solver), other(solver);
  Named first = named;
  AnyJoint second = any;
  first.a = second.a = one.wall, first.b = second.b = one.arm;
  REQUIRE(one.world.add(first));
  REQUIRE(other.world.add(second));
  CHECK(state_hash(one.world) == state_hash(other.world));
  Simulation a(std::move(one.world), {.h = 1e-3}), b(std::move(other.world), {.h = 1e-3});
  for (int i = 0; i < 20; ++i) {
    CHECK(a.step().status == Status::ok);
    CHECK(b.step().status == Status::ok);
  }
  CHECK(state_hash(a.world) == state_hash(b.world));
}

std::string complaint(const AnyJoint& described) {
  Two t;
  AnyJoint joint = described;
  joint.a = t.wall, joint.b = t.arm;
  const std::size_t before = t.world.entities.alive();
  const Result<Entity> made = t.world.add(joint);
  CHECK(t.world.entities.alive() == before + (made ? 1 : 0));
  return made ? "" : made.errors().front().message;
}

}  // namespace

TEST_CASE("A joint by the name of its kind is the one that its own builder makes") {
  const Interval range{-0.5, 0.7};
  check_same(BallJoint{.anchor = kAnchor,
                       .axis = kAxis,
                       .across = {1, 0, 0},
                       .cone = ConeLimit{0.5, 0.3},
                       .twist = range,
                       .soft_stop = SoftStop{0.1, 5, 1}},
             AnyJoint{.kind = "ball",
                      .anchor = kAnchor,
                      .axis = kAxis,
                      .across = {1, 0, 0},
                      .limits = range,
                      .cone = ConeLimit{0.5, 0.3},
                      .soft_stop = SoftStop{0.1, 5, 1}},
             Solver::articulated);
  check_same(HingeJoint{.anchor = kAnchor,
                        .axis = kAxis,
                        .limits = range,
                        .motor = kMotor,
                        .spring = kSpring,
                        .restitution = 0.5},
             AnyJoint{.kind = "hinge",
                      .anchor = kAnchor,
                      .axis = kAxis,
                      .limits = range,
                      .restitution = 0.5,
                      .angle = {.motor = kMotor, .spring = kSpring}});
  check_same(FixedJoint{.anchor = kAnchor},
             AnyJoint{.kind = "fixed", .anchor = kAnchor, .across = {0, 1, 0}});
  check_same(UniversalJoint{.anchor = kAnchor,
                            .axis_a = {0, 1, 0},
                            .axis_b = {0, 0, 1},
                            .limits = range,
                            .second_limits = range},
             AnyJoint{.kind = "universal",
                      .anchor = kAnchor,
                      .across = {0, 1, 0},
                      .limits = range,
                      .second_limits = range});
  check_same(PrismaticJoint{.anchor = kAnchor, .axis = kAxis, .travel = range, .motor = kMotor},
             AnyJoint{.kind = "prismatic",
                      .anchor = kAnchor,
                      .axis = kAxis,
                      .travel_limits = range,
                      .travel = {.motor = kMotor}});
  check_same(CylindricalJoint{.anchor = kAnchor,
                              .axis = kAxis,
                              .limits = range,
                              .motor = kMotor,
                              .travel_spring = kSpring},
             AnyJoint{.kind = "cylindrical",
                      .anchor = kAnchor,
                      .axis = kAxis,
                      .limits = range,
                      .angle = {.motor = kMotor},
                      .travel = {.spring = kSpring}});
  check_same(ScrewJoint{.anchor = kAnchor, .axis = kAxis, .pitch = 0.1, .motor = kMotor},
             AnyJoint{.kind = "screw",
                      .anchor = kAnchor,
                      .axis = kAxis,
                      .parameters = {{"pitch", 0.1}},
                      .angle = {.motor = kMotor}});
  check_same(PlanarJoint{.anchor = kAnchor, .normal = kAxis},
             AnyJoint{.kind = "planar", .anchor = kAnchor, .axis = kAxis});
  check_same(
      SkateJoint{.anchor = kAnchor, .across = kAxis, .grip = 4},
      AnyJoint{.kind = "skate", .anchor = kAnchor, .axis = kAxis, .parameters = {{"grip", 4}}});
}

TEST_CASE("Every kind in the list can be added by its name and parameters alone") {
  REQUIRE(joint_kinds().size() + 1 == std::size(detail::kJointKindInfos));  // all but custom
  for (const std::string& kind : joint_kinds()) {
    CAPTURE(kind);
    Two t;
    AnyJoint joint{.kind = kind, .a = t.wall, .b = t.arm, .anchor = kAnchor, .axis = kAxis};
    for (const std::string& key : parameters_of_kind(kind))
      if (key != "friction_coefficient")  // excludes a grip
        joint.parameters.push_back({key, 0.3});
    detail::JointKind found{};
    REQUIRE(detail::joint_kind_from_name(kind, found));
    if (!detail::holds_point(found)) joint.anchor_b = kAnchor + 0.3 * glm::normalize(kAxis);
    const auto made = t.world.add(joint);
    REQUIRE(made);
    CHECK(t.world.links[*made].joint.kind == found);
    Simulation simulation(std::move(t.world), {.h = 1e-3});
    for (int i = 0; i < 50; ++i) REQUIRE(simulation.step().status == Status::ok);
  }
}

TEST_CASE("A parameter that follows from the place is measured") {
  Two t;
  const Entity rod = t.world
                         .add(AnyJoint{.kind = "distance",
                                       .a = t.wall,
                                       .b = t.arm,
                                       .anchor = {0, 0, 0},
                                       .anchor_b = Vec3(0, 3, 4)})
                         .value();
  CHECK(t.world.links[rod].joint.parameters->length == 5);
}

TEST_CASE("What a kind does not have is refused with the kinds that do") {
  CHECK(complaint({.kind = "hnge"}) ==
        "AnyJoint: kind: found 'hnge', expected ball, hinge, universal, fixed, cylindrical, "
        "prismatic, screw, planar, distance, spring, skate or wheel");
  CHECK(complaint({.kind = "custom"}).find("kind: found 'custom'") != std::string::npos);
  CHECK(complaint({.kind = "screw", .name = "bolt"}) ==
        "AnyJoint 'bolt': pitch: found none, expected the travel per rad of rotation, in m/rad");
  CHECK(complaint({.kind = "skate", .parameters = {{"grip", 1}, {"friction_coefficient", 0.5}}})
            .find("has both a grip and a coefficient of friction") != std::string::npos);
  CHECK(complaint({.kind = "hinge", .parameters = {{"pitch", 1}}}) ==
        "AnyJoint: parameters: found 'pitch' of a joint of kind hinge, expected none");
  CHECK(complaint({.kind = "hinge", .second_limits = Interval{}}) ==
        "AnyJoint: second_limits: found it of a joint of kind hinge, expected it of these kinds "
        "only: universal");
  CHECK(complaint({.kind = "ball", .anchor_b = Vec3(1)}).find("anchor_b: found it") !=
        std::string::npos);
  CHECK(complaint({.kind = "ball", .angle = {.motor = kMotor}}).find("angle: found it") !=
        std::string::npos);
  CHECK(complaint({.kind = "fixed", .drive = JointDrive{}}).find("drive: found it") !=
        std::string::npos);
  CHECK(complaint({.kind = "distance"}) == "AnyJoint: length: found 0, expected a number above 0");
  CHECK(complaint({.kind = "hinge", .axis = {0, 0, 0}}) ==
        "AnyJoint: axis: found (0, 0, 0), expected a direction that is not zero");
  CHECK(complaint({.kind = "screw", .parameters = {{"pitch", std::nan("")}}})
            .find("pitch: found nan") != std::string::npos);
}
