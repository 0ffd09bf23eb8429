// What joints, cables and pins are asked for, against closed forms.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;
using namespace pantin::detail;

namespace {

constexpr Real kG = 9.81;

World world_of(Solver solver) {
  World world;
  world.default_settings.solver = solver;
  return world;
}

Entity fixed_at(World& world, Vec3 at) {
  return world.add(RigidBody{.motion = Motion::fixed, .position = at}).value();
}

Entity ball_at(World& world, Vec3 at, Real mass) {
  return world
      .add(RigidBody{.shape = SphereShape{.radius = 0.1}, .mass = mass, .position = at, .drag = 0})
      .value();
}

StepReport run(Simulation& simulation, int steps) {
  StepReport last;
  for (int i = 0; i < steps; ++i) {
    last = simulation.step();
    REQUIRE(last.status == Status::ok);
  }
  return last;
}

}  // namespace

TEST_CASE("two balls at rest below a nail: each joint bears what hangs on it") {
  const Solver solver = GENERATE(Solver::articulated, Solver::lagrangian);
  CAPTURE(name_of(solver));
  World world = world_of(solver);
  const Entity nail = fixed_at(world, {0, 0, 0});
  const Entity upper = ball_at(world, {0, -1, 0}, 2), lower = ball_at(world, {0, -2, 0}, 3);
  const Entity top = world.add(BallJoint{.a = nail, .b = upper}).value();
  // The other way round: the force on b is the opposite.
  const Entity middle = world.add(BallJoint{.a = lower, .b = upper, .anchor = {0, -1, 0}}).value();
  CHECK_FALSE(joint_reaction(world, top));
  Simulation simulation = Simulation::copy_of(world);
  run(simulation, 30);
  const auto at_top = joint_reaction(simulation.world, top);
  const auto in_middle = joint_reaction(simulation.world, middle);
  REQUIRE(at_top);
  REQUIRE(in_middle);
  CHECK(glm::length(at_top->force - Vec3(0, 5 * kG, 0)) < 1e-6);
  CHECK(glm::length(in_middle->force - Vec3(0, -3 * kG, 0)) < 1e-6);
  CHECK_FALSE(joint_reaction(simulation.world, upper));
}

TEST_CASE("a beam held at one end: force and torque of its clamp") {
  World world = world_of(Solver::lagrangian);
  const Entity wall = fixed_at(world, {0, 0, 0});
  const Entity beam = world
                          .add(RigidBody{.shape = BoxShape{.half_extents = {0.5, 0.05, 0.05}},
                                         .mass = 4.0,
                                         .position = {0.5, 0, 0}})
                          .value();
  const Entity clamp = world.add(FixedJoint{.a = wall, .b = beam}).value();
  Simulation simulation = Simulation::copy_of(world);
  run(simulation, 10);
  const auto reaction = joint_reaction(simulation.world, clamp);
  REQUIRE(reaction);
  CHECK(glm::length(reaction->force - Vec3(0, 4 * kG, 0)) < 1e-9);
  CHECK(glm::length(reaction->torque - Vec3(0, 0, 4 * kG * 0.5)) < 1e-9);
}

TEST_CASE("a cable bears its weight, a slack one nothing, a stretchy one as well") {
  const Solver solver = GENERATE(Solver::articulated, Solver::lagrangian);
  const Real compliance = GENERATE(0.0, 1e-4);
  CAPTURE(name_of(solver), compliance);
  World world = world_of(solver);
  const Entity nail = fixed_at(world, {0, 0, 0}), ball = ball_at(world, {0, -1, 0}, 2);
  world.bodies[ball].drag = 20;  // so that the stretchy one comes to rest
  const Entity cable =
      world
          .add(CableJoint{.a = nail, .b = ball, .anchor_b = {0, -0.9, 0}, .compliance = compliance})
          .value();
  const Entity slack =
      world.add(CableJoint{.a = nail, .b = ball, .anchor_b = {0, -0.9, 0}, .length = 2.0}).value();
  Simulation simulation = Simulation::copy_of(world, {.h = 1.0 / 240});
  run(simulation, 1200);
  CHECK(cable_tension(simulation.world, cable) == Approx(2 * kG).epsilon(1e-3));
  CHECK(cable_tension(simulation.world, slack) == 0);
  CHECK(std::isnan(cable_tension(simulation.world, ball)));
}

TEST_CASE("a pin pulls up what hangs on it") {
  const Solver solver = GENERATE(Solver::articulated, Solver::lagrangian);
  const Real stiffness = GENERATE(0.0, 500.0);
  CAPTURE(name_of(solver), stiffness);
  World world = world_of(solver);
  const Entity ball = ball_at(world, {0, 0, 0}, 2);
  world.bodies[ball].drag = 5;
  const Entity pin =
      world.add(PinConstraint{.body = ball, .point = {0, 0.1, 0}, .stiffness = stiffness}).value();
  CHECK_FALSE(pin_force(world, pin));
  Simulation simulation = Simulation::copy_of(world, {.h = 1.0 / 240});
  run(simulation, 2400);
  const auto force = pin_force(simulation.world, pin);
  REQUIRE(force);
  CHECK(glm::length(*force - Vec3(0, 2 * kG, 0)) < 0.02);
}

TEST_CASE("a motor turns a door as fast as it is told, whole turns counted") {
  World world = world_of(Solver::lagrangian);
  world.gravity = Vec3(0);
  const Entity wall = fixed_at(world, {0, 0, 0});
  const Entity door = world
                          .add(RigidBody{.shape = BoxShape{.half_extents = {0.5, 1, 0.02}},
                                         .density = 100,
                                         .position = {0.5, 0, 0},
                                         .drag = 0})
                          .value();
  const Entity hinge =
      world
          .add(HingeJoint{.a = wall,
                          .b = door,
                          .axis = {0, 1, 0},
                          .motor = {.kind = MotorKind::velocity, .target = 2, .gain = 1000}})
          .value();
  Simulation simulation = Simulation::copy_of(world, {.h = 1e-3});
  run(simulation, 5000);
  CHECK(joint_angular_speed(simulation.world, hinge) == Approx(2).epsilon(1e-3));
  CHECK(joint_angle(simulation.world, hinge) == Approx(10).epsilon(0.01));
}

TEST_CASE("a weight slides down a rail: travel and speed") {
  World world = world_of(Solver::lagrangian);
  const Entity rail = fixed_at(world, {0, 0, 0}), weight = ball_at(world, {0, 0, 0}, 2);
  const Entity translation =
      world.add(PrismaticJoint{.a = rail, .b = weight, .axis = {0, -1, 0}}).value();
  Simulation simulation = Simulation::copy_of(world, {.h = 1e-3});
  run(simulation, 1000);
  CHECK(joint_travel(simulation.world, translation) == Approx(kG / 2));
  CHECK(joint_speed(simulation.world, translation) == Approx(kG));
  CHECK(std::isnan(joint_angle(simulation.world, translation)));
}

TEST_CASE("a joint that is added again with its frames keeps its zero, its limits and its spring") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian})
    for (const Real low : {0.2, 0.69}) {
      World world = world_of(solver);
      world.gravity = Vec3(0);
      const Entity wall = fixed_at(world, {0, 0, 0});
      const Entity arm =
          world
              .add(RigidBody{
                  .shape = BoxShape{{0.4, 0.05, 0.05}, {}}, .mass = 2, .position = {1, 0, 0}})
              .value();
      HingeJoint hinge{.a = wall, .b = arm, .anchor = {0.2, 0, 0}, .axis = {0, 0, 1}};
      hinge.limits = Interval{low, 2};
      const Entity first = world.add(hinge).value();
      const Quat turn = glm::angleAxis(0.7, Vec3(0, 0, 1));
      world.bodies[arm].pose = {Vec3(0.2, 0, 0) + turn * Vec3(0.8, 0, 0), turn};
      world.bodies[arm].restart = true;
      CHECK(joint_angle(world, first) == Approx(0.7));
      hinge.frames = joint_frames(world, first);
      world.destroy(first);
      hinge.spring = {.stiffness = 4};
      const Entity second = world.add(hinge).value();
      CAPTURE(name_of(solver), low);
      CHECK(joint_angle(world, second) == Approx(0.7));
      Simulation simulation = Simulation::copy_of(world, {.h = 1e-3});
      Real least = 1;
      for (int i = 0; i < 2000; ++i)
        simulation.step(), least = std::min(least, joint_angle(simulation.world, second));
      CHECK(least == Approx(low).margin(1e-3));  // drawn to 0, held by its limit
    }
  World world = world_of(Solver::articulated);
  const Entity wall = fixed_at(world, {0, 0, 0}), ball = ball_at(world, {1, 0, 0}, 1);
  const Entity tie = world.add(DistanceJoint{.a = wall, .b = ball, .anchor_b = {1, 0, 0}}).value();
  CHECK_FALSE((joint_frames(world, tie) || joint_frames(world, wall)));
}

TEST_CASE("both axes of a universal joint are told apart") {
  World world = world_of(Solver::articulated);
  const Entity wall = fixed_at(world, {0, 0, 0}), ball = ball_at(world, {1, 0, 0}, 1);
  const Entity cardan =
      world.add(UniversalJoint{.a = wall, .b = ball, .axis_a = {0, 1, 0}, .axis_b = {0, 0, 1}})
          .value();
  const auto rotation = [](Vec3 axis, Real angle) { return glm::angleAxis(angle, axis); };
  world.bodies[ball].pose.rotation = rotation({0, 1, 0}, 0.3) * rotation({0, 0, 1}, 0.2);
  CHECK(joint_angle(world, cardan) == Approx(0.3));
  CHECK(joint_second_angle(world, cardan) == Approx(0.2));
}
