// Equations of joints: against stored numbers, against differences along curves, and as physics
// wants them. Poses are drawn with open joints: nothing here may hold on the solution only.
#include "engine/joints/rows.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "tests/paths.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using nlohmann::json;
using test::Dice;

namespace {

/// A block of at most six rows.
struct Equations {
  std::array<Real, 6> c{}, gamma{};
  std::array<Vec3, 24> j{};
  RowsOut out() { return {c.data(), j.data(), gamma.data()}; }
  Real rate(int row, const BodyState& a, const BodyState& b) const {
    const Vec3* k = &j[std::size_t(4 * row)];
    return glm::dot(k[0], a.velocity) + glm::dot(k[1], a.angular_velocity) +
           glm::dot(k[2], b.velocity) + glm::dot(k[3], b.angular_velocity);
  }
};

Equations rows_of(const Joint& joint, const BodyState& a, const BodyState& b, Real before = 0) {
  Equations block;
  write_rows(joint, a, b, before, block.out());
  return block;
}
Equations coordinate(const Joint& joint, Coordinate which, const BodyState& a, const BodyState& b,
                     Real before = 0) {
  Equations block;
  write_coordinate(joint, which, a, b, before, block.out());
  return block;
}

BodyState placed(Vec3 position, Quat rotation, Vec3 velocity = Vec3(0),
                 Vec3 angular_velocity = Vec3(0)) {
  return {position, rotation, glm::mat3_cast(rotation), velocity, angular_velocity};
}

Quat about_x(Real angle) { return from_rotation_vector({angle, 0, 0}); }
Quat about_y(Real angle) { return from_rotation_vector({0, angle, 0}); }
Quat about_z(Real angle) { return from_rotation_vector({0, 0, angle}); }

/// A ball joint as a user would write it, and one row more: how x axes of the bodies stand.
class UserBall : public CustomJoint {
 public:
  UserBall(Vec3 a, Vec3 b) : a_(a), b_(b) {}
  int rows() const override { return 4; }
  void residual(const Pose& a, const Pose& b, std::span<Real> c) const override {
    const Vec3 d = to_world(a, a_) - to_world(b, b_), x(1, 0, 0);
    c[0] = d.x, c[1] = d.y, c[2] = d.z;
    c[3] = glm::dot(a.rotation * x, b.rotation * x);
  }

 private:
  Vec3 a_, b_;
};

Joint any_joint(JointKind kind, Dice& dice) {
  Joint joint;
  joint.kind = kind;
  joint.anchor_a = dice.in_cube(1), joint.anchor_b = dice.in_cube(1);
  const Quat frame_a = dice.rotation(), frame_b = dice.rotation();
  joint.frames.set(frame_a, frame_b);
  JointLimits limits;
  limits.swing.on = true;
  limits.swing.y = dice.between(0.5, 2), limits.swing.z = dice.between(0.5, 2);
  joint.limits = limits;
  JointParameters& parameters = joint.parameters.edit();
  parameters.length = dice.between(0.5, 2), parameters.pitch = dice.between(-0.5, 0.5);
  parameters.custom = std::make_shared<UserBall>(joint.anchor_a, joint.anchor_b);
  return joint;
}

/// Body b where its axes stand by `q` in those of a and its anchor `d` away (world axes).
BodyState standing(const Joint& joint, const BodyState& a, Quat q, Vec3 d) {
  const Quat rotation = a.rotation * joint.frames.a() * q * glm::conjugate(joint.frames.b());
  return placed(a.position + a.rotation * joint.anchor_a + d - rotation * joint.anchor_b, rotation);
}

/// Two bodies under way; constant v', and R = exp(t p) exp(t t q / 2) R0, so w' = q at first.
struct Flow {
  BodyState start;
  Vec3 push{0}, twist{0};
  BodyState after(Real t) const {
    const Quat first = from_rotation_vector(t * start.angular_velocity);
    return placed(start.position + t * start.velocity + t * t / 2 * push,
                  first * from_rotation_vector(t * t / 2 * twist) * start.rotation,
                  start.velocity + t * push, start.angular_velocity + first * (t * twist));
  }
};

/// A joint ajar: its angles anywhere, off its solution by half a radian and half a metre.
struct Ajar {
  Joint joint;
  Flow a, b;
  Real first = 0, second = 0;  // the turns that were drawn
};
Ajar ajar(JointKind kind, Dice& dice) {
  Ajar s;
  s.joint = any_joint(kind, dice);
  s.first = dice.between(-3, 3), s.second = dice.between(-3, 3);
  const Vec3 place = dice.in_cube(1);
  s.a.start = placed(place, dice.rotation());
  const Vec3 off = dice.between(0.1, 0.5) * dice.direction();
  const Quat q = kind == JointKind::universal
                     ? about_y(s.first) * about_x(off.x) * about_z(s.second)
                     : rotation_of(SwingTwist{s.first, {0, off.y, off.z}});
  const Vec3 apart = dice.between(0.5, 1) * dice.direction();
  s.b.start = standing(s.joint, s.a.start, q, apart);
  for (Flow* flow : {&s.a, &s.b}) {
    flow->start.velocity = dice.in_cube(1), flow->start.angular_velocity = dice.in_cube(1);
    flow->push = dice.in_cube(1), flow->twist = dice.in_cube(1);
  }
  return s;
}

struct Misses {
  Real rate = 0, second = 0;
};

/// dC/dt against J V, and d(J V)/dt against J a - gamma, by sixth-order differences.
template <class Write>
Misses misses(const Ajar& s, int rows, Write write) {
  constexpr Real h = 1e-3, weights[] = {45, -9, 1};
  const auto at = [&](Real t) {
    const BodyState a = s.a.after(t), b = s.b.after(t);
    Equations block = write(a, b);
    for (int i = 0; i < rows; ++i) block.gamma[std::size_t(i)] = block.rate(i, a, b);
    return block;
  };
  Equations change;
  for (int n = 1; n <= 3; ++n) {
    const Equations ahead = at(n * h), behind = at(-n * h);
    for (std::size_t i = 0; i < 6; ++i) {
      change.c[i] += weights[n - 1] * (ahead.c[i] - behind.c[i]) / (60 * h);
      change.gamma[i] += weights[n - 1] * (ahead.gamma[i] - behind.gamma[i]) / (60 * h);
    }
  }
  const BodyState a = s.a.start, b = s.b.start;
  const BodyState push_a{{}, {}, {}, s.a.push, s.a.twist}, push_b{{}, {}, {}, s.b.push, s.b.twist};
  const Equations here = write(a, b);
  Misses out;
  for (int i = 0; i < rows; ++i) {
    const auto k = std::size_t(i);
    out.rate = std::max(out.rate, std::abs(change.c[k] - here.rate(i, a, b)));
    out.second = std::max(out.second,
                          std::abs(change.gamma[k] - here.rate(i, push_a, push_b) + here.gamma[k]));
  }
  return out;
}
Misses operator|(Misses p, Misses q) {
  return {std::max(p.rate, q.rate), std::max(p.second, q.second)};
}

// ---- Stored numbers -----------------------------------------------------------------------------

Vec3 vec(const json& j) { return {j.at(0), j.at(1), j.at(2)}; }
Quat quat(const json& j) { return Quat(j.at(0), j.at(1), j.at(2), j.at(3)); }

const json& stored() {
  static const json kAll = json::parse(std::ifstream(test_data("lagrangian.json")));
  return kAll;
}

BodyState placed(const json& entry, int i) {
  return placed(vec(entry.at("x").at(i)), quat(entry.at("q").at(i)), vec(entry.at("v").at(i)),
                vec(entry.at("w").at(i)));
}

/// Row `mine` of a block against row `theirs` of an entry, which is `scale` times as large.
Real miss(const Equations& block, int mine, const json& entry, int theirs, Real scale = 1) {
  const auto i = std::size_t(mine);
  const Real c = entry.at("C").at(theirs), gamma = entry.at("gamma").at(theirs);
  Real worst = std::max(std::abs(scale * block.c[i] - c), std::abs(scale * block.gamma[i] - gamma));
  for (int k = 0; k < 12; ++k)
    worst = std::max(worst, std::abs(scale * block.j[4 * i + std::size_t(k / 3)][k % 3] -
                                     entry.at("J").at(theirs).at(k).get<Real>()));
  return worst;
}

/// The turn of joint axes of which two are known; the vectors are square to each other.
Quat frame_yz(Vec3 y, Vec3 z) { return glm::quat_cast(Mat3(glm::cross(y, z), y, z)); }
Quat frame_x(Vec3 x) {
  const Vec3 y = glm::normalize(glm::cross(x, std::abs(x.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
  return frame_yz(y, glm::cross(x, y));
}

/// The entry's joint made of its primitives, if it is one of our kinds; a universal joint's second
/// axis may have any length in the entry.
Joint joint_of(const json& entry) {
  Joint joint;
  REQUIRE(joint_kind_from_name(entry.at("kind").get<std::string>().c_str(), joint.kind));
  std::vector<Vec3> f, g;
  for (const json& p : entry.at("prims")) {
    const std::string name = p.at(0);
    if (name == "d1") {
      f.push_back(vec(p.at(1))), g.push_back(vec(p.at(2)));
      continue;
    }
    const int first = name == "d2" ? 2 : 1;
    joint.anchor_a = vec(p.at(first)), joint.anchor_b = vec(p.at(first + 1));
    if (name == "dist") joint.parameters.edit().length = p.at(3);
  }
  if (joint.kind == JointKind::universal) {
    const Vec3 z = glm::normalize(g[0]);
    const Quat on_a = frame_x(f[0]), on_b = frame_x(z);  // x to y, x to z
    joint.frames.set(on_a * about_z(-kPi / 2), on_b * about_y(kPi / 2));
  } else if (f.size() == 2) {
    joint.frames.set(frame_yz(f[0], f[1]), frame_x(g[0]));
  } else if (f.size() == 3) {
    joint.frames.set(frame_yz(f[0], f[1]), frame_yz(glm::cross(g[2], g[0]), g[2]));
  }
  return joint;
}

}  // namespace

TEST_CASE("the primitives of joints are those of the stored numbers") {
  for (const json& entry : stored().at("joints")) {
    INFO(entry.at("kind").get<std::string>());
    const BodyState a = placed(entry, 0), b = placed(entry, 1);
    int row = 0;
    for (const json& p : entry.at("prims")) {
      const std::string name = p.at(0);
      Joint joint;
      if (name != "d1") {
        const int first = name == "d2" ? 2 : 1;
        joint.anchor_a = vec(p.at(first)), joint.anchor_b = vec(p.at(first + 1));
      }
      const AnchorSpan span = span_of(joint, a, b, true);
      const auto f = [&] { return a.rotation_matrix * vec(p.at(1)); };
      Equations block;
      if (name == "pt") write_point(span, block.out());
      if (name == "d1") write_square(0, f(), b.rotation_matrix * vec(p.at(2)), a, b, block.out());
      if (name == "d2") write_along(0, f(), span, a, block.out());
      if (name == "dist") write_distance(0, p.at(3), span, block.out());
      for (int i = 0; i < (name == "pt" ? 3 : 1); ++i) CHECK(miss(block, i, entry, row++) <= 1e-13);
    }
    CHECK(row == int(entry.at("C").size()));
  }
}

TEST_CASE("the kinds of joints are those of the stored numbers") {
  for (const json& entry : stored().at("joints")) {
    INFO(entry.at("kind").get<std::string>());
    const Joint joint = joint_of(entry);
    const Equations block = rows_of(joint, placed(entry, 0), placed(entry, 1));
    const int rows = row_count(joint);
    REQUIRE(rows == int(entry.at("C").size()));
    // The page has a prismatic joint's third direction before its offsets.
    const bool prismatic = joint.kind == JointKind::prismatic;
    const std::array<int, 6> theirs =
        prismatic ? std::array{0, 1, 3, 4, 2, 5} : std::array{0, 1, 2, 3, 4, 5};
    for (int i = 0; i < rows; ++i) {
      const bool scaled = joint.kind == JointKind::universal && i == 3;
      const Real scale = scaled ? glm::length(vec(entry.at("prims").at(1).at(2))) : 1;
      CHECK(miss(block, i, entry, theirs[std::size_t(i)], scale) <= 1e-12);
    }
  }
}

// ---- Derivatives --------------------------------------------------------------------------------

TEST_CASE("Jacobian and gamma are the derivatives of the residual along any motion") {
  Dice dice(11);
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
  Dice dice(12);
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
  Dice dice(13);
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
  Dice dice(14);
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
  Dice dice(15);
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
  Dice dice(16);
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
  Dice dice(17);
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
  Dice dice(18);
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
  Dice dice(19);
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
  Dice dice(20);
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
  write_rows(joint, {}, {}, 0, {});
  joint.parameters.edit().custom = std::make_shared<UserBall>(Vec3(1, 2, 3), Vec3(0));
  const Equations block = rows_of(joint, {}, {});
  for (std::size_t i = 0; i < 4; ++i) CHECK(block.gamma[i] == 0);
}

TEST_CASE("numbers do not depend on which others are asked for") {
  Dice dice(21);
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
    check([&](RowsOut out) { write_rows(s.joint, a, b, 0, out); });
    for (const auto which :
         {Coordinate::angle, Coordinate::second, Coordinate::travel, Coordinate::swing})
      check([&](RowsOut out) { write_coordinate(s.joint, which, a, b, 0, out); });
  }
}
