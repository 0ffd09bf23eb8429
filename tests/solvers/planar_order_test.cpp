// The planar solver's linkages, belts, motors and limits: order 2, energy, and what stays what it
// was where bodies touch.
#include <catch2/catch.hpp>

#include "engine/runtime/save.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/planar.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

World chain(int rods, Real length) {
  World w = planar_world();
  Entity above = add_fixed(w);
  for (int i = 0; i < rods; ++i) {
    const Entity below = add_rod(w, {length * i, 0, 0}, {length * (i + 1), 0, 0});
    add_hinge(w, above, below, {length * i, 0, 0});
    above = below;
  }
  return w;
}

World slider_crank() {
  World w = planar_world();
  const Entity frame = add_fixed(w), crank = add_rod(w, {0, 0, 0}, {0.3, 0, 0});
  const Entity rod = add_rod(w, {0.3, 0, 0}, {1.3, 0, 0});
  const Entity piston = add_rod(w, {1.2, 0, 0}, {1.4, 0, 0});
  add_hinge(w, frame, crank, {0, 0, 0}), add_hinge(w, crank, rod, {0.3, 0, 0});
  add_hinge(w, rod, piston, {1.3, 0, 0});
  add_link(w, {frame, piston,
               planar_joint(w, frame, piston, JointKind::prismatic, {1.3, 0, 0}, {1, 0, 0})});
  w.bodies[crank].angular_velocity.z = 3;
  return w;
}

/// A wheel out of round that drives another, with a weight on its rim.
World belt_drive() {
  World w = planar_world();
  const Entity frame = add_fixed(w);
  Entity wheels[2];
  Belt belt;
  std::vector<Pose> poses;
  for (int i = 0; i < 2; ++i) {
    Body b;
    b.mass = 1, b.inertia = Vec3(1 + 3 * i), b.drag = 0, b.pose.position = {3.0 * i, 0, 0};
    wheels[i] = w.add_body(b);
    add_hinge(w, frame, wheels[i], b.pose.position);
    BeltPulley p;
    p.body = wheels[i], p.outline.radius = 0.5 * (i + 1);
    belt.pulleys.push_back(p), poses.push_back(b.pose);
  }
  std::vector<Vec3> corners;
  for (int i = 0; i < 720; ++i)
    corners.push_back({0.6 * std::cos(i * kPi / 360), 0.4 * std::sin(i * kPi / 360), 0});
  belt.pulleys[0].outline = hull_outline(corners);
  REQUIRE(lay_belt(belt, poses));
  add_belt(w, belt);
  w.bodies[wheels[0]].angular_velocity.z = 2;
  const Entity weight = add_rod(w, {3.5, 0, 0}, {3.5, -0.4, 0});
  add_hinge(w, wheels[1], weight, {3.5, 0, 0});
  return w;
}

void add_motor(World& w, Real gain) {
  JointParameters own;
  own.rotation.motor = {MotorKind::velocity, 3, gain, 0, 1e300};
  w.links.values()[0].joint.parameters.edit() = own;
}

Vec3 end_after(World w, int steps, Real time) {
  for (int i = 0; i < steps; ++i) REQUIRE(run(w, time / steps, 1).status == Status::ok);
  return w.bodies.values().back().pose.position;
}

Real energy_of(const World& w) {
  Real sum = 0;
  for (const Body& b : w.bodies.values())
    if (b.motion == Motion::dynamic)
      sum += 0.5 * b.mass * glm::dot(b.velocity, b.velocity) +
             0.5 * b.inertia.z * b.angular_velocity.z * b.angular_velocity.z -
             b.mass * glm::dot(w.gravity, b.pose.position);
  return sum;
}

/// The most by which energy differs from what it is after a step, of the most kinetic energy.
Real energy_error(World w, int steps, Real h) {
  run(w, h, 1);
  const Real start = energy_of(w);
  Real worst = 0, swing = 0;
  for (int i = 0; i < steps; ++i) {
    REQUIRE(run(w, h, 1).status == Status::ok);
    Real kinetic = 0;
    for (const Body& b : w.bodies.values())
      kinetic += 0.5 * b.mass * glm::dot(b.velocity, b.velocity);
    swing = std::max(swing, kinetic), worst = std::max(worst, std::abs(energy_of(w) - start));
  }
  return worst / swing;
}

}  // namespace

TEST_CASE("planar linkages, belts and motors are of order 2") {
  World soft = planar_four_bar(), stiff = soft;
  add_motor(soft, 0.2), add_motor(stiff, 5);
  const World worlds[] = {chain(1, 1), chain(2, 1), planar_four_bar(), slider_crank(), belt_drive(),
                          soft,        stiff};
  const Real most[] = {2e-4, 2e-3, 2e-3, 2e-3, 2e-3, 2e-3, 2e-3};
  for (std::size_t i = 0; i < std::size(worlds); ++i) {
    const Vec3 exact = end_after(worlds[i], 3840, 1);
    const Real coarse = glm::length(end_after(worlds[i], 60, 1) - exact);
    const Real fine = glm::length(end_after(worlds[i], 240, 1) - exact);
    INFO(i << ": " << coarse << " " << fine);
    CHECK(coarse < most[i]);
    CHECK(fine < coarse / 12);
  }
}

TEST_CASE("planar linkages and belts come to the motion of the exact solver") {
  for (World w : {planar_four_bar(), slider_crank(), belt_drive()}) {
    const Vec3 flat = end_after(w, 3840, 1);
    w.default_settings.solver = Solver::lagrangian;
    CHECK(glm::length(flat - end_after(w, 1000, 1)) < 1e-6);
  }
}

TEST_CASE("a chain of a hundred planar hinges follows its motion until it cracks") {
  const World w = chain(100, 0.1);
  CHECK(glm::length(end_after(w, 60, 0.5) - end_after(w, 1920, 0.5)) < 5e-5);
}

TEST_CASE("planar linkages and belts keep their energy over ten seconds at 60 Hz") {
  CHECK(energy_error(chain(1, 1), 600, 1.0 / 60) < 3e-3);
  CHECK(energy_error(planar_four_bar(), 600, 1.0 / 60) < 0.02);
  CHECK(energy_error(slider_crank(), 600, 1.0 / 60) < 4e-3);
  CHECK(energy_error(belt_drive(), 600, 1.0 / 60) < 2e-3);
}

TEST_CASE("a planar joint stops at its limits, and rests there") {
  World w = chain(1, 1);
  JointLimits limits;
  limits.angle = {true, -0.4, 2};
  w.links.values()[0].joint.limits = limits;
  Real least = 0;
  for (int i = 0; i < 120; ++i) {
    REQUIRE(run(w, 1.0 / 60, 1).status == Status::ok);
    const Quat q = w.bodies.values()[1].pose.rotation;
    least = std::min(least, 2 * std::atan2(q.z, q.w));
  }
  CHECK(least == Approx(-0.4).margin(1e-10));
  CHECK(w.bodies.values()[1].angular_velocity.z == Approx(0).margin(1e-10));
}

TEST_CASE("a planar body that is teleported comes back without a speed from it") {
  World w = chain(3, 1);
  w.gravity = Vec3(0);
  const Entity last = w.bodies.owners().back();
  Pose there = w.bodies[last].pose;
  there.position.y += 0.5;
  w.teleport(last, there);
  for (int i = 0; i < 3; ++i) {
    REQUIRE(run(w, 1.0 / 60, 1).status == Status::ok);
    CHECK(measure(w).worst_gap < 1e-11);
    for (const Body& b : w.bodies.values()) CHECK(glm::length(b.velocity) < 1e-9);
  }
}

TEST_CASE("a planar linkage that falls on the ground rests on it, and moves on when it is lifted") {
  World w = planar_world();
  w.default_settings.sleep_speed = 0;
  add_slope(w, 0);
  const Vec3 size(0.3, 0.1, 0.1);
  const Entity one = add_solid(w, ShapeKind::box, size, {{0, 0.5, 0}, kIdentity});
  const Entity two = add_solid(w, ShapeKind::box, size, {{0.7, 0.5, 0}, kIdentity});
  add_hinge(w, one, two, {0.35, 0.5, 0});
  run(w, 1.0 / 60, 120);
  for (const Entity e : {one, two}) CHECK(w.bodies[e].pose.position.y == Approx(0.1).margin(2e-3));
  w.gravity = {0, 5, 0};
  run(w, 1.0 / 60, 60);
  for (const Entity e : {one, two}) CHECK(w.bodies[e].velocity.y == Approx(5).margin(0.1));
}

TEST_CASE("a World of planar linkages goes on from a file with the same bits") {
  World stiff = planar_four_bar();
  add_motor(stiff, 5);
  for (World w : {chain(20, 0.1), stiff, belt_drive()}) {
    run(w, 1.0 / 60, 40);
    const auto bytes = world_to_bytes(w);
    REQUIRE(bytes);
    auto loaded = world_from_bytes(*bytes);
    REQUIRE(loaded);
    run(w, 1.0 / 60, 40), run(*loaded, 1.0 / 60, 40);
    CHECK(state_hash(w) == state_hash(*loaded));
  }
}
