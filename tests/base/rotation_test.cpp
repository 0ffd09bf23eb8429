// Rotations as quaternions and as rotation vectors.
#include "engine/base/rotation.hpp"

#include <catch2/catch.hpp>

#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::test;

TEST_CASE("a rotation vector becomes a quaternion and comes back, from tiny to half a turn") {
  Random dice(1);
  Real worst = 0, worst_norm = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 r = std::pow(10, dice.between(-12, std::log10(3.14))) * dice.direction();
    const Quat q = from_rotation_vector(r);
    worst_norm = std::max(worst_norm, std::abs(glm::length(q) - 1));
    worst = std::max(worst, glm::length(rotation_vector(q) - r) / glm::length(r));
  }
  CHECK(worst_norm <= 5e-16);
  CHECK(worst <= 1e-12);
}

TEST_CASE("the series near zero joins the closed form without a step") {
  for (Real angle : {0.9999e-3, 0.99999999e-3, 1.00000001e-3, 1.0001e-3}) {
    const Vec3 axis = glm::normalize(Vec3(1, -2, 0.5));
    const Quat q = from_rotation_vector(angle * axis);
    CHECK(q.w == Approx(std::cos(angle / 2)).epsilon(1e-15));
    CHECK(glm::length(Vec3(q.x, q.y, q.z) - std::sin(angle / 2) * axis) <= 1e-18);
  }
  CHECK(from_rotation_vector(Vec3(0)) == kIdentity);
  CHECK(rotation_vector(kIdentity) == Vec3(0));
}

TEST_CASE("a rotation vector is the shortest way round") {
  const Vec3 axis = glm::normalize(Vec3(1, 2, 3));
  for (Real angle : {0.5, 3.0, 3.3, 6.0, 9.0, -2.0}) {
    const Vec3 r = rotation_vector(from_rotation_vector(angle * axis));
    CHECK(glm::length(r) <= kPi + 1e-15);
    const Real rest = std::remainder(angle, 2 * kPi);
    CHECK(glm::length(r - rest * axis) <= 1e-14);
  }
  CHECK(glm::length(rotation_vector(from_rotation_vector(kPi * axis))) ==
        Approx(kPi).epsilon(1e-14));
}

TEST_CASE("turning a vector by a quaternion is turning it about the axis by the angle") {
  Random dice(2);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 axis = dice.direction(), v = dice.in_cube(2);
    const Real angle = dice.between(-6, 6);
    // Rodrigues' formula.
    const Vec3 expected = std::cos(angle) * v + std::sin(angle) * glm::cross(axis, v) +
                          (1 - std::cos(angle)) * glm::dot(axis, v) * axis;
    CHECK(glm::length(from_rotation_vector(angle * axis) * v - expected) <= 5e-15);
  }
}

TEST_CASE("Cayley's map turns by twice the arctangent of half, below half a turn") {
  Random dice(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 d = std::pow(10, dice.between(-6, 6)) * dice.direction();
    const Quat q = cayley(d);
    CHECK(std::abs(glm::length(q) - 1) <= 5e-16);
    const Vec3 r = rotation_vector(q);
    CHECK(glm::length(r) < kPi);
    CHECK(glm::length(r) == Approx(2 * std::atan(glm::length(d) / 2)).epsilon(1e-12));
    CHECK(glm::length(glm::cross(r, d)) <= 1e-12 * glm::length(r) * glm::length(d));
  }
}

TEST_CASE("parts of a rotation add up to it") {
  Random dice(4);
  for (int i = 0; i < 300; ++i) {
    const Quat q = dice.rotation();
    const Real k = dice.between(0, 1);
    const Quat whole = fraction_of(q, k) * fraction_of(q, 1 - k);
    CHECK(std::abs(glm::dot(whole, q)) == Approx(1).epsilon(1e-15));
    CHECK(glm::length(rotation_vector(whole * glm::conjugate(q))) <= 1e-14);
  }
}

TEST_CASE("the spin between two rotations carries one to the other") {
  Random dice(5);
  for (int i = 0; i < 300; ++i) {
    const Quat from = dice.rotation(), to = from_rotation_vector(dice.in_cube(1.5)) * from;
    const Vec3 angular_velocity = angular_velocity_between(from, to, 0.02);
    const Quat reached = from_rotation_vector(0.02 * angular_velocity) * from;
    CHECK(glm::length(rotation_vector(reached * glm::conjugate(to))) <= 1e-14);
  }
}

TEST_CASE("a world inertia has the body's moments along the body's axes") {
  Random dice(6);
  for (int i = 0; i < 300; ++i) {
    const Vec3 moments = Vec3(1, 2, 2.5) * dice.between(0.1, 10);
    const Quat q = dice.rotation();
    const Mat3 inertia = world_inertia(q, moments);
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 e(0);
      e[axis] = 1;
      const Vec3 world = q * e;
      CHECK(glm::length(inertia * world - moments[axis] * world) <= 1e-14 * moments.z);
    }
    CHECK(inertia[0][1] == Approx(inertia[1][0]).margin(1e-15 * moments.z));
  }
}

TEST_CASE("poses compose, invert and carry points there and back") {
  Random dice(7);
  for (int i = 0; i < 300; ++i) {
    const Pose a{dice.in_cube(3), dice.rotation()}, b{dice.in_cube(3), dice.rotation()};
    const Vec3 p = dice.in_cube(2);
    CHECK(glm::length(to_local(a, to_world(a, p)) - p) <= 5e-15);
    CHECK(glm::length(to_world(compose(a, b), p) - to_world(a, to_world(b, p))) <= 1e-14);
    const Pose none = compose(a, inverse(a));
    CHECK(glm::length(none.position) <= 1e-14);
    CHECK(std::abs(none.rotation.w) == Approx(1).epsilon(1e-15));
  }
}
