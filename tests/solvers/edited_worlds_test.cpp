// What is taken away or changed by the caller is felt in the next step, by what rests too.
#include <catch2/catch.hpp>
#include <functional>

#include "engine/pantin/pantin.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kGravity = 9.81;

/// Boxes in two piles on a floor, in a World whose gravity leans by `slope` rad.
struct Piles {
  Simulation sim;
  Entity floor;
  std::vector<Entity> boxes;
};

Piles piles(Real slope, int steps) {
  World w;
  w.gravity = kGravity * Vec3(std::sin(slope), -std::cos(slope), 0);
  Piles p;
  p.floor = add_solid(w, box_shape({20, 0.5, 20}), {{0, -0.5, 0}, kIdentity}, Motion::fixed);
  for (const Vec3 at : {Vec3(0, 0.1, 0), Vec3(0, 0.3, 0), Vec3(5, 0.1, 0)})
    p.boxes.push_back(add_solid(w, box_shape(Vec3(0.1)), {at, kIdentity}, Motion::dynamic));
  p.sim = Simulation(std::move(w));
  for (int i = 0; i < steps; ++i) p.sim.step();
  return p;
}

/// m: by how much each box moves in `steps`.
std::vector<Vec3> ways(Piles& p, int steps) {
  std::vector<Vec3> from;
  for (const Entity e : p.boxes) from.push_back(p.sim.world.bodies[e].pose.position);
  for (int i = 0; i < steps; ++i) REQUIRE(p.sim.step().status == Status::ok);
  for (std::size_t i = 0; i < from.size(); ++i)
    from[i] = p.sim.world.bodies[p.boxes[i]].pose.position - from[i];
  return from;
}

constexpr int kAwake = 5, kAsleep = 400;

}  // namespace

TEST_CASE("boxes fall freely once their floor has no Collision, awake or asleep") {
  const std::pair<const char*, std::function<void(World&, Entity)>> ends[] = {
      {"set_collision", [](World& w, Entity e) { must(set_collision(w, e, std::nullopt)); }},
      {"component removed", [](World& w, Entity e) { w.collisions.remove(e); }},
      {"destroyed", [](World& w, Entity e) { w.destroy(e); }}};
  for (const int before : {kAwake, kAsleep})
    for (const auto& [how, end] : ends) {
      CAPTURE(before, how);
      Piles p = piles(0, before);
      end(p.sim.world, p.floor);
      constexpr int kSteps = 60;
      for (const Vec3 way : ways(p, kSteps)) CHECK(-way.y == Approx(0.5 * kGravity).epsilon(0.03));
    }
}

TEST_CASE("balls that fly together pass where walls were opened") {
  World w;
  std::vector<Entity> walls, balls;
  for (int i = 0; i < 5; ++i)
    walls.push_back(
        add_solid(w, box_shape({0.1, 5, 5}), {{20.0 + 10 * i, 0, 0}, kIdentity}, Motion::fixed));
  for (int i = 0; i < 4; ++i) {
    balls.push_back(add_solid(w, ball_shape(0.1), {{0, 0.3 * i, 0}, kIdentity}, Motion::dynamic));
    w.bodies[balls.back()].velocity = {20, 0, 0};
  }
  w.gravity = Vec3(0);
  Simulation sim(std::move(w));
  for (int i = 0; i < 240; ++i) {
    if (i % 20 == 10 && i / 20 < 5)
      must(set_collision(sim.world, walls[static_cast<std::size_t>(i / 20)], std::nullopt));
    REQUIRE(sim.step().status == Status::ok);
  }
  for (const Entity e : balls) CHECK(sim.world.bodies[e].pose.position.x == Approx(80));
}

TEST_CASE("a sleeper whose own surface starts to run drives off") {
  for (const int before : {kAwake, kAsleep}) {
    Piles p = piles(0, before);
    p.sim.world.collisions[p.boxes[2]].surface_velocity = {1, 0, 0};
    const std::vector<Vec3> way = ways(p, 120);
    CHECK(way[2].x == Approx(-1.9).epsilon(0.05));
    CHECK(glm::length(way[0]) < 1e-6);
  }
}

TEST_CASE("sleepers slide when their materials turn out to be slippery together") {
  constexpr Real kSlope = 0.2;
  for (const int before : {kAwake, kAsleep}) {
    Piles p = piles(kSlope, before);
    must(p.sim.world.add(MaterialPair{.a = 0, .b = 0, .friction = 0}));
    constexpr Real kSeconds = 1;
    const Real far = 0.5 * kGravity * std::sin(kSlope) * kSeconds * kSeconds;
    for (const Vec3 way : ways(p, 60)) CHECK(way.x == Approx(far).epsilon(0.1));
  }
}

TEST_CASE("a cable that the caller shortens does the caller's work, whatever else is changed") {
  for (const bool changes_other : {false, true}) {
    World w;
    const Entity hook = must(w.add(RigidBody{.motion = Motion::fixed, .position = {0, 5, 0}}));
    const Entity ball = must(w.add(RigidBody{.shape = SphereShape{.radius = 0.1}}));
    const Entity other =
        must(w.add(RigidBody{.shape = SphereShape{.radius = 0.1}, .position = {9, 0, 0}}));
    const Entity cable = must(w.add(CableJoint{.a = hook, .b = ball, .anchor_a = {0, 5, 0}}));
    Simulation sim(std::move(w), {.watch = true});
    for (int i = 0; i < 30; ++i) sim.step();
    must(set_cable_length(sim.world, cable, 4.8));
    if (changes_other) must(set_mass(sim.world, other, 3));
    for (int i = 0; i < 5; ++i) sim.step();
    CAPTURE(changes_other);
    CHECK(sim.world.bodies[ball].velocity.y > 5);  // as by a fast winch
    CHECK(sim.findings().empty());
  }
}
