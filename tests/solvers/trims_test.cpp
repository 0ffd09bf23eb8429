// Bodies on trimmed faces: what rolls over a trim leaves it there, what is free falls through it.
#include <catch2/catch.hpp>

#include "engine/geometry/skin_model.hpp"
#include "engine/nurbs/plane_curves.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kDisc = 0.7, kHole = 0.3, kBall = 0.1;

/// A plate of 2 m by 2 m at height 0, trimmed to circles about its middle.
nurbs::Surface plate(std::initializer_list<Real> radii) {
  nurbs::Surface s = nurbs::plane({{}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, 2, 2);
  for (const Real radius : radii)
    s.trims.push_back(transformed(nurbs::circle({}, radius / 2), {Mat3(1), Vec3(0.5, 0.5, 0)}));
  return s;
}

struct Roller {
  Simulation sim;
  Entity ball, contact;
};

/// A ball that rolls over a plate, from `from` along x at 1 m/s.
Roller ball_on(const nurbs::Surface& on, OnRim on_rim, Vec3 from, Integrator integrator) {
  World w = exact_world(integrator);
  const Entity ground = add_ground(w);
  const Entity ball = w.add_body(solid_ball(1, kBall, from));
  const Entity contact =
      touch(w, {ball, ball_skin(Vec3(kBall)), ground, skin_of(on)}, SurfaceMotion::rolling);
  w.surface_contacts[contact].on_rim = on_rim;
  w.bodies[ball].velocity = {1, 0, 0}, w.bodies[ball].angular_velocity = {0, 0, -1 / kBall};
  return {Simulation(std::move(w), {1.0 / 100}), ball, contact};
}

/// The time at which the contact leaves the surface. A step over the trim is not taken, so that it
/// can be repeated with half the length.
Real time_of_loss(Roller& r) {
  for (int n = 0; n < 200 && r.sim.settings.h > 1e-9; ++n) {
    const Real time = r.sim.world.time;
    const StepReport report = r.sim.step();
    if (report.status == Status::ok) continue;
    REQUIRE(report.status == Status::contact_lost);
    CHECK(std::string(report.contact_fault) == "ContactLeftPatch");
    CHECK(report.contact == r.contact);
    r.sim.settings.h /= 2, r.sim.world.time = time;
  }
  return r.sim.world.time;
}

Entity add_plate(World& w, const nurbs::Surface& on) {
  const Entity ground = add_ground(w);
  Shape shape;
  shape.kind = ShapeKind::nurbs, shape.surface = *make_skin(skin_of(on));
  w.shapes.add(ground, {{shape}}), w.collisions.add(ground, {});
  return ground;
}
Entity add_free(World& w, Shape shape, Vec3 at) {
  const Entity body = w.add_body(solid(1, Vec3(0.004), {at, kIdentity}));
  w.shapes.add(body, {{std::move(shape)}}), w.collisions.add(body, {});
  return body;
}
Shape ball_shape() {
  Shape shape;
  shape.kind = ShapeKind::sphere, shape.size = Vec3(kBall, 0, 0);
  return shape;
}

}  // namespace

TEST_CASE("a ball rolls off a disc at its radius, and over the edge of a hole") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    // Along a chord 0.2 m beside the middle.
    Roller out = ball_on(plate({kDisc}), OnRim::stop, {0.3, kBall, 0.2}, integrator);
    const Real rim = std::sqrt(kDisc * kDisc - 0.2 * 0.2);
    CHECK(time_of_loss(out) == Approx(rim - 0.3).margin(1e-6));
    CHECK(out.sim.world.bodies[out.ball].pose.position.x == Approx(rim).margin(1e-6));

    Roller in = ball_on(plate({kDisc, kHole}), OnRim::stop, {-0.6, kBall, 0.1}, integrator);
    CHECK(time_of_loss(in) == Approx(0.6 - std::sqrt(kHole * kHole - 0.01)).margin(1e-6));

    Roller frees = ball_on(plate({kDisc}), OnRim::release, {0.3, kBall, 0}, integrator);
    int released = 0;
    for (int i = 0; i < 60; ++i) released += frees.sim.step().released;
    CHECK(released == 1);
    CHECK(frees.sim.world.surface_contacts[frees.contact].over);
    CHECK(frees.sim.world.surface_contacts[frees.contact].status ==
          nurbs::ContactStatus::left_patch);
    CHECK(frees.sim.world.bodies[frees.ball].pose.position.y < kBall - 0.1);
  }
}

TEST_CASE("a free ball rests on a trimmed plate and falls through its hole and beside it") {
  for (const Solver solver : {Solver::articulated, Solver::lagrangian}) {
    World w;
    w.default_settings.solver = solver;
    add_plate(w, plate({kDisc, kHole}));
    const Entity on = add_free(w, ball_shape(), {0.5, 0.15, 0});
    const Entity through = add_free(w, ball_shape(), {0.05, 0.15, 0});
    const Entity beside = add_free(w, ball_shape(), {0, 0.15, 0.85});
    Simulation sim(std::move(w), {1.0 / 240});
    for (int i = 0; i < 240; ++i) REQUIRE(sim.step().status == Status::ok);
    CHECK(sim.world.bodies[on].pose.position.y == Approx(kBall).margin(2e-3));
    CHECK(sim.world.bodies[through].pose.position.y < -1);
    CHECK(sim.world.bodies[beside].pose.position.y < -1);
  }
}

TEST_CASE("a box stands on a trimmed plate, and tips over its rim") {
  World w;
  add_plate(w, plate({kDisc}));
  Shape box;
  box.kind = ShapeKind::box, box.size = Vec3(0.1);
  const Entity stands = add_free(w, box, {0, 0.1, 0});
  const Entity reaches_over = add_free(w, box, {0.66, 0.1, 0}),
               tips = add_free(w, box, {0, 0.1, 0.75});
  Simulation sim(std::move(w), {1.0 / 240});
  for (int i = 0; i < 240; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(sim.world.bodies[stands].pose.position.y == Approx(0.1).margin(2e-3));
  CHECK(sim.world.bodies[reaches_over].pose.position.y == Approx(0.1).margin(2e-3));
  CHECK(sim.world.bodies[tips].pose.position.y < -0.5);
}
