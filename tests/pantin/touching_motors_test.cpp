// Motors, springs and friction of joints whose bodies touch: a car, a foot that presses, a leg that
// does not fold.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;

namespace {

constexpr Real kG = 9.81, kRadius = 0.2, kWheel = 2, kChassis = 20;

Entity ground(World& world, Real friction) {
  Collision collision;
  collision.friction = friction;
  const RigidBody floor{.motion = Motion::fixed,
                        .shape = BoxShape{{100, 0.5, 10}},
                        .position = {0, -0.5, 0},
                        .collision = collision};
  return world.add(floor).value();
}

struct Car {
  World world;
  Entity chassis;
  std::vector<Entity> wheels, axles;
};

/// Four balls as wheels, driven towards +x.
Car car(const JointMotor& motor, Real friction) {
  Car c;
  ground(c.world, friction);
  Collision collision;
  collision.friction = friction;
  c.chassis = c.world
                  .add(RigidBody{.shape = BoxShape{{0.6, 0.1, 0.25}},
                                 .mass = kChassis,
                                 .position = {0, 0.3, 0},
                                 .drag = 0})
                  .value();
  for (const Real x : {-0.5, 0.5})
    for (const Real z : {-0.4, 0.4}) {
      const Vec3 at(x, kRadius, z);
      c.wheels.push_back(c.world
                             .add(RigidBody{.shape = SphereShape{kRadius},
                                            .mass = kWheel,
                                            .position = at,
                                            .collision = collision,
                                            .drag = 0})
                             .value());
      c.axles.push_back(c.world
                            .add(HingeJoint{.a = c.chassis,
                                            .b = c.wheels.back(),
                                            .anchor = at,
                                            .axis = {0, 0, -1},
                                            .motor = motor})
                            .value());
    }
  return c;
}

constexpr Real kAlong = kChassis + 4 * kWheel * 1.4;  // kg, the wheels' turning included

/// m/s, after the seconds.
Real speed_after(const Car& c, Real seconds, Real rate) {
  Simulation sim = Simulation::copy_of(c.world, {1 / rate});
  for (int i = 0; i < seconds * rate; ++i) REQUIRE(sim.step().status == Status::ok);
  return sim.world.bodies[c.chassis].velocity.x;
}

}  // namespace

TEST_CASE("a car's wheels roll at the speed of their motors") {
  for (const Real rate : {60.0, 240.0}) {
    const Car c = car({.kind = MotorKind::velocity, .target = 10, .gain = 50}, 0.8);
    CHECK(speed_after(c, 3, rate) == Approx(10 * kRadius).epsilon(1e-6));
  }
}

TEST_CASE("a car is as fast as the torque of its motors, or its friction, makes it") {
  for (const Real rate : {60.0, 240.0}) {
    const JointMotor weak{.kind = MotorKind::velocity, .target = 100, .gain = 50, .cap = 5};
    CHECK(speed_after(car(weak, 0.8), 1, rate) == Approx(4 * 5 / kRadius / kAlong).epsilon(1e-4));
    const JointMotor strong{.kind = MotorKind::velocity, .target = 500, .gain = 50, .cap = 300};
    CHECK(speed_after(car(strong, 0.3), 1, rate) == Approx(0.3 * kG).epsilon(0.02));
  }
}

TEST_CASE("a motor at its cap presses a foot to the ground with its torque") {
  World world;
  ground(world, 0);
  const Entity post = world.add(RigidBody{.motion = Motion::fixed}).value();
  const Real length = 0.5, radius = 0.05;
  Collision slippery;
  slippery.friction = 0;
  const Entity foot = world
                          .add(RigidBody{.shape = SphereShape{radius},
                                         .mass = 1.0,
                                         .position = {length, radius, 0},
                                         .collision = slippery,
                                         .drag = 0})
                          .value();
  const JointMotor motor{.kind = MotorKind::velocity, .target = -9, .gain = 100, .cap = 4};
  world
      .add(HingeJoint{
          .a = post, .b = foot, .anchor = {0, radius, 0}, .axis = {0, 0, 1}, .motor = motor})
      .value();
  Simulation sim = Simulation::copy_of(world, {1.0 / 60});
  for (int i = 0; i < 120; ++i) REQUIRE(sim.step().status == Status::ok);
  ContactEvents events(sim.world);
  sim.step();
  const auto found = events.update(sim.world);
  REQUIRE(found.size() == 1);
  CHECK(60 * glm::length(found.front().impulse) == Approx(kG + 4 / length).epsilon(1e-4));
}

TEST_CASE("a leg whose knee rubs stands, and folds where it rubs too little") {
  const Real half = 0.2, radius = 0.04, mass = 2;
  for (const Real part : {1.5, 0.5}) {  // of the torque that holds it
    World world;
    ground(world, 1);
    // A foot, a shin that leans, held by the ankle alone.
    const Entity foot = world
                            .add(RigidBody{.shape = BoxShape{{0.3, 0.03, 0.2}},
                                           .mass = 20.0,
                                           .position = {0, 0.03, 0},
                                           .collision = Collision{},
                                           .drag = 0})
                            .value();
    const Real lean = 0.3;
    const Vec3 along(std::sin(lean), std::cos(lean), 0);
    const Vec3 ankle(0, 0.06, 0);
    const Entity shin = world
                            .add(RigidBody{.shape = CapsuleShape{radius, half - radius},
                                           .mass = mass,
                                           .position = ankle + half * along,
                                           .rotation = glm::angleAxis(-lean, Vec3(0, 0, 1)),
                                           .drag = 0})
                            .value();
    const Real weight = mass * kG * half * std::sin(lean);
    const JointFriction friction{.dry = part * weight, .slip = 1e-4};
    world
        .add(HingeJoint{
            .a = foot, .b = shin, .anchor = ankle, .axis = {0, 0, 1}, .friction = friction})
        .value();
    Simulation sim = Simulation::copy_of(world, {1.0 / 60});
    for (int i = 0; i < 30; ++i) REQUIRE(sim.step().status == Status::ok);
    const Vec3 now = sim.world.bodies[shin].pose.rotation * Vec3(0, 1, 0);
    const Real fallen = std::atan2(now.x, now.y) - lean;
    CAPTURE(part, fallen);
    if (part > 1)
      CHECK(std::abs(fallen) < 1e-3);
    else
      CHECK(fallen > 0.1);
  }
}

TEST_CASE("in a loop of joints the one with a motor is driven; all that have one are") {
  const JointMotor motor{.kind = MotorKind::velocity, .target = 1, .gain = 200};
  for (const bool all : {false, true}) {
    World world;
    world.gravity = Vec3(0);
    const Entity ground = world.add(RigidBody{.motion = Motion::fixed}).value();
    const Vec3 corners[4] = {{0, 0, 0}, {0.2, 0.2, 0}, {0.9, 0.6, 0}, {1, 0, 0}};
    std::vector<Entity> bars{ground};
    for (int i = 0; i < 3; ++i) {
      const Vec3 way = corners[i + 1] - corners[i];
      bars.push_back(
          world
              .add(RigidBody{.shape = BoxShape{{0.5 * glm::length(way), 0.02, 0.02}},
                             .position = corners[i] + 0.5 * way,
                             .rotation = glm::angleAxis(std::atan2(way.y, way.x), Vec3(0, 0, 1)),
                             .drag = 0})
              .value());
    }
    bars.push_back(ground);
    std::vector<Entity> hinges;
    for (int i = 3; i >= 0; --i) {  // the driven one last
      const JointMotor own = all || i == 0 ? motor : JointMotor{};
      hinges.push_back(world
                           .add(HingeJoint{.a = bars[static_cast<std::size_t>(i)],
                                           .b = bars[static_cast<std::size_t>(i) + 1],
                                           .anchor = corners[i],
                                           .axis = {0, 0, 1},
                                           .motor = own})
                           .value());
    }
    CAPTURE(all);
    CHECK(check(world).empty());
    Simulation sim = Simulation::copy_of(world, {1.0 / 60});
    world.default_settings.solver = Solver::lagrangian;
    Simulation exact = Simulation::copy_of(world, {1.0 / 60});
    for (int i = 0; i < 120; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      REQUIRE(exact.step().status == Status::ok);
    }
    const Real speed = joint_angular_speed(sim.world, hinges.back()),
               exactly = joint_angular_speed(exact.world, hinges.back());
    CHECK(speed == Approx(exactly).epsilon(1e-2));
    CHECK((speed == exactly) == all);  // "auto" leaves a loop of motors to "lagrangian"
    if (!all) CHECK(speed == Approx(1).epsilon(1e-2));
    CHECK(measure(sim.world).worst_gap < 1e-6);
  }
}
