// Rolling and spinning friction against closed forms.
#include <catch2/catch.hpp>

#include "engine/contact/contact.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kG = 9.81, kRadius = 0.1;

/// A step, and the error that is allowed at it.
struct Case {
  Real h, error;
};
constexpr Case kCases[] = {{1.0 / 60, 0.01}, {1.0 / 240, 0.001}};

Collision surface(Real friction, Real rolling, Real spinning = 0) {
  Collision c;
  c.friction = friction, c.rolling = rolling, c.spinning = spinning, c.others = true;
  return c;
}

constexpr Solver kSolvers[] = {Solver::articulated, Solver::lagrangian};

/// m/s: what stands. The exact solver finds impulses to 1e-10 of the largest.
Real rest_of(Solver solver) { return solver == Solver::lagrangian ? 1e-10 : 1e-12; }

World awake(Solver solver) {
  World w;
  w.default_settings.solver = solver, w.default_settings.sleep_speed = 0;
  return w;
}

Quat slope(Real degrees) { return from_rotation_vector({0, 0, -degrees * kPi / 180}); }

Entity add_ball(World& w, const Collision& c, Vec3 at = {0, kRadius, 0}) {
  return add_solid(w, ball_shape(kRadius), {at, kIdentity}, Motion::dynamic, c);
}

void run(Simulation& sim, Real seconds) {
  for (int i = 0; i < std::lround(seconds / sim.settings.h); ++i)
    REQUIRE(sim.step().status == Status::ok);
}

}  // namespace

TEST_CASE("a rolling ball loses five sevenths of g rho / r, stops and stays") {
  for (const Solver solver : kSolvers) {
    for (const auto& [h, error] : kCases)
      for (const Real rolling : {0.0005, 0.005}) {
        World w = awake(solver);
        add_ground(w, surface(0.5, 0));
        const Entity e = add_ball(w, surface(0.5, rolling));  // of two bodies the larger counts
        const Real loss = 5.0 / 7 * kG * rolling / kRadius, speed = 2 * loss;
        w.bodies[e].velocity = {speed, 0, 0}, w.bodies[e].angular_velocity = {0, 0, -10 * speed};
        Simulation sim = Simulation::copy_of(w, {h});
        const Body& b = sim.world.bodies[e];
        run(sim, 1);
        INFO("rolling " << rolling << " at " << h << " s");
        CHECK(b.velocity.x == Approx(speed - loss).epsilon(error));
        CHECK(b.angular_velocity.z == Approx(-10 * b.velocity.x).epsilon(1e-6));
        run(sim, 1.1);
        const Real stopped = b.pose.position.x;
        CHECK(stopped == Approx(speed * speed / (2 * loss)).epsilon(0.01));  // of first order
        for (int i = 0; i < std::lround(5 / h); ++i) {
          sim.step();
          REQUIRE(glm::length(b.velocity) < rest_of(solver));
          REQUIRE(glm::length(b.angular_velocity) < 10 * rest_of(solver));
        }
        CHECK(std::abs(b.pose.position.x - stopped) < rest_of(solver));
      }
  }
}

TEST_CASE("a ball stands on a slope up to rho / r, and rolls above") {
  for (const Solver solver : kSolvers) {
    for (const auto& [h, error] : kCases)
      for (const Real part : {0.5, 0.99, 1.01, 2.0}) {
        const Real rolling = 0.01, degrees = std::atan(part * rolling / kRadius) * 180 / kPi;
        World w = awake(solver);
        add_ground(w, surface(0.9, rolling), slope(degrees));
        const Entity e = add_ball(w, surface(0.9, 0), slope(degrees) * Vec3(0, kRadius, 0));
        Simulation sim = Simulation::copy_of(w, {h});
        run(sim, 2);
        const Real angle = degrees * kPi / 180;
        const Real pull =
            5.0 / 7 * kG * std::max(Real(0), std::sin(angle) - rolling / kRadius * std::cos(angle));
        INFO(part << " of the least slope at " << h << " s");
        CHECK(std::abs(glm::length(sim.world.bodies[e].velocity) - 2 * pull) <=
              error * 2 * pull + 1e-9);
      }
  }
}

TEST_CASE("a spinning ball loses its spin by 5/2 lambda g / r^2 and stands") {
  for (const Solver solver : kSolvers) {
    for (const auto& [h, error] : kCases) {
      World w = awake(solver);
      add_ground(w, surface(0.5, 0, 0.002));
      const Entity e = add_ball(w, surface(0.5, 0));
      const Real loss = 2.5 * 0.002 * kG / (kRadius * kRadius);
      w.bodies[e].angular_velocity = {0, -2 * loss, 0};
      Simulation sim = Simulation::copy_of(w, {h});
      const Body& b = sim.world.bodies[e];
      run(sim, 1);
      CHECK(b.angular_velocity.y == Approx(-loss).epsilon(error));
      Vec3 torque(0);
      for (const Contact& c : contacts_of(sim.world)) torque += c.torque;
      CHECK(torque.y == Approx(0.002 * b.mass * kG).epsilon(1e-6));
      run(sim, 1.1);
      for (int i = 0; i < std::lround(2 / h); ++i) {
        sim.step();
        REQUIRE(glm::length(b.angular_velocity) < rest_of(solver));
        REQUIRE(glm::length(b.velocity) < rest_of(solver));
      }
    }
  }
}

TEST_CASE("spinning friction leaves rolling alone, and rolling friction spinning") {
  for (const Solver solver : kSolvers) {
    World w = awake(solver);
    add_ground(w, surface(0.5, 0, 0.01));
    const Entity rolls = add_ball(w, surface(0.5, 0));
    w.bodies[rolls].velocity = {1, 0, 0}, w.bodies[rolls].angular_velocity = {0, 0, -10};
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    run(sim, 2);
    CHECK(sim.world.bodies[rolls].velocity.x == Approx(1).epsilon(1e-9));

    World v = awake(solver);
    add_ground(v, surface(0.5, 0.01, 0));
    const Entity spins = add_ball(v, surface(0.5, 0));
    v.bodies[spins].angular_velocity = {0, 20, 0};
    Simulation other = Simulation::copy_of(v, {1.0 / 60});
    run(other, 2);
    CHECK(other.world.bodies[spins].angular_velocity.y == Approx(20).epsilon(1e-9));
  }
}

TEST_CASE("a ball that rolls and one that it rolls on are pushed by opposite torques") {
  for (const Solver solver : kSolvers) {
    // A plank on smooth ground: what the ball loses, the plank gains.
    World w = awake(solver);
    add_ground(w, surface(0, 0));
    const Entity plank = add_solid(w, box_shape({5, 0.1, 1}), {{0, 0.1, 0}, kIdentity},
                                   Motion::dynamic, surface(0.5, 0));
    const Entity e = add_ball(w, surface(0.5, 0.01, 0.01), {0, 0.2 + kRadius, 0});
    w.bodies[e].velocity = {0, 0, 2}, w.bodies[e].angular_velocity = {20, 30, 0};
    const Real m = w.bodies[e].mass, n = w.bodies[plank].mass;
    const Vec3 inertia = w.bodies[plank].inertia;
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    for (int i = 0; i < 24; ++i) {  // until it leaves the plank
      sim.step();
      const Body &ball = sim.world.bodies[e], &under = sim.world.bodies[plank];
      REQUIRE(std::abs(m * ball.velocity.z + n * under.velocity.z - 2 * m) < 1e-9 * m);
      // About the vertical axis through the middle of all.
      const Real whole =
          m * (ball.pose.position.z * ball.velocity.x - ball.pose.position.x * ball.velocity.z) +
          n * (under.pose.position.z * under.velocity.x -
               under.pose.position.x * under.velocity.z) +
          0.4 * m * kRadius * kRadius * ball.angular_velocity.y +
          inertia.y * under.angular_velocity.y;
      // The plank tips a little.
      REQUIRE(whole == Approx(0.4 * m * kRadius * kRadius * 30)
                           .epsilon(solver == Solver::lagrangian ? 2e-7 : 1e-7));
    }
  }
}

TEST_CASE("balls with rolling friction come to rest on one another and fall asleep") {
  World w;
  add_ground(w, surface(0.6, 0.004, 0.004));
  std::vector<Entity> balls;
  for (int i = 0; i < 30; ++i)
    balls.push_back(
        add_ball(w, surface(0.6, 0.004, 0.004), {0.06 * (i % 3), 0.15 + 0.21 * i, 0.05 * (i % 2)}));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  for (int i = 0; i < 60 * 40; ++i) REQUIRE(sim.step().status == Status::ok);
  for (const Entity e : balls) CHECK(sim.world.bodies[e].velocity == Vec3(0));
}

TEST_CASE("the wheel of a barrow is braked by what its contact bears") {
  for (const Solver solver : kSolvers) {
    // A wheel on an axle that a chain of two holds; the whole rolls on two balls.
    for (const auto& [h, error] : kCases) {
      World w = awake(solver);
      add_ground(w, surface(0.8, 0));
      const Real rolling = 0.004;
      const Entity frame = add_solid(w, box_shape({0.5, 0.02, 0.02}), {{0, kRadius, 0}, kIdentity},
                                     Motion::dynamic, surface(0.8, 0));
      w.collisions.remove(std::vector<Entity>{frame});
      Real inertia = 0, mass = w.bodies[frame].mass;
      for (const Real x : {-0.5, 0.5}) {
        const Entity wheel = add_ball(w, surface(0.8, rolling), {x, kRadius, 0});
        Joint joint;
        joint.kind = JointKind::hinge;
        joint.anchor_a = {x, 0, 0};
        const Quat across = from_rotation_vector({0, -kPi / 2, 0});  // x to z
        joint.frames.set(across, across);
        add_link(w, {frame, wheel, joint});
        inertia += w.bodies[wheel].inertia.x, mass += w.bodies[wheel].mass;
        w.bodies[wheel].velocity = {1, 0, 0}, w.bodies[wheel].angular_velocity = {0, 0, -10};
      }
      w.bodies[frame].velocity = {1, 0, 0};
      Simulation sim = Simulation::copy_of(w, {h});
      run(sim, 1);
      // Work of the torques: (m + I / r^2) v dv = -rho / r m g v dt.
      const Real loss = rolling / kRadius * mass * kG / (mass + inertia / (kRadius * kRadius));
      CHECK(1 - sim.world.bodies[frame].velocity.x == Approx(loss).epsilon(2 * error));
    }
  }
}
