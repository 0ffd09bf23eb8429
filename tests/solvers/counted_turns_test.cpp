// Whole turns that a joint has counted outlast edits, another solver and a step that was aborted.
#include <catch2/catch.hpp>

#include "engine/pantin/pantin.hpp"

using namespace pantin;

namespace {

constexpr Real kStep = 1.0 / 240;

/// A wheel on a hinge in a World without gravity, and a small one at its rim.
struct Wheel {
  World world;
  Entity base, wheel, hinge, load, rim;
};

Wheel wheel_on_servo(Solver solver) {
  Wheel w;
  w.world.gravity = Vec3(0);
  w.world.default_settings.solver = solver;
  w.world.default_settings.sleep_speed = 0;
  w.base = must(w.world.add(RigidBody{.motion = Motion::fixed}));
  w.wheel = must(w.world.add(RigidBody{.shape = CylinderShape{0.1, 0.05},
                                       .mass = 1,
                                       .inertia = Mat3(0.02),
                                       .collision = Collision{}}));
  w.load = must(
      w.world.add(RigidBody{.shape = SphereShape{0.05}, .mass = 0.1, .position = {0.2, 0, 0}}));
  w.hinge = must(w.world.add(
      HingeJoint{.a = w.base,
                 .b = w.wheel,
                 .axis = {0, 0, 1},
                 .motor = {.kind = MotorKind::position, .target = 20, .gain = 2, .damping = 0.5}}));
  w.rim = must(
      w.world.add(HingeJoint{.a = w.wheel, .b = w.load, .anchor = {0.2, 0, 0}, .axis = {0, 0, 1}}));
  return w;
}

SolverSettings by(const World& world, Solver solver) {
  SolverSettings settings = world.default_settings;
  settings.solver = solver;
  return settings;
}

using Edit = void (*)(Simulation&, Wheel&);
const std::pair<const char*, Edit> kEdits[] = {
    {"cut", [](Simulation& s, Wheel& w) { s.world.destroy(w.rim); }},
    {"destroy", [](Simulation& s, Wheel& w) { s.world.destroy(w.load); }},
    {"limits",
     [](Simulation& s, Wheel& w) {
       must(set_limits(s.world, w.rim, Interval{-1, 1}));
     }},
    {"own limits",
     [](Simulation& s, Wheel& w) {
       must(set_limits(s.world, w.hinge, Interval{-50, 50}));
     }},
    {"friction",
     [](Simulation& s, Wheel& w) { must(set_friction(s.world, w.rim, {.viscous = 1e-6})); }},
    {"far body",
     [](Simulation& s, Wheel&) {
       must(s.world.add(RigidBody{.shape = SphereShape{0.1}, .position = {50, 0, 0}}));
     }},
    {"memory", [](Simulation& s, Wheel&) { s.world.mark_dirty(); }},
    {"saved", [](Simulation& s,
                 Wheel&) { s.world = must(world_from_bytes(must(world_to_bytes(s.world)))); }},
};

}  // namespace

TEST_CASE("a servo that has turned three times stays where it is, whatever is edited") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian, Solver::planar})
    for (const auto& [what, edit] : kEdits) {
      CAPTURE(name_of(solver), what);
      Wheel w = wheel_on_servo(solver);
      Simulation sim(std::move(w.world), {kStep});
      for (int i = 0; i < 1200; ++i) sim.step();
      const Quat before = sim.world.bodies[w.wheel].pose.rotation;
      edit(sim, w);
      Real fastest = 0;
      for (int i = 0; i < 600; ++i) {
        CHECK(sim.step().status == Status::ok);
        fastest = std::max(fastest, glm::length(sim.world.bodies[w.wheel].angular_velocity));
      }
      CHECK(fastest < 0.05);
      CHECK(std::abs(glm::dot(before, sim.world.bodies[w.wheel].pose.rotation)) > 0.9999);
    }
}

TEST_CASE("a spring wound by more than a turn swings on as it would, under each solver") {
  constexpr Real kFar = 9, kStiff = 0.5, kInertia = 0.02;
  const Real omega = std::sqrt(kStiff / kInertia);
  for (const Solver solver : {Solver::articulated, Solver::lagrangian, Solver::planar})
    for (const int what : {0, 1, 2}) {  // nothing; an aborted step; another solver and back
      if (what == 2 && solver == Solver::planar) continue;
      CAPTURE(name_of(solver), what);
      World world;
      world.gravity = Vec3(0);
      world.default_settings.solver = solver;
      world.default_settings.sleep_speed = 0;
      const Entity base = must(world.add(RigidBody{.motion = Motion::fixed}));
      const Entity body = must(world.add(RigidBody{.shape = SphereShape{0.1},
                                                   .mass = 1,
                                                   .inertia = Mat3(kInertia),
                                                   .angular_velocity = {0, 0, kFar * omega}}));
      must(
          world.add(HingeJoint{.a = base, .b = body, .axis = {0, 0, 1}, .spring = {kStiff, 0, 0}}));
      for (const Real x : {5.0, 5.15})
        must(world.add(
            RigidBody{.shape = SphereShape{0.1}, .position = {x, 9, 0}, .collision = Collision{}}));
      bool throws = false;
      StepSettings settings{kStep};
      settings.filter = [&](const ContactPair&) {
        if (std::exchange(throws, false)) throw std::runtime_error("filter");
        return true;
      };
      Simulation sim(std::move(world), settings);
      Real worst = 0, t = 0;
      for (int i = 0; i < 600; ++i) {
        if (what == 1 && i == 60) throws = true;
        if (what == 2 && (i == 60 || i == 90)) {
          const bool back = i == 90;
          const Solver other =
              solver == Solver::articulated ? Solver::lagrangian : Solver::articulated;
          sim.world.settings.add(body, by(sim.world, back ? solver : other));
        }
        if (sim.step().status == Status::aborted) continue;
        t += kStep;
        const Real rate = kFar * omega * std::cos(omega * t);
        const Real error = sim.world.bodies[body].angular_velocity.z - rate;
        worst = std::max(worst, std::abs(error) / (kFar * omega));
      }
      CHECK(worst < 0.03);
    }
}

TEST_CASE("a servo keeps its turns when another solver takes it over") {
  Wheel w = wheel_on_servo(Solver::articulated);
  const Entity ball = must(w.world.add(RigidBody{.shape = SphereShape{0.05},
                                                 .mass = 0.01,
                                                 .position = {0, 2.95, 0},
                                                 .velocity = {0, -0.5, 0},
                                                 .collision = Collision{.friction = 0}}));
  w.world.settings.add(ball, by(w.world, Solver::lagrangian));
  Simulation sim(std::move(w.world), {kStep});
  Real fastest = 0;
  for (int i = 0; i < 2400; ++i) {
    sim.step();
    if (i > 1000)
      fastest = std::max(fastest, glm::length(sim.world.bodies[w.wheel].angular_velocity));
  }
  CHECK(sim.world.bodies[ball].pose.position.y > 0.1);
  CHECK(fastest < 0.5);
}

TEST_CASE("gears mesh as before when something of their island changes") {
  constexpr Real kRatio = -0.7, kRate = 7;
  for (const int what : {0, 1, 2}) {
    CAPTURE(what);
    World world;
    world.gravity = Vec3(0);
    world.default_settings.solver = Solver::lagrangian;
    const Entity base = must(world.add(RigidBody{.motion = Motion::fixed}));
    const auto wheel = [&](Real x, Real rate) {
      return must(world.add(RigidBody{.shape = SphereShape{0.1},
                                      .mass = 1,
                                      .position = {x, 0, 0},
                                      .angular_velocity = {0, 0, rate}}));
    };
    const Entity a = wheel(0, kRate), b = wheel(2, kRatio * kRate);
    const Entity on_a = must(world.add(HingeJoint{.a = base, .b = a, .axis = {0, 0, 1}}));
    const Entity on_b =
        must(world.add(HingeJoint{.a = base, .b = b, .anchor = {2, 0, 0}, .axis = {0, 0, 1}}));
    must(world.add(GearJoint{.first = on_a, .second = on_b, .ratio = kRatio, .offset = 0.0}));
    Simulation sim(std::move(world), {kStep});
    for (int i = 0; i < 400; ++i) {
      if (i == 333 && what == 0) must(set_limits(sim.world, on_a, Interval{-50, 50}));
      if (i == 333 && what == 1)
        must(sim.world.add(PinConstraint{.body = a, .point = Vec3(0), .stiffness = 1e-9}));
      if (i == 333 && what == 2)
        must(set_motor(sim.world, on_a, {.kind = MotorKind::velocity, .gain = 1, .cap = 0}));
      const Quat before = sim.world.bodies[a].pose.rotation;
      CHECK(sim.step().status == Status::ok);
      const Quat turn = sim.world.bodies[a].pose.rotation * glm::conjugate(before);
      CHECK(2 * std::atan2(std::abs(turn.z), std::abs(turn.w)) == Approx(kRate * kStep));
    }
  }
}
