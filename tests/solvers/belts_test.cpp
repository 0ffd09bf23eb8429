// Surfaces that move on their bodies, as belts do, against closed forms.
#include <catch2/catch.hpp>

#include "engine/contact/contact.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81;

/// A step, and the error that is allowed at it.
struct Case {
  Real h, error;
};
constexpr Case kCases[] = {{1.0 / 60, 0.01}, {1.0 / 240, 0.001}};

Collision surface(Real friction, Vec3 velocity = Vec3(0)) {
  Collision c;
  c.friction = friction, c.others = true, c.surface_velocity = velocity;
  return c;
}

Quat slope(Real degrees) { return from_rotation_vector({0, 0, degrees * kPi / 180}); }

World awake() {
  World w;
  w.default_settings.sleep_speed = 0;
  return w;
}

void run(Simulation& sim, Real seconds) {
  for (int i = 0; i < std::lround(seconds / sim.settings.h); ++i)
    REQUIRE(sim.step().status == Status::ok);
}

/// Bodies that a belt may be part of, its surface at y = 0, running along its own x axis.
Entity add_belt(World& w, Motion motion, Real friction, Real speed, Quat rotation = kIdentity) {
  const Entity e = add_solid(w, box_shape({50, 0.1, 1}), {rotation * Vec3(0, -0.1, 0), rotation},
                             motion, surface(friction, {speed, 0, 0}));
  return e;
}

}  // namespace

TEST_CASE("a box laid on a belt slides until it has the belt's speed") {
  for (const auto& [h, error] : kCases)
    for (const Motion motion : {Motion::fixed, Motion::kinematic})
      for (const Real friction : {0.1, 0.4}) {
        World w = awake();
        add_belt(w, motion, friction, 1);
        const Entity e = add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0, 0.1, 0}, kIdentity},
                                   Motion::dynamic, surface(friction));
        Simulation sim = Simulation::copy_of(w, {h});
        const Real time = 1 / (friction * kG), way = 1 / (2 * friction * kG);
        const Body& b = sim.world.bodies[e];
        Real reached = 0;
        for (int i = 1; i <= std::lround(2 / h); ++i) {
          const Real before = b.velocity.x;
          sim.step();
          // Within the step, by the acceleration before.
          if (reached == 0 && b.velocity.x > 1 - 1e-9)
            reached = (i - 1) * h + (1 - before) / (friction * kG);
        }
        INFO("friction " << friction << " at " << h << " s");
        CHECK(reached == Approx(time).epsilon(error));
        CHECK(b.velocity.x == Approx(1).epsilon(1e-9));
        const Real slid = 2 - b.pose.position.x;   // beside the belt, that has come 2 m
        CHECK(slid == Approx(way).epsilon(0.01));  // of first order in the substep
        CHECK(glm::length(b.angular_velocity) < 1e-9);
        CHECK(std::abs(b.pose.position.z) < 1e-9);
      }
}

TEST_CASE("a ball laid on a belt rolls back with two sevenths of its speed") {
  for (const auto& [h, error] : kCases) {
    World w = awake();
    add_belt(w, Motion::fixed, 0.3, 1);
    const Entity e =
        add_solid(w, ball_shape(0.1), {{0, 0.1, 0}, kIdentity}, Motion::dynamic, surface(0.3));
    Simulation sim = Simulation::copy_of(w, {h});
    run(sim, 2);
    const Body& b = sim.world.bodies[e];
    // Its moment about a line on the belt stays nought: v = 2/5 r w, and v + r w is the belt's.
    CHECK(b.velocity.x == Approx(2.0 / 7).epsilon(error));
    CHECK(b.angular_velocity.z == Approx(10 * 5.0 / 7).epsilon(error));
  }
}

TEST_CASE("a belt on a slope below the angle of friction carries up, above it lets slide") {
  for (const auto& [h, error] : kCases)
    for (const Real degrees : {20.0, 26.5, 27.0, 35.0}) {  // from 26.565 on
      World w = awake();
      add_belt(w, Motion::fixed, 0.5, 0.7, slope(degrees));
      const Entity e = add_solid(w, box_shape({0.2, 0.05, 0.2}),
                                 {slope(degrees) * Vec3(0, 0.05, 0), slope(degrees)},
                                 Motion::dynamic, surface(0.5));
      w.bodies[e].velocity = slope(degrees) * Vec3(0.7, 0, 0);
      Simulation sim = Simulation::copy_of(w, {h});
      run(sim, 2);
      const Real angle = degrees * kPi / 180;
      const Real loss = 2 * kG * std::max(Real(0), std::sin(angle) - 0.5 * std::cos(angle));
      const Vec3 v = glm::conjugate(slope(degrees)) * sim.world.bodies[e].velocity;
      INFO(degrees << " degrees at " << h << " s");
      CHECK(std::abs(v.x - (0.7 - loss)) <= error * loss + 1e-9);
      CHECK(std::abs(v.y) < 1e-9);
    }
}

TEST_CASE("a belt turns with its body, and with the frame that the body was placed by") {
  World w = awake();
  const Quat turn = from_rotation_vector({0, kPi / 2, 0});  // x to -z
  const Entity belt = add_belt(w, Motion::fixed, 0.5, 1);
  w.origins.add(belt, {Vec3(0), turn});
  const Entity e = add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0, 0.1, 0}, kIdentity},
                             Motion::dynamic, surface(0.5));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  run(sim, 1);
  CHECK(glm::length(sim.world.bodies[e].velocity - Vec3(0, 0, -1)) < 1e-9);
}

TEST_CASE("the speeds of two belts, and of a belt and its body, add up") {
  World w = awake();
  const Entity belt = add_belt(w, Motion::kinematic, 0.5, 1);
  KinematicPath path;
  path.curve = Keyframes{{{0, {{0, -0.1, 0}, kIdentity}}, {10, {{5, -0.1, 0}, kIdentity}}}, false};
  w.paths.add(belt, path);
  // Its own tracks run backwards below, and so drive it ahead.
  const Entity e = add_solid(w, box_shape({0.4, 0.1, 0.2}), {{0, 0.1, 0}, kIdentity},
                             Motion::dynamic, surface(0.5, {-0.25, 0, 0}));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  run(sim, 2);
  const Real driven = sim.world.bodies[belt].velocity.x;
  CHECK(driven > 0.4);
  CHECK(sim.world.bodies[e].velocity.x == Approx(driven + 1.25).epsilon(1e-9));
}

TEST_CASE("what runs along a normal moves nothing") {
  World w = awake();
  add_solid(w, box_shape({5, 0.1, 1}), {{0, -0.1, 0}, kIdentity}, Motion::fixed,
            surface(0.5, {0, 3, 0}));
  const Entity e = add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0, 0.1, 0}, kIdentity},
                             Motion::dynamic, surface(0.5));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  run(sim, 1);
  CHECK(glm::length(sim.world.bodies[e].velocity) < 1e-9);
  CHECK(std::abs(sim.world.bodies[e].pose.position.y - 0.1) < 1e-9);
}

TEST_CASE("a belt on a dynamic body drives both ways: momentum is kept") {
  for (const auto& [h, error] : kCases) {
    World w = awake();
    add_ground(w, surface(0));
    const Entity cart = add_solid(w, box_shape({2, 0.1, 1}), {{0, 0.1, 0}, kIdentity},
                                  Motion::dynamic, surface(0.5, {1, 0, 0}), 50);
    const Entity load = add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0, 0.3, 0}, kIdentity},
                                  Motion::dynamic, surface(0.5));
    // The ground is smooth: of two frictions the geometric mean counts.
    const Real m = w.bodies[cart].mass, n = w.bodies[load].mass;
    Simulation sim = Simulation::copy_of(w, {h});
    run(sim, 0.6);
    const Real v = sim.world.bodies[cart].velocity.x, u = sim.world.bodies[load].velocity.x;
    CHECK(std::abs(m * v + n * u) < 1e-9 * n);
    CHECK(u - v == Approx(1).epsilon(1e-3));
    CHECK(u == Approx(m / (m + n)).epsilon(error));
  }
}

TEST_CASE("tracks drive a vehicle by no more than friction allows") {
  for (const auto& [h, error] : kCases) {
    World w = awake();
    add_ground(w, surface(0.3));
    const Entity e = add_solid(w, box_shape({0.5, 0.1, 0.3}), {{0, 0.1, 0}, kIdentity},
                               Motion::dynamic, surface(0.3, {-2, 0, 0}));
    Simulation sim = Simulation::copy_of(w, {h});
    run(sim, 0.5);
    CHECK(sim.world.bodies[e].velocity.x == Approx(0.5 * 0.3 * kG).epsilon(error));
    run(sim, 1);
    CHECK(sim.world.bodies[e].velocity.x == Approx(2).epsilon(1e-9));
  }
}

TEST_CASE("what lies on a belt sleeps while it stands and wakes when it starts") {
  World w;
  const Entity belt = add_belt(w, Motion::fixed, 0.5, 0);
  const Entity lower = add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0, 0.1, 0}, kIdentity},
                                 Motion::dynamic, surface(0.5));
  const Entity upper = add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0, 0.3, 0}, kIdentity},
                                 Motion::dynamic, surface(0.5));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  run(sim, 4);
  CHECK(sim.world.bodies[lower].velocity == Vec3(0));  // what sleeps has no speed at all
  CHECK(sim.world.bodies[upper].velocity == Vec3(0));
  const Real start = sim.world.bodies[lower].pose.position.x;
  sim.world.collisions[belt].surface_velocity = {0.5, 0, 0};
  run(sim, 2);
  for (const Entity e : {lower, upper}) {
    CHECK(sim.world.bodies[e].velocity.x == Approx(0.5).epsilon(1e-3));
    CHECK(sim.world.bodies[e].pose.position.x - start > 0.9);
  }
  sim.world.collisions[belt].surface_velocity = Vec3(0);
  run(sim, 5);
  CHECK(sim.world.bodies[lower].velocity == Vec3(0));
  CHECK(sim.world.bodies[upper].velocity == Vec3(0));
}

TEST_CASE("a slow belt, far below the speed of sleep, carries all the same") {
  World w;
  w.default_settings.sleep_speed = 0.05;
  add_belt(w, Motion::fixed, 0.5, 0.002);
  const Entity e = add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0, 0.1, 0}, kIdentity},
                             Motion::dynamic, surface(0.5));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  run(sim, 10);
  CHECK(sim.world.bodies[e].pose.position.x == Approx(0.02).epsilon(1e-3));
}

TEST_CASE("a chain laid along a belt is carried, and takes no more than friction gives") {
  for (const auto& [h, error] : kCases) {
    World w = awake();
    add_belt(w, Motion::fixed, 0.2, 1);
    const Real half = 0.1, r = 0.05;
    Entity before;
    std::vector<Entity> links;
    for (int i = 0; i < 6; ++i) {
      const Entity e = add_solid(w, box_shape({half, r, r}), {{2 * half * i, r, 0}, kIdentity},
                                 Motion::dynamic, surface(0.2));
      links.push_back(e);
      if (i > 0) {
        Joint joint;
        joint.anchor_a = {half, 0, 0}, joint.anchor_b = {-half, 0, 0};
        add_link(w, {before, e, joint});
      }
      before = e;
    }
    Simulation sim = Simulation::copy_of(w, {h});
    run(sim, 0.25);
    for (const Entity e : links)
      CHECK(sim.world.bodies[e].velocity.x == Approx(0.25 * 0.2 * kG).epsilon(error));
    run(sim, 1.25);
    for (const Entity e : links) CHECK(sim.world.bodies[e].velocity.x == Approx(1).epsilon(error));
  }
}

TEST_CASE("a thin box is carried upright round the clock, blocked or not") {
  // Against a wall at the belt's end it stands and rubs; the wall bears mu times its weight.
  World w;
  add_belt(w, Motion::fixed, 0.4, 1);
  const Entity wall =
      add_solid(w, box_shape({0.1, 1, 1}), {{1, 1, 0}, kIdentity}, Motion::fixed, surface(0));
  const Entity e = add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0.5, 0.1, 0}, kIdentity},
                             Motion::dynamic, surface(0.4));
  const Real weight = w.bodies[e].mass * kG;
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  run(sim, 3);
  Vec3 on_wall(0);
  for (const Contact& c : contacts_of(sim.world))
    if (c.slot_b == sim.world.bodies.slot(wall)) on_wall += c.force;
  CHECK(on_wall.x == Approx(-0.4 * weight).epsilon(1e-3));
  CHECK(sim.world.bodies[e].pose.position.x == Approx(0.7).margin(1e-4));
}
