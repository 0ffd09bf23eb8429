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
    Simulation sim(w, {1.0 / rate});
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
