// Friction where surfaces touch: what slides, when it rolls, when what rolls begins to slip.
#include <catch2/catch.hpp>

#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81, kRadius = 0.1;

void run(Simulation& sim, Real time) {
  const int steps = static_cast<int>(std::lround(time / sim.settings.h));
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
}

/// A ball on a floor, or on one that rises along x by `slope`.
struct Ball {
  World world;
  Entity ball, contact;
  Vec3 up, down;
};
Ball ball_on(Integrator integrator, SurfaceMotion motion, Real friction, Real slope = 0) {
  Ball s{exact_world(integrator), {}, {}, {}, {}};
  s.up = {-std::sin(slope), std::cos(slope), 0}, s.down = {-std::cos(slope), -std::sin(slope), 0};
  const Entity ground = add_ground(s.world);
  s.ball = s.world.add_body(solid_ball(2, kRadius, kRadius * s.up));
  s.contact =
      touch(s.world, {s.ball, ball_skin(Vec3(kRadius)), ground, flat_skin(40, s.up)}, motion);
  s.world.surface_contacts[s.contact].friction = friction;
  return s;
}

/// How far a result of the first order may be off.
Real loose(Integrator integrator, Real tight) {
  return integrator == Integrator::euler ? 2e-2 : tight;
}

}  // namespace

TEST_CASE("surfaces: a ball that is thrown slides, loses 2/7 of its speed, and rolls") {
  for (const Integrator integrator : kAll)
    for (const SurfaceMotion motion : {SurfaceMotion::sliding, SurfaceMotion::rolling}) {
      INFO(name_of(integrator) << " " << static_cast<int>(motion));
      constexpr Real kFriction = 0.2, kSpeed = 3;
      Ball s = ball_on(integrator, motion, kFriction);
      s.world.bodies[s.ball].velocity = {kSpeed, 0, 0};
      Simulation sim(std::move(s.world), {1.0 / 100});
      const Real ends = 2 * kSpeed / (7 * kFriction * kG);  // 0.437 s
      run(sim, 0.4);
      const Body& b = sim.world.bodies[s.ball];
      const SurfaceContact& c = sim.world.surface_contacts[s.contact];
      CHECK(c.slips);
      CHECK(b.velocity.x == Approx(kSpeed - kFriction * kG * 0.4).epsilon(1e-9));
      CHECK(b.angular_velocity.z == Approx(-2.5 * kFriction * kG * 0.4 / kRadius).epsilon(1e-9));
      // On the floor: its weight, and friction the way it slides.
      CHECK(glm::distance(c.force, {kFriction * 2 * kG, -2 * kG, 0}) <= 1e-9 * 2 * kG);
      run(sim, 0.2);
      CHECK_FALSE(c.slips);
      CHECK(b.velocity.x == Approx(5.0 / 7 * kSpeed).epsilon(1e-8));
      CHECK(slip_of(sim.world, s.contact) <= 1e-8);
      const Real way =
          kSpeed * ends - kFriction * kG * ends * ends / 2 + 5.0 / 7 * kSpeed * (0.6 - ends);
      CHECK(b.pose.position.x == Approx(way).epsilon(loose(integrator, 1e-7)));
    }
}

TEST_CASE("surfaces: a ball on an incline rolls, or slips where friction cannot hold it") {
  for (const Integrator integrator : kAll)
    for (const Real friction : {0.05, 0.1, 0.2}) {
      INFO(name_of(integrator) << ", friction " << friction);
      const Real slope = 0.4;  // needs 2/7 of its tangent: 0.121
      Ball s = ball_on(integrator, SurfaceMotion::rolling, friction, slope);
      Simulation sim(std::move(s.world), {1.0 / 100});
      run(sim, 0.5);
      const bool holds = friction > 2.0 / 7 * std::tan(slope);
      const Real a = holds ? 5.0 / 7 * kG * std::sin(slope)
                           : kG * (std::sin(slope) - friction * std::cos(slope));
      const Body& b = sim.world.bodies[s.ball];
      CHECK(glm::length(b.velocity - 0.5 * a * s.down) <= 1e-9);
      const Real spin =
          holds ? 0.5 * a / kRadius : 0.5 * 2.5 * friction * kG * std::cos(slope) / kRadius;
      CHECK(glm::length(b.angular_velocity) == Approx(spin).epsilon(1e-9));
      CHECK(sim.world.surface_contacts[s.contact].slips == !holds);
    }
}

TEST_CASE("surfaces: a ball that is thrown with spin curves as it slides, along a parabola") {
  // The slip keeps its way in space, so friction is constant until the ball rolls.
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    constexpr Real kFriction = 0.1;
    Ball s = ball_on(integrator, SurfaceMotion::sliding, kFriction);
    Body& start = s.world.bodies[s.ball];
    start.velocity = {2, 0, 0}, start.angular_velocity = {20, 0, 0};
    const Vec3 slip = start.velocity + glm::cross(start.angular_velocity, -kRadius * s.up);
    Simulation sim(std::move(s.world), {1.0 / 100});
    const Real ends = 2 * glm::length(slip) / (7 * kFriction * kG);
    const Vec3 rolls = Vec3(2, 0, 0) - 2.0 / 7 * slip;
    run(sim, 0.3);
    CHECK(glm::length(sim.world.bodies[s.ball].velocity -
                      (Vec3(2, 0, 0) - kFriction * kG * 0.3 * glm::normalize(slip))) <= 1e-8);
    run(sim, std::ceil(ends * 10) / 10);
    CHECK(glm::length(sim.world.bodies[s.ball].velocity - rolls) <= 1e-7);
  }
}

namespace {

/// The error of a ball that lies on a turntable of low friction, after a second.
struct OnTable {
  Real speed = 0, side = 0;
  bool slips = false;
};
OnTable on_turntable(Integrator integrator, Real friction, Real radius, Real h) {
  World w = exact_world(integrator);
  constexpr Real kRate = 4;
  Body table;
  table.motion = Motion::kinematic;
  const Entity turntable = w.add_body(table);
  const Entity ball = w.add_body(solid_ball(1, kRadius, {radius, kRadius, 0}));
  const Entity contact =
      touch(w, {ball, ball_skin(Vec3(kRadius)), turntable, flat_skin(10)}, SurfaceMotion::rolling);
  w.surface_contacts[contact].friction = friction;
  Simulation sim(std::move(w), {h});
  compile_if_changed(sim.world);
  lagrangian::Frame& frame = lagrangian::islands_of(sim.world).at(0).frames.at(0);
  frame.before = {}, frame.known = true;
  for (int i = 0; i < std::lround(0.05 / h); ++i) {
    sim.world.bodies[turntable].pose.rotation = from_rotation_vector({0, kRate * h * (i + 1), 0});
    REQUIRE(sim.step().status == Status::ok);
  }
  const Body& b = sim.world.bodies[ball];
  return {glm::length(b.velocity), b.pose.position.x, sim.world.surface_contacts[contact].slips};
}

}  // namespace

TEST_CASE("surfaces: a ball that is put on a turntable slips, as friction can drag it") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    // It gets mu g whichever way the table drags it, while it slips.
    const OnTable found = on_turntable(integrator, 0.05, 0.5, 1.0 / 400);
    CHECK(found.slips);
    CHECK(found.speed == Approx(0.05 * kG * 0.05).epsilon(loose(integrator, 3e-3)));
    const OnTable held = on_turntable(integrator, 20, 0.5, 1.0 / 400);
    CHECK_FALSE(held.slips);
    CHECK(held.speed > 0.1);
  }
}

TEST_CASE("surfaces: friction keeps order 4 while it slides in a bowl") {
  const auto end_of = [](Integrator integrator, Real h) {
    World w = exact_world(integrator);
    const Entity ground = add_ground(w);
    const Entity ball = w.add_body(solid_ball(1, kRadius, {0.6, -0.6708203932499369, 0}));
    const SkinPtr bowl =
        skin_of(turned_over(nurbs::sphere({{}, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, 1)));
    const Entity contact =
        touch(w, {ball, ball_skin(Vec3(kRadius)), ground, bowl}, SurfaceMotion::sliding);
    w.surface_contacts[contact].friction = 0.1;
    w.bodies[ball].velocity = {0, 0, 1};
    Simulation sim(std::move(w), {h});
    run(sim, 0.2);
    CHECK(sim.world.surface_contacts[contact].slips);
    return sim.world.bodies[ball].pose.position;
  };
  const Vec3 best = end_of(Integrator::rk4, 1.0 / 3200);
  const Real coarse = glm::distance(end_of(Integrator::rk4, 1.0 / 100), best),
             fine = glm::distance(end_of(Integrator::rk4, 1.0 / 200), best);
  CHECK(fine <= 1e-8);
  CHECK(std::log2(coarse / fine) == Approx(4).margin(0.5));
  CHECK(glm::distance(end_of(Integrator::radau, 1.0 / 100), best) <= 1e-8);
  const auto error = [&](Integrator by, Real h) { return glm::distance(end_of(by, h), best); };
  CHECK(error(Integrator::rattle, 1.0 / 400) <= 3e-6);
  CHECK(std::log2(error(Integrator::rattle, 1.0 / 200) / error(Integrator::rattle, 1.0 / 400)) ==
        Approx(2).margin(0.1));
  CHECK(error(Integrator::implicit, 1.0 / 400) <= 2e-6);
  CHECK(std::log2(error(Integrator::implicit, 1.0 / 200) /
                  error(Integrator::implicit, 1.0 / 400)) == Approx(2).margin(0.1));
  CHECK(std::log2(error(Integrator::euler, 1.0 / 200) / error(Integrator::euler, 1.0 / 400)) ==
        Approx(1).margin(0.1));
}

TEST_CASE("surfaces: a ball that lands on a floor with friction loses what the blow can take") {
  for (const Integrator integrator : kAll)
    for (const Real friction : {0.05, 1.0}) {
      INFO(name_of(integrator) << ", friction " << friction);
      Ball s = ball_on(integrator, SurfaceMotion::rolling, friction);
      s.world.surface_contacts[s.contact].lifts = true;
      Body& start = s.world.bodies[s.ball];
      start.pose.position.y = kRadius + 0.2;
      start.velocity = {1, 0, 0};
      Simulation sim(std::move(s.world), {1.0 / 100});
      const Real lands = std::sqrt(0.4 / kG), blow = std::sqrt(0.4 * kG);
      run(sim, 0.25);
      const Body& b = sim.world.bodies[s.ball];
      CHECK(b.pose.position.y == Approx(kRadius).margin(1e-8));
      // The blow takes mu times its own speed, or 2/7 of the slip.
      const Real after = std::max(1 - friction * (blow + kG * (0.25 - lands)), 5.0 / 7);
      CHECK(b.velocity.x == Approx(after).epsilon(loose(integrator, 1e-4)));
    }
}

TEST_CASE("surfaces: friction drags what is below as much as it holds back what slides") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    World w = exact_world(integrator, {0, 0, 0});
    const Entity slab = w.add_body(solid(4, Vec3(0.5)));
    const Entity ball = w.add_body(solid_ball(1, kRadius, {0, kRadius, 0}));
    w.bodies[ball].velocity = {2, 0, 0};
    const Entity contact =
        touch(w, {ball, ball_skin(Vec3(kRadius)), slab, flat_skin(4)}, SurfaceMotion::sliding);
    w.surface_contacts[contact].friction = 0.2;
    w.forces.add(ball, {{0, -20, 0}, {0, 0, 0}}), w.forces.add(slab, {{0, 20, 0}, {0, 0, 0}});
    Simulation sim(std::move(w), {1.0 / 200});
    sim.step();
    const Real left = sim.world.bodies[ball].velocity.x, taken = sim.world.bodies[slab].velocity.x;
    CHECK(left < 2 - 0.01);
    CHECK(left + 4 * taken == Approx(2).epsilon(1e-9));
  }
}

TEST_CASE("surfaces: a slip goes on to the same bits in copies and saved worlds") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    Ball s = ball_on(integrator, SurfaceMotion::sliding, 0.2);
    s.world.bodies[s.ball].velocity = {3, 0, 0.5};
    Simulation one(std::move(s.world), {1.0 / 100});
    run(one, 0.2);
    Simulation copy = Simulation::copy_of(one.world, {1.0 / 100});
    run(one, 0.4), run(copy, 0.4);
    CHECK(state_hash(one.world) == state_hash(copy.world));
  }
}
