// Two or three free bodies that fall on one another: round ones whose contact runs around a rim,
// heavy ones on light ones, with restitution and friction. They are iterated to convergence, which
// must neither diverge nor add energy.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/base/random.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr ShapeKind kKinds[] = {ShapeKind::box,     ShapeKind::cylinder,  ShapeKind::cone,
                                ShapeKind::capsule, ShapeKind::ellipsoid, ShapeKind::sphere};

/// One to three bodies of any convex kind above one another, from 1 cm to 10 m.
World dropped(std::uint64_t seed) {
  Random dice(seed);
  World w;
  Collision how;
  how.friction = dice.below(2) ? 0.5 : 0, how.restitution = std::max(0, dice.below(4) - 1) * 0.5;
  add_ground(w, how);
  const Real scale = std::pow(10.0, dice.between(-2, 1));
  const int count = 1 + dice.below(3);
  for (int i = 0; i < count; ++i) {
    Shape s;
    s.kind = kKinds[dice.below(6)];
    s.size =
        scale * Vec3(dice.between(0.05, 0.15), dice.between(0.05, 0.15), dice.between(0.05, 0.15));
    const Quat turned = dice.below(2) ? dice.rotation() : kIdentity;
    const Vec3 at(dice.between(-0.05, 0.05), 0.35 + 0.6 * i, dice.between(-0.05, 0.05));
    const Real density = dice.below(2) ? 1000 : 1000 * std::pow(10.0, dice.between(-1.5, 1.5));
    add_solid(w, s, {scale * at, turned}, Motion::dynamic, how, density);
  }
  return w;
}

/// J: the largest gain over the energy at the start, relative to it.
Real largest_gain(const World& world, Real h, Real duration) {
  Simulation sim = Simulation::copy_of(world, {h});
  const Real first = measure(sim.world).energy();
  Real most = first;
  for (int i = 0; i < std::lround(duration / h); ++i) {
    REQUIRE(sim.step().status == Status::ok);
    most = std::max(most, measure(sim.world).energy());
  }
  return most / first - 1;
}

}  // namespace

TEST_CASE("few bodies that fall on one another gain no energy, whatever their shapes and masses") {
  int gained = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    CAPTURE(seed);
    const Real gain = largest_gain(dropped(seed), seed % 2 ? 1.0 / 60 : 1.0 / 240, 2);
    CHECK(gain < 0.5);
    gained += gain > 0.02;
  }
  CHECK(gained <= 2);
}

TEST_CASE("a tilted drum comes to rest on a box of its mass") {
  for (const Real tilt : {0.05, 0.2, 0.35, 0.7})
    for (const Real friction : {0.0, 0.5})
      for (const Real h : {1.0 / 60, 1.0 / 240}) {
        CAPTURE(tilt, friction, h);
        World w;
        Collision how;
        how.friction = friction;
        add_ground(w, how);
        add_solid(w, box_shape(Vec3(0.25)), {{0, 0.25, 0}, kIdentity}, Motion::dynamic, how, 8);
        Shape drum;
        drum.kind = ShapeKind::cylinder, drum.size = {0.2, 0.1, 0};
        add_solid(w, drum, {{0, 0.85, 0}, from_rotation_vector({0, 0, tilt})}, Motion::dynamic, how,
                  40);
        CHECK(largest_gain(w, h, 2) < 1e-3);
      }
}

TEST_CASE("a heavy cube that falls on a light one stays there, up to a million to one") {
  for (const Real size : {0.01, 0.1, 10.0})
    for (const Real ratio : {1e2, 1e3, 1e4, 1e6})
      for (const Real h : {1.0 / 60, 1.0 / 240}) {
        CAPTURE(size, ratio, h);
        World w;
        add_ground(w);
        const Shape cube = box_shape(Vec3(0.5 * size));
        add_solid(w, cube, {{0, 0.5 * size, 0}, kIdentity}, Motion::dynamic);
        const Entity heavy =
            add_solid(w, cube, {{0, 1.55 * size, 0}, kIdentity}, Motion::dynamic, {}, 1000 * ratio);
        Simulation sim = Simulation::copy_of(w, {h});
        const Real first = measure(sim.world).energy();
        for (int i = 0; i < std::lround(2 / h); ++i) {
          REQUIRE(sim.step().status == Status::ok);
          CHECK(measure(sim.world).energy() <= (1 + 1e-6) * first);
        }
        CHECK(sim.world.bodies[heavy].pose.position.y == Approx(1.5 * size).epsilon(1e-3));
      }
}
