// Heavy bodies that fall on jointed ones: on chains, planks, trapdoors, welded towers. What they
// press lies below them, however light it is.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"
#include "tests/solvers/standing.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Lengths are in sizes; the densest body has `ratio` times the density of water.
struct Load {
  Real size, ratio, drop;
};

struct Pressed {
  World world;
  Collision of = rough();
  Load load;

  explicit Pressed(const Load& falls) : load(falls) { add_ground(world, of); }
  Entity add(const Shape& shape, Vec3 at, Quat turn = kIdentity, Real density = 1000) {
    return add_solid(world, shape, {load.size * at, turn}, Motion::dynamic, of, density);
  }
  Entity add_box(Vec3 at, Vec3 half) { return add(box_shape(load.size * half), at); }
  void add_load(Vec3 at, Vec3 half) {
    add(box_shape(load.size * half), at + Vec3(0, load.drop, 0), kIdentity, 1000 * load.ratio);
  }
  Entity add_ledge(Vec3 at, Vec3 half) {
    return add_solid(world, box_shape(load.size * half), {load.size * at, kIdentity}, Motion::fixed,
                     of);
  }
  void join(Entity a, Entity b, JointKind kind, Vec3 at) {
    add_link(world, {a, b, joint_at(world, a, b, kind, load.size * at, frame_along({0, 0, 1}))});
  }

  /// Falls; then nothing overlaps, and the ground bears the weight.
  void lies(Real hz) const {
    CAPTURE(load.size, load.ratio, load.drop, hz);
    Simulation sim = Simulation::copy_of(world, {1 / hz});
    const Real first = measure(sim.world).energy();
    Real weight = 0, borne = 0;
    for (const Body& b : world.bodies.values())
      if (b.motion == Motion::dynamic) weight += 9.81 * b.mass;
    const auto steps = std::lround((load.size < 0.05 ? 1 : 2.5) * hz);
    for (long n = 0; n < steps; ++n) {
      const StepReport report = sim.step();
      REQUIRE(report.status == Status::ok);
      CHECK(report.measures.worst_gap_rel < 1e-12);
      CHECK(measure(sim.world).energy() < first + 1e-3 * weight * load.size);
      if (const Real now = borne_by_ground(sim.world); now > 0) borne = now;  // none of sleepers
    }
    each_contact(sim.world, [&](const Contact& c) { CHECK(c.depth < 0.02 * load.size); });
    CHECK(borne == Approx(weight).epsilon(1e-3));
  }
};

template <class Build>
void lie(const Build& build) {
  for (const Real size : {0.01, 0.1, 1.0})
    for (const Real ratio : {10.0, 100.0, 1e3, 1e4})
      for (const Real drop : {0.0, 0.5})
        for (const Real hz : {60.0, 240.0}) {
          Pressed p({size, ratio, drop});
          build(p);
          p.lies(hz);
        }
}

}  // namespace

TEST_CASE("a slab that falls on a chain lies on it") {
  for (const JointKind kind : {JointKind::hinge, JointKind::ball})
    lie([&](Pressed& p) {
      const Quat level = glm::angleAxis(kPi / 2, Vec3(0, 0, 1));
      Entity last;
      for (int i = 0; i < 6; ++i) {
        const Entity link =
            p.add(rod_shape(0.2 * p.load.size, 0.3 * p.load.size), {i, 0.2, 0}, level);
        if (i > 0) p.join(last, link, kind, {i - 0.5, 0.2, 0});
        last = link;
      }
      p.add_load({2.5, 0.9, 0}, {2.5, 0.5, 1});
    });
}

TEST_CASE("a crate that falls on jointed planks lies on them") {
  for (const JointKind kind : {JointKind::hinge, JointKind::ball})
    lie([&](Pressed& p) {
      Entity last;
      for (int i = 0; i < 4; ++i) {
        const Entity plank = p.add_box({2 * i, 0.2, 0}, {1, 0.2, 1});
        if (i > 0) p.join(last, plank, kind, {2 * i - 1, 0.2, 0});
        last = plank;
      }
      p.add_load({2.6, 0.9, 0}, Vec3(0.5));
    });
}

TEST_CASE("welded columns bear a beam, and a welded tower a crate") {
  lie([](Pressed& p) {
    for (const Real x : {-1.5, 1.5}) {
      const Entity low = p.add_box({x, 0.5, 0}, {0.3, 0.5, 0.3}),
                   high = p.add_box({x, 1.5, 0}, {0.3, 0.5, 0.3});
      p.join(low, high, JointKind::fixed, {x, 1, 0});
    }
    p.add_load({0, 2.3, 0}, {2, 0.3, 0.4});
  });
  lie([](Pressed& p) {
    for (int i = 0; i < 4; i += 2) {
      const Entity low = p.add_box({0, 2 * i + 1, 0}, Vec3(1)),
                   high = p.add_box({0, 2 * i + 3, 0}, Vec3(1));
      p.join(low, high, JointKind::fixed, {0, 2 * i + 2, 0});
    }
    p.add_load({0, 9, 0}, Vec3(1));
  });
}

TEST_CASE("a trapdoor bears what falls on it") {
  for (const Real size : {0.1, 1.0})
    for (const Real ratio : {100.0, 1e4})
      for (const Real hz : {60.0, 240.0}) {
        Pressed p({size, ratio, 0.5});
        const Entity wall = p.add_ledge({-1.2, 0.5, 0}, {0.2, 0.5, 1});
        p.add_ledge({1, 0.35, 0}, {0.2, 0.35, 1});
        const Entity door = p.add_box({0, 0.8, 0}, {1, 0.1, 1});
        p.join(wall, door, JointKind::hinge, {-1, 0.8, 0});
        p.add_load({0.2, 1.3, 0}, Vec3(0.4));
        Simulation sim = Simulation::copy_of(p.world, {1 / hz});
        CAPTURE(size, ratio, hz);
        for (int n = 0; n < 2.5 * hz; ++n) REQUIRE(sim.step().status == Status::ok);
        CHECK(std::abs(sim.world.bodies[door].pose.position.y / size - 0.8) < 0.005);
        each_contact(sim.world, [&](const Contact& c) { CHECK(c.depth < 0.02 * size); });
      }
}
