// The planar solver: contacts, and what a World has to stay whatever solves it: a value.
#include <catch2/catch.hpp>

#include "engine/runtime/save.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/planar.hpp"

using namespace pantin;
using namespace pantin::test;

TEST_CASE("a planar stack of boxes rests where it stands, and falls asleep") {
  World w = planar_stack(10);
  const World before = w;
  const StepReport report = run(w, 1.0 / 60, 300);
  CHECK(report.asleep == 10);
  CHECK(report.contacts == 20);
  CHECK(report.worst_depth < 1e-3);
  for (std::size_t i = 1; i < w.bodies.size(); ++i) {
    const Vec3 gone = w.bodies.values()[i].pose.position - before.bodies.values()[i].pose.position;
    CHECK(std::abs(gone.x) < 1e-4);
    CHECK(std::abs(gone.y) < 2e-3);
  }
}

TEST_CASE("a planar box slides down a slope beyond the angle of friction, and no other") {
  for (const Real friction : {0.2, 0.5})
    for (const Real steeper : {-0.03, 0.03}) {
      const Real angle = std::atan(friction) + steeper;
      Collision how;
      how.friction = friction;
      World w = planar_world();
      add_slope(w, angle, how);
      const Quat tilt = from_rotation_vector({0, 0, angle});
      const Entity box =
          add_solid(w, ShapeKind::box, {0.2, 0.1, 0.1}, {tilt * Vec3(0, 0.1, 0), tilt}, how);
      const Vec3 start = w.bodies[box].pose.position;
      run(w, 1.0 / 120, 240);
      const Real down = std::max(0.0, std::sin(angle) - friction * std::cos(angle));
      const Real way = glm::length(w.bodies[box].pose.position - start);
      INFO("friction " << friction << ", slope " << angle);
      if (steeper > 0)
        CHECK(way == Approx(0.5 * 9.81 * down * 4).epsilon(0.05));
      else
        CHECK(way < 2e-3);
    }
}

TEST_CASE("a planar ball bounces back with its restitution") {
  for (const Real restitution : {0.0, 0.5, 0.9}) {
    Collision how;
    how.restitution = restitution;
    World w = planar_world();
    add_slope(w, 0, how);
    const Entity ball = add_solid(w, ShapeKind::sphere, {0.1, 0, 0}, {{0, 1.1, 0}, kIdentity}, how);
    const Real fall = std::sqrt(2 * 9.81 * 1.0);
    Real fastest = 0;
    for (int i = 0; i < 240; ++i) {
      run(w, 1.0 / 480, 1);
      fastest = std::max(fastest, w.bodies[ball].velocity.y);
    }
    CHECK(fastest == Approx(restitution * fall).margin(0.03 * fall));
  }
}

TEST_CASE("planar bodies touch where their own surfaces meet") {
  const ShapeKind kinds[] = {ShapeKind::box, ShapeKind::sphere, ShapeKind::capsule};
  for (const ShapeKind below : kinds)
    for (const ShapeKind above : kinds) {
      World w = planar_world();
      const Quat lying = from_rotation_vector({0, 0, kPi / 2});
      const auto add = [&](ShapeKind kind, Real y, Motion motion) {
        const Quat turn = kind == ShapeKind::capsule ? lying : kIdentity;
        const Entity e = add_solid(w, kind, {0.1, 0.1, 0.1}, {{0, y, 0}, turn});
        w.bodies[e].motion = motion;
        return e;
      };
      add(below, 0, Motion::fixed);
      const Entity top = add(above, 0.2, Motion::dynamic);
      run(w, 1.0 / 60, 30);
      INFO(static_cast<int>(below) << " below " << static_cast<int>(above));
      CHECK(w.bodies[top].pose.position.y == Approx(0.2).margin(1e-3));
    }
}

TEST_CASE(
    "planar bodies at other heights, of other groups and those that a joint ties do not touch") {
  World w = planar_world({0, 0, 0});
  const Collision plain;
  Collision other;
  other.groups = 2, other.with = 2;
  const Entity left = add_solid(w, ShapeKind::box, Vec3(0.1), {{0, 0, 0}, kIdentity}, plain);
  add_solid(w, ShapeKind::box, Vec3(0.1), {{0.05, 0, 0.5}, kIdentity}, plain);
  add_solid(w, ShapeKind::box, Vec3(0.1), {{0.05, 0.05, 0}, kIdentity}, other);
  const Entity tied = add_solid(w, ShapeKind::box, Vec3(0.1), {{0.1, 0, 0}, kIdentity}, plain);
  add_hinge(w, left, tied, {0.05, 0, 0});
  const World before = w;
  const StepReport report = run(w, 1.0 / 60, 20);
  CHECK(report.contacts == 0);
  for (std::size_t i = 0; i < w.bodies.size(); ++i)
    CHECK(w.bodies.values()[i].pose.position == before.bodies.values()[i].pose.position);
}

TEST_CASE("a planar World is a value: copies and saved ones go on with the same bits") {
  World w = planar_stack(6);
  w.bodies.values()[3].velocity = {0.5, 0, 0};
  run(w, 1.0 / 60, 20);  // in the middle of the fall
  World copy = w;
  Result<World> loaded = world_from_bytes(world_to_bytes(w, nullptr).value(), World(), "test");
  REQUIRE(loaded);
  World read = *loaded;
  CHECK(state_hash(read) == state_hash(w));
  for (int i = 0; i < 60; ++i) {
    for (World* one : {&w, &copy, &read}) run(*one, 1.0 / 60, 1);
    REQUIRE(state_hash(copy) == state_hash(w));
    REQUIRE(state_hash(read) == state_hash(w));
  }
}

TEST_CASE("a planar step depends on the contacts before it, and on nothing else that is hidden") {
  World w = planar_stack(6);
  run(w, 1.0 / 60, 10);
  World forgetful = w;
  planar::plane_of(forgetful).touches.clear();
  CHECK(state_hash(forgetful) != state_hash(w));
  run(w, 1.0 / 60, 1), run(forgetful, 1.0 / 60, 1);
  CHECK(state_hash(forgetful) != state_hash(w));
}

TEST_CASE("a planar stack goes on as it was when something is added elsewhere") {
  World w = planar_stack(8);
  run(w, 1.0 / 60, 20);
  const World before = w;
  Body far;
  far.pose.position = {50, 0, 0}, far.motion = Motion::fixed;
  w.add_body(far);
  run(w, 1.0 / 60, 40);
  for (std::size_t i = 0; i < before.bodies.size(); ++i)
    CHECK(glm::length(w.bodies.values()[i].pose.position -
                      before.bodies.values()[i].pose.position) < 1e-3);
  CHECK(planar::plane_of(w).touches.size() == 16);
}

TEST_CASE("planar steps are the same whatever the number of threads") {
  World one = planar_stack(5), four = one;
  StepSettings settings;
  settings.h = 1.0 / 60;
  for (int i = 0; i < 30; ++i) {
    settings.threads = 1, step_world(one, settings, {}, {});
    settings.threads = 4, step_world(four, settings, {}, {});
  }
  CHECK(state_hash(one) == state_hash(four));
}

TEST_CASE("bodies of other solvers stand on planar ones, which feel them") {
  World w = planar_stack(1);
  w.bodies.values()[1].motion = Motion::dynamic;
  Collision how;
  const Entity ball =
      add_solid(w, ShapeKind::sphere, {0.05, 0, 0}, {{0.05, 0.3, 0}, kIdentity}, how);
  SolverSettings own;
  w.settings.add(ball, own);
  run(w, 1.0 / 60, 30);
  CHECK(w.bodies[ball].pose.position.y == Approx(0.25).margin(5e-3));
}

TEST_CASE("what no plane has is named, and does not move") {
  World w = planar_world();
  const auto faults = [&] {
    std::string all;
    for (const StructureFault& f : check(w)) all += f.reason + "; ";
    return all;
  };
  const Entity e = add_solid(w, ShapeKind::box, {0.1, 0.2, 0.3}, {{0, 1, 0}, kIdentity});
  CHECK(faults().empty());
  SECTION("a velocity out of it") {
    w.bodies[e].velocity = {0, 0, 1};
    CHECK(faults() == "moves along z, out of the xy plane; ");
  }
  SECTION("a spin out of it") {
    w.bodies[e].angular_velocity = {1, 0, 0};
    CHECK(faults() == "rotates about an axis other than z, out of the xy plane; ");
  }
  SECTION("no principal axis along z") {
    w.bodies[e].pose.rotation = from_rotation_vector({0.5, 0, 0});
    CHECK(faults() ==
          "has no principal axis along z: rotating, it would tilt out of the xy plane; ");
  }
  SECTION("gravity out of it") {
    w.gravity = {0, -9, 1};
    CHECK(faults() == "falls along z, out of the xy plane; ");
  }
  SECTION("a shape with another section") {
    w.shapes[e].list[0].kind = ShapeKind::ellipsoid;
    CHECK(faults() == "has a shape without a planar section of discs and polygons; ");
  }
  const Vec3 before = w.bodies[e].pose.position;
  run(w, 1.0 / 60, 5);
  CHECK(w.bodies[e].pose.position == before);
}

TEST_CASE("joints that no plane has are named and left out") {
  World w = planar_world();
  const Entity a = add_fixed(w), b = add_rod(w, {0, 0, 0}, {1, 0, 0});
  Joint joint = planar_joint(w, a, b, JointKind::hinge, {0, 0, 0});
  std::string expected;
  SECTION("a hinge askew") {
    joint = planar_joint(w, a, b, JointKind::hinge, {0, 0, 0}, {1, 0, 1});
    expected = "has an axis other than z, unlike a hinge in the xy plane";
  }
  SECTION("a universal joint") {
    joint.kind = JointKind::universal;
    expected = "is of a kind that has no planar form";
  }
  SECTION("anchors at two heights") {
    joint.anchor_a.z = 0.1;
    expected = "has anchors at two heights z, which no motion in the plane closes";
  }
  SECTION("a ball joint with limits") {
    joint.kind = JointKind::ball;
    joint.limits.edit().swing = {true, 1, 1};
    expected = "is a ball joint with limits: \"planar\" needs a hinge along z for them";
  }
  add_link(w, {a, b, joint});
  REQUIRE(check(w).size() == 1);
  CHECK(check(w)[0].reason == expected);
  CHECK(check(w)[0].kind == StructureFault::left_out);
}
