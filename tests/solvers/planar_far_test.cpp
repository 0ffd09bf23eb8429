// The planar solver: bodies far from the origin and from one another, and numbers that none can be
// computed with. Box2D computes in single precision, and ends the program where it meets such.
#include <catch2/catch.hpp>
#include <limits>

#include "tests/solvers/planar.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();
constexpr Real kInfinity = std::numeric_limits<Real>::infinity();

/// A box on level ground and one on top of it.
void add_tower(World& w, Vec3 at) {
  add_solid(w, ShapeKind::box, {0.2, 0.1, 0.1}, {at + Vec3(0, 0.1, 0), kIdentity});
  add_solid(w, ShapeKind::box, {0.1, 0.1, 0.1}, {at + Vec3(0.05, 0.3, 0), kIdentity});
}

}  // namespace

TEST_CASE("planar towers rest wherever they stand, alone or far from one another") {
  for (const Real far : {0.0, 1e4, 1e6, -3e7}) {
    CAPTURE(far);
    World w = planar_world();
    add_slope(w, 0);
    add_tower(w, {far, 0, 0});
    if (far != 0) add_tower(w, {0, 0, 0});
    const World before = w;
    const StepReport report = run(w, 1.0 / 60, 120);
    CHECK(report.contacts == (far != 0 ? 8 : 4));
    for (std::size_t i = 1; i < w.bodies.size(); ++i) {
      const Vec3 gone =
          w.bodies.values()[i].pose.position - before.bodies.values()[i].pose.position;
      CHECK(glm::length(gone) < 2e-3);
    }
  }
}

TEST_CASE("what falls for ever disturbs nothing that stands") {
  for (const Real height : {-1e3, -1e6, -1e9, 1e9}) {
    CAPTURE(height);
    World w = planar_world();
    add_slope(w, 0);
    add_tower(w, {0, 0, 0});
    // Beside the half-space there is no place below it: far aside, in groups of its own.
    Collision apart;
    apart.groups = 2, apart.with = 2;
    const Entity lost =
        add_solid(w, ShapeKind::box, {0.2, 0.2, 0.2}, {{-0.63, height, 0}, kIdentity}, apart);
    const World before = w;
    run(w, 1.0 / 60, 60);
    for (std::size_t i = 1; i < 3; ++i)
      CHECK(glm::length(w.bodies.values()[i].pose.position -
                        before.bodies.values()[i].pose.position) < 2e-3);
    CHECK(w.bodies[lost].velocity.y == Approx(-9.81).epsilon(1e-4));
    CHECK(w.bodies[lost].pose.position.y - height == Approx(-4.905).epsilon(0.02));
  }
}

TEST_CASE("planar bodies deep within a half-space far away end in finite numbers") {
  for (const Real depth : {1e2, 1e4, 1e6, 1e9, 1e11}) {
    CAPTURE(depth);
    World w = planar_world();
    add_slope(w, 0);
    add_solid(w, ShapeKind::sphere, {0.3, 0, 0}, {{0, 0, 0}, kIdentity});
    add_solid(w, ShapeKind::box, {0.2, 0.2, 0.2}, {{0, 0, 0}, kIdentity});
    add_solid(w, ShapeKind::box, {0.2, 0.2, 0.2}, {{-0.63, -depth, 0}, kIdentity});
    run(w, 1.0 / 60, 60);
    for (const Body& b : w.bodies.values()) CHECK(is_finite(b.pose));
  }
}

TEST_CASE(
    "numbers that no plane can be stepped with are told with their body, and spoil no other") {
  const auto spoil = [](World& w, int how, Real bad) {
    Body& b = w.bodies.values()[2];
    Collision& c = w.collisions.values()[2];
    if (how == 0) b.pose.position.x = bad;
    if (how == 1) b.pose.rotation = Quat(bad, 0, 0, 0);
    if (how == 2) b.velocity.y = bad;
    if (how == 3) b.angular_velocity.z = bad;
    if (how == 4) b.mass = bad;
    if (how == 5) b.inertia.z = bad;
    if (how == 6) c.friction = bad;
    if (how == 7) c.restitution = bad;
    if (how == 8) w.push(w.bodies.owners()[2], {bad, 0, 0}, b.pose.position);
    if (how == 9) w.gravity.y = bad;
    if (how == 10) b.gravity_scale = bad;
  };
  for (int how = 0; how < 11; ++how)
    for (const Real bad : {kNan, kInfinity, -kInfinity, 1e300, -1e300, 1e39}) {
      CAPTURE(how, bad);
      World w = planar_world();
      add_slope(w, 0);
      add_tower(w, {0, 0, 0});
      Simulation sim = Simulation::copy_of(w);
      for (int i = 0; i < 3; ++i) REQUIRE(sim.step().status == Status::ok);
      const Vec3 before = sim.world.bodies.values()[1].pose.position;
      spoil(sim.world, how, bad);
      const StepReport report = sim.step();
      // Heavy, but a number; a rotation that is only long.
      const bool allowed = ((how == 4 || how == 5) && bad == 1e300) || (how == 1 && bad == 1e39);
      if (!allowed) CHECK(report.status == Status::diverged);
      const Vec3 after = sim.world.bodies.values()[1].pose.position;
      // What is wrong in its own members stops a body alone; the others fall on.
      CHECK(is_finite(after));
      CHECK(glm::length(after - before) < 1e-2);
    }
}
