// Bodies that turn while what they lean on holds them, without friction: their energy is kept.
#include <catch2/catch.hpp>

#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kGravity = 9.81, kRadius = 0.02, kHalf = 1, kMass = 1, kMoment = 1.0 / 3;

/// rad: the angle of a ladder to the wall, after a time: a (I + m l^2) = m g l sin a.
Real ladder_angle(Real angle, Real time) {
  const Real k = kMass * kGravity * kHalf / (kMoment + kMass * kHalf * kHalf);
  constexpr int kParts = 4000;
  const Real h = time / kParts;
  Real spin = 0;
  for (int i = 0; i < kParts; ++i) {  // leapfrog
    spin += 0.5 * h * k * std::sin(angle);
    angle += h * spin;
    spin += 0.5 * h * k * std::sin(angle);
  }
  return angle;
}

Real energy_of(const Body& b) {
  const Vec3 inside = glm::conjugate(b.pose.rotation) * b.angular_velocity;
  return 0.5 * (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(inside, b.inertia * inside)) +
         b.mass * kGravity * b.pose.position.y;
}

}  // namespace

TEST_CASE("a ladder slides down between floor and wall as its energy says, at every rate") {
  constexpr Real kTime = 0.3;
  for (const int rate : {30, 60, 240, 480, 960, 3840}) {
    World w;
    w.gravity = {0, -kGravity, 0}, w.default_settings.sleep_speed = 0;
    Collision smooth;
    smooth.friction = 0;
    const Real start = 20 * kPi / 180;
    const Entity floor = add_ground(w, smooth);
    w.bodies[floor].pose.position = {0, -kRadius, 0};
    const Entity wall = add_ground(w, smooth, from_rotation_vector({0, 0, -kPi / 2}));
    w.bodies[wall].pose.position = {-kRadius, 0, 0};
    const Entity rod = add_solid(w, rod_shape(kRadius, kHalf),
                                 {{kHalf * std::sin(start), kHalf * std::cos(start), 0},
                                  from_rotation_vector({0, 0, start})},
                                 Motion::dynamic, smooth);
    w.bodies[rod].mass = kMass, w.bodies[rod].inertia = {kMoment, 1e-4, kMoment};
    Simulation sim = Simulation::copy_of(w, {1.0 / rate});
    const Real before = energy_of(sim.world.bodies[rod]);
    for (int i = 0; i < std::lround(kTime * rate); ++i) {
      REQUIRE(sim.step().status == Status::ok);
      REQUIRE(energy_of(sim.world.bodies[rod]) <= (1 + 1e-3) * before);
    }
    const Quat q = sim.world.bodies[rod].pose.rotation;
    const Real angle = 2 * std::atan2(q.z, q.w);
    INFO(rate << " Hz");
    CHECK(std::abs(angle - ladder_angle(start, kTime)) <= 0.05 * kPi / 180);
  }
}

namespace {

Shape disc_shape(Real radius, Real half) {
  Shape s;
  s.kind = ShapeKind::cylinder, s.size = {radius, half, 0};
  return s;
}

Collision rough(Real friction) {
  Collision c;
  c.friction = friction;
  return c;
}

World grounded(Real friction) {
  World w;
  w.gravity = {0, -kGravity, 0}, w.default_settings.sleep_speed = 0;
  add_ground(w, rough(friction));
  return w;
}

Real tilt_of(const Body& b) {
  return std::acos(std::min(Real(1), std::abs((b.pose.rotation * Vec3(0, 1, 0)).y)));
}

}  // namespace

// Its middle stands still while the point of contact runs around: for a thin disc of radius r that
// leans by a from the floor, Omega^2 = 4 g / (r sin a), and its spin Omega sin a is about its
// diameter through that point.
TEST_CASE("a disc that rolls on its rim about its resting middle keeps energy and tilt") {
  for (const Real degrees : {10.0, 30.0, 60.0})
    for (const int rate : {60, 240, 960}) {
      World w = grounded(2);
      const Real r = 0.1, half = 1e-3, lean = degrees * kPi / 180;
      const Quat at = from_rotation_vector({0, 0, -lean});
      const Entity e = add_solid(w, disc_shape(r, half),
                                 {{0, r * std::sin(lean) + half * std::cos(lean), 0}, at},
                                 Motion::dynamic, rough(2));
      w.bodies[e].mass = 1, w.bodies[e].inertia = {0.25 * r * r, 0.5 * r * r, 0.25 * r * r};
      const Real spin = std::sqrt(4 * kGravity * std::sin(lean) / r);
      w.bodies[e].angular_velocity = spin * (at * Vec3(-1, 0, 0));
      Simulation sim(std::move(w), {1.0 / rate});
      const Real before = energy_of(sim.world.bodies[e]);
      Real least = before, most = before;
      for (int i = 0; i < 2 * rate; ++i) {
        REQUIRE(sim.step().status == Status::ok);
        const Real now = energy_of(sim.world.bodies[e]);
        least = std::min(least, now), most = std::max(most, now);
      }
      INFO(degrees << " degrees at " << rate << " Hz");
      CHECK(most <= 1.001 * before);
      CHECK(least >= (rate < 240 ? 0.95 : 0.999) * before);
      CHECK(std::abs(tilt_of(sim.world.bodies[e]) - lean) < (rate < 240 ? 0.5 : 0.1) * lean);
    }
}

// The state after half a second, of coins of any size that roll as they like: energy is kept, and
// the tilt is that of a finer step.
TEST_CASE("thick coins roll with their energy kept, and to where a finer step has them") {
  struct Coin {
    Real radius, half, degrees, speed;
  };
  for (const Coin& c :
       {Coin{0.0116, 0.0012, 30, 1}, Coin{0.0116, 0.0012, 60, 1}, Coin{0.0116, 0.0012, 45, 1.5},
        Coin{0.1, 0.01, 30, 0.8}, Coin{0.1, 0.02, 45, 1.3}, Coin{0.4, 0.03, 20, 1.1}}) {
    Real fine = 0;
    for (const int rate : {1920, 60, 240, 960}) {
      World w = grounded(2);
      const Real lean = c.degrees * kPi / 180;
      const Quat at = from_rotation_vector({0, 0, -lean});
      const Vec3 middle(0, c.radius * std::sin(lean) + c.half * std::cos(lean), 0);
      const Entity e =
          add_solid(w, disc_shape(c.radius, c.half), {middle, at}, Motion::dynamic, rough(2), 8000);
      const Vec3 spin =
          c.speed * std::sqrt(4 * kGravity * std::sin(lean) / c.radius) * (at * Vec3(-1, 0, 0));
      w.bodies[e].angular_velocity = spin;
      w.bodies[e].velocity = -glm::cross(spin, at * Vec3(c.radius, -c.half, 0));
      Simulation sim(std::move(w), {1.0 / rate});
      const Real before = energy_of(sim.world.bodies[e]);
      INFO(c.radius << " m, " << c.degrees << " degrees at " << rate << " Hz");
      for (int i = 0; i < rate / 2; ++i) {
        REQUIRE(sim.step().status == Status::ok);
        REQUIRE(std::abs(energy_of(sim.world.bodies[e]) / before - 1) <= 2e-3);
      }
      const Real tilt = tilt_of(sim.world.bodies[e]);
      if (rate == 1920) fine = tilt;
      CHECK(std::abs(tilt - fine) <= 0.2 * kPi / 180);
    }
  }
}

TEST_CASE("capsules and drums roll at constant speed, however fast") {
  for (const ShapeKind kind : {ShapeKind::capsule, ShapeKind::cylinder})
    for (const Real speed : {0.5, 5.0, 20.0})
      for (const int rate : {30, 60, 240}) {
        World w = grounded(0.5);
        const Shape shape{kind, {0.1, 0.15, 0}, {}};
        const Entity e = add_solid(w, shape, {{0, 0.1, 0}, from_rotation_vector({kPi / 2, 0, 0})},
                                   Motion::dynamic, rough(0.5));
        w.bodies[e].velocity = {speed, 0, 0};
        w.bodies[e].angular_velocity = {0, 0, -speed / 0.1};
        Simulation sim(std::move(w), {1.0 / rate});
        for (int i = 0; i < 5 * rate; ++i) REQUIRE(sim.step().status == Status::ok);
        const Body& b = sim.world.bodies[e];
        INFO(int(kind) << " at " << speed << " m/s and " << rate << " Hz");
        CHECK(glm::length(b.velocity - Vec3(speed, 0, 0)) <= 1e-6 * speed);
        CHECK(glm::length(b.pose.position - Vec3(5 * speed, 0.1, 0)) <= 1e-5 * speed);
      }
}

TEST_CASE("a box that slides to a stop or down a slope goes the way of constant acceleration") {
  for (const int rate : {30, 60, 240})
    for (const Real degrees : {0.0, 40.0}) {
      constexpr Real kFriction = 0.4, kTime = 0.5, kStart = 3;
      World w;
      w.gravity = {0, -kGravity, 0}, w.default_settings.sleep_speed = 0;
      const Real a = degrees * kPi / 180;
      const Quat slope = from_rotation_vector({0, 0, -a});
      add_ground(w, rough(kFriction), slope);
      const Entity e = add_solid(w, box_shape({0.2, 0.05, 0.2}), {slope * Vec3(0, 0.05, 0), slope},
                                 Motion::dynamic, rough(kFriction));
      w.bodies[e].velocity = slope * Vec3(kStart, 0, 0);
      Simulation sim(std::move(w), {1.0 / rate});
      for (int i = 0; i < std::lround(kTime * rate); ++i) REQUIRE(sim.step().status == Status::ok);
      const Real along = kGravity * (std::sin(a) - kFriction * std::cos(a));
      const Real way = kStart * kTime + 0.5 * along * kTime * kTime;
      const Vec3 at = glm::conjugate(slope) * sim.world.bodies[e].pose.position;
      INFO(degrees << " degrees at " << rate << " Hz");
      CHECK(glm::length(at - Vec3(way, 0.05, 0)) <= 1e-6);
    }
}
