// Equations of joints against differences along curves, and as physics wants them.
#include "engine/joints/rows.hpp"

#include <array>
#include <catch2/catch.hpp>

#include "tests/joints/drawn_joints.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

// ---- Derivatives --------------------------------------------------------------------------------

TEST_CASE("Jacobian and gamma are the derivatives of the residual along any motion") {
  Random dice(11);
  for (int k = 0; k < kJointKinds; ++k) {
    const auto kind = static_cast<JointKind>(k);
    Misses worst;
    for (int i = 0; i < 200; ++i) {
      const Ajar s = ajar(kind, dice);
      const Real before = s.first + 4 * kPi;
      worst = worst | misses(s, row_count(s.joint), [&](const BodyState& a, const BodyState& b) {
                return rows_of(s.joint, a, b, before);
              });
    }
    INFO(name_of(kind) << ": " << worst.rate << ", " << worst.second);
    if (info_of(kind).binds_poses())
      CHECK(worst.rate <= (kind == JointKind::custom ? 1e-11 : 5e-12));
    CHECK(worst.second <= (kind == JointKind::custom ? 1e-8 : 1e-11));
  }
}

TEST_CASE("Jacobian and gamma are the derivatives of coordinates along any motion") {
  struct Case {
    JointKind kind;
    Coordinate which;
  };
  const Case cases[] = {
      {JointKind::hinge, Coordinate::angle},       {JointKind::ball, Coordinate::angle},
      {JointKind::universal, Coordinate::angle},   {JointKind::universal, Coordinate::second},
      {JointKind::cylindrical, Coordinate::angle}, {JointKind::screw, Coordinate::angle},
      {JointKind::planar, Coordinate::angle},      {JointKind::cylindrical, Coordinate::travel},
      {JointKind::prismatic, Coordinate::travel},  {JointKind::screw, Coordinate::travel},
      {JointKind::distance, Coordinate::travel},   {JointKind::spring, Coordinate::travel},
      {JointKind::ball, Coordinate::swing}};
  Random dice(12);
  for (const Case& c : cases) {
    Misses worst;
    for (int i = 0; i < 200; ++i) {
      const Ajar s = ajar(c.kind, dice);
      const Real before = c.which == Coordinate::second ? s.second - 2 * kPi : s.first + 2 * kPi;
      worst = worst | misses(s, 1, [&](const BodyState& a, const BodyState& b) {
                return coordinate(s.joint, c.which, a, b, before);
              });
    }
    INFO(name_of(c.kind) << " " << int(c.which) << ": " << worst.rate << ", " << worst.second);
    CHECK(worst.rate <= 2e-11);
    CHECK(worst.second <= 5e-10);
  }
}

TEST_CASE("a swing keeps its derivatives from no swing at all to nearly half a turn") {
  Random dice(13);
  for (const Real angle : {0., 1e-9, 1e-5, 0.01, 0.3, 0.45, 0.4510268, 0.46, 1., 2., 2.7}) {
    Misses worst;
    for (int i = 0; i < 50; ++i) {
      Ajar s = ajar(JointKind::ball, dice);
      const Real way = dice.between(-kPi, kPi);
      const Vec3 swing = angle * Vec3(0, std::cos(way), std::sin(way));
      const BodyState b =
          standing(s.joint, s.a.start, rotation_of(SwingTwist{s.first, swing}), Vec3(0));
      s.b.start.position = b.position, s.b.start.rotation = b.rotation,
      s.b.start.rotation_matrix = b.rotation_matrix;
      worst = worst | misses(s, 1, [&](const BodyState& p, const BodyState& q) {
                return coordinate(s.joint, Coordinate::swing, p, q);
              });
    }
    INFO(angle << ": " << worst.rate << ", " << worst.second);
    CHECK(worst.rate <= 1e-9);
    CHECK(worst.second <= 1e-8);
  }
}

// ---- Physics ------------------------------------------------------------------------------------

TEST_CASE("rows do not notice bodies that move as one, and their forces balance") {
  Random dice(14);
  for (int k = 0; k < kJointKinds; ++k) {
    const auto kind = static_cast<JointKind>(k);
    INFO(name_of(kind));
    const Real tolerance = kind == JointKind::custom ? 1e-11 : 1e-13;
    const auto check = [&](const Equations& block, int rows, BodyState a, BodyState b) {
      a.velocity = dice.in_cube(1), a.angular_velocity = b.angular_velocity = dice.in_cube(1);
      b.velocity = a.velocity + glm::cross(a.angular_velocity, b.position - a.position);
      for (int i = 0; i < rows; ++i) {
        REQUIRE(std::abs(block.rate(i, a, b)) <= tolerance);
        const Vec3* j = &block.j[std::size_t(4 * i)];
        const Vec3 force = j[0] + j[2];
        const Vec3 moment =
            glm::cross(a.position, j[0]) + j[1] + glm::cross(b.position, j[2]) + j[3];
        REQUIRE(glm::length(force) <= tolerance);
        REQUIRE(glm::length(moment) <= 4 * tolerance);
      }
    };
    for (int i = 0; i < 100; ++i) {
      const Ajar s = ajar(kind, dice);
      const BodyState a = s.a.start;
      BodyState b = s.b.start;
      // The rows of a shared point are along the world's axes: they turn, unless they are zero.
      if (holds_point(kind) || kind == JointKind::custom)
        b.position = a.position + a.rotation_matrix * s.joint.anchor_a -
                     b.rotation_matrix * s.joint.anchor_b;
      check(rows_of(s.joint, a, b), row_count(s.joint), a, b);
      for (const auto which :
           {Coordinate::angle, Coordinate::second, Coordinate::travel, Coordinate::swing})
        check(coordinate(s.joint, which, a, b), 1, a, b);
    }
  }
}

TEST_CASE("a closed joint lacks nothing, and moves in its freedoms without lacking anything") {
  Random dice(15);
  for (const auto kind : {JointKind::ball, JointKind::hinge, JointKind::universal, JointKind::fixed,
                          JointKind::cylindrical, JointKind::prismatic, JointKind::screw,
                          JointKind::planar, JointKind::distance, JointKind::spring}) {
    INFO(name_of(kind));
    for (int i = 0; i < 100; ++i) {
      const Joint joint = any_joint(kind, dice);
      const BodyState a = placed(dice.in_cube(1), dice.rotation());
      const Quat axes = a.rotation * joint.frames.a();
      const Real rotation = dice.between(-3, 3), second = dice.between(-3, 3);
      Quat q = allowed_by_kind(kind, dice.rotation());
      Vec3 d(0);  // joint axes of a
      if (kind == JointKind::universal) q = about_y(rotation) * about_z(second);
      if (kind == JointKind::cylindrical) q = about_x(rotation), d.x = second;
      if (kind == JointKind::prismatic) q = kIdentity, d.x = second;
      if (kind == JointKind::screw) q = about_x(rotation), d.x = rotation * joint.parameters->pitch;
      if (kind == JointKind::planar) q = about_x(rotation), d = {0, rotation, second};
      if (kind == JointKind::distance) d = joint.parameters->length * dice.direction();
      const Equations block = rows_of(joint, a, standing(joint, a, q, axes * d), rotation);
      REQUIRE(row_count(joint) == 6 - degrees_of_freedom(kind));
      for (int row = 0; row < row_count(joint); ++row)
        REQUIRE(std::abs(block.c[std::size_t(row)]) <= 4e-15);
    }
  }
}

// ---- Roots and turns ----------------------------------------------------------------------------

TEST_CASE("spurious roots are told from the true one") {
  Random dice(16);
  const Quat roots[] = {kIdentity, about_x(kPi), about_y(kPi), about_z(kPi)};
  for (const auto kind : {JointKind::fixed, JointKind::prismatic, JointKind::hinge,
                          JointKind::cylindrical, JointKind::planar}) {
    INFO(name_of(kind));
    for (int root = 0; root < 4; ++root) {
      const Joint joint = any_joint(kind, dice);
      const BodyState a = placed(Vec3(0), dice.rotation());
      const BodyState b = standing(joint, a, roots[root], Vec3(0));
      const Equations block = rows_of(joint, a, b);
      for (int i = 0; i < row_count(joint); ++i)
        CHECK(std::abs(block.c[std::size_t(i)]) <= 2e-15);  // a root of the equations it is
      const bool whole = kind == JointKind::fixed || kind == JointKind::prismatic;
      CHECK(on_right_branch(joint, a.rotation, b.rotation) == (whole ? root == 0 : root <= 1));
    }
  }
  // A universal joint has none: what looks like one has both angles half a turn on.
  const Joint joint = any_joint(JointKind::universal, dice);
  const BodyState a = placed(Vec3(0), dice.rotation());
  const BodyState b = standing(joint, a, about_y(0.3) * about_x(kPi) * about_z(0.4), Vec3(0));
  CHECK(on_right_branch(joint, a.rotation, b.rotation));
  CHECK(coordinate(joint, Coordinate::angle, a, b).c[0] == Approx(0.3 - kPi).margin(1e-14));
  CHECK(coordinate(joint, Coordinate::second, a, b).c[0] == Approx(0.4 - kPi).margin(1e-14));
}

TEST_CASE("the coordinates are the angles that limits speak of") {
  Random dice(17);
  Real worst = 0;
  for (int i = 0; i < 500; ++i) {
    for (const auto kind : {JointKind::hinge, JointKind::ball}) {
      const Ajar s = ajar(kind, dice);
      const BodyState a = s.a.start, b = s.b.start;
      const SwingTwist parts = swing_twist(relative_rotation(s.joint, a.rotation, b.rotation));
      worst = std::max(worst,
                       std::abs(coordinate(s.joint, Coordinate::angle, a, b).c[0] - parts.twist));
      const SwingLimit cone = s.joint.limits->swing;
      const Real y = parts.swing.y / cone.y, z = parts.swing.z / cone.z;
      worst = std::max(
          worst, std::abs(coordinate(s.joint, Coordinate::swing, a, b).c[0] - (1 - y * y - z * z)));
    }
    const Ajar s = ajar(JointKind::universal, dice);
    const BodyState a = s.a.start, b = s.b.start;
    const UniversalAngles at = universal_angles(relative_rotation(s.joint, a.rotation, b.rotation));
    worst = std::max(worst, std::abs(coordinate(s.joint, Coordinate::angle, a, b).c[0] - at.first));
    worst =
        std::max(worst, std::abs(coordinate(s.joint, Coordinate::second, a, b).c[0] - at.second));
  }
  CHECK(worst <= 1e-14);
}

TEST_CASE("slides and lengths run from anchor to anchor") {
  Random dice(18);
  for (int i = 0; i < 100; ++i) {
    const Joint joint = any_joint(JointKind::cylindrical, dice);
    const BodyState a = placed(dice.in_cube(1), dice.rotation());
    const Vec3 d = dice.in_cube(1);
    const BodyState b = standing(joint, a, dice.rotation(), a.rotation * joint.frames.a() * d);
    REQUIRE(coordinate(joint, Coordinate::travel, a, b).c[0] == Approx(d.x).margin(2e-15));
    Joint spring = joint;
    spring.kind = JointKind::spring;
    REQUIRE(coordinate(spring, Coordinate::travel, a, b).c[0] ==
            Approx(glm::length(d)).margin(2e-15));
  }
  // Anchors that meet leave a length no derivatives; it must not leave wrong numbers either.
  const BodyState a = placed(Vec3(0), kIdentity);
  Joint plain;
  plain.kind = JointKind::spring;
  const Equations block = coordinate(plain, Coordinate::travel, a, a);
  CHECK(block.c[0] == 0);
  CHECK(block.gamma[0] == 0);
  for (int i = 0; i < 4; ++i) CHECK(block.j[std::size_t(i)] == Vec3(0));
}

TEST_CASE("turns and screws count whole turns") {
  Random dice(19);
  for (const Real step : {1.0, -2.5}) {
    const Joint joint = any_joint(JointKind::screw, dice);
    const BodyState a = placed(dice.in_cube(1), dice.rotation());
    const Vec3 x = a.rotation * joint.frames.a() * Vec3(1, 0, 0);
    Real before = 0;
    for (int i = 1; i <= 40; ++i) {
      const Real angle = i * step;
      const BodyState b = standing(joint, a, about_x(angle), joint.parameters->pitch * angle * x);
      const Equations block = rows_of(joint, a, b, before);
      REQUIRE(std::abs(block.c[4]) <= 1e-13);
      before = coordinate(joint, Coordinate::angle, a, b, before).c[0];
      REQUIRE(before == Approx(angle).epsilon(1e-14));
    }
  }
}

// ---- From outside -------------------------------------------------------------------------------

TEST_CASE("a ball joint from outside has the rows of the one within") {
  Random dice(20);
  Real worst = 0, worst_j = 0, worst_gamma = 0;
  for (int i = 0; i < 500; ++i) {
    Ajar s = ajar(JointKind::ball, dice);
    const BodyState a = s.a.start, b = s.b.start;
    const Equations within = rows_of(s.joint, a, b);
    s.joint.kind = JointKind::custom;
    REQUIRE(row_count(s.joint) == 4);
    const Equations outside = rows_of(s.joint, a, b);
    for (std::size_t row = 0; row < 3; ++row) {
      worst = std::max(worst, std::abs(within.c[row] - outside.c[row]));
      worst_gamma = std::max(worst_gamma, std::abs(within.gamma[row] - outside.gamma[row]));
      for (std::size_t k = 4 * row; k < 4 * row + 4; ++k)
        worst_j = std::max(worst_j, glm::length(within.j[k] - outside.j[k]));
    }
  }
  INFO(worst_j << ", " << worst_gamma);
  CHECK(worst <= 1e-15);
  CHECK(worst_j <= 5e-12);
  CHECK(worst_gamma <= 5e-9);
}

TEST_CASE("a joint from outside without its equations, or at rest, is no trouble") {
  Joint joint;
  joint.kind = JointKind::custom;
  CHECK(row_count(joint) == 0);
  write_rows({joint, {}, {}}, {});
  joint.parameters.edit().custom = std::make_shared<UserBall>(Vec3(1, 2, 3), Vec3(0));
  const Equations block = rows_of(joint, {}, {});
  for (std::size_t i = 0; i < 4; ++i) CHECK(block.gamma[i] == 0);
}

TEST_CASE("numbers do not depend on which others are asked for") {
  Random dice(21);
  for (int k = 0; k < kJointKinds; ++k) {
    const Ajar s = ajar(static_cast<JointKind>(k), dice);
    INFO(name_of(s.joint.kind));
    const BodyState a = s.a.start, b = s.b.start;
    const auto check = [&](auto write) {
      Equations all, alone;
      write(all.out());
      write({alone.c.data(), nullptr, nullptr});
      write({nullptr, alone.j.data(), nullptr});
      write({nullptr, nullptr, alone.gamma.data()});
      CHECK(all.c == alone.c);
      CHECK(all.gamma == alone.gamma);
      CHECK(all.j == alone.j);
    };
    check([&](RowsOut out) { write_rows({s.joint, a, b}, out); });
    for (const auto which :
         {Coordinate::angle, Coordinate::second, Coordinate::travel, Coordinate::swing})
      check([&](RowsOut out) { write_coordinate({s.joint, a, b}, which, out); });
  }
}
