// Surfaces that roll and slide on one another: against what is known in closed form.
#include "tests/solvers/surfaces.hpp"

#include <catch2/catch.hpp>

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81;

/// Steps until `time`, each of which has to be well.
void run(Simulation& sim, Real time) {
  const int steps = static_cast<int>(std::lround(time / sim.settings.h));
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
}

/// A ball on a plane that rises along x by `slope`; axes of the plane.
struct Incline {
  World world;
  Entity ball, contact;
  Vec3 up, down;
};
Incline incline(Integrator integrator, Real slope) {
  Incline s{exact_world(integrator), {}, {}, {}, {}};
  const Real r = 0.1;
  s.up = {-std::sin(slope), std::cos(slope), 0}, s.down = {-std::cos(slope), -std::sin(slope), 0};
  const Entity ground = add_ground(s.world);
  s.ball = s.world.add_body(solid_ball(2, r, r * s.up));
  s.contact = touch(s.world, {s.ball, ball_skin(Vec3(r)), ground, flat_skin(20, s.up)},
                    SurfaceMotion::rolling);
  return s;
}

}  // namespace

TEST_CASE("surfaces: a ball rolls down an incline with 5/7 of its slope, spinning or not") {
  for (const Integrator integrator : kAll) {
    Incline s = incline(integrator, 0.4);
    const Entity ball = s.ball, contact = s.contact;
    s.world.bodies[ball].angular_velocity = 7.0 * s.up;
    Simulation sim(std::move(s.world), {1.0 / 100});
    run(sim, 1);
    const Real a = 5.0 / 7 * kG * std::sin(0.4);
    INFO(name_of(integrator));
    const Body& b = sim.world.bodies[ball];
    CHECK(glm::length(b.velocity - a * s.down) <= 1e-10 * a);
    CHECK(std::abs(glm::dot(b.angular_velocity, s.up) - 7) <= 1e-10);
    const Real way = glm::dot(b.pose.position - 0.1 * s.up, s.down);
    CHECK(way == Approx(a / 2).epsilon(integrator == Integrator::euler ? 1.02e-2 : 1e-10));
    CHECK(slip_of(sim.world, contact) <= 1e-12);
    CHECK(std::abs(sim.world.surface_contacts[contact].gap) <= 1e-12);
    CHECK(glm::dot(sim.world.surface_contacts[contact].force, s.up) ==
          Approx(-2 * kG * std::cos(0.4)).epsilon(1e-9));
  }
}

namespace {

/// Where the centre of a ball on a table that turns about the vertical is after 3 s, and where it
/// should be: its velocity turns at 2/7 of the table's rate.
Real error_on_turntable(Integrator integrator, Real h, Jacobians jacobians = Jacobians::analytic) {
  constexpr Real kRate = 3, kRadius = 0.1;
  World w = exact_world(integrator);
  w.default_settings.jacobians = jacobians;
  Body table;
  table.motion = Motion::kinematic;
  const Entity turntable = w.add_body(table);
  const Entity ball = w.add_body(solid_ball(1, kRadius, {0.5, kRadius, 0}));
  touch(w, {ball, ball_skin(Vec3(kRadius)), turntable, flat_skin(10)}, SurfaceMotion::rolling);
  const Vec3 start(0.2, 0, 0.4);
  // Without slip: v + w x (-r up) = table's velocity there.
  const Vec3 slip = start - glm::cross(Vec3(0, kRate, 0), Vec3(0.5, 0, 0));
  w.bodies[ball].velocity = start;
  w.bodies[ball].angular_velocity = glm::cross(Vec3(0, 1, 0), slip) / kRadius;
  Simulation sim(std::move(w), {h});
  // As if it had turned before.
  compile_if_changed(sim.world);
  lagrangian::Frame& frame = lagrangian::islands_of(sim.world).at(0).frames.at(0);
  frame.before = {}, frame.known = true;
  const int steps = static_cast<int>(std::lround(3 / h));
  for (int i = 0; i < steps; ++i) {
    sim.world.bodies[turntable].pose.rotation = from_rotation_vector({0, kRate * h * (i + 1), 0});
    REQUIRE(sim.step().status == Status::ok);
  }
  const Real turn = 2.0 / 7 * kRate * 3;  // about the vertical
  const Real s = std::sin(turn) / (2.0 / 7 * kRate), c = (1 - std::cos(turn)) / (2.0 / 7 * kRate);
  const Vec3 way(s * start.x + c * start.z, 0, s * start.z - c * start.x);
  return glm::distance(sim.world.bodies[ball].pose.position, Vec3(0.5, kRadius, 0) + way);
}

}  // namespace

TEST_CASE("surfaces: the velocity of a ball on a turntable turns at 2/7 of the table's rate") {
  CHECK(error_on_turntable(Integrator::rk4, 0.04) <= 8.9e-9 * 3);
  CHECK(error_on_turntable(Integrator::rk4, 0.02) <= 1.0e-9);
  CHECK(error_on_turntable(Integrator::rk4, 0.01) <= 5e-10);
  CHECK(error_on_turntable(Integrator::radau, 0.02) <= 1e-10);
  for (const Integrator second : {Integrator::rattle, Integrator::implicit}) {
    INFO(name_of(second));
    const Real coarse = error_on_turntable(second, 0.01), fine = error_on_turntable(second, 0.005);
    CHECK(fine <= 8.6e-6);
    CHECK(std::log2(coarse / fine) == Approx(2).margin(0.2));
  }
  CHECK(error_on_turntable(Integrator::euler, 0.005) <= 2e-2);
}

TEST_CASE("surfaces: differences roll as closed forms do, the squared distance does not") {
  for (const Integrator integrator : kAll) {
    INFO(name_of(integrator));
    const auto error = [&](Jacobians j) { return error_on_turntable(integrator, 0.01, j); };
    const Real exact = error(Jacobians::analytic);
    CHECK(std::abs(error(Jacobians::differences) - exact) <= 1e-10);
  }
  CHECK(error_on_turntable(Integrator::rk4, 0.01, Jacobians::squared_distance) > 1e-7);
}

namespace {

/// The angle of a ball that rolls down a fixed one, from 0.2 rad, by its own equation.
Real angle_on_sphere(Real radii, Real time) {
  const auto pull = [&](Real x) { return 5.0 / 7 * kG * std::sin(x) / radii; };
  Real x = 0.2, v = 0;
  const int steps = 20000;
  const Real h = time / steps;
  for (int i = 0; i < steps; ++i) {
    const Real k1 = pull(x), k2 = pull(x + h / 2 * v), k3 = pull(x + h / 2 * v + h * h / 4 * k1),
               k4 = pull(x + h * v + h * h / 2 * k2);
    x += h * v + h * h / 6 * (k1 + k2 + k3), v += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return x;
}

Real error_on_sphere(Integrator integrator, Real h) {
  constexpr Real kFixed = 1, kOwn = 0.3, kTime = 0.6;
  World w = exact_world(integrator);
  const Entity ground = add_ground(w);
  const Real radii = kFixed + kOwn;
  const Entity ball =
      w.add_body(solid_ball(1, kOwn, radii * Vec3(std::sin(0.2), std::cos(0.2), 0)));
  touch(w, {ball, ball_skin(Vec3(kOwn)), ground, ball_skin(Vec3(kFixed))}, SurfaceMotion::rolling);
  Simulation sim(std::move(w), {h});
  run(sim, kTime);
  const Vec3 at = sim.world.bodies[ball].pose.position;
  return std::abs(std::atan2(at.x, at.y) - angle_on_sphere(radii, kTime));
}

}  // namespace

TEST_CASE("surfaces: a ball on a fixed ball rolls as its equation says, to order 4") {
  const Real coarse = error_on_sphere(Integrator::rk4, 0.02),
             middle = error_on_sphere(Integrator::rk4, 0.01),
             fine = error_on_sphere(Integrator::rk4, 0.005);
  CHECK(coarse <= 2.1e-8);
  CHECK(middle <= 1.3e-9);
  CHECK(fine <= 8e-11);
  CHECK(std::log2(coarse / middle) == Approx(4).margin(0.3));
  CHECK(error_on_sphere(Integrator::radau, 0.01) <= 2e-11);
  for (const Integrator second : {Integrator::rattle, Integrator::implicit}) {
    INFO(name_of(second));
    CHECK(error_on_sphere(second, 0.005) <= 1e-4);
    CHECK(std::log2(error_on_sphere(second, 0.01) / error_on_sphere(second, 0.005)) ==
          Approx(2).margin(0.2));
  }
  CHECK(error_on_sphere(Integrator::euler, 0.005) <= 2e-2);
}

namespace {

/// A torus that leans and rolls round on the floor (z up) in a steady turn; numbers of the method's
/// vectors, from the closed form.
Real error_of_wheel(Integrator integrator, Real h) {
  World w = exact_world(integrator, {0, 0, -9.81});
  const Entity ground = add_ground(w);
  Body wheel = solid(1, {0.05, 0.05, 0.09},
                     {{0.5355941332790835, 0, 0.47281563438689056},
                      Quat(0.8253356149096783, 0, 0.5646424733950354, 0)});
  wheel.velocity = {0, 1.071188266558167, 0};
  wheel.angular_velocity = {-2.5721097967198503, 0, 1.0000162608635152};
  const Entity torus = w.add_body(wheel);
  const Entity contact =
      touch(w, {torus, skin_of(nurbs::torus({}, 0.4, 0.1)), ground, flat_skin(6, {0, 0, 1})},
            SurfaceMotion::rolling);
  Simulation sim(std::move(w), {h});
  run(sim, 1);
  CHECK(std::abs(sim.world.surface_contacts[contact].gap) <= 1e-12);
  return glm::distance(sim.world.bodies[torus].pose.position,
                       {-0.22288580423729915, 0.4870143672136018, 0.47281563438689056});
}

}  // namespace

TEST_CASE("surfaces: a leaning wheel goes round in its steady turn") {
  const Real coarse = error_of_wheel(Integrator::rk4, 0.02),
             middle = error_of_wheel(Integrator::rk4, 0.01),
             fine = error_of_wheel(Integrator::rk4, 0.005);
  CHECK(coarse <= 3.8e-7);
  CHECK(middle <= 2.45e-8);
  CHECK(fine <= 1.55e-9);
  CHECK(std::log2(middle / fine) == Approx(4).margin(0.3));
  CHECK(error_of_wheel(Integrator::radau, 0.01) <= 1e-11);
  for (const Integrator second : {Integrator::rattle, Integrator::implicit}) {
    INFO(name_of(second));
    CHECK(error_of_wheel(second, 0.005) <= 1e-3);
    CHECK(std::log2(error_of_wheel(second, 0.01) / error_of_wheel(second, 0.005)) ==
          Approx(2).margin(0.1));
  }
  CHECK(error_of_wheel(Integrator::euler, 0.005) <= 2.5e-2);
}

namespace {

/// Two ellipsoids, one fixed, that roll on one another.
struct Pair {
  World world;
  Entity moving, contact;
};
Pair ellipsoids(Integrator integrator, SurfaceMotion motion) {
  Pair p{exact_world(integrator), {}, {}};
  const Entity ground = add_ground(p.world, {{}, from_rotation_vector({0.2, 0.4, 0.1})});
  const Vec3 half(0.2, 0.15, 0.1);
  p.moving = p.world.add_body(
      solid_ellipsoid(1, half, {{0.03, 0.45, -0.02}, from_rotation_vector({0.3, 0.5, -0.2})}));
  p.world.bodies[p.moving].angular_velocity = {0.4, 1.5, -0.6};
  p.contact =
      touch(p.world, {p.moving, ball_skin(half), ground, ball_skin({0.5, 0.3, 0.4})}, motion);
  return p;
}

Vec3 end_of_ellipsoids(Integrator integrator, SurfaceMotion motion, Real h) {
  Pair p = ellipsoids(integrator, motion);
  Simulation sim(std::move(p.world), {h});
  run(sim, 0.01);  // the joint has closed
  const Real energy = measure(sim.world).energy();
  run(sim, 0.39);
  CHECK(std::abs(sim.world.surface_contacts[p.contact].gap) <= 1e-12);
  if (motion != SurfaceMotion::sliding) CHECK(slip_of(sim.world, p.contact) <= 1e-12);
  if (integrator == Integrator::rk4) CHECK(std::abs(measure(sim.world).energy() - energy) <= 5e-6);
  return sim.world.bodies[p.moving].pose.position;
}

}  // namespace

TEST_CASE("surfaces: ellipsoids slide and roll on one another to the order of the integrator") {
  for (const SurfaceMotion motion :
       {SurfaceMotion::sliding, SurfaceMotion::rolling, SurfaceMotion::rolling_without_spin}) {
    INFO(static_cast<int>(motion));
    const Vec3 best = end_of_ellipsoids(Integrator::rk4, motion, 0.000625);
    const auto error = [&](Integrator integrator, Real h) {
      return glm::distance(end_of_ellipsoids(integrator, motion, h), best);
    };
    const Real coarse = error(Integrator::rk4, 0.01), fine = error(Integrator::rk4, 0.005);
    CHECK(fine <= 2e-8);
    CHECK(std::log2(coarse / fine) == Approx(4).margin(0.5));
    CHECK(error(Integrator::radau, 0.005) <= 2e-8);
    for (const Integrator second : {Integrator::rattle, Integrator::implicit}) {
      INFO(name_of(second));
      CHECK(std::log2(error(second, 0.005) / error(second, 0.0025)) == Approx(2).margin(0.3));
    }
    CHECK(std::log2(error(Integrator::euler, 0.0025) / error(Integrator::euler, 0.00125)) ==
          Approx(1).margin(0.3));
  }
}

TEST_CASE("surfaces: a ball rolled round a square comes back turned by the known rotation") {
  constexpr Real kRadius = 0.1, kSide = 0.23, kSpeed = 0.5;
  World w = exact_world(Integrator::rk4);
  const Entity ground = add_ground(w);
  const Entity ball = w.add_body(solid_ball(1, kRadius, {0, kRadius, 0}));
  touch(w, {ball, ball_skin(Vec3(kRadius)), ground, flat_skin(4)},
        SurfaceMotion::rolling_without_spin);
  Simulation sim(std::move(w), {kSide / kSpeed / 50});
  Quat turned = kIdentity;
  for (const Vec3 way : {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(-1, 0, 0), Vec3(0, 0, -1)}) {
    const Vec3 axis = glm::cross(Vec3(0, 1, 0), way);
    sim.world.bodies[ball].velocity = kSpeed * way;
    sim.world.bodies[ball].angular_velocity = kSpeed / kRadius * axis;
    sim.world.bodies[ball].restart = true;
    run(sim, kSide / kSpeed);
    turned = from_rotation_vector(kSide / kRadius * axis) * turned;
  }
  const Body& b = sim.world.bodies[ball];
  CHECK(glm::distance(b.pose.position, {0, kRadius, 0}) <= 1e-12);
  const Quat off = b.pose.rotation * glm::conjugate(turned);
  CHECK(glm::length(rotation_vector(off)) <= 1e-6);
  CHECK(glm::length(rotation_vector(turned)) > 0.5);
}
