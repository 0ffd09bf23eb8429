// What holds for every kind of joint in the list, read from what the kind tells of itself. A new
// kind needs no line here.
#include <array>
#include <catch2/catch.hpp>
#include <set>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "tests/base/random.hpp"
#include "tests/joints/equations.hpp"

using namespace pantin;
using namespace pantin::detail;
using test::Equations, test::placed, test::Random;

namespace {

constexpr int kCases = 50;
constexpr Real kStep = 1e-3;  // of differences, s; sixth order

/// Two bodies and a joint between them.
struct Pair {
  Joint joint;
  BodyState a, b;
};

/// Rows of a kind that comes from outside: the anchors at one place.
class SharedPoint : public CustomJoint {
 public:
  SharedPoint(Vec3 a, Vec3 b) : a_(a), b_(b) {}
  int rows() const override { return 3; }
  void residual(const Pose& a, const Pose& b, std::span<Real> c) const override {
    const Vec3 d = to_world(b, b_) - to_world(a, a_);
    c[0] = d.x, c[1] = d.y, c[2] = d.z;
  }

 private:
  Vec3 a_, b_;
};

/// A joint of the kind with its parameters, and bodies under way that stand off its solution by
/// `off` m and rad.
Pair any_pair(JointKind kind, Random& dice, Real off) {
  Pair s;
  s.joint.kind = kind;
  s.joint.anchor_a = dice.in_cube(1), s.joint.anchor_b = dice.in_cube(1);
  const Quat frame_a = dice.rotation(), frame_b = dice.rotation();
  s.joint.frames.set(frame_a, frame_b);
  s.joint.limits.edit().swing = {true, 1, 2};
  JointParameters& parameters = s.joint.parameters.edit();
  parameters.custom = std::make_shared<SharedPoint>(s.joint.anchor_a, s.joint.anchor_b);
  for (const Parameter& p : info_of(kind).parameters) {
    const bool was_sound = info_of(kind).fault(s.joint) == nullptr;
    const Real before = std::exchange(p.value(parameters), dice.between(0.5, 1));
    // Some exclude each other.
    if (was_sound && info_of(kind).fault(s.joint)) p.value(parameters) = before;
  }
  info_of(kind).complete(parameters);
  s.a = placed(dice.in_cube(1), dice.rotation(), dice.in_cube(1), dice.in_cube(1));
  const Quat q = from_rotation_vector(off * dice.direction());
  const Quat rotation = s.a.rotation * s.joint.frames.a() * q * glm::conjugate(s.joint.frames.b());
  const Vec3 gap = off * dice.direction();
  s.b = placed(s.a.position + s.a.rotation * s.joint.anchor_a + gap - rotation * s.joint.anchor_b,
               rotation, dice.in_cube(1), dice.in_cube(1));
  return s;
}

/// The body after a time at constant velocities.
BodyState after(const BodyState& at, Real t) {
  return placed(at.position + t * at.velocity,
                from_rotation_vector(t * at.angular_velocity) * at.rotation, at.velocity,
                at.angular_velocity);
}

/// The worst of dC/dt - J V, and of d(J V)/dt + gamma, along constant velocities.
std::array<Real, 2> misses(const Pair& s, int rows, auto write) {
  constexpr Real kWeights[] = {45, -9, 1};
  Equations change;
  for (int n = -3; n <= 3; ++n) {
    if (n == 0) continue;
    const BodyState a = after(s.a, n * kStep), b = after(s.b, n * kStep);
    Equations there;
    write(a, b, there.out());
    const Real weight = (n < 0 ? -1 : 1) * kWeights[std::abs(n) - 1] / (60 * kStep);
    for (int i = 0; i < rows; ++i) {
      change.c[std::size_t(i)] += weight * there.c[std::size_t(i)];
      change.gamma[std::size_t(i)] += weight * there.rate(i, a, b);
    }
  }
  Equations here;
  write(s.a, s.b, here.out());
  std::array<Real, 2> worst{};
  for (int i = 0; i < rows; ++i) {
    const auto k = std::size_t(i);
    worst[0] = std::max(worst[0], std::abs(change.c[k] - here.rate(i, s.a, s.b)));
    worst[1] = std::max(worst[1], std::abs(change.gamma[k] + here.gamma[k]));
  }
  return worst;
}

/// Kinds that constrain velocities only: the worst of J V minus the slip velocity along the
/// tangents. That is the velocity of the point of a, at the contact point, minus that of the point
/// of b.
Real slip_miss(const Pair& s) {
  constexpr Real kWeights[] = {45, -9, 1};
  const SlipPoint p = info_of(s.joint.kind).slip_point(s.joint, s.a, s.b);
  const auto carried = [](const BodyState& from, Vec3 arm, Real t) {
    const BodyState at = after(from, t);
    return at.position + at.rotation_matrix * (glm::transpose(from.rotation_matrix) * arm);
  };
  Vec3 slip(0);
  for (int n = -3; n <= 3; ++n) {
    if (n == 0) continue;
    const Real weight = (n < 0 ? -1 : 1) * kWeights[std::abs(n) - 1] / (60 * kStep);
    slip += weight * (carried(s.a, p.arm_a, n * kStep) - carried(s.b, p.arm_b, n * kStep));
  }
  Equations here;
  write_rows({s.joint, s.a, s.b}, here.out());
  Real worst = glm::length(s.a.position + p.arm_a - s.b.position - p.arm_b);
  for (int i = 0; i < row_count(s.joint); ++i)
    worst = std::max({worst, std::abs(glm::dot(p.tangent[i], slip) - here.rate(i, s.a, s.b)),
                      std::abs(glm::length(p.tangent[i]) - 1), std::abs(here.c[std::size_t(i)])});
  return worst;
}

/// y = (J J^T)^-1 c; the smallest pivot tells how far the rows are from depending on one another.
Real solve(const Equations& rows, int count, std::array<Real, 6>& y) {
  std::array<std::array<Real, 6>, 6> m{};
  y = rows.c;
  const auto n = std::size_t(count);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t v = 0; v < 4; ++v) m[i][k] += glm::dot(rows.j[4 * i + v], rows.j[4 * k + v]);
  Real least = 1e300;
  for (std::size_t p = 0; p < n; ++p) {
    least = std::min(least, m[p][p]);
    for (std::size_t i = p + 1; i < n; ++i) {
      const Real factor = m[i][p] / m[p][p];
      for (std::size_t k = p; k < n; ++k) m[i][k] -= factor * m[p][k];
      y[i] -= factor * y[p];
    }
  }
  for (std::size_t p = n; p-- > 0;) {
    for (std::size_t k = p + 1; k < n; ++k) y[p] -= m[p][k] * y[k];
    y[p] /= m[p][p];
  }
  return least;
}

/// Newton steps onto the joint. The least pivot of the last.
Real close(Pair& s) {
  const int rows = row_count(s.joint);
  Real least = 1e300;
  for (int round = 0; round < 30; ++round) {
    Equations here;
    write_rows({s.joint, s.a, s.b}, here.out());
    std::array<Real, 6> y{};
    least = solve(here, rows, y);
    std::array<Vec3, 4> move{};
    for (std::size_t i = 0; i < std::size_t(rows); ++i)
      for (std::size_t v = 0; v < 4; ++v) move[v] -= y[i] * here.j[4 * i + v];
    s.a =
        placed(s.a.position + move[0], glm::normalize(from_rotation_vector(move[1]) * s.a.rotation),
               s.a.velocity, s.a.angular_velocity);
    s.b =
        placed(s.b.position + move[2], glm::normalize(from_rotation_vector(move[3]) * s.b.rotation),
               s.b.velocity, s.b.angular_velocity);
  }
  return least;
}

template <class Check>
void for_every_kind(Check check) {
  Random dice(31);
  for (int i = 0; i < kJointKinds; ++i) {
    const auto kind = static_cast<JointKind>(i);
    INFO(name_of(kind));
    check(kind, info_of(kind), dice);
  }
}

}  // namespace

TEST_CASE("every kind has names of its own, by which it is found") {
  std::set<std::string_view> names;
  for_every_kind([&](JointKind kind, const JointKindInfo& info, Random&) {
    CHECK(name_of(kind) == std::string(info.name));
    for (const std::string_view name : {info.name, info.alias}) {
      if (name.empty()) continue;
      CHECK(names.insert(name).second);
      JointKind found{};
      REQUIRE(joint_kind_from_name(name, found));
      CHECK(found == kind);
    }
  });
  JointKind untouched = JointKind::screw;
  CHECK_FALSE(joint_kind_from_name("", untouched));
  CHECK_FALSE(joint_kind_from_name("hinj", untouched));
  CHECK(untouched == JointKind::screw);
}

TEST_CASE("every kind takes as many motions as it has rows, and they are independent") {
  for_every_kind([](JointKind kind, const JointKindInfo& info, Random& dice) {
    for (int i = 0; i < kCases; ++i) {
      Pair s = any_pair(kind, dice, 0.2);
      if (info.rows != kOwnRows) {
        REQUIRE(row_count(s.joint) == info.rows);
        REQUIRE(info.rows + degrees_of_freedom(kind) == 6);
      }
      REQUIRE(info.fault(s.joint) == nullptr);
      if (row_count(s.joint) > 0) REQUIRE(close(s) > 1e-3);
    }
  });
}

TEST_CASE("rows of every kind have the derivatives that differences find") {
  for_every_kind([](JointKind kind, const JointKindInfo& info, Random& dice) {
    // Rows that come by differences themselves are as good as those.
    const Real loose = info.rows == kOwnRows ? 1e3 : 1;
    for (int i = 0; i < kCases; ++i) {
      const Pair s = any_pair(kind, dice, 0.4);
      const auto worst =
          misses(s, row_count(s.joint), [&](const BodyState& a, const BodyState& b, RowsOut out) {
            write_rows({s.joint, a, b, 0.1}, out);
          });
      REQUIRE((info.binds_poses() ? worst[0] : slip_miss(s)) <= 1e-11);
      REQUIRE(worst[1] <= 2e-11 * loose);
    }
  });
}

TEST_CASE("every entry of every kind's Jacobian is the derivative that differences find") {
  for_every_kind([](JointKind kind, const JointKindInfo& info, Random& dice) {
    for (int i = 0; i < 5; ++i)
      for (int column = 0; column < 12; ++column) {
        Pair s = any_pair(kind, dice, 0.4);
        Vec3* twists[] = {&s.a.velocity, &s.a.angular_velocity, &s.b.velocity,
                          &s.b.angular_velocity};
        for (Vec3* twist : twists) *twist = Vec3(0);
        (*twists[column / 3])[column % 3] = 1;
        const auto worst =
            misses(s, row_count(s.joint), [&](const BodyState& a, const BodyState& b, RowsOut out) {
              write_rows({s.joint, a, b, 0.1}, out);
            });
        INFO("column " << column);
        REQUIRE((info.binds_poses() ? worst[0] : slip_miss(s)) <= 1e-11);
      }
  });
}

TEST_CASE("coordinates of every kind have the derivatives that differences find") {
  for_every_kind([](JointKind kind, const JointKindInfo& info, Random& dice) {
    for (const FreeCoordinate& c : info.coordinates)
      for (int i = 0; i < kCases; ++i) {
        const Pair s = any_pair(kind, dice, 0.4);
        const auto worst = misses(s, 1, [&](const BodyState& a, const BodyState& b, RowsOut out) {
          write_coordinate({s.joint, a, b}, c.which, out);
        });
        INFO("coordinate " << int(c.which));
        REQUIRE(worst[0] <= 1e-10);
        REQUIRE(worst[1] <= 1e-9);
      }
  });
}

TEST_CASE("what is closed has no gap, stands as the kind allows, and is the root that is meant") {
  for_every_kind([](JointKind kind, const JointKindInfo& info, Random& dice) {
    for (int i = 0; i < kCases; ++i) {
      Pair s = any_pair(kind, dice, 0.2);
      s.joint.limits = {};
      close(s);
      const Pose a{s.a.position, s.a.rotation}, b{s.b.position, s.b.rotation};
      REQUIRE(std::abs(info.gap(s.joint, a, b)) <= 1e-12);
      REQUIRE(on_right_branch(s.joint, a.rotation, b.rotation));
      const Quat q = relative_rotation(s.joint, a.rotation, b.rotation);
      REQUIRE(violation(s.joint, q) <= 1e-7);  // rows are sines and products of them
      const Quat any = dice.rotation(), allowed = allowed_by_kind(kind, any);
      const Quat again = allowed_by_kind(kind, allowed);
      REQUIRE(glm::length(rotation_vector(again * glm::conjugate(allowed))) <= 1e-14);
    }
  });
}

TEST_CASE("kinds that hold a point write it the short way too") {
  for_every_kind([](JointKind kind, const JointKindInfo& info, Random& dice) {
    if (!info.holds_point) return;
    for (int i = 0; i < kCases; ++i) {
      const Pair s = any_pair(kind, dice, 0.4);
      Equations whole;
      write_rows({s.joint, s.a, s.b}, whole.out());
      std::array<Vec3, 5> point;
      point.fill(Vec3(1e9));
      write_rows({s.joint, s.a, s.b}, {nullptr, nullptr, nullptr, point.data()});
      CHECK(point[0] == s.a.rotation_matrix * s.joint.anchor_a);
      CHECK(point[1] == s.b.rotation_matrix * s.joint.anchor_b);
      for (int row = 0; row < 3; ++row)
        for (std::size_t v = 0; v < 4; v += 2) {
          Vec3 unit(0);
          unit[row] = v == 0 ? 1 : -1;
          CHECK(whole.j[4 * std::size_t(row) + v] == unit);
        }
      for (int row = 3; row < row_count(s.joint); ++row) {
        const Vec3* j = &whole.j[4 * std::size_t(row)];
        CHECK(j[0] == Vec3(0));
        CHECK(j[2] == Vec3(0));
        CHECK(j[1] == point[std::size_t(row) - 1]);
        CHECK(j[3] == -j[1]);
      }
    }
  });
}

TEST_CASE("a kind's slide tells its turn where it says so") {
  for_every_kind([](JointKind kind, const JointKindInfo& info, Random& dice) {
    for (int i = 0; i < kCases; ++i) {
      Pair s = any_pair(kind, dice, 0.2);
      const Real pitch = info.slide_per_turn(s.joint);
      if (pitch == 0) return;
      REQUIRE(info.counts_turns);
      close(s);
      Real rotation = 0, translation = 0;
      write_coordinate({s.joint, s.a, s.b}, Coordinate::angle, {&rotation, nullptr, nullptr});
      write_coordinate({s.joint, s.a, s.b}, Coordinate::travel, {&translation, nullptr, nullptr});
      CHECK(translation == Approx(pitch * rotation).margin(1e-12));
    }
  });
}
