// Free bodies that roll, slide, bounce and stand, against closed forms.
#include <catch2/catch.hpp>

#include "engine/contact/contact.hpp"
#include "engine/pantin/measure.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// A step, and the error that is allowed at it.
struct Case {
  Real h, error;
};
constexpr Case kCases[] = {{1.0 / 60, 0.01}, {1.0 / 240, 0.001}};

Collision surface(Real friction, Real restitution = 0) {
  Collision c;
  c.friction = friction, c.restitution = restitution, c.others = true;
  return c;
}

World awake() {
  World w;
  w.default_settings.sleep_speed = 0;
  return w;
}

Quat slope(Real degrees) { return from_rotation_vector({0, 0, -degrees * kPi / 180}); }

void run(Simulation& sim, Real seconds, Real h) {
  for (int i = 0; i < std::lround(seconds / h); ++i) REQUIRE(sim.step().status == Status::ok);
}

}  // namespace

TEST_CASE("a ball rolls on level ground at constant speed") {
  for (const auto& [h, error] : kCases)
    for (const Real speed : {0.05, 1.0, 12.0}) {
      World w = awake();
      add_ground(w, surface(0.5));
      const Entity e =
          add_solid(w, ball_shape(0.1), {{0, 0.1, 0}, kIdentity}, Motion::dynamic, surface(0.5));
      w.bodies[e].velocity = {speed, 0, 0}, w.bodies[e].angular_velocity = {0, 0, -10 * speed};
      Simulation sim = Simulation::copy_of(w, {h});
      for (int i = 0; i < std::lround(5 / h); ++i) {
        sim.step();
        const Body& b = sim.world.bodies[e];
        REQUIRE(std::abs(b.velocity.x - speed) <= 1e-9 * speed);
        REQUIRE(std::abs(b.angular_velocity.z + 10 * speed) <= 1e-8 * speed);
        REQUIRE(std::abs(b.pose.position.y - 0.1) <= 1e-9);
      }
    }
}

TEST_CASE("a ball rolls down a slope with five sevenths of what slides") {
  for (const auto& [h, error] : kCases) {
    World w = awake();
    add_ground(w, surface(0.5), slope(10));
    const Entity e = add_solid(w, ball_shape(0.1), {slope(10) * Vec3(0, 0.1, 0), kIdentity},
                               Motion::dynamic, surface(0.5));
    Simulation sim = Simulation::copy_of(w, {h});
    run(sim, 1, h);
    const Real exact = 5.0 / 7 * 9.81 * std::sin(10 * kPi / 180);
    CHECK(glm::length(sim.world.bodies[e].velocity) == Approx(exact).epsilon(error));
  }
}

TEST_CASE("a bowling ball slides until it rolls; a belt sets one in motion") {
  for (const auto& [h, error] : kCases) {
    World w = awake();
    add_ground(w, surface(0.2));
    const Entity bowled =
        add_solid(w, ball_shape(0.1), {{0, 0.1, 0}, kIdentity}, Motion::dynamic, surface(0.2));
    w.bodies[bowled].velocity = {5, 0, 0};
    Simulation sim = Simulation::copy_of(w, {h});
    run(sim, 2, h);
    CHECK(sim.world.bodies[bowled].velocity.x == Approx(25.0 / 7).epsilon(error));

    World belt = awake();
    const Entity moved = add_solid(belt, box_shape({50, 0.1, 1}), {{0, -0.1, 0}, kIdentity},
                                   Motion::kinematic, surface(0.3));
    KinematicPath path;
    path.curve =
        Keyframes{{{0, {{0, -0.1, 0}, kIdentity}}, {10, {{10, -0.1, 0}, kIdentity}}}, false};
    belt.paths.add(moved, path);
    const Entity laid =
        add_solid(belt, ball_shape(0.1), {{0, 0.1, 0}, kIdentity}, Motion::dynamic, surface(0.3));
    Simulation carried = Simulation::copy_of(belt, {h});
    run(carried, 2, h);
    CHECK(carried.world.bodies[laid].velocity.x ==
          Approx(2.0 / 7 * carried.world.bodies[moved].velocity.x).epsilon(error));
  }
}

TEST_CASE("a box slides from the angle of friction on, and below it stays") {
  for (const auto& [h, error] : kCases)
    for (const Real degrees : {26.5, 26.63, 27.0, 40.0}) {  // from 26.565 on
      World w = awake();
      add_ground(w, surface(0.5), slope(degrees));
      const Vec3 start = slope(degrees) * Vec3(0, 0.05, 0);
      const Entity e = add_solid(w, box_shape({0.2, 0.05, 0.2}), {start, slope(degrees)},
                                 Motion::dynamic, surface(0.5));
      Simulation sim = Simulation::copy_of(w, {h});
      run(sim, 2, h);
      const Real angle = degrees * kPi / 180;
      const Real a = 9.81 * std::max(Real(0), std::sin(angle) - 0.5 * std::cos(angle));
      INFO(degrees << " degrees at " << h << " s");
      CHECK(std::abs(glm::length(sim.world.bodies[e].velocity) - 2 * a) <= error * 2 * a + 1e-9);
    }
}

TEST_CASE("a box moves from the least push on") {
  for (const auto& [h, error] : kCases)
    for (const Real push : {0.999, 1.001}) {
      World w = awake();
      add_ground(w, surface(0.4));
      const Entity e = add_solid(w, box_shape({0.2, 0.05, 0.2}), {{0, 0.05, 0}, kIdentity},
                                 Motion::dynamic, surface(0.4));
      const Real most = 0.4 * w.bodies[e].mass * 9.81;
      Simulation sim = Simulation::copy_of(w, {h});
      for (int i = 0; i < std::lround(1 / h); ++i) {
        sim.world.push(e, {push * most, 0, 0}, sim.world.bodies[e].pose.position);
        sim.step();
      }
      const Real exact = std::max(Real(0), (push - 1) * 0.4 * 9.81);
      CHECK(std::abs(sim.world.bodies[e].velocity.x - exact) <= 0.02 * exact + 1e-9);
    }
}

TEST_CASE("a ball bounces to the square of its restitution") {
  for (const Real restitution : {1.0, 0.7, 0.3})
    for (const Real height : {1.0, 1.037, 2.3}) {
      World w = awake();
      add_ground(w, surface(0, restitution));
      const Entity e = add_solid(w, ball_shape(0.1), {{0, 0.1 + height, 0}, kIdentity},
                                 Motion::dynamic, surface(0, restitution));
      Simulation sim = Simulation::copy_of(w, {1.0 / 60});
      Real top = 0;
      bool bounced = false;
      for (int i = 0; i < 240; ++i) {
        const Real before = sim.world.bodies[e].velocity.y;
        sim.step();
        const Body& b = sim.world.bodies[e];
        bounced = bounced || b.velocity.y > 0;
        if (bounced && before > 0 && b.velocity.y <= 0) break;
        // The apex of the parabola through what the step shows.
        if (bounced) top = b.pose.position.y - 0.1 + b.velocity.y * b.velocity.y / (2 * 9.81);
      }
      INFO(restitution << " from " << height);
      CHECK(top == Approx(restitution * restitution * height).epsilon(0.01));
    }
}

TEST_CASE("without weight balls bounce however slow they are") {
  for (const Real speed : {1e-4, 2e-3, 0.04, 0.06, 3.0})
    for (const Real h : {1.0 / 60, 1.0 / 480}) {
      World w = awake();
      w.gravity = Vec3(0);
      const Entity still =
          add_solid(w, ball_shape(0.1), {{0, 0, 0}, kIdentity}, Motion::dynamic, surface(0, 1));
      const Entity comes = add_solid(w, ball_shape(0.1), {{0.2 + 0.5 * speed, 0, 0}, kIdentity},
                                     Motion::dynamic, surface(0, 1));
      w.bodies[comes].velocity = {-speed, 0, 0};
      Simulation sim = Simulation::copy_of(w, {h});
      for (int i = 0; i < std::lround(1 / h); ++i) sim.step();
      CAPTURE(speed, h);
      CHECK(sim.world.bodies[still].velocity.x == Approx(-speed).epsilon(1e-6));
      CHECK(sim.world.bodies[comes].velocity.x == Approx(0).margin(1e-6 * speed));
    }
}

TEST_CASE("a blow passes from ball to ball") {
  for (const int balls : {2, 5}) {
    World w = awake();
    w.gravity = Vec3(0);
    std::vector<Entity> row;
    for (int i = 0; i < balls; ++i)
      row.push_back(add_solid(w, ball_shape(0.1), {{0.2 * i + (i > 0 ? 0.5 : 0), 0, 0}, kIdentity},
                              Motion::dynamic, surface(0, 1)));
    w.bodies[row[0]].velocity = {2, 0, 0};
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    const Measures start = measure(w);
    run(sim, 0.6, 1.0 / 60);
    const Measures end = measure(sim.world);
    CHECK(glm::length(end.momentum - start.momentum) <= 1e-12 * glm::length(start.momentum));
    CHECK(end.kinetic == Approx(start.kinetic).epsilon(1e-12));
    for (int i = 0; i < balls; ++i)
      CHECK(sim.world.bodies[row[static_cast<std::size_t>(i)]].velocity.x ==
            Approx(i == balls - 1 ? 2 : 0).margin(1e-9));
  }
}

TEST_CASE("ten boxes stand on one another, and fall asleep where they stand") {
  for (const Real askew : {0.0, 0.03}) {
    World w;
    add_ground(w, surface(0.5));
    std::vector<Entity> boxes;
    for (int i = 0; i < 10; ++i)
      boxes.push_back(add_solid(w, box_shape({0.2, 0.2, 0.2}),
                                {{i % 2 == 0 ? askew : -askew, 0.2 + 0.4 * i, 0},
                                 from_rotation_vector({0, askew * i, 0})},
                                Motion::dynamic, surface(0.5), 400));
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    Real kinetic = 0;
    for (int i = 0; i < 60 * 60; ++i) {
      sim.step();
      if (i > 600) kinetic = std::max(kinetic, measure(sim.world).kinetic);
    }
    CHECK(kinetic <= 1e-3);
    CHECK(sim.step().asleep == 10);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const Body& b = sim.world.bodies[boxes[i]];
      CHECK(glm::distance(b.pose.position, w.bodies[boxes[i]].pose.position) <= 1e-3);
    }
    Real borne = 0;
    each_contact(sim.world, [&](const Contact& c) {
      if (sim.world.bodies.values()[c.slot_b].motion == Motion::fixed) borne += c.force.y;
    });
    CHECK(borne == Approx(10 * 25.6 * 9.81).epsilon(1e-6));
  }
}

TEST_CASE("what bore a load lies on the ground again without it") {
  World w;
  add_ground(w, surface(0.5));
  std::vector<Entity> boxes;
  for (int i = 0; i < 5; ++i)
    boxes.push_back(add_solid(w, box_shape({0.2, 0.2, 0.2}), {{0, 0.2 + 0.4 * i, 0}, kIdentity},
                              Motion::dynamic, surface(0.5), 400));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  run(sim, 15, 1.0 / 60);
  for (std::size_t i = 1; i < boxes.size(); ++i) sim.world.destroy(boxes[i]);
  run(sim, 2, 1.0 / 60);
  CHECK(std::abs(sim.world.bodies[boxes[0]].pose.position.y - 0.2) <= 1e-9);
}

TEST_CASE("a pyramid of boxes stands and falls asleep") {
  World w;
  add_ground(w, surface(0.5));
  std::vector<Entity> boxes;
  for (int row = 0; row < 6; ++row)
    for (int i = 0; i < 6 - row; ++i)
      boxes.push_back(add_solid(w, box_shape({0.2, 0.2, 0.2}),
                                {{0.45 * i + 0.225 * row, 0.2 + 0.4 * row, 0}, kIdentity},
                                Motion::dynamic, surface(0.5), 400));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  for (int i = 0; i < 60 * 4; ++i) sim.step();
  CHECK(sim.step().asleep == 21);
  for (const Entity e : boxes)
    CHECK(glm::distance(sim.world.bodies[e].pose.position, w.bodies[e].pose.position) <= 1e-3);
}

TEST_CASE("a ball that spins on the spot keeps no heap awake, but spins on where few touch") {
  for (const int boxes : {1, 4}) {
    World w;
    add_ground(w, surface(0.5));
    for (int i = 0; i < boxes; ++i)
      add_solid(w, box_shape({0.2, 0.2, 0.2}), {{0, 0.2 + 0.4 * i, 0}, kIdentity}, Motion::dynamic,
                surface(0.5), 400);
    const Entity ball = add_solid(w, ball_shape(0.1), {{0, 0.4 * boxes + 0.1, 0}, kIdentity},
                                  Motion::dynamic, surface(0));
    w.bodies[ball].angular_velocity = {0, 0.1, 0};
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    for (int i = 0; i < 60 * 6; ++i) sim.step();
    CHECK(sim.step().asleep == (boxes == 1 ? 0 : 5));
    if (boxes == 1) CHECK(std::abs(sim.world.bodies[ball].angular_velocity.y - 0.1) <= 1e-9);
  }
}

TEST_CASE("what starts overlapping is pushed apart gently") {
  World w;
  add_ground(w, surface(0.5));
  for (int i = 0; i < 8; ++i)
    add_solid(w, box_shape({0.2, 0.2, 0.2}),
              {{0.1 * (i % 2), 0.25 + 0.15 * (i / 2), 0.07 * i}, kIdentity}, Motion::dynamic,
              surface(0.5));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  Real fastest = 0, depth = 0;
  for (int i = 0; i < 60 * 8; ++i) {
    depth = sim.step().worst_depth;
    for (const Body& b : sim.world.bodies.values())
      fastest = std::max(fastest, glm::length(b.velocity));
  }
  CHECK(fastest <= 6);
  CHECK(depth <= 1e-4);
}

TEST_CASE("a box that falls flat bounces flat, to the height of its restitution") {
  for (const auto& [h, error] : kCases)
    for (const Real restitution : {0.5, 0.8, 1.0}) {
      World w = awake();
      add_ground(w, surface(0.5, restitution));
      const Entity box = add_solid(w, box_shape(Vec3(0.1)), {{0, 1.1, 0}, kIdentity},
                                   Motion::dynamic, surface(0.5, restitution));
      Simulation sim(std::move(w), {h});
      const Real start = measure(sim.world).energy();
      Real highest = 0, spin = 0, most = start;
      const Real fall = std::sqrt(2 / 9.81);
      for (int i = 0; i < std::lround((1 + 1.9 * restitution) * fall / h); ++i) {
        REQUIRE(sim.step().status == Status::ok);
        const Body& b = sim.world.bodies[box];
        if (i * h > fall) highest = std::max(highest, b.pose.position.y - 0.1);
        spin = std::max(spin, glm::length(b.angular_velocity));
        most = std::max(most, measure(sim.world).energy());
      }
      INFO("restitution " << restitution << " at " << h);
      CHECK(highest == Approx(restitution * restitution).epsilon(error));
      CHECK(spin < 1e-6);
      CHECK(most < start * (1 + 1e-8));
    }
}

TEST_CASE("a body that fits exactly between two walls stays there") {
  // Walls that overlap it by 0.3 mm each, one of them rotated by a hair.
  for (const Real turned : {0.0, 1e-6, 1e-4, 1e-3})
    for (const Shape& shape : {ball_shape(0.1), box_shape(Vec3(0.1))})
      for (const Real h : {1.0 / 60, 1.0 / 240}) {
        World w = awake();
        w.gravity = Vec3(0);
        for (const Real side : {-1.0, 1.0})
          add_solid(w, box_shape({0.1, 1, 1}),
                    {{side * 0.1997, 0, 0}, from_rotation_vector({0, side > 0 ? turned : 0, 0})},
                    Motion::fixed, surface(0.5));
        const Entity body =
            add_solid(w, shape, {Vec3(0), kIdentity}, Motion::dynamic, surface(0.5));
        Simulation sim(std::move(w), {h});
        run(sim, 1, h);
        INFO("rotated by " << turned << " at " << h);
        CHECK(glm::length(sim.world.bodies[body].pose.position) < 1e-3);
      }
}
