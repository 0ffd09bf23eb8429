// Springs, dampers and motors of joints that bear loads through contacts: statics and steady motion
// do not depend on the step, nor on how light the part between spring and load is.
#include <catch2/catch.hpp>
#include <pantin/must.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;

namespace {

constexpr Real kG = 9.81, kLoad = 20;

/// A table on a vertical prismatic joint with a load on it that is not joined to it.
struct Lift {
  World world;
  Entity table, load, joint;
};
Lift lift(Real table_mass, PrismaticJoint joint) {
  Lift l;
  l.table = must(l.world.add(RigidBody{.shape = BoxShape{{0.5, 0.05, 0.5}},
                                       .mass = table_mass,
                                       .position = {0, 0.5, 0},
                                       .collision = Collision{},
                                       .drag = 0}));
  l.load = must(l.world.add(RigidBody{.shape = BoxShape{{0.15, 0.15, 0.15}},
                                      .mass = kLoad,
                                      .position = {0, 0.7, 0},
                                      .collision = Collision{},
                                      .drag = 0}));
  joint.a = must(l.world.add(RigidBody{.motion = Motion::fixed}));
  joint.b = l.table, joint.anchor = {0, 0.5, 0}, joint.axis = {0, 1, 0};
  l.joint = must(l.world.add(joint));
  return l;
}

struct Ended {
  Real table = 0, load = 0, speed = 0;  // m, m, m/s
  Real force = 0;                       // N, upwards on the load
};
Ended run(Lift made, Real h, Real duration) {
  Simulation sim(std::move(made.world));
  sim.settings.h = h;
  while (sim.world.time < duration - h / 2) REQUIRE(sim.step().status == Status::ok);
  CHECK(sim.findings().empty());
  Ended e;
  e.table = sim.world.bodies[made.table].pose.position.y;
  e.load = sim.world.bodies[made.load].pose.position.y;
  e.speed = sim.world.bodies[made.table].velocity.y;
  const std::uint32_t load = sim.world.bodies.slot(made.load);
  for (const Contact& c : contacts_of(sim.world))
    e.force += c.slot_a == load ? c.force.y : c.slot_b == load ? -c.force.y : 0;
  return e;
}

}  // namespace

TEST_CASE("a spring yields to a load that lies on it by its weight over the stiffness") {
  const Real h = GENERATE(1.0 / 30, 1.0 / 60, 1.0 / 240, 1.0 / 960),
             mass = GENERATE(0.1, 5.0, 80.0);
  CAPTURE(h, mass);
  constexpr Real kStiff = 1e4;
  const Ended e =
      run(lift(mass, {.spring = {.stiffness = kStiff, .damping = 1500, .rest = 0}}), h, 4);
  CHECK(e.table == Approx(0.5 - (mass + kLoad) * kG / kStiff).margin(2e-6));
  CHECK(e.load == Approx(e.table + 0.2).margin(1e-9));
  CHECK(std::abs(e.speed) < 1e-5);
  CHECK(e.force == Approx(kLoad * kG).epsilon(1e-4));
}

TEST_CASE("a damper lets a load that lies on it sink at its weight over the damping") {
  const Real h = GENERATE(1.0 / 60, 1.0 / 960);
  const Ended e = run(lift(0.5, {.spring = {.stiffness = 0, .damping = 2000}}), h, 2);
  CHECK(e.speed == Approx(-(0.5 + kLoad) * kG / 2000).epsilon(1e-6));
  CHECK(e.force == Approx(kLoad * kG).epsilon(1e-6));
}

TEST_CASE("a motor lifts a load that lies on it as if it were joined") {
  const Real h = GENERATE(1.0 / 30, 1.0 / 60, 1.0 / 240, 1.0 / 960);
  const Real cap = GENERATE(300.0, 1e5);
  CAPTURE(h, cap);
  constexpr Real kGain = 1e4, kSpeed = 0.2, kWeight = (5 + kLoad) * kG;
  const Ended e = run(
      lift(5,
           {.motor = {.kind = MotorKind::velocity, .target = kSpeed, .gain = kGain, .cap = cap}}),
      h, 2);
  CHECK(e.speed == Approx(kSpeed - kWeight / kGain).epsilon(1e-9));
  CHECK(e.load == Approx(e.table + 0.2).margin(1e-9));
  CHECK(e.force == Approx(kLoad * kG).epsilon(1e-6));
}

TEST_CASE("a motor at its bound presses with that force, whatever is between") {
  const Real h = GENERATE(1.0 / 60, 1.0 / 240, 1.0 / 960), cap = GENERATE(100.0, 5000.0);
  CAPTURE(h, cap);
  World w;
  must(w.add(RigidBody{.motion = Motion::fixed, .shape = PlaneShape{}, .collision = Collision{}}));
  const auto box = [&](Real mass, Vec3 half, Real y) {
    return must(w.add(RigidBody{.shape = BoxShape{half},
                                .mass = mass,
                                .position = {0, y, 0},
                                .collision = Collision{},
                                .drag = 0}));
  };
  const Entity lower = box(1, {0.1, 0.1, 0.1}, 0.1), piston = box(2, {0.2, 0.05, 0.2}, 0.25);
  const Entity frame = must(w.add(RigidBody{.motion = Motion::fixed}));
  must(w.add(PrismaticJoint{
      .a = frame,
      .b = piston,
      .anchor = {0, 0.6, 0},
      .axis = {0, 1, 0},
      .motor = {.kind = MotorKind::velocity, .target = -0.5, .gain = 1e6, .cap = cap}}));
  Simulation sim(std::move(w));
  sim.settings.h = h;
  while (sim.world.time < 1) REQUIRE(sim.step().status == Status::ok);
  CHECK(sim.findings().empty());
  const std::uint32_t floor = 0, slot = sim.world.bodies.slot(lower);
  Real pressed = 0;
  for (const Contact& c : contacts_of(sim.world))
    if (c.slot_a == slot && c.slot_b == floor) pressed += c.force.y;
  CHECK(pressed == Approx(cap + 3 * kG).epsilon(1e-6));
  CHECK(glm::length(sim.world.bodies[piston].velocity) < 1e-9);
}

TEST_CASE("a load dropped on a spring moves alike at all steps, to first order") {
  const auto after = [](Real h) {
    Lift made = lift(1, {.spring = {.stiffness = 4000, .damping = 100, .rest = 0}});
    made.world.bodies[made.load].pose.position.y += 0.1;
    return run(std::move(made), h, 1).load;
  };
  const Real exact = after(1.0 / 15360);
  const Real coarse = std::abs(after(1.0 / 960) - exact),
             fine = std::abs(after(1.0 / 3840) - exact);
  CHECK(coarse < 2e-3);
  CHECK(fine < 0.4 * coarse);
}
