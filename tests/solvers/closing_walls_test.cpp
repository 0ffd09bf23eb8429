// What kinematic bodies crush is not thrown: their impulses have no limit, their speed has.
#include <catch2/catch.hpp>

#include "engine/pantin/figures.hpp"
#include "engine/pantin/measure.hpp"
#include "engine/pantin/must.hpp"
#include "tests/base/random.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kStep = 1.0 / 60;

enum class What { boxes, balls, rods, mixture };

Shape shape_of(What what, int i, Random& dice) {
  const auto half = [&] { return dice.between(0.08, 0.12); };
  if (what == What::mixture) what = static_cast<What>(i % 3);
  if (what == What::balls) return ball_shape(half());
  if (what == What::rods) return rod_shape(dice.between(0.05, 0.08), dice.between(0.08, 0.15));
  const Real x = half(), y = half(), z = half();
  return box_shape({x, y, z});
}

struct Fastest {
  Real speed = 0;    // m/s
  Real kinetic = 0;  // of all, as a multiple of theirs at the speed of the plate
};

/// Lets a plate come down on what lies on the ground, until nothing is left of the gap.
Fastest crush(World w, Real speed) {
  const Entity plate =
      add_solid(w, box_shape({2, 0.1, 2}), {{0, 1.6, 0}, kIdentity}, Motion::kinematic);
  Simulation sim(std::move(w));
  for (int i = 0; i < 120; ++i) sim.step();
  Real mass = 0;
  for (const Body& b : sim.world.bodies.values())
    if (b.motion == Motion::dynamic) mass += b.mass;
  Fastest most;
  const int steps = static_cast<int>(1.5 / speed / kStep);
  for (int i = 0; i < steps; ++i) {
    Body& b = sim.world.bodies[plate];
    b.pose.position.y -= speed * kStep, b.velocity = {0, -speed, 0};
    CHECK(sim.step().status != Status::diverged);
    for (const Body& body : sim.world.bodies.values())
      if (body.motion == Motion::dynamic)
        most.speed = std::max(most.speed, glm::length(body.velocity));
    const Real all = 0.5 * mass * speed * speed;
    most.kinetic = std::max(most.kinetic, measure(sim.world).kinetic / all);
  }
  return most;
}

}  // namespace

TEST_CASE("a plate that crushes a pile throws nothing out of it") {
  for (const What what : {What::boxes, What::balls, What::rods, What::mixture})
    for (const std::uint64_t seed : {1, 2, 3})
      for (const Real speed : {0.5, 2.0}) {
        World w;
        add_ground(w);
        Random dice(seed);
        for (int i = 0; i < 10; ++i) {
          const Real x = dice.between(-0.2, 0.2), z = dice.between(-0.2, 0.2);
          add_solid(w, shape_of(what, i, dice), {{x, 0.15 + 0.12 * i, z}, kIdentity},
                    Motion::dynamic);
        }
        CAPTURE(static_cast<int>(what), seed, speed);
        const Fastest most = crush(std::move(w), speed);
        CHECK(most.speed < 8 * speed + 2);
        CHECK(most.kinetic < 25);
      }
}

TEST_CASE("a plate that crushes a ragdoll does not tear or throw it") {
  for (const Real speed : {0.5, 2.0}) {
    World w;
    add_ground(w);
    must(build_ragdoll(w, RagdollOptions{.position = {0, 0.2, 0}}));
    CAPTURE(speed);
    const Fastest most = crush(std::move(w), speed);
    CHECK(most.speed < 20 * speed);
    CHECK(most.kinetic < 25);
  }
}

TEST_CASE("a plate that leans a little drives what is under it out as a wedge does") {
  constexpr Real kRadius = 0.1;
  for (const Real degrees : {2.0, 5.0, 12.0})
    for (const int balls : {2, 3, 6})
      for (const Real h : {1.0 / 60, 1.0 / 240}) {
        CAPTURE(degrees, balls, h);
        const Real angle = degrees * kPi / 180, speed = 0.1;
        const Collision smooth{.friction = 0};
        World w;
        w.gravity = Vec3(0);
        add_ground(w, smooth);
        std::vector<Entity> all;
        for (int i = 0; i < balls; ++i)
          all.push_back(add_solid(w, ball_shape(kRadius),
                                  {{0, kRadius, 2 * kRadius * i}, kIdentity}, Motion::dynamic,
                                  smooth));
        const Vec3 down(std::sin(angle), -std::cos(angle), 0);
        const Pose from{Vec3(0, kRadius, 0) - 0.2001 * down, glm::angleAxis(angle, Vec3(0, 0, 1))};
        const Entity plate = add_solid(w, box_shape({8, 0.1, 3}), from, Motion::kinematic, smooth);
        Simulation sim(std::move(w), {h});
        for (int i = 0; i < static_cast<int>(0.03 / speed / h); ++i) {
          Body& b = sim.world.bodies[plate];
          b.pose.position.y -= speed * h, b.velocity = {0, -speed, 0};
          CHECK(sim.step().unsolved == 0);
        }
        for (const Entity e : all)
          CHECK(glm::length(sim.world.bodies[e].velocity) ==
                Approx(speed / std::tan(angle)).epsilon(0.01));
      }
}

TEST_CASE("a door that is struck near its hinge turns as fast as its lever says") {
  constexpr Real kRestitution = 0.5, kSpeed = 1, kRadius = 0.02;
  for (const Real lever : {0.5, 0.1})
    for (const Real h : {1.0 / 60, 1.0 / 240}) {
      CAPTURE(lever, h);
      const Collision how{.friction = 0, .restitution = kRestitution};
      World w;
      w.gravity = Vec3(0);
      const Entity post = must(w.add(RigidBody{.motion = Motion::fixed, .position = {0, 5, 0}}));
      const Entity door = must(w.add(RigidBody{
          .shape = BoxShape{{1, 1, 0.04}}, .position = {0.5, 0, 0}, .collision = how, .drag = 0}));
      must(w.add(HingeJoint{.a = post, .b = door, .axis = {0, 1, 0}}));
      const Entity striker = add_solid(w, ball_shape(kRadius), {{lever, 0, -0.0405}, kIdentity},
                                       Motion::kinematic, how);
      Simulation sim(std::move(w), {h});
      for (int i = 0; i < 3; ++i) {
        Body& b = sim.world.bodies[striker];
        b.pose.position.z += kSpeed * h, b.velocity = {0, 0, kSpeed};
        sim.step();
      }
      const Real rate = glm::length(sim.world.bodies[door].angular_velocity);
      CHECK(rate == Approx((1 + kRestitution) * kSpeed / lever).epsilon(0.02));
    }
}

TEST_CASE("boxes that a piston jams in a channel as wide as they are do not explode") {
  constexpr Real kSpeed = 5;
  for (const Real h : {1.0 / 60, 1.0 / 240})
    for (const int boxes : {2, 5, 10}) {
      CAPTURE(h, boxes);
      World w;
      add_ground(w);
      std::vector<Entity> all;
      for (int i = 0; i < boxes; ++i)
        all.push_back(add_solid(w, box_shape(Vec3(0.1)), {{0.1 + 0.2 * i, 0.1, 0}, kIdentity},
                                Motion::dynamic, {}, i % 2 == 0 ? 50 : 1000));
      for (const int side : {-1, 1})
        add_solid(w, box_shape({10, 0.2, 0.1}), {{5, 0.2, 0.2 * side}, kIdentity}, Motion::fixed,
                  {.friction = 0.2});
      const Entity piston = add_solid(w, box_shape({0.05, 0.08, 0.08}),
                                      {{-0.06, 0.1, 0}, kIdentity}, Motion::kinematic);
      Simulation sim(std::move(w), {h});
      for (int i = 0; i < 10; ++i) sim.step();
      Real fastest = 0;
      for (int i = 0; i < static_cast<int>(0.4 / h); ++i) {
        Body& b = sim.world.bodies[piston];
        b.pose.position.x += kSpeed * h, b.velocity = {kSpeed, 0, 0};
        sim.step();
        for (const Entity e : all)
          fastest = std::max(fastest, glm::length(sim.world.bodies[e].velocity));
      }
      CHECK(fastest < 40 * kSpeed);  // a jammed one may leave at 18 times it
    }
}
