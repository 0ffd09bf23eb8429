// The planar solver: motions of mechanisms, against the Lagrangian solver and closed forms.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/planar.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

World pendulum(int rods) {
  World w = planar_world();
  Entity above = add_fixed(w);
  for (int i = 0; i < rods; ++i) {
    const Entity below = add_rod(w, {1.0 * i, 0, 0}, {1.0 * (i + 1), 0, 0});
    add_hinge(w, above, below, {1.0 * i, 0, 0});
    above = below;
  }
  return w;
}

/// Where the last body is after a second by the solver that integrates to a tolerance.
Pose exact_end(World w) {
  w.default_settings.solver = Solver::lagrangian;
  run(w, 1e-3, 1000);
  return w.bodies.values().back().pose;
}

Real error_after_a_second(World w, int steps, const Pose& exact) {
  run(w, 1.0 / steps, steps);
  return glm::length(w.bodies.values().back().pose.position - exact.position);
}

}  // namespace

TEST_CASE("planar mechanisms come to the exact motion as the step shrinks") {
  for (const World& w : {pendulum(1), pendulum(2), planar_four_bar()}) {
    const Pose exact = exact_end(w);
    const Real coarse = error_after_a_second(w, 120, exact);
    const Real fine = error_after_a_second(w, 960, exact);
    INFO(coarse << " " << fine);
    CHECK(coarse < 0.02);
    CHECK(fine < coarse / 5);
  }
}

TEST_CASE("planar joints stay closed to rounding") {
  for (World w : {pendulum(20), planar_four_bar()}) {
    for (int i = 0; i < 300; ++i) {
      REQUIRE(run(w, 1.0 / 60, 1).status == Status::ok);
      REQUIRE(measure(w).worst_gap < 1e-12);
    }
    CHECK(w.bodies.values().back().velocity != Vec3(0));
  }
}

TEST_CASE("a long planar chain that cracks like a whip stays closed") {
  World w = planar_world();
  Entity above = add_fixed(w);
  for (int i = 0; i < 100; ++i) {
    const Entity below = add_rod(w, {0.1 * i, 0, 0}, {0.1 * (i + 1), 0, 0});
    add_hinge(w, above, below, {0.1 * i, 0, 0});
    above = below;
  }
  for (int i = 0; i < 300; ++i) {
    REQUIRE(run(w, 1.0 / 60, 1).status == Status::ok);
    REQUIRE(measure(w).worst_gap < 1e-11);
  }
}

TEST_CASE("a planar body that flies free falls as the closed form says, far from the origin too") {
  for (const Real far : {0.0, 1e5}) {
    World w = planar_world();
    const Entity e = add_solid(w, ShapeKind::box, Vec3(0.1), {{far, 0, 0.3}, kIdentity});
    w.bodies[e].velocity = {3, 4, 0}, w.bodies[e].angular_velocity = {0, 0, 5};
    run(w, 1.0 / 240, 240);
    const Body& b = w.bodies[e];
    CHECK(b.pose.position.x - far == Approx(3).margin(1e-5));
    CHECK(b.pose.position.y == Approx(4 - 0.5 * 9.81).margin(0.012));  // of first order
    CHECK(b.velocity.y == Approx(4 - 9.81).margin(1e-5));
    CHECK(std::remainder(2 * std::atan2(b.pose.rotation.z, b.pose.rotation.w) - 5, 2 * kPi) ==
          Approx(0).margin(1e-5));
  }
}

TEST_CASE("no planar body leaves its plane, nor tilts") {
  World w = planar_world();
  add_slope(w, 0.1);
  for (int i = 0; i < 12; ++i) {
    const Quat lying = from_rotation_vector({kPi / 2, 0, 0});
    const Pose at{{0.3 * (i % 4), 0.5 + 0.3 * i, 0.05 * (i % 3)}, i % 2 ? lying : kIdentity};
    add_solid(w, i % 2 ? ShapeKind::cylinder : ShapeKind::box, Vec3(0.1, 0.1, 0.1), at);
  }
  const World before = w;
  run(w, 1.0 / 60, 600);
  for (std::size_t i = 0; i < w.bodies.size(); ++i) {
    const Body &was = before.bodies.values()[i], &is = w.bodies.values()[i];
    CHECK(is.pose.position.z == was.pose.position.z);
    CHECK(is.velocity.z == 0);
    const Vec3 z(0, 0, 1);
    const Vec3 then = glm::conjugate(was.pose.rotation) * z,
               now = glm::conjugate(is.pose.rotation) * z;
    CHECK(glm::length(then - now) < 1e-14);
    if (was.motion == Motion::dynamic) CHECK(is.pose.position != was.pose.position);
  }
}

TEST_CASE("planar springs, motors and limits of hinges act as in the exact solver") {
  World w = planar_world();
  const Entity frame = add_fixed(w), rod = add_rod(w, {0, 0, 0}, {1, 0, 0});
  const Entity link = add_hinge(w, frame, rod, {0, 0, 0}, {0, 0, -1});
  Joint& joint = w.links[link].joint;
  SECTION("a spring") {
    JointParameters own;
    own.rotation.spring = {20, 0.5, 0.3};
    joint.parameters.edit() = own;
  }
  SECTION("a motor that asks for a speed") {
    JointParameters own;
    own.rotation.motor = {MotorKind::velocity, 3, 40, 0, 1e300};
    joint.parameters.edit() = own;
  }
  SECTION("a limit") {
    JointLimits limits;
    limits.angle = {true, -0.4, 0.4};
    joint.limits = limits;
  }
  const Pose exact = exact_end(w);
  CHECK(error_after_a_second(w, 960, exact) < 5e-3);
}

TEST_CASE("the energy of a planar World includes its springs") {
  World w = planar_world();
  const Entity frame = add_fixed(w), rod = add_rod(w, {0, 0, 0}, {1, 0, 0}),
               cart = add_rod(w, {2, 1, 0}, {2.4, 1, 0}), bob = add_rod(w, {5, 0, 0}, {5.2, 0, 0});
  const Entity hinge = add_hinge(w, frame, rod, {0, 0, 0}, {0, 0, -1});
  JointParameters own;
  own.rotation.spring = {200, 0, 0.3};
  w.links[hinge].joint.parameters.edit() = own;
  Joint slide = planar_joint(w, frame, cart, JointKind::prismatic, {2.2, 1, 0}, {1, 0, 0});
  own = {};
  own.translation.spring = {50, 0, 0.2};
  slide.parameters.edit() = own;
  add_link(w, {frame, cart, slide});
  Joint coil = planar_joint(w, frame, bob, JointKind::spring, {5.1, 0, 0});
  coil.anchor_a = {5.1, 0.5, 0};
  own.translation.spring = {30, 0, 0.1};
  coil.parameters.edit() = own;
  add_link(w, {frame, bob, coil});
  const Real stored = 0.5 * (200 * 0.3 * 0.3 + 50 * 0.2 * 0.2 + 30 * 0.4 * 0.4);
  CHECK(measure(w).elastic == Approx(stored).epsilon(1e-12));
  World exact = w;
  exact.default_settings.solver = Solver::lagrangian;
  CHECK(measure(exact).elastic == Approx(stored).epsilon(1e-12));
  const Measures before = measure(w);
  for (int i = 0; i < 240; ++i) {
    run(w, 1.0 / 480, 1);
    const Measures now = measure(w);
    REQUIRE(now.kinetic + now.potential + now.elastic ==
            Approx(before.kinetic + before.potential + before.elastic).margin(0.05 * stored));
  }
  CHECK(measure(w).elastic != Approx(stored).epsilon(0.1));
}

TEST_CASE("planar sliders, rods and welds hold, and slide as the exact solver says") {
  World w = planar_world();
  const Entity frame = add_fixed(w), cart = add_rod(w, {-0.2, 0, 0}, {0.2, 0, 0});
  const Entity arm = add_rod(w, {0, 0, 0}, {0, -0.5, 0}),
               bob = add_rod(w, {0.4, -0.5, 0}, {0.4, -0.6, 0});
  add_link(
      w, {frame, cart, planar_joint(w, frame, cart, JointKind::prismatic, {0, 0, 0}, {1, 0.2, 0})});
  add_link(w, {cart, arm, planar_joint(w, cart, arm, JointKind::fixed, {0, 0, 0})});
  Joint rod = planar_joint(w, arm, bob, JointKind::distance, {0, -0.5, 0});
  rod.anchor_b = {0, 0, 0};
  JointParameters own;
  own.length = glm::length(Vec3(0.4, -0.55, 0) - Vec3(0, -0.5, 0));
  rod.parameters.edit() = own;
  add_link(w, {arm, bob, rod});
  const Pose exact = exact_end(w);
  CHECK(error_after_a_second(w, 960, exact) < 5e-3);
  run(w, 1.0 / 60, 120);
  CHECK(measure(w).worst_gap < 1e-12);
}

TEST_CASE("a pin holds a planar body to a place that moves") {
  World w = pendulum(3);
  Pin pin;
  pin.body = w.bodies.owners().back(), pin.anchor = {0.5, 0, 0}, pin.target = {2, -1, 0};
  const Entity held = w.add_pin(pin);
  for (int i = 0; i < 60; ++i) {
    w.pins[held].target.x -= 0.005;
    run(w, 1.0 / 60, 1);
    const Body& b = w.bodies.values().back();
    CHECK(glm::length(to_world(b.pose, pin.anchor) - w.pins[held].target) < 1e-10);
  }
  CHECK(measure(w).worst_gap < 1e-10);
}

TEST_CASE("gears between planar hinges keep their ratio over a thousand turns") {
  for (const Real ratio : {0.5, -0.5}) {
    World w = planar_world();
    const Entity frame = add_fixed(w);
    const Entity one = add_rod(w, {-0.5, 0, 0}, {0.5, 0, 0}),
                 two = add_rod(w, {2, 0, 0}, {4, 0, 0});
    const Entity first = add_hinge(w, frame, one, {0, 0, 0});
    const Entity second = add_hinge(w, frame, two, {3, 0, 0}, {0, 0, 1});
    JointParameters own;
    own.rotation.motor = {MotorKind::velocity, 60, 5, 0, 1e300};
    w.links[first].joint.parameters.edit() = own;
    Gear gear;
    gear.first = first, gear.second = second, gear.ratio = ratio;
    add_gear(w, gear);
    Real turned_one = 0, turned_two = 0, before_one = 0, before_two = 0;
    const auto angle = [&](Entity e) {
      const Quat q = w.bodies[e].pose.rotation;
      return 2 * std::atan2(q.z, q.w);
    };
    while (std::abs(turned_one) < 1000 * 2 * kPi) {
      REQUIRE(run(w, 1.0 / 120, 1).status == Status::ok);
      turned_one += std::remainder(angle(one) - before_one, 2 * kPi);
      turned_two += std::remainder(angle(two) - before_two, 2 * kPi);
      before_one = angle(one), before_two = angle(two);
      INFO(w.bodies[one].angular_velocity.z << " " << w.bodies[two].angular_velocity.z << " "
                                            << turned_one);
      REQUIRE(w.time < 200);
    }
    CHECK(std::abs(turned_two - ratio * turned_one) < 1e-6);
    CHECK(std::abs(w.bodies[two].angular_velocity.z - ratio * w.bodies[one].angular_velocity.z) <
          1e-9);
  }
}

TEST_CASE("planar joints begin from what they did: a motor drives a stiff loop at its speed") {
  World w = planar_four_bar();
  for (Body& b : w.bodies.values()) b.mass *= 0.2, b.inertia *= 0.2;
  JointParameters own;
  own.rotation.motor = {MotorKind::velocity, 3, 50, 0, 1e300};
  w.links.values()[0].joint.parameters.edit() = own;
  const Real exact = 2 * std::atan2(exact_end(w).rotation.z, exact_end(w).rotation.w);
  run(w, 0.01, 100);
  const Quat q = w.bodies.values().back().pose.rotation;
  CHECK(std::remainder(2 * std::atan2(q.z, q.w) - exact, 2 * kPi) == Approx(0).margin(2e-3));
}

TEST_CASE("what planar joints bore is state: the next step begins from it where bodies touch") {
  World w = planar_world();
  add_slope(w, 0);
  const Vec3 size(0.3, 0.1, 0.1);
  const Entity one = add_solid(w, ShapeKind::box, size, {{0, 0.1, 0}, kIdentity});
  const Entity two = add_solid(w, ShapeKind::box, size, {{0.7, 0.1, 0}, kIdentity});
  add_hinge(w, one, two, {0.35, 0.1, 0});
  w.bodies[one].velocity = {3, 0, 0};
  run(w, 0.01, 5);
  World forgetful = w;
  forgetful.memory.of<planar::Planar>().loads.assign(1, {});
  run(w, 0.01, 1), run(forgetful, 0.01, 1);
  CHECK(state_hash(w) != state_hash(forgetful));
}
