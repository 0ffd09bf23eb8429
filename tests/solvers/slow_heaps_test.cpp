// Heaps whose bodies all move slowly do not fall asleep; those that have no room do.
#include <catch2/catch.hpp>

#include "engine/pantin/change.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"
#include "tests/solvers/standing.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Five balls of 0.1 m side by side on the ground.
struct Row {
  World world;
  std::vector<Entity> balls;
  Row() {
    add_ground(world, rough());
    for (int i = 0; i < 5; ++i)
      balls.push_back(add_solid(world, ball_shape(0.1), {{0, 0.1, 0.2 * i}, kIdentity},
                                Motion::dynamic, rough()));
  }
};

}  // namespace

TEST_CASE("balls side by side roll down a slight slope and where they are pushed slightly") {
  const Real time = 10, share = 5.0 / 7;  // of the acceleration, where it also spins a ball
  for (const Real slope : {1e-3, 2e-3}) {
    Row row;
    row.world.gravity = 9.81 * Vec3(std::sin(slope), -std::cos(slope), 0);
    Simulation sim(std::move(row.world), {.h = 1.0 / 60});
    for (int i = 0; i < 60 * time; ++i) REQUIRE(sim.step().asleep == 0);
    CHECK(sim.world.bodies[row.balls[2]].pose.position.x ==
          Approx(0.5 * share * 9.81 * std::sin(slope) * time * time).epsilon(5e-3));
  }
  for (const Real push : {3e-3, 8e-3}) {  // m/s^2
    Row row;
    Simulation sim(std::move(row.world), {.h = 1.0 / 60});
    for (int i = 0; i < 60 * time; ++i) {
      for (const Entity e : row.balls) {
        const Body& b = sim.world.bodies[e];
        REQUIRE(sim.world.push(e, {1.4 * push * b.mass, 0, 0}, b.pose.position));
      }
      REQUIRE(sim.step().asleep == 0);
    }
    CHECK(sim.world.bodies[row.balls[2]].pose.position.x ==
          Approx(0.5 * push * time * time).epsilon(5e-3));
  }
}

TEST_CASE("balls too large for their box stay where they are and fall asleep") {
  for (const Real larger : {1.02, 1.05}) {
    World world;
    world.gravity = {0, -9.81, 0};
    const auto wall = [&](Vec3 at, Vec3 half) {
      add_solid(world, box_shape(half), {at, kIdentity}, Motion::fixed, rough());
    };
    for (const int side : {-1, 1}) {
      wall({0.8 * side, 0, 0}, {0.5, 0.9, 0.9});
      wall({0, 0.8 * side, 0}, {0.9, 0.5, 0.9});
      wall({0, 0, 0.8 * side}, {0.9, 0.9, 0.5});
    }
    std::vector<Entity> balls;
    for (int i = 0; i < 27; ++i)
      balls.push_back(add_solid(world, ball_shape(0.1 * larger),
                                {0.2 * Vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1), kIdentity},
                                Motion::dynamic, rough()));
    const World start = world;
    Simulation sim(std::move(world), {.h = 1.0 / 60});
    StepReport report;
    for (int i = 0; i < 360; ++i) report = sim.step();
    INFO(larger);
    CHECK(report.asleep == 27);
    for (const Entity e : balls)
      CHECK(glm::distance(sim.world.bodies[e].pose.position, start.bodies[e].pose.position) < 0.01);
  }
}

TEST_CASE("five hinged balls in a row swing on") {
  World world;
  const Entity bar = add_solid(world, box_shape({0.1, 0.1, 1}), {{0, 1, 0}, kIdentity},
                               Motion::fixed, Collision{});
  std::vector<Entity> balls;
  Collision bouncing = rough();
  bouncing.restitution = 1, bouncing.friction = 0;
  const Real swing = 0.1;
  for (int i = 0; i < 5; ++i) {
    const Real angle = i == 0 ? swing : 0;
    const Vec3 hook(0, 1, 0.2 * i);
    balls.push_back(add_solid(world, ball_shape(0.1),
                              {hook - Vec3(0, std::cos(angle), std::sin(angle)), kIdentity},
                              Motion::dynamic, bouncing));
    add_link(world,
             {bar, balls.back(),
              joint_at(world, bar, balls.back(), JointKind::hinge, hook, frame_along({1, 0, 0}))});
  }
  Simulation sim(std::move(world), {.h = 1.0 / 240});
  Real farthest = 0;
  for (int i = 0; i < 240 * 12; ++i) {
    REQUIRE(sim.step().asleep < 5);
    if (i < 240 * 9) continue;
    for (std::size_t k = 0; k < balls.size(); ++k)
      farthest = std::max(farthest, std::abs(sim.world.bodies[balls[k]].pose.position.z -
                                             0.2 * static_cast<Real>(k)));
  }
  CHECK(farthest > 0.9 * swing);
}
