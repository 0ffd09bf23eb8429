// Timed events: pushes, winds, hands, cuts and changes that a World makes happen by itself.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <pantin/pantin.hpp>
#include <string>
#include <utility>

#include "engine/world/timed_event.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

/// A World without gravity, in which a ball of 2 kg without drag is at the origin.
struct Space {
  World world;
  Entity ball;

  Space() {
    world.gravity = Vec3(0);
    ball = world.add(RigidBody{.shape = SphereShape{0.1}, .mass = 2, .drag = 0}).value();
  }
  const Body& body(const World& w) const { return w.bodies[ball]; }
};

void run_until(Simulation& sim, Real end) {
  while (sim.world.time < end - 1e-9) sim.step();
}

Simulation run(const World& world, Real h, Real end, int substeps = 1) {
  Simulation sim = Simulation::copy_of(world, {h, substeps});
  run_until(sim, end);
  return sim;
}

/// Steps that hit no event's time.
constexpr std::pair<Real, int> kSteps[] = {{1.0 / 60, 1}, {0.0071, 1}, {0.0313, 3}, {0.25, 1}};

/// A load of 3 kg that hangs on a cable of 2 m.
struct Load {
  World world;
  Entity load, cable;

  explicit Load(Real compliance = 0) {
    const Entity beam = world.add(RigidBody{.motion = Motion::fixed}).value();
    load =
        world.add(RigidBody{.shape = SphereShape{0.1}, .mass = 3, .position = {0, -2, 0}}).value();
    cable =
        world
            .add(CableJoint{.a = beam, .b = load, .anchor_b = {0, -2, 0}, .compliance = compliance})
            .value();
  }
};

/// A wheel on a hinge with a motor that stands still.
struct Wheel {
  World world;
  Entity hinge;

  explicit Wheel(Solver solver) {
    world.default_settings.solver = solver;
    const Entity wall = world.add(RigidBody{.motion = Motion::fixed}).value();
    const Entity wheel =
        world.add(RigidBody{.shape = SphereShape{0.2}, .mass = 2, .drag = 0}).value();
    const JointMotor motor{.kind = MotorKind::velocity, .target = 0, .gain = 50};
    hinge = world.add(HingeJoint{.a = wall, .b = wheel, .axis = {0, 0, 1}, .motor = motor}).value();
  }
};

}  // namespace

TEST_CASE("A push gives the same impulse at any step") {
  Space space;
  REQUIRE(space.world.add(PushEvent{.body = space.ball,
                                    .force = {10, 0, -4},
                                    .torque = {0, 0.001, 0},
                                    .from = 0.123,
                                    .to = 0.456}));
  for (const auto& [h, substeps] : kSteps) {
    CAPTURE(h, substeps);
    const Simulation sim = run(space.world, h, 2, substeps);
    const Vec3 momentum = 2.0 * space.body(sim.world).velocity;
    CHECK(momentum.x == Approx(3.33).epsilon(1e-9));
    CHECK(momentum.z == Approx(-1.332).epsilon(1e-9));
    const Real inertia = space.body(sim.world).inertia.y;
    CHECK(inertia * space.body(sim.world).angular_velocity.y == Approx(0.000333).epsilon(1e-6));
  }
}

TEST_CASE("A push that starts again and again acts as often as it has to") {
  Space space;
  REQUIRE(space.world.add(
      PushEvent{.body = space.ball, .force = {4, 0, 0}, .from = 0.1, .to = 0.15, .every = 0.3}));
  for (const auto& [h, substeps] : kSteps) {
    CAPTURE(h, substeps);
    // At 0.1, 0.4, 0.7 and 1.0 s.
    const Simulation sim = run(space.world, h, 1.2, substeps);
    CHECK(2 * space.body(sim.world).velocity.x == Approx(4 * 4 * 0.05).epsilon(1e-9));
  }
}

TEST_CASE("An impulse is what it says, at any step, off the centre too") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian}) {
    Space space;
    space.world.default_settings.solver = solver;
    REQUIRE(space.world.add(ImpulseEvent{
        .body = space.ball, .impulse = {0, 0, 0.01}, .anchor = {0, 0.1, 0}, .at = 0.3}));
    for (const auto& [h, substeps] : kSteps) {
      CAPTURE(h, substeps, name_of(solver));
      const Simulation sim = run(space.world, h, 2, substeps);
      const Body& body = space.body(sim.world);
      CHECK(2 * body.velocity.z == Approx(0.01).epsilon(1e-9));
      CHECK(body.inertia.x * body.angular_velocity.x == Approx(0.001).epsilon(1e-3));
    }
  }
}

TEST_CASE("Impulses that repeat are not lost in long steps") {
  Space space;
  REQUIRE(
      space.world.add(ImpulseEvent{.body = space.ball, .impulse = {0.01, 0, 0}, .every = 0.01}));
  for (const auto& [h, substeps] : kSteps) {
    CAPTURE(h, substeps);
    const Simulation sim = run(space.world, h, 1, substeps);
    const Real count = std::floor((sim.world.time - h / substeps / 2) / 0.01) + 1;
    CHECK(2 * space.body(sim.world).velocity.x == Approx(0.01 * count).epsilon(2e-3));
  }
}

TEST_CASE("Wind takes bodies along until they go with the air") {
  for (const Real own : {-1.0, 2.0}) {
    Space space;
    World& world = space.world;
    world.bodies[space.ball].drag = own < 0 ? 2 : 0;
    REQUIRE(world.add(WindEvent{.velocity = {3, 0, 0}, .drag = own, .to = 1e300}));
    for (const Real h : {0.01, 1.0}) {
      CAPTURE(own, h);
      const Simulation sim = run(world, h, 20);
      const Real tolerance = own < 0 ? h : 1e-6;
      CHECK(space.body(sim.world).velocity.x == Approx(3).epsilon(tolerance));
      CHECK(space.body(sim.world).velocity.x <= 3 + 3 * tolerance);
    }
  }
}

TEST_CASE("Gusts follow from their seed, whatever the step") {
  const Noise noise{7, 0, 0.8};
  const Real whole = mean_of(noise, 0.13, 5.7);
  Real parts = 0;
  for (int i = 0; i < 100; ++i)
    parts += mean_of(noise, 0.13 + 0.0557 * i, 0.13 + 0.0557 * (i + 1)) / 100;
  CHECK(parts == Approx(whole).epsilon(1e-9));
  CHECK(mean_of({8, 0, 0.8}, 0.13, 5.7) != whole);
  CHECK(mean_of({7, 1, 0.8}, 0.13, 5.7) != whole);
  Real least = 1, most = -1, sum = 0;
  for (int i = 0; i < 4000; ++i) {
    const Real x = mean_of(noise, 0.2 * i, 0.2 * i + 1e-6);
    least = std::min(least, x), most = std::max(most, x), sum += x / 4000;
  }
  CHECK((least >= -1 && least < -0.9));
  CHECK((most <= 1 && most > 0.9));
  CHECK(std::abs(sum) < 0.05);

  Space space;
  REQUIRE(space.world.add(
      WindEvent{.gusts = Vec3(2), .seed = 5, .drag = 1e-6, .from = 0.1, .to = 3.3}));
  Vec3 first(0);
  for (const auto& [h, substeps] : kSteps) {
    CAPTURE(h, substeps);
    const Vec3 velocity = run(space.world, h, 4, substeps).world.bodies[space.ball].velocity;
    if (first == Vec3(0)) first = velocity;
    CHECK(glm::length(velocity - first) < 2e-5 * glm::length(first));
  }
  CHECK(glm::length(first) > 1e-7);
}

TEST_CASE("A hand takes a body to a place, holds it there and lets go") {
  for (const Real stiffness : {0.0, 400.0}) {
    CAPTURE(stiffness);
    World world;
    const Entity ball = world.add(RigidBody{.shape = SphereShape{0.1}, .mass = 2}).value();
    REQUIRE(world.add(PullEvent{.body = ball,
                                .target = {1, 2, 0},
                                .stiffness = stiffness,
                                .damping = 40,
                                .to = 2.5,
                                .over = 1}));
    Simulation sim = run(world, 1.0 / 120, 2.5);
    const Real sag = stiffness > 0 ? 2 * 9.81 / stiffness : 0;
    const Vec3 off = sim.world.bodies[ball].pose.position - Vec3(1, 2 - sag, 0);
    CHECK(glm::length(off) < (stiffness > 0 ? 0.02 : 1e-6));
    CHECK(sim.world.pins.size() == 1);
    run_until(sim, 3);
    CHECK(sim.world.pins.empty());
    CHECK(sim.world.bodies[ball].velocity.y < -4);
  }
}

TEST_CASE("What is cut is gone at its time, in the order of the times") {
  World world;
  const Entity wall = world.add(RigidBody{.motion = Motion::fixed}).value();
  const Entity rod =
      world.add(RigidBody{.shape = SphereShape{0.1}, .position = {0.5, 0, 0}}).value();
  const Entity joint = world.add(BallJoint{.a = wall, .b = rod}).value();
  const Entity pin = world.add(PinConstraint{.body = rod, .point = {0.5, 0, 0}}).value();
  // Added in the other order.
  REQUIRE(world.add(CutEvent{.tie = joint, .at = 1}));
  REQUIRE(world.add(CutEvent{.tie = pin, .at = 0.5}));
  Simulation sim = run(world, 1.0 / 60, 0.5);
  CHECK(sim.world.pins.size() == 1);
  sim.step();
  CHECK((sim.world.pins.empty() && sim.world.links.size() == 1));
  run_until(sim, 1);
  CHECK(sim.world.links.size() == 1);
  sim.step();
  CHECK(sim.world.links.empty());
  // Twice the same is no harm; nor is what was destroyed meanwhile.
  CHECK_FALSE(sim.world.add(CutEvent{.tie = rod, .at = 9}));
  CHECK(sim.step().status == Status::ok);
}

TEST_CASE("A winch lifts a load by as much as it takes in, and lets it down again") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian})
    for (const Real compliance : {0.0, 1e-3}) {
      CAPTURE(name_of(solver), compliance);
      Load lift(compliance);
      lift.world.default_settings.solver = solver;
      if (compliance > 0) lift.world.bodies[lift.load].drag = 5;  // it starts unstretched
      for (const auto& [from, length] : {std::pair<Real, Real>{0.5, 0.8}, {4, 1.5}})
        REQUIRE(lift.world.add(
            WinchEvent{.cable = lift.cable, .length = length, .at = from, .over = 2}));
      Simulation sim = run(lift.world, 1.0 / 60, 3);
      const Real sag = compliance * 3 * 9.81;
      CHECK(sim.world.bodies[lift.load].pose.position.y == Approx(-0.8 - sag).margin(6e-3));
      CHECK(sim.world.cables[lift.cable].joint.length == 0.8);
      run_until(sim, 8);
      CHECK(sim.world.bodies[lift.load].pose.position.y == Approx(-1.5 - sag).margin(6e-3));
    }
}

TEST_CASE("Gravity changes at once or slowly, and the energy account with it") {
  for (const Solver solver : {Solver::articulated, Solver::sweep, Solver::lagrangian}) {
    CAPTURE(name_of(solver));
    Space space;
    World& world = space.world;
    world.default_settings.solver = solver;
    world.bodies[space.ball].pose.position.y = 100;
    REQUIRE(world.add(GravityEvent{.gravity = {0, 8, 0}, .at = 0.5}));
    REQUIRE(world.add(GravityEvent{.gravity = {0, 0, -4}, .at = 1, .over = 2}));
    const Simulation sim = run(world, 1.0 / 64, 4);
    // 8 for half a second, half of 8 and half of -4 for two, -4 for one.
    const Vec3 v = space.body(sim.world).velocity;
    CHECK(v.y == Approx(12).epsilon(1e-3));
    CHECK(v.z == Approx(-8).epsilon(1e-3));
    CHECK(sim.world.gravity == Vec3(0, 0, -4));
  }
  // A pendulum goes over where gravity turns upwards, and swings as far.
  World world;
  const Entity wall = world.add(RigidBody{.motion = Motion::fixed}).value();
  const Entity bob =
      world
          .add(RigidBody{
              .shape = SphereShape{0.05}, .mass = 1, .position = {0.5, -0.5, 0}, .drag = 0})
          .value();
  REQUIRE(world.add(BallJoint{.a = wall, .b = bob}));
  REQUIRE(world.add(GravityEvent{.gravity = {0, 9.81, 0}, .at = 2}));
  Simulation sim = run(world, 1.0 / 240, 2);
  sim.step();
  const Real energy = measure(sim.world).energy();
  Real worst = 0;
  while (sim.world.time < 6) {
    sim.step();
    worst = std::max(worst, std::abs(measure(sim.world).energy() - energy));
  }
  CHECK(worst < 1e-2);
}

TEST_CASE("A motor gets another speed, another law and is turned off") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian}) {
    CAPTURE(name_of(solver));
    Wheel wheel(solver);
    const auto at = [&](Real from, Real over, JointMotor motor) {
      REQUIRE(wheel.world.add(
          MotorEvent{.joint = wheel.hinge, .motor = motor, .at = from, .over = over}));
    };
    at(0.5, 0, {.kind = MotorKind::velocity, .target = 2, .gain = 50});
    at(1.5, 1, {.kind = MotorKind::velocity, .target = -4, .gain = 50});
    at(4, 0, {.kind = MotorKind::position, .target = 0.5, .gain = 50, .damping = 5});
    at(7, 0, {.kind = MotorKind::none});
    Simulation sim = run(wheel.world, 1.0 / 120, 1.5);
    CHECK(joint_angular_speed(sim.world, wheel.hinge) == Approx(2).epsilon(1e-2));
    run_until(sim, 2);
    CHECK(joint_angular_speed(sim.world, wheel.hinge) == Approx(-1).margin(0.1));
    run_until(sim, 4);
    CHECK(joint_angular_speed(sim.world, wheel.hinge) == Approx(-4).epsilon(1e-2));
    run_until(sim, 7);
    CHECK(joint_angle(sim.world, wheel.hinge) == Approx(0.5).margin(1e-2));
    sim.step();
    CHECK(sim.step().faults == 0);
    CHECK(sim.world.links[wheel.hinge].joint.parameters->rotation.motor.kind == MotorKind::none);
  }
}

TEST_CASE("Another solver takes over with the motion there is") {
  World world;
  const Entity wall = world.add(RigidBody{.motion = Motion::fixed}).value();
  const Entity bob =
      world.add(RigidBody{.shape = SphereShape{0.05}, .position = {1, 0, 0}, .drag = 0}).value();
  REQUIRE(world.add(BallJoint{.a = wall, .b = bob}));
  REQUIRE(world.add(SolverEvent{.solver = Solver::lagrangian, .at = 0.4}));
  Simulation sim = run(world, 1.0 / 240, 0.4);
  const Real before = measure(sim.world).energy(),
             speed = glm::length(sim.world.bodies[bob].velocity);
  sim.step();
  CHECK(sim.world.default_settings.solver == Solver::lagrangian);
  CHECK(glm::length(sim.world.bodies[bob].velocity) == Approx(speed).epsilon(0.02));
  run_until(sim, 2);
  CHECK(measure(sim.world).energy() == Approx(before).margin(2e-2 * std::abs(before) + 1e-3));
}

TEST_CASE("A run with events goes on from a file and from a copy with the same bits") {
  Load lift;
  World& world = lift.world;
  const Entity ball =
      world.add(RigidBody{.shape = SphereShape{0.1}, .position = {3, 0, 0}}).value();
  REQUIRE(world.add(PushEvent{.body = lift.load, .force = {5, 0, 1}, .from = 0.2, .to = 1.1}));
  REQUIRE(world.add(WindEvent{.velocity = {1, 0, 0}, .gusts = Vec3(1)}));
  REQUIRE(
      world.add(PullEvent{.body = ball, .target = {3, 1, 0}, .from = 0.3, .to = 1.2, .over = 0.5}));
  REQUIRE(world.add(WinchEvent{.cable = lift.cable, .length = 1, .at = 0.1, .over = 1}));
  REQUIRE(world.add(ImpulseEvent{.body = ball, .impulse = {0, 0, 1}, .every = 0.4}));
  REQUIRE(world.add(CutEvent{.tie = lift.cable, .at = 1.3}));
  const std::uint64_t whole = state_hash(run(world, 1.0 / 60, 2).world);
  for (const Real half : {0.05, 0.5, 1.25, 1.5}) {
    CAPTURE(half);
    const Simulation sim = run(world, 1.0 / 60, half);
    const auto bytes = world_to_bytes(sim.world);
    REQUIRE(bytes);
    const auto loaded = world_from_bytes(*bytes);
    REQUIRE(loaded);
    CHECK(state_hash(run(*loaded, 1.0 / 60, 2).world) == whole);
    CHECK(state_hash(run(sim.world, 1.0 / 60, 2).world) == whole);
  }
  Simulation threads = Simulation::copy_of(world, {1.0 / 60, 1, 4});
  run_until(threads, 2);
  CHECK(state_hash(threads.world) == whole);
}

TEST_CASE("A hand that cannot get there opens no joint") {
  for (const Real stiffness : {0.0, 1e5}) {
    World world;
    const Entity wall = world.add(RigidBody{.motion = Motion::fixed}).value();
    const Chain chain =
        build_chain(world, {.from = {0, 0, 0}, .to = {1, 0, 0}, .links = 10, .start = wall})
            .value();
    REQUIRE(world.add(PullEvent{.body = chain.links.back(),
                                .target = {0, 3, 0},
                                .stiffness = stiffness,
                                .from = 0.2,
                                .over = 0.5}));
    Simulation sim = Simulation::copy_of(world);
    sim.settings.measure = true;
    Real worst = 0;
    while (sim.world.time < 2) worst = std::max(worst, sim.step().measures.worst_gap_rel);
    CHECK(worst < 1e-9);
    CHECK(sim.world.bodies[chain.links.back()].pose.position.y == Approx(0.95).margin(0.1));
  }
}

TEST_CASE("What sleeps is woken by an event") {
  using Change = std::function<TimedEvent(Entity)>;
  const Change changes[] = {
      [](Entity box) {
        return TimedEvent{PushEvent{.body = box, .force = {0, 300, 0}, .from = 4, .to = 4.2}};
      },
      [](Entity box) {
        return TimedEvent{ImpulseEvent{.body = box, .impulse = {0, 50, 0}, .at = 4}};
      },
      [](Entity) {
        return TimedEvent{GravityEvent{.gravity = {0, 5, 0}, .at = 4}};
      },
      [](Entity box) {
        return TimedEvent{PullEvent{.body = box, .target = {0, 2, 0}, .from = 4, .over = 0.3}};
      }};
  for (const Change& change : changes) {
    World world;
    world.add(RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}})
        .value();
    const Entity box = world
                           .add(RigidBody{.shape = BoxShape{{0.1, 0.1, 0.1}},
                                          .mass = 10,
                                          .position = {0, 0.1, 0},
                                          .collision = Collision{}})
                           .value();
    REQUIRE(world.add(change(box)));
    Simulation sim = Simulation::copy_of(world);
    StepReport report;
    while (sim.world.time < 3.9) report = sim.step();
    CHECK(report.asleep == 1);
    const Real rest = sim.world.bodies[box].pose.position.y;
    while (sim.world.time < 4.4) sim.step();
    CHECK(sim.world.bodies[box].pose.position.y > rest + 0.05);
  }
}

TEST_CASE("Events that are past leave no trace in the accuracy") {
  // A pendulum beside which something was pushed keeps its energy as one alone does.
  const auto drift = [](bool pushed) {
    World world;
    const Entity wall = world.add(RigidBody{.motion = Motion::fixed}).value();
    const Entity bob =
        world.add(RigidBody{.shape = SphereShape{0.05}, .position = {1, 0, 0}, .drag = 0}).value();
    const Entity ball =
        world.add(RigidBody{.shape = SphereShape{0.1}, .position = {5, 0, 0}, .drag = 0}).value();
    REQUIRE(world.add(BallJoint{.a = wall, .b = bob}));
    if (pushed) REQUIRE(world.add(PushEvent{.body = ball, .force = {1, 0, 0}, .to = 0.1}));
    return run(world, 1.0 / 60, 3).world.bodies[bob].pose.position;
  };
  CHECK(drift(true) == drift(false));
}

TEST_CASE("Events that cannot be meant are refused with a line") {
  Space space;
  World& world = space.world;
  const Entity wall = world.add(RigidBody{.motion = Motion::fixed}).value();
  const auto refused = [&](const auto& event, const std::string& word) {
    const auto added = world.add(event);
    REQUIRE_FALSE(added);
    CAPTURE(added.errors().front().message);
    CHECK(added.errors().front().message.find(word) != std::string::npos);
  };
  const Real nan = std::nan("");
  refused(PushEvent{.body = wall}, "dynamic");
  refused(PushEvent{}, "body");
  refused(PushEvent{.body = space.ball, .from = -1}, "from");
  refused(PushEvent{.body = space.ball, .from = nan}, "from");
  refused(PushEvent{.body = space.ball, .from = 2, .to = 1}, "to");
  refused(PushEvent{.body = space.ball, .to = nan}, "to");
  refused(PushEvent{.body = space.ball, .to = 1, .every = 0.5}, "every");
  refused(PushEvent{.body = space.ball, .to = 1e-9, .every = 1e-6}, "every");
  refused(PushEvent{.body = space.ball, .force = Vec3(nan)}, "finite");
  refused(CutEvent{.tie = space.ball}, "joint");
  refused(WinchEvent{.cable = space.ball}, "cable");
  refused(DriveEvent{.joint = space.ball}, "drive");
  refused(MotorEvent{.joint = space.ball}, "joint");
  refused(WindEvent{.gust_time = 0}, "gust_time");
  refused(PullEvent{.body = wall}, "dynamic");
  CHECK(events_of(std::as_const(world)) == nullptr);
}
