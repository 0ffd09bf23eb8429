// Towers that fall a little: of small boxes, under heavy ones, high ones. What the impact leaves of
// their motion must neither press them flat nor move them aside.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/base/random.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Boxes of a height `size` above one another, the lowest `drop` sizes above the ground, a little
/// aside and turned; the top one is `top` times as heavy as the others.
struct Tower {
  World world;
  std::vector<Entity> boxes;
  Real size;

  struct Kind {
    Real size, drop, top;
    int count;
  };
  explicit Tower(const Kind& kind) : size(kind.size) {
    Random dice(7);
    Collision rough;
    rough.friction = 0.5;
    add_ground(world, rough);
    for (int i = 0; i < kind.count; ++i) {
      const Vec3 at(dice.between(-0.005, 0.005), 0.5 + kind.drop + i * (1 + 1e-9),
                    dice.between(-0.005, 0.005));
      const Quat turned = from_rotation_vector({0, dice.between(-0.02, 0.02), 0});
      boxes.push_back(add_solid(world, box_shape(Vec3(0.5 * size)), {size * at, turned},
                                Motion::dynamic, rough,
                                i + 1 == kind.count ? 1000 * kind.top : 1000));
    }
  }
};

void each_collision(World& w, const auto& visit) {
  for (const Entity e : w.bodies.owners())
    if (Collision* c = w.collisions.find(e)) visit(*c);
}

/// In sizes: the deepest overlap of a box with the one below it, or with the ground.
Real deepest(const Tower& t, const World& w) {
  Real most = 0, below = -0.5;
  for (const Entity e : t.boxes) {
    const Real at = w.bodies[e].pose.position.y / t.size;
    most = std::max(most, below + 1 - at), below = at;
  }
  return most;
}

}  // namespace

TEST_CASE("towers of any size and load that fall by a tenth of a box stand") {
  for (const Real size : {0.001, 0.01, 0.1, 1.0})
    for (const int count : {4, 10, 20})
      for (const Real top : {1.0, 10.0, 100.0, 1000.0})
        for (const Real drop : {0.02, 0.1}) {
          CAPTURE(size, count, top, drop);
          const Tower t({size, drop, top, count});
          Simulation sim = Simulation::copy_of(t.world, {1.0 / 60});
          const Real first = measure(sim.world).energy();
          for (int n = 0; n < 150; ++n) {
            REQUIRE(sim.step().status == Status::ok);
            CHECK(deepest(t, sim.world) < 0.03);
            CHECK(measure(sim.world).energy() < (1 + 1e-9) * first);
          }
          for (std::size_t i = 0; i < t.boxes.size(); ++i) {
            const Vec3 at = sim.world.bodies[t.boxes[i]].pose.position / size;
            const Vec3 from = t.world.bodies[t.boxes[i]].pose.position / size;
            CHECK(std::abs(at.y - 0.5 - static_cast<Real>(i)) < 2e-3);
            CHECK(std::hypot(at.x - from.x, at.z - from.z) < 0.01);
          }
        }
}

TEST_CASE("boxes that fall on one another one after the other form a tower") {
  for (const Real size : {0.001, 0.01, 0.1, 1.0})
    for (const Real top : {1.0, 100.0}) {
      CAPTURE(size, top);
      Tower t({size, 0, top, 10});
      for (std::size_t i = 0; i < t.boxes.size(); ++i)
        t.world.bodies[t.boxes[i]].pose.position.y += 0.1 * size * static_cast<Real>(i + 1);
      Simulation sim = Simulation::copy_of(t.world, {1.0 / 60});
      for (int n = 0; n < 180; ++n) {
        REQUIRE(sim.step().status == Status::ok);
        CHECK(deepest(t, sim.world) < 0.05);
      }
      CHECK(sim.world.bodies[t.boxes.back()].pose.position.y == Approx(9.5 * size).epsilon(2e-3));
    }
}

TEST_CASE("boxes without friction do not stick to one another") {
  World w;
  w.gravity = Vec3(0);
  Collision smooth;
  smooth.friction = 0;
  std::vector<Entity> boxes;
  for (int i = 0; i < 5; ++i)
    boxes.push_back(
        add_solid(w, box_shape(Vec3(0.1)), {{0.2 * i, 0, 0}, kIdentity}, Motion::dynamic, smooth));
  w.bodies[boxes.back()].velocity = {0.015, 0, 0};
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  for (int n = 0; n < 60; ++n) REQUIRE(sim.step().status == Status::ok);
  CHECK(sim.world.bodies[boxes.back()].velocity.x == Approx(0.015).epsilon(1e-6));
  CHECK(std::abs(sim.world.bodies[boxes.front()].velocity.x) < 1e-9);
}

TEST_CASE("plates on balls stay there, up to a thousand times their weight") {
  for (const Real size : {0.001, 0.01, 0.1})
    for (const Real ratio : {1.0, 10.0, 100.0, 1000.0})
      for (const Real drop : {0.0, 0.02, 0.5}) {
        CAPTURE(size, ratio, drop);
        World w;
        Collision rough;
        rough.friction = 0.5;
        add_ground(w, rough);
        Shape ball;
        ball.kind = ShapeKind::sphere, ball.size.x = 0.5 * size;
        Entity top{};
        constexpr int kLayers = 3;
        for (int layer = 0; layer < kLayers; ++layer) {
          const Real from = (layer + (layer + 1) * drop) * 1.5;
          for (int i = 0; i < 9; ++i)
            add_solid(w, ball,
                      {size * Vec3(1.5 * (i / 3 - 1), from + 0.5, 1.5 * (i % 3 - 1)), kIdentity},
                      Motion::dynamic, rough);
          // Nine balls weigh as much as a plate of half the density.
          top = add_solid(w, box_shape(size * Vec3(2.25, 0.25, 2.25)),
                          {size * Vec3(0, from + 1.25 + drop, 0), kIdentity}, Motion::dynamic,
                          rough, 465 * (layer + 1 == kLayers ? ratio : 1));
        }
        Simulation sim = Simulation::copy_of(w, {1.0 / 60});
        for (int n = 0; n < 150; ++n) REQUIRE(sim.step().status == Status::ok);
        const Vec3 at = sim.world.bodies[top].pose.position / size;
        CHECK(at.y == Approx(kLayers * 1.5 - 0.25).epsilon(5e-3));
        // Where sweeps are used, a plate may roll a little from a fall by half a ball.
        CHECK(std::hypot(at.x, at.z) < (drop < 0.5 ? 0.01 : 0.25));
      }
}

TEST_CASE("a tower with a heavy top slides down a smooth slope as one body") {
  struct Slope {
    Real size, degrees, friction;
  };
  for (const Slope& slope : {Slope{0.001, 35, 0}, {0.1, 20, 0}, {10, 35, 0}}) {
    CAPTURE(slope.size, slope.degrees, slope.friction);
    Tower t({slope.size, 0, 1e4, 10});
    each_collision(t.world, [&](Collision& c) { c.friction = slope.friction; });
    const Real angle = slope.degrees * kPi / 180;
    t.world.gravity = 9.81 * Vec3(std::sin(angle), -std::cos(angle), 0);
    Simulation sim = Simulation::copy_of(t.world, {1.0 / 60});
    for (int n = 0; n < 60; ++n) REQUIRE(sim.step().status == Status::ok);
    const Real way = 0.5 * 9.81 * (std::sin(angle) - slope.friction * std::cos(angle));
    for (std::size_t i = 0; i < t.boxes.size(); ++i) {
      const Vec3 at = sim.world.bodies[t.boxes[i]].pose.position;
      const Vec3 from = t.world.bodies[t.boxes[i]].pose.position;
      CHECK(at.x - from.x == Approx(way).epsilon(5e-3));
      CHECK(std::abs(at.y - from.y) < 5e-3 * slope.size);
    }
  }
}

TEST_CASE("a tower lands on a floor that moves along with it as on one at rest") {
  for (const Real size : {0.001, 0.01, 0.1})
    for (const Real top : {1.0, 1e4})
      for (const Real speed : {1.0, 10.0, 50.0}) {
        CAPTURE(size, top, speed);
        Tower t({size, 0.1, top, 5});
        for (const Entity e : t.boxes) t.world.bodies[e].velocity.x = speed;
        Body& ground = t.world.bodies[t.world.bodies.owners().front()];
        ground.motion = Motion::kinematic, ground.velocity.x = speed;
        Simulation sim = Simulation::copy_of(t.world, {1.0 / 240});
        for (int n = 0; n < 120; ++n) {
          REQUIRE(sim.step().status == Status::ok);
          CHECK(deepest(t, sim.world) < 0.03);
        }
        for (const Entity e : t.boxes) CHECK(sim.world.bodies[e].velocity.x == Approx(speed));
      }
}
