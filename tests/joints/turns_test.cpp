#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "tests/base/random.hpp"
#include "tests/paths.hpp"

using namespace pantin;
using namespace pantin::detail;
using test::Random;

namespace {

Quat quat(const nlohmann::json& j) { return Quat(j.at(0), j.at(1), j.at(2), j.at(3)); }

/// The angle between two turns, rad; 0 for q and -q.
Real apart(Quat a, Quat b) { return glm::length(rotation_vector(a * glm::conjugate(b))); }

Joint jointed(JointKind kind, const JointLimits& limits) {
  Joint j;
  j.kind = kind, j.limits = limits;
  return j;
}

}  // namespace

TEST_CASE("clamped turns are those of the stored numbers") {
  std::ifstream file(test_data("procedural.json"));
  const auto all = nlohmann::json::parse(file);
  for (const auto& entry : all.at("limits")) {
    INFO(entry.at("name").get<std::string>());
    const Vec3 axis(entry.at("axis").at(0), entry.at("axis").at(1), entry.at("axis").at(2));
    REQUIRE(axis == Vec3(0, 1, 0));
    const Quat from_x = from_rotation_vector({0, 0, kPi / 2});  // x becomes their twist axis y
    JointLimits limits;
    limits.angle = {true, entry.at("twist").at(0), entry.at("twist").at(1)};
    const bool hinge = entry.at("hinge");
    if (!hinge) limits.swing = {true, entry.at("cone"), entry.at("cone")};
    const Joint joint = jointed(hinge ? JointKind::hinge : JointKind::ball, limits);
    const Quat q = glm::conjugate(from_x) * quat(entry.at("rel")) * from_x;
    const SwingTwist parts = swing_twist(q);
    CHECK(glm::length(parts.swing) == Approx(entry.at("swing_angle").get<Real>()).margin(4e-15));
    if (glm::length(parts.swing) < 3)
      CHECK(parts.twist == Approx(entry.at("twist_angle").get<Real>()).margin(4e-15));
    const Quat out = from_x * allowed_rotation(joint, q) * glm::conjugate(from_x);
    CHECK(apart(out, quat(entry.at("out"))) <= 1e-14);
  }
}

TEST_CASE("swing and twist make up the turn they were taken from") {
  Random dice(3);
  for (int i = 0; i < 2000; ++i) {
    const Quat q = dice.rotation();
    const SwingTwist parts = swing_twist(q);
    REQUIRE(apart(rotation_of(parts), q) <= 4e-15);
    REQUIRE(parts.swing.x == 0);
    REQUIRE(std::abs(parts.twist) <= kPi);
    REQUIRE(glm::length(parts.swing) <= kPi + 1e-12);
  }
}

TEST_CASE("what limits allow without trigonometric functions is what angles say") {
  Random dice(9);
  int inside = 0, found = 0;
  for (int i = 0; i < 20000; ++i) {
    JointLimits limits;
    limits.angle = {true, -dice.between(0, 3.3), dice.between(0, 3.3)};
    limits.second = {true, -dice.between(0, 1.6), dice.between(0, 1.6)};
    limits.swing = {true, dice.between(0, 3), dice.between(0, 3)};
    const Quat q = fraction_of(dice.rotation(), dice.between(0, 1));
    const SwingTwist at = swing_twist(q);
    const UniversalAngles two = universal_angles(q);
    const Real twist = clamped(limits.angle, at.twist);
    const bool is_in = twist == at.twist && clamped(limits.swing, at.swing) == at.swing;
    inside += is_in, found += is_within(limits, q);
    REQUIRE((is_in || !is_within(limits, q)));
    const Real n = std::sqrt(q.w * q.w + q.x * q.x), sign = q.w < 0 ? -1 : 1;
    REQUIRE((twist == at.twist || !is_within(limits.angle, sign * q.x / n, sign * q.w / n)));
    const Quat hinged = rotation_of(SwingTwist{twist, Vec3(0)});
    CHECK(apart(allowed_rotation(jointed(JointKind::hinge, limits), q), hinged) <= 4e-15);
    const UniversalAngles to{clamped(limits.angle, two.first), clamped(limits.second, two.second)};
    CHECK(apart(allowed_rotation(jointed(JointKind::universal, limits), q), rotation_of(to)) <=
          4e-15);
  }
  CHECK(found > 0.75 * inside);
}

TEST_CASE("a joint far from its limits stays within when it turns by less") {
  Random dice(10);
  for (int i = 0; i < 20000; ++i) {
    JointLimits limits;
    limits.angle = {true, -dice.between(0, 3), dice.between(0, 3)};
    limits.second = {true, -dice.between(0, 1.5), dice.between(0, 1.5)};
    limits.swing = {true, dice.between(0, 3), dice.between(0, 3)};
    const JointKind kinds[] = {JointKind::ball, JointKind::hinge, JointKind::universal};
    const Joint joint = jointed(kinds[i % 3], limits);
    const Quat q = allowed_rotation(joint, fraction_of(dice.rotation(), dice.between(0, 1)));
    const Real margin = dice.between(0, 0.3);
    if (!is_far_from_limits(joint, q, margin)) continue;
    Real turns = margin;  // of one angle
    if (joint.kind == JointKind::hinge) {
      const Real angle = swing_twist(q).twist;
      REQUIRE(angle + turns < limits.angle.high);
      REQUIRE(angle - turns > limits.angle.low);
    } else if (joint.kind == JointKind::universal) {
      const UniversalAngles at = universal_angles(q);
      REQUIRE(std::abs(clamped(limits.angle, at.first + turns) - at.first - turns) < 1e-15);
      REQUIRE(std::abs(clamped(limits.second, at.second - turns) - at.second + turns) < 1e-15);
    } else {
      const Quat turned = q * from_rotation_vector(turns * Vec3(1, 0, 0));
      REQUIRE(violation(joint, turned) < 1e-12);
    }
  }
}

TEST_CASE("what a joint allows violates nothing, and what is allowed stays as it is") {
  Random dice(5);
  for (int i = 0; i < 2000; ++i) {
    JointLimits limits;
    const Real low = dice.between(-3, 2.5);
    limits.angle = {dice.below(4) > 0, low, low + dice.between(0, 3)};
    limits.second = {true, -dice.between(0, 1.4), dice.between(0, 1.4)};
    limits.swing = {dice.below(4) > 0, dice.between(0.05, 3), dice.between(0.05, 3)};
    const auto kind = static_cast<JointKind>(dice.below(kJointKinds));
    const Joint joint = jointed(kind, limits);
    const Quat q = allowed_rotation(joint, dice.rotation());
    INFO(name_of(kind));
    REQUIRE(is_finite(q));
    // A twist beyond half a turn is another twist; swings that far have none to tell.
    if (limits.angle.high > kPi || limits.swing.y > 2.8 || limits.swing.z > 2.8) continue;
    REQUIRE(violation(joint, q) <= 1e-14);
    REQUIRE(apart(allowed_rotation(joint, q), q) <= 1e-14);
  }
}

TEST_CASE("a range need not contain zero, and equal limits lock") {
  JointLimits limits;
  limits.angle = {true, 0.5, 0.9};
  const Joint knee = jointed(JointKind::hinge, limits);
  CHECK(swing_twist(allowed_rotation(knee, from_rotation_vector({0.1, 0, 0}))).twist ==
        Approx(0.5));
  CHECK(swing_twist(allowed_rotation(knee, from_rotation_vector({2, 0, 0}))).twist == Approx(0.9));
  CHECK(swing_twist(allowed_rotation(knee, from_rotation_vector({0.7, 0.2, -0.1}))).twist ==
        Approx(0.7).margin(0.02));
  limits.angle = {true, -0.3, -0.3};
  const Joint locked = jointed(JointKind::hinge, limits);
  for (Real angle : {-3.0, -0.3, 0.0, 2.0})
    CHECK(swing_twist(allowed_rotation(locked, from_rotation_vector({angle, 0, 0}))).twist ==
          Approx(-0.3));
}

TEST_CASE("a range of more than a turn allows all, one beyond half a turn is met from both sides") {
  JointLimits limits;
  limits.angle = {true, -kPi, kPi};
  const Joint any = jointed(JointKind::hinge, limits);
  limits.angle = {true, 2.5, 4.0};
  const Joint far = jointed(JointKind::hinge, limits);
  for (Real angle = -3; angle < 3.1; angle += 0.25) {
    const Quat q = from_rotation_vector({angle, 0, 0});
    CHECK(apart(allowed_rotation(any, q), q) <= 1e-15);
    const Real to = clamped(AngleLimit{true, 2.5, 4.0}, angle);
    CHECK((to >= 2.5 && to <= 4.0));
    CHECK(violation(far, allowed_rotation(far, q)) <= 1e-14);
  }
}

TEST_CASE("an elliptic cone lets a limb farther one way than the other") {
  JointLimits limits;
  limits.swing = {true, 1.2, 0.3};
  const Joint hip = jointed(JointKind::ball, limits);
  CHECK(violation(hip, from_rotation_vector({0, 1.19, 0})) == 0);
  CHECK(violation(hip, from_rotation_vector({0, 0, 0.31})) == Approx(0.01));
  CHECK(violation(hip, from_rotation_vector({0, 0.849, 0.212})) <=
        1e-3);  // on the rim, at 45 degrees of it
  CHECK(violation(hip, from_rotation_vector({0, 0.9, 0.3})) > 0.05);
  // A cone without width one way is an arc.
  limits.swing = {true, 1.2, 0};
  const Quat q =
      allowed_rotation(jointed(JointKind::ball, limits), from_rotation_vector({0, 0.5, 0.4}));
  CHECK(swing_twist(q).swing.z == Approx(0).margin(1e-15));
  CHECK(swing_twist(q).swing.y == Approx(0.5));
}

TEST_CASE("a universal joint turns about two axes at right angles") {
  Random dice(8);
  for (int i = 0; i < 500; ++i) {
    const UniversalAngles angles{dice.between(-3, 3), dice.between(-1.5, 1.5)};
    const UniversalAngles back = universal_angles(rotation_of(angles));
    REQUIRE(back.first == Approx(angles.first).margin(1e-13));
    REQUIRE(back.second == Approx(angles.second).margin(1e-13));
    // y of a and z of b stay at right angles.
    const Quat q = allowed_by_kind(JointKind::universal, dice.rotation());
    REQUIRE(std::abs((q * Vec3(0, 0, 1)).y) <= 1e-15);
  }
}
