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

namespace {

/// How far a ball that rolls off a disc is from its parabola, 0.3 s after it left the rim.
Real error_of_flight(Integrator integrator, Real h) {
  constexpr Real kFrom = 0.303, kTime = kDisc - kFrom + 0.3;
  Roller r = ball_on(plate({kDisc}), OnRim::release, {kFrom, kBall, 0}, integrator);
  r.sim.settings.h = h;
  for (int i = 0; i < std::lround(kTime / h); ++i) REQUIRE(r.sim.step().status == Status::ok);
  const Real flown = r.sim.world.time - (kDisc - kFrom);
  const Body& b = r.sim.world.bodies[r.ball];
  const Vec3 place(kDisc + flown, kBall - 9.81 / 2 * flown * flown, 0);
  return glm::distance(b.pose.position, place) +
         glm::distance(b.velocity, Vec3(1, -9.81 * flown, 0));
}

/// A ball that spins and rolls obliquely out of a trough, a part of a cylinder, over its rim, and
/// flies on: in the end.
Body out_of_trough(Integrator integrator, Real h) {
  constexpr Real kTime = 0.5, kRim = 0.8;  // s, rad
  World w = exact_world(integrator);
  const Entity ground = add_ground(w);
  const nurbs::Curve section =
      nurbs::arc({{0, 1, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1, {-kPi / 2 - 1, -kPi / 2 + kRim});
  const Entity ball = w.add_body(solid_ball(1, kBall, {0, kBall, 0}));
  const Entity contact = touch(
      w, {ball, ball_skin(Vec3(kBall)), ground, skin_of(nurbs::extruded(section, {0, 0, -2}))},
      SurfaceMotion::rolling);
  w.surface_contacts[contact].on_rim = OnRim::release;
  w.bodies[ball].velocity = {3, 0, -0.4}, w.bodies[ball].angular_velocity = {-4, 5, -30};
  Simulation sim(std::move(w), {h});
  int released = 0;
  for (int i = 0; i < std::lround(kTime / h); ++i) {
    const StepReport report = sim.step();
    REQUIRE(report.status == Status::ok);
    released += report.released;
  }
  CHECK(released == 1);
  return sim.world.bodies[ball];
}

}  // namespace

TEST_CASE("a ball that leaves a rim amid a step falls from the rim at the order of the method") {
  const Body exact = out_of_trough(Integrator::rk4, 2.5e-4);
  CHECK(exact.velocity.x < 2.5);  // it rose and flew
  const auto error_of = [&](Integrator integrator, Real h) {
    const Body b = out_of_trough(integrator, h);
    return glm::distance(b.pose.position, exact.pose.position) +
           glm::distance(b.velocity, exact.velocity) +
           kBall * glm::distance(b.angular_velocity, exact.angular_velocity);
  };
  for (const Integrator integrator : kAll) {
    // At no step is it at the rim at the end of one.
    const Real flat = error_of_flight(integrator, 0.01);
    const Real coarse = error_of(integrator, 0.01), fine = error_of(integrator, 0.0025);
    INFO(name_of(integrator) << ": " << flat << "; " << coarse << ", " << fine);
    const bool first = integrator == Integrator::euler;
    CHECK(flat <= (first ? 0.02 : 1e-8));
    CHECK(fine <= (first ? 0.01 : 1e-4));
    if (integrator == Integrator::radau) continue;
    CHECK(std::log2(coarse / fine) / 2 > (first ? 0.9 : 1.9));
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
