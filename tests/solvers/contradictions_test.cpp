// Surface joints that hold a body within an obstacle: refused, with nothing moved.
#include <catch2/catch.hpp>

#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// An ellipsoid that rolls or slides on the plane y = 0 of a body, and a box around (0, height, 0)
/// with which it collides.
struct Held {
  World world;
  Entity egg, joint, box;
};
Held held(Integrator integrator, SurfaceMotion motion, Vec3 half, Real height) {
  Held s{exact_world(integrator), {}, {}, {}};
  const Vec3 radii(0.3, 0.15, 0.2);
  const Entity ground = add_ground(s.world);
  s.egg = s.world.add_body(solid_ellipsoid(2, radii, {{0, radii.y, 0}, kIdentity}));
  s.world.bodies[s.egg].velocity = {0.3, 0, 0.2};
  s.joint = touch(s.world, {s.egg, ball_skin(radii), ground, flat_skin(20)}, motion);
  const auto collide = [&](Entity e, ShapeKind kind, Vec3 size) {
    Shape shape;
    shape.kind = kind, shape.size = size;
    s.world.shapes.add(e, {{shape}});
    s.world.collisions.add(e, {});
  };
  collide(s.egg, ShapeKind::ellipsoid, radii);
  s.box = add_ground(s.world, {{0, height, 0}, kIdentity});
  collide(s.box, ShapeKind::box, half);
  return s;
}

}  // namespace

TEST_CASE(
    "contradictions: a surface joint within an obstacle is refused with both, nothing moves") {
  for (const Integrator integrator : kAll)
    for (const SurfaceMotion motion : {SurfaceMotion::rolling, SurfaceMotion::sliding})
      for (const Real depth : {0.002, 0.01, 0.05}) {
        INFO(name_of(integrator) << " " << static_cast<int>(motion) << " " << depth);
        Held s = held(integrator, motion, {5, depth, 5}, 0);
        const Body before = s.world.bodies[s.egg];
        Simulation sim(std::move(s.world), {1.0 / 240});
        for (int i = 0; i < 3; ++i) {
          const StepReport report = sim.step();
          REQUIRE(report.status == Status::inconsistent);
          CHECK(report.worst_residual_at == s.joint);
          CHECK(report.body == s.box);
          CHECK(report.worst_residual == Approx(depth).epsilon(0.05));
          const Body& now = sim.world.bodies[s.egg];
          CHECK(now.pose.position == before.pose.position);
          CHECK(now.velocity == before.velocity);
        }
      }
}

TEST_CASE("contradictions: obstacles beside, above, or flush with the surface are none") {
  for (const Integrator integrator : kAll)
    for (const SurfaceMotion motion : {SurfaceMotion::rolling, SurfaceMotion::sliding}) {
      INFO(name_of(integrator) << " " << static_cast<int>(motion));
      for (const Real height : {-0.5, 1.2}) {  // its top at the plane; its bottom at 0.7
        Held s = held(integrator, motion, {5, 0.5, 5}, height);
        Simulation sim(std::move(s.world), {1.0 / 240});
        for (int i = 0; i < 120; ++i) REQUIRE(sim.step().status == Status::ok);
        const Body& b = sim.world.bodies[s.egg];
        CHECK(glm::length(b.pose.position) < 1);
      }
    }
}

TEST_CASE("contradictions: an egg that rolls against a wall is stopped by it") {
  for (const Integrator integrator : {Integrator::rk4, Integrator::rattle, Integrator::euler}) {
    INFO(name_of(integrator));
    Held s = held(integrator, SurfaceMotion::rolling, {0.1, 0.5, 5}, 0.5);
    s.world.bodies[s.box].pose.position.x = 0.7;
    s.world.bodies[s.egg].velocity = {0.8, 0, 0};
    s.world.mark_dirty();
    Simulation sim(std::move(s.world), {1.0 / 240});
    for (int i = 0; i < 240; ++i) REQUIRE(sim.step().status == Status::ok);
    const Vec3 at = sim.world.bodies[s.egg].pose.position;
    CHECK(at.x < 0.6 - 0.15 + 1e-3);
    CHECK(glm::length(sim.world.bodies[s.egg].velocity) < 2);
  }
}
