// The motion of one body whose joint point must reach a place: what holds for every arm and gap.
#include "engine/solvers/articulated/procedural/compulsive.hpp"

#include <catch2/catch.hpp>

#include "tests/solvers/stages.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;
using namespace pantin::detail::articulated;

namespace {

/// A body, an arm in it and a gap, all of random sizes and directions.
struct Case {
  Vec3 arm, gap, moments;
  Quat rotation;
  Real mass;
  Mat3 inertia() const { return world_inertia(rotation, moments); }
  CompulsiveMotion motion(Real stiffness = 1) const {
    return least_displacement(arm, gap, {mass, inertia()}, stiffness);
  }
  /// Kinetic cost of turning by `angle` about r x s and sliding so that the anchor lands.
  Real action(Real angle) const {
    const Vec3 axis = glm::normalize(glm::cross(arm, gap));
    const Quat turn = from_rotation_vector(angle * axis);
    const Pose from{Vec3(0), rotation}, to{arm + gap - turn * arm, turn * rotation};
    return Stages::displacement(mass, moments, from, to);
  }
};

Case random_case(Random& dice) {
  Case c;
  c.arm = std::pow(10, dice.between(-2, 1)) * dice.direction();
  c.gap = std::pow(10, dice.between(-4, 1)) * dice.direction();
  c.mass = std::pow(10, dice.between(-2, 2));
  c.moments = box_inertia(c.mass, dice.in_box(0.01, 1));
  c.rotation = dice.rotation();
  return c;
}

Real angle_of(Quat q) { return 2 * std::atan2(glm::length(Vec3(q.x, q.y, q.z)), q.w); }
Real angle_between(Vec3 a, Vec3 b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}
Real size_of(const Case& c) { return glm::length(c.arm) + glm::length(c.gap); }

}  // namespace

TEST_CASE("a compulsive motion lands the anchor on its goal for any split") {
  Random dice(1);
  for (int i = 0; i < 2000; ++i) {
    const Case c = random_case(dice);
    for (Real stiffness : {0.0, 0.01, 1.0, 50.0}) {
      const CompulsiveMotion m = c.motion(stiffness);
      CHECK(glm::length(m.rotation * c.arm + m.translation - c.arm - c.gap) <= 4e-16 * size_of(c));
    }
    const CompulsiveMotion m = literal_rule(c.arm, c.gap, dice.between(0, 2));
    CHECK(glm::length(m.rotation * c.arm + m.translation - c.arm - c.gap) <= 4e-16 * size_of(c));
  }
}

TEST_CASE("the sign printed in [Lee 2000] would miss the goal by twice the gap") {
  Random dice(2);
  for (int i = 0; i < 200; ++i) {
    const Case c = random_case(dice);
    const CompulsiveMotion m = c.motion();
    const Vec3 printed = m.translation - 2.0 * c.gap;  // (1 - R) r - s
    CHECK(glm::length(printed - (c.arm - m.rotation * c.arm - c.gap)) <= 1e-15 * size_of(c));
    const Real miss = glm::length(m.rotation * c.arm + printed - c.arm - c.gap);
    CHECK(miss == Approx(2 * glm::length(c.gap)).epsilon(1e-12 * size_of(c) / glm::length(c.gap)));
  }
}

TEST_CASE("the turn lies between nothing and the whole angle to the goal") {
  Random dice(3);
  for (int i = 0; i < 2000; ++i) {
    const Case c = random_case(dice);
    const Real psi = angle_between(c.arm, c.arm + c.gap);
    const Real theta = angle_of(c.motion().rotation);
    CHECK(theta >= 0);
    CHECK(theta <= psi + 1e-15);
    // Without inertia the arm points all the way; with a lot of it the body only slides.
    CHECK(angle_of(c.motion(0).rotation) == Approx(psi).margin(1e-15).epsilon(1e-12));
    CHECK(angle_of(c.motion(1e12).rotation) < 1e-4);
  }
}

TEST_CASE("a small gap turns by the angle of an impulse at the anchor") {
  Random dice(4);
  for (int i = 0; i < 500; ++i) {
    Case c = random_case(dice);
    c.gap *= 1e-7 * glm::length(c.arm) / glm::length(c.gap);
    const Vec3 a = glm::cross(c.arm, c.gap);
    if (glm::length(a) < 0.01 * glm::length(c.arm) * glm::length(c.gap)) continue;
    const Real about = inertia_about_turn(c.arm, c.gap, c.inertia());
    const Real impulse = c.mass * glm::length(a) / (about + c.mass * glm::dot(c.arm, c.arm));
    CHECK(angle_of(c.motion().rotation) == Approx(impulse).epsilon(1e-6));
  }
}

TEST_CASE("a goal almost straight behind the body is reached by a finite turn") {
  const Vec3 arm(0, 0.5, 0);
  for (Real degrees : {179.0, 179.999, 179.9999999}) {
    const Real phi = degrees * kPi / 180;
    for (Real length : {0.25, 0.5, 0.9}) {
      const Vec3 gap = length * Vec3(std::sin(phi), std::cos(phi), 0);
      for (Real inertia : {0.0, 1e-6, 0.02, 10.0}) {
        const CompulsiveMotion m = least_displacement(arm, gap, {1, Mat3(inertia)});
        INFO(degrees << " degrees, gap " << length << ", inertia " << inertia);
        CHECK(is_finite(m.rotation));
        CHECK(glm::length(m.rotation * arm + m.translation - arm - gap) <= 1e-15);
        CHECK(std::abs(glm::length(m.rotation) - 1) <= 1e-15);
      }
    }
  }
}

TEST_CASE("where there is no axis the body slides and does not turn") {
  // Numbers whose products are exact: beyond the centre the last bit would choose an axis.
  const Vec3 arm(0.25, 0.5, 0);
  const Vec3 gap = GENERATE(Vec3(0), Vec3(0.25, 0.5, 0), Vec3(-0.125, -0.25, 0), Vec3(-2, -4, 0));
  for (const CompulsiveMotion& m :
       {least_displacement(arm, gap, {2, Mat3(0.1)}), literal_rule(arm, gap, 0.05)}) {
    CHECK(m.rotation == kIdentity);
    CHECK(m.translation == gap);
  }
  for (const CompulsiveMotion& m :
       {least_displacement(Vec3(0), arm, {2, Mat3(0.1)}), literal_rule(Vec3(0), arm, 0.05)}) {
    CHECK(m.rotation == kIdentity);
    CHECK(m.translation == arm);
  }
}

TEST_CASE("a compulsive turn has no part along the arm and goes about r x s") {
  Random dice(5);
  for (int i = 0; i < 1000; ++i) {
    const Case c = random_case(dice);
    const Vec3 a = glm::cross(c.arm, c.gap);
    if (glm::length(a) < 1e-3 * glm::length(c.arm) * glm::length(c.gap)) continue;
    for (Quat turn :
         {c.motion().rotation,
          literal_rule(c.arm, c.gap, 0.5 * glm::length(c.arm) * glm::length(c.gap)).rotation}) {
      const Vec3 r = rotation_vector(turn);
      CHECK(glm::length(glm::cross(r, glm::normalize(a))) <= 1e-12 * glm::length(r));
      CHECK(std::abs(glm::dot(r, glm::normalize(c.arm))) <= 1e-12 * glm::length(r));
      CHECK(glm::dot(r, a) >= 0);
    }
  }
}

TEST_CASE("no other turn about r x s moves the matter of the body less") {
  Random dice(6);
  Real worst = 0;
  for (int i = 0; i < 1000; ++i) {
    Case c = random_case(dice);
    const bool round = i % 2 == 0;
    if (round) c.moments = Vec3(c.moments.x);
    const Real theta = angle_of(c.motion().rotation), best = c.action(theta);
    if (!(glm::length(glm::cross(c.arm, c.gap)) > 1e-3 * glm::length(c.arm) * glm::length(c.gap)))
      continue;
    // A step of 1e-4 rad costs about stiffness * 1e-8 / 2; rounding of the sums is far below.
    CHECK(c.action(theta + 1e-4) > best);
    CHECK(c.action(theta - 1e-4) > best);
    for (Real other = 0; other < kPi; other += 0.1)
      worst = std::max(worst, (best - c.action(other)) / best);
  }
  CHECK(worst <= 1e-12);
}

TEST_CASE("the turn without trigonometry is the axis and angle of the formula") {
  Random dice(7);
  for (int i = 0; i < 1000; ++i) {
    const Case c = random_case(dice);
    const Vec3 a = glm::cross(c.arm, c.gap), axis = glm::normalize(a);
    if (glm::length(a) < 1e-3 * glm::length(c.arm) * glm::length(c.gap)) continue;
    const Real about = glm::dot(axis, c.inertia() * axis);
    const Real theta =
        std::atan2(c.mass * glm::length(a), about + c.mass * glm::dot(c.arm, c.arm + c.gap));
    const Quat expected(std::cos(theta / 2), std::sin(theta / 2) * axis);
    CHECK(glm::length(c.motion().rotation - expected) <= 3e-15);
  }
}

TEST_CASE("two free anchors meet on the line between them, nearer to the heavier body") {
  Random dice(8);
  for (int i = 0; i < 500; ++i) {
    const Vec3 a = dice.in_cube(1), b = dice.in_cube(1);
    const Real ma = std::pow(10, dice.between(-3, 3)), mb = std::pow(10, dice.between(-3, 3));
    const Vec3 c = meeting_point(ma, a, mb, b);
    const Real part = glm::length(c - a) / glm::length(b - a);
    CHECK(glm::length(a + part * (b - a) - c) <= 1e-15);
    CHECK(std::abs(ma * glm::length(c - a) - mb * glm::length(b - c)) <=
          1e-15 * (ma + mb) * glm::length(b - a) + 1e-15);
  }
}
