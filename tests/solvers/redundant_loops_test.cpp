// Loops that close within a rigid part: their ties have no response. They neither gain energy in
// the air nor on the ground, and impulses after exact rest without weight act in full.
#include <catch2/catch.hpp>

#include "engine/pantin/measure.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"
#include "tests/solvers/standing.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Two legs and a top, 0.4 m wide, joined in a triangle.
struct Frame : Standing {
  Entity left, right, top;

  Frame(JointKind kind, Real from) : Standing(0.6) {
    left = add({-0.15, from + 0.1, 0}, {0.05, 0.1, 0.2}, 300);
    right = add({0.15, from + 0.1, 0}, {0.05, 0.1, 0.2}, 300);
    top = add({0, from + 0.225, 0}, {0.2, 0.025, 0.2}, 300);
    join(left, top, JointKind::fixed, {-0.15, from + 0.2, 0});
    join(right, top, JointKind::fixed, {0.15, from + 0.2, 0});
    join(left, right, kind, {0, from + 0.1, 0});
  }
  void join(Entity a, Entity b, JointKind kind, Vec3 at) {
    add_link(world, {a, b, joint_at(world, a, b, kind, at, frame_along({0, 0, 1}))});
  }
};

constexpr JointKind kKinds[] = {JointKind::fixed, JointKind::ball, JointKind::hinge};

}  // namespace

TEST_CASE("a rigid frame with a redundant joint flies as one body") {
  for (const JointKind kind : kKinds)
    for (const Real h : {1.0 / 60, 1.0 / 240}) {
      Frame f(kind, 1);
      for (const Entity e : f.blocks) {  // about its mass centre, some 1.2 m up
        Body& b = f.world.bodies[e];
        const Vec3 spin(0.4, 1.1, -0.3);
        b.angular_velocity = spin;
        b.velocity = Vec3(1, 0, 0.5) + glm::cross(spin, b.pose.position - Vec3(0, 1.15, 0));
      }
      f.world.gravity = Vec3(0);
      Simulation sim(std::move(f.world), {h, 1, 1, false, true});
      const Measures start = measure(sim.world);
      for (int i = 0; i < std::lround(4 / h); ++i) REQUIRE(sim.step().status == Status::ok);
      const Measures now = measure(sim.world);
      INFO(static_cast<int>(kind) << " at " << h);
      CHECK(now.energy() == Approx(start.energy()).epsilon(1e-6));
      CHECK(glm::distance(now.momentum, start.momentum) < 1e-9);
      CHECK(now.worst_gap < 1e-7);
      CHECK(sim.findings().empty());
    }
}

TEST_CASE("a rigid frame with a redundant joint falls on its feet and stays there") {
  for (const JointKind kind : kKinds)
    for (const Real h : {1.0 / 60, 1.0 / 240}) {
      Frame f(kind, 0.2);
      Simulation sim(std::move(f.world), {h, 1, 1, false, true});
      const Real start = measure(sim.world).energy();
      for (int i = 0; i < std::lround(3 / h); ++i) {
        REQUIRE(sim.step().status == Status::ok);
        REQUIRE(measure(sim.world).energy() < start + 1e-6);
      }
      INFO(static_cast<int>(kind) << " at " << h);
      CHECK(measure(sim.world).worst_gap < 1e-5);
      CHECK(sim.world.bodies[f.top].pose.position.y == Approx(0.225).margin(1e-3));
      CHECK(is_asleep(sim.world, f.top));
      CHECK(sim.findings().empty());
    }
}

TEST_CASE("an impulse after exact rest without weight acts in full") {
  for (const int wait : {1, 2, 3})
    for (const JointKind kind : {JointKind::ball, JointKind::hinge}) {
      Frame f(kind, 1);
      f.world.gravity = Vec3(0);
      const Entity pushed = f.left;
      Simulation sim(std::move(f.world), {1.0 / 60, 1, 1, false, true});
      for (int i = 0; i < wait; ++i) sim.step();
      sim.world.forces.add(pushed, {Vec3(60, 0, 30), Vec3(0)});
      sim.step();
      sim.world.forces.remove(pushed);
      INFO(static_cast<int>(kind) << " after " << wait);
      for (int i = 0; i < 30; ++i) {
        CHECK(glm::distance(measure(sim.world).momentum, Vec3(1, 0, 0.5)) < 1e-9);
        sim.step();
      }
      CHECK(sim.findings().empty());
    }
}

TEST_CASE("random mechanisms with more joints than they need never gain energy") {
  constexpr JointKind kAny[] = {JointKind::ball, JointKind::hinge, JointKind::fixed,
                                JointKind::universal};
  for (unsigned seed = 1; seed <= 60; ++seed) {
    Random dice(seed);
    World w;
    w.gravity = Vec3(0);
    std::vector<Entity> bodies;
    const int count = 2 + dice.below(5);
    const Vec3 spin = dice.between(0.5, 4) * dice.direction();
    for (int i = 0; i < count; ++i) {
      const Vec3 at =
          i == 0 ? Vec3(0) : w.bodies[bodies.back()].pose.position + 0.3 * dice.direction();
      const Vec3 half(0.15, dice.between(0.01, 0.1), dice.between(0.01, 0.1));
      bodies.push_back(add_solid(w, box_shape(half), {at, kIdentity}, Motion::dynamic));
      w.collisions.remove(bodies.back());
      w.bodies[bodies.back()].angular_velocity = spin;
      w.bodies[bodies.back()].velocity = Vec3(0.5, 0, 0) + glm::cross(spin, at);
    }
    const auto join = [&](int a, int b) {
      const Entity first = bodies[static_cast<std::size_t>(a)],
                   second = bodies[static_cast<std::size_t>(b)];
      const Vec3 middle = 0.5 * (w.bodies[first].pose.position + w.bodies[second].pose.position);
      add_link(w, {first, second,
                   joint_at(w, first, second, kAny[dice.below(4)], middle,
                            frame_along(dice.direction()))});
    };
    for (int i = 1; i < count; ++i) join(dice.below(i), i);
    for (int extra = 1 + dice.below(3); extra > 0; --extra) {
      const int a = dice.below(count), b = dice.below(count);
      if (a != b) join(a, b);
    }
    Simulation sim(std::move(w), {1.0 / 60});
    const Measures start = measure(sim.world);
    INFO("seed " << seed);
    for (int i = 0; i < 120; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      const Measures now = measure(sim.world);
      REQUIRE(now.energy() < 1.01 * start.energy());
      REQUIRE(glm::distance(now.momentum, start.momentum) < 1e-6 * glm::length(start.momentum));
    }
  }
}
