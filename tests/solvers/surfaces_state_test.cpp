// Surfaces that touch: what is kept of them, what ends them, lifting off and landing.
#include <catch2/catch.hpp>
#include <filesystem>

#include "engine/runtime/save.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/surfaces.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81;

/// An ellipsoid that rolls on another one.
struct RollingPair {
  World world;
  Entity moving, contact;
};
RollingPair rolling(Integrator integrator) {
  RollingPair p{exact_world(integrator), {}, {}};
  const Entity ground = add_ground(p.world, {{}, from_rotation_vector({0.2, 0.4, 0.1})});
  const Vec3 half(0.2, 0.15, 0.1);
  p.moving = p.world.add_body(
      solid_ellipsoid(1, half, {{0.03, 0.43, -0.02}, from_rotation_vector({0.3, 0.5, -0.2})}));
  p.world.bodies[p.moving].angular_velocity = {0.4, 1.5, -0.6};
  p.contact = touch(p.world, {p.moving, ball_skin(half), ground, ball_skin({0.5, 0.3, 0.4})},
                    SurfaceMotion::rolling);
  return p;
}

void run(Simulation& sim, int steps) {
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
}

}  // namespace

TEST_CASE("surfaces: copies, saved worlds and repeated runs go on to the same bits") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    const std::string path =
        (std::filesystem::temp_directory_path() / "pantin_surfaces.world").string();
    Simulation one(rolling(integrator).world, {1.0 / 200}),
        two(rolling(integrator).world, {1.0 / 200});
    run(one, 20), run(two, 20);
    CHECK(state_hash(one.world) == state_hash(two.world));
    Simulation copy = Simulation::copy_of(one.world, {1.0 / 200});
    REQUIRE(save_world(one.world, path));
    Result<World> loaded = load_world(path);
    REQUIRE(loaded);
    CHECK(state_hash(*loaded) == state_hash(one.world));
    Simulation back(std::move(*loaded), {1.0 / 200});
    run(one, 20), run(copy, 20), run(back, 20);
    CHECK(state_hash(one.world) == state_hash(copy.world));
    CHECK(state_hash(one.world) == state_hash(back.world));
    std::filesystem::remove(path);
  }
}

TEST_CASE("surfaces: where they touch is kept when something else of the World changes") {
  RollingPair p = rolling(Integrator::rk4);
  Simulation with = Simulation::copy_of(p.world, {1.0 / 200}),
             without = Simulation::copy_of(p.world, {1.0 / 200});
  run(with, 20), run(without, 20);
  with.world.add_body(solid(1, Vec3(1), {{3, 3, 3}, kIdentity}));
  run(with, 20), run(without, 20);
  const Body &one = with.world.bodies[p.moving], &two = without.world.bodies[p.moving];
  CHECK(one.pose.position == two.pose.position);
  CHECK(one.pose.rotation == two.pose.rotation);
  // A joint that is added to the same island starts from the same places.
  const Entity touched = with.world.add_body(solid(1e-9, Vec3(1e-9), {{0, 2, 0}, kIdentity}));
  Joint spring;
  spring.kind = JointKind::spring;
  spring.parameters.edit().translation.spring = {1e-12, 0, 1}, spring.parameters.edit().length = 1;
  add_link(with.world, {p.moving, touched, spring});
  const nurbs::PlacePair before = with.world.surface_contacts[p.contact].at;
  run(with, 1), run(without, 1);
  const nurbs::PlacePair after = with.world.surface_contacts[p.contact].at;
  CHECK(after.a.face == before.a.face);
  CHECK(glm::distance(with.world.bodies[p.moving].pose.position,
                      without.world.bodies[p.moving].pose.position) <= 1e-9);
}

TEST_CASE("surfaces: a saved place off its surface is refused") {
  SurfaceContact c;
  c.on_a.skin = ball_skin(Vec3(1)), c.on_b.skin = flat_skin(1);
  c.known = true;
  CHECK(c.restored() == nullptr);
  c.at.b.u = 2;
  CHECK(c.restored() != nullptr);
  c.at.b.u = 0.5, c.at.a.face = 6;
  CHECK(c.restored() != nullptr);
  c.at.a.face = -1;
  CHECK(c.restored() != nullptr);
  c.at.a.face = 0, c.on_b.skin = nullptr;
  CHECK(c.restored() != nullptr);
}

namespace {

/// A ball that rolls over the rim of a small plate.
Simulation over_the_rim(OnRim on_rim, Integrator integrator, Entity& ball, Entity& contact) {
  World w = exact_world(integrator);
  const Entity ground = add_ground(w);
  ball = w.add_body(solid_ball(1, 0.1, {0.3, 0.1, 0.1}));
  contact = touch(w, {ball, ball_skin(Vec3(0.1)), ground, flat_skin(1)}, SurfaceMotion::rolling);
  w.surface_contacts[contact].on_rim = on_rim;
  w.bodies[ball].velocity = {1, 0, 0}, w.bodies[ball].angular_velocity = {0, 0, -10};
  return Simulation(std::move(w), {1.0 / 100});
}

}  // namespace

TEST_CASE("surfaces: a ball that rolls over the rim ends the run, by name, or comes free") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    Entity ball, contact;
    Simulation stops = over_the_rim(OnRim::stop, integrator, ball, contact);
    StepReport report;
    int steps = 0;
    for (; steps < 100 && report.status == Status::ok; ++steps) report = stops.step();
    CHECK(report.status == Status::contact_lost);
    CHECK(report.contact == contact);
    CHECK(report.body == ball);
    CHECK(std::string(report.contact_fault) == "ContactLeftPatch");
    CHECK(steps == Approx(21).margin(1));
    CHECK(stops.world.bodies[ball].pose.position.x == Approx(0.5).margin(0.011));
    CHECK(stops.world.bodies[ball].pose.position.y == Approx(0.1).margin(1e-9));

    Simulation frees = over_the_rim(OnRim::release, integrator, ball, contact);
    int released = 0;
    for (int i = 0; i < 40; ++i) {
      report = frees.step();
      REQUIRE(report.status == Status::ok);
      released += report.released;
    }
    CHECK(released == 1);
    const SurfaceContact& c = frees.world.surface_contacts[contact];
    CHECK(c.over);
    CHECK_FALSE(c.touches);
    CHECK(c.force == Vec3(0));
    CHECK(c.status == nurbs::ContactStatus::left_patch);
    // It has fallen freely since, still at its speed.
    CHECK(frees.world.bodies[ball].velocity.x == Approx(1).epsilon(1e-9));
    CHECK(frees.world.bodies[ball].velocity.y == Approx(-kG * 0.2).epsilon(0.06));
  }
}

namespace {

/// The cosine of the angle at which a body that slides, or rolls, down a ball leaves it.
Real cosine_where_it_leaves(Integrator integrator, SurfaceMotion motion, Real h) {
  constexpr Real kFixed = 1, kOwn = 0.1, kRadii = kFixed + kOwn;
  World w = exact_world(integrator);
  const Entity ground = add_ground(w);
  const Real start = 0.1;
  const Entity ball =
      w.add_body(solid_ball(1, kOwn, kRadii * Vec3(std::sin(start), std::cos(start), 0)));
  const Entity contact =
      touch(w, {ball, ball_skin(Vec3(kOwn)), ground, ball_skin(Vec3(kFixed))}, motion);
  w.surface_contacts[contact].lifts = true;
  Simulation sim(std::move(w), {h});
  Real last = 0;
  for (int i = 0; i < 4 / h && sim.world.bodies[ball].pose.position.y > 0; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    const SurfaceContact& c = sim.world.surface_contacts[contact];
    if (c.touches)
      last = sim.world.bodies[ball].pose.position.y / kRadii;
    else if (last > 0)
      break;
  }
  return last;
}

}  // namespace

TEST_CASE("surfaces: a ball leaves another where the force between them vanishes") {
  const Real start = std::cos(0.1);
  for (const Integrator integrator :
       {Integrator::rk4, Integrator::euler, Integrator::rattle, Integrator::radau}) {
    INFO(name_of(integrator));
    // Sliding: v^2 = 2 g R (cos 0.1 - cos), and g cos = v^2 / R.
    CHECK(cosine_where_it_leaves(integrator, SurfaceMotion::sliding, 1.0 / 500) ==
          Approx(2.0 / 3 * start).margin(integrator == Integrator::euler ? 0.02 : 0.006));
    // RollingPair: 7/10 v^2 = g R (cos 0.1 - cos).
    CHECK(cosine_where_it_leaves(integrator, SurfaceMotion::rolling, 1.0 / 500) ==
          Approx(10.0 / 17 * start).margin(integrator == Integrator::euler ? 0.02 : 0.006));
  }
}

TEST_CASE("surfaces: a ball that is dropped lands, stays and rolls; it is not held down") {
  for (const Integrator integrator :
       {Integrator::rk4, Integrator::euler, Integrator::rattle, Integrator::radau}) {
    INFO(name_of(integrator));
    World w = exact_world(integrator);
    const Entity ground = add_ground(w);
    const Entity ball = w.add_body(solid_ball(1, 0.1, {0, 0.6, 0}));
    const Entity contact =
        touch(w, {ball, ball_skin(Vec3(0.1)), ground, flat_skin(8)}, SurfaceMotion::rolling);
    w.surface_contacts[contact].lifts = true;
    w.bodies[ball].velocity = {1, 0, 0};
    Simulation sim(std::move(w), {1.0 / 100});
    const Real lands = std::sqrt(2 * 0.5 / kG);
    int first = -1;
    for (int i = 0; i < 60; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      if (first < 0 && sim.world.surface_contacts[contact].touches) first = i + 1;
      CHECK(sim.world.bodies[ball].pose.position.y >= 0.1 - 1e-6);
    }
    CHECK(first * 0.01 == Approx(lands).margin(0.021));
    const Body& b = sim.world.bodies[ball];
    CHECK(b.pose.position.y == Approx(0.1).margin(1e-8));
    // The blow takes the slip: 5/7 of the speed is left, rolling.
    CHECK(b.velocity.x == Approx(5.0 / 7).epsilon(1e-6));
    CHECK(b.angular_velocity.z == Approx(-50.0 / 7).epsilon(1e-6));
    sim.world.bodies[ball].velocity.y = 2;
    sim.world.bodies[ball].restart = true;
    run(sim, 10);
    CHECK(sim.world.bodies[ball].pose.position.y > 0.2);
    CHECK_FALSE(sim.world.surface_contacts[contact].touches);
  }
}
