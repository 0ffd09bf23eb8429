// Cylinders, cones and ellipsoids: where they touch, by closed forms and by brute force.
#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/geometry/collide.hpp"
#include "engine/geometry/kinds/turned.hpp"
#include "tests/geometry/brute_force.hpp"
#include "tests/geometry/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

using Points = std::vector<ContactPoint>;

const Shape kPlane{ShapeKind::plane, {10, 0, 0}, {}, 0};
const Shape kTable{ShapeKind::box, {1, 0.5, 1}, {}, 0};

Shape cylinder(Real r, Real half) { return {ShapeKind::cylinder, {r, half, 0}, {}, 0}; }
Shape cone(Real r, Real half) { return {ShapeKind::cone, {r, half, 0}, {}, 0}; }
Shape ellipsoid(Vec3 radii) { return {ShapeKind::ellipsoid, radii, {}, 0}; }
Shape ball(Real r) { return {ShapeKind::sphere, {r, 0, 0}, {}, 0}; }
Shape rod(Real r, Real half) { return {ShapeKind::capsule, {r, half, 0}, {}, 0}; }

Shape ground() {
  const std::vector<Real> flat(9 * 9, 0.0);
  return {ShapeKind::height_field, {}, {}, 0, *make_height_field({9, 9, 0.5, 0.5, flat})};
}

Points touching(const PlacedShape& a, const PlacedShape& b, Real margin) {
  NarrowPhaseScratch scratch;
  Points out;
  collide(a, b, scratch, {margin, out});
  return out;
}

const ContactPoint& deepest(const Points& points) {
  return *std::min_element(
      points.begin(), points.end(),
      [](const ContactPoint& p, const ContactPoint& q) { return p.gap < q.gap; });
}

Real least(const Points& points) { return points.empty() ? 1e300 : deepest(points).gap; }

Aabb extent(const Points& points) {
  Aabb box;
  for (const ContactPoint& p : points) box.add(p.on_b);
  return box;
}

bool sound(const Points& points) {
  return std::all_of(points.begin(), points.end(), [](const ContactPoint& p) {
    return is_finite(p.on_a) && is_finite(p.on_b) && std::abs(glm::length(p.normal) - 1) < 1e-12 &&
           std::abs(glm::dot(p.normal, p.on_a - p.on_b) - p.gap) < 1e-9;
  });
}

Quat about(Vec3 axis, Real angle) { return from_rotation_vector(angle * axis); }

/// Grounds whose top is at y = 0, as bodies rest on them.
struct Ground {
  Shape shape;
  Pose at;
};
std::vector<Ground> grounds() {
  return {{kPlane, {}}, {kTable, {{0, -0.5, 0}, kIdentity}}, {ground(), {}}};
}

std::vector<Shape> round_kinds() {
  return {cylinder(0.2, 0.3), cone(0.3, 0.25), ellipsoid({0.3, 0.15, 0.2})};
}
std::vector<Shape> convex_kinds() {
  std::vector<Shape> all = round_kinds();
  all.push_back(cylinder(0.3, 0.05)), all.push_back(ball(0.2)), all.push_back(rod(0.1, 0.25));
  all.push_back({ShapeKind::box, {0.2, 0.3, 0.25}, {}, 0});
  for (const Sample& s : samples())
    if (s.shape.kind == ShapeKind::hull) all.push_back(s.shape);
  return all;
}

}  // namespace

TEST_CASE("a cylinder on its end touches around its rim, on its side with the two ends of a line") {
  const Shape can = cylinder(0.2, 0.3);
  for (const Ground& g : grounds())
    for (const Real gap : {0.004, -0.004})
      for (const Real angle : {0.0, 0.3, 1.1}) {
        CAPTURE(name_of(g.shape.kind), gap, angle);
        const Pose upright{{0.1, 0.3 + gap, 0.05}, about({0, 1, 0}, angle)};
        const Points end = touching({can, upright}, {g.shape, g.at}, 0.01);
        REQUIRE(sound(end));
        CHECK(end.size() >= 4);
        for (const ContactPoint& p : end) {
          CHECK(p.gap == Approx(gap).margin(1e-12));
          CHECK(glm::distance(p.normal, {0, 1, 0}) < 1e-12);
        }
        const Aabb rim = extent(end);
        CHECK(rim.high.x - rim.low.x > 2 * 0.2 * std::cos(kPi / 4) - 1e-9);
        CHECK(rim.high.z - rim.low.z > 2 * 0.2 * std::cos(kPi / 4) - 1e-9);
        // Lying, turned about its own axis and about the upright.
        const Pose lying{
            {0.1, 0.2 + gap, 0.05},
            about({0, 1, 0}, angle) * about({0, 0, 1}, kPi / 2) * about({0, 1, 0}, 2 * angle)};
        const Points side = touching({can, lying}, {g.shape, g.at}, 0.01);
        REQUIRE(sound(side));
        CHECK(side.size() >= 2);
        const Vec3 axis = lying.rotation * Vec3(0, 1, 0);
        for (const ContactPoint& p : side) {
          CHECK(p.gap == Approx(gap).margin(1e-12));
          CHECK(glm::distance(p.normal, {0, 1, 0}) < 1e-12);
          // Straight below the axis.
          const Vec3 beside = p.on_a - lying.position;
          CHECK(glm::distance(beside - glm::dot(beside, axis) * axis, Vec3(0, -0.2, 0)) < 1e-12);
        }
        const Aabb line = extent(side);
        CHECK(glm::distance(line.high, line.low) == Approx(0.6).epsilon(1e-9));
      }
}

TEST_CASE("a cone rests on its base, on its side with tip and rim, and on its tip") {
  const Real r = 0.3, half = 0.4, slope = std::atan2(r, 2 * half);
  const Shape hat = cone(r, half);
  for (const Ground& g : grounds())
    for (const Real gap : {0.003, -0.003}) {
      CAPTURE(name_of(g.shape.kind), gap);
      const Points base = touching({hat, {{0, half + gap, 0}, kIdentity}}, {g.shape, g.at}, 0.01);
      CHECK(sound(base));
      CHECK(base.size() >= 4);
      CHECK(least(base) == Approx(gap).margin(1e-12));
      // On its side: the axis rises by the half angle, the tip is down.
      const Quat lean = about({0, 0, 1}, -(kPi / 2 + slope));
      const Vec3 tip = lean * Vec3(0, half, 0);
      const Pose lying{{0.02, gap - tip.y, 0.01}, lean};
      const Points side = touching({hat, lying}, {g.shape, g.at}, 0.01);
      REQUIRE(sound(side));
      CHECK(side.size() >= 2);
      for (const ContactPoint& p : side) CHECK(p.gap == Approx(gap).margin(1e-12));
      CHECK(glm::distance(extent(side).high, extent(side).low) ==
            Approx(std::hypot(r, 2 * half)).epsilon(1e-9));
      const Pose down{{0, half + gap, 0}, about({1, 0, 0}, kPi)};
      const Points point = touching({hat, down}, {g.shape, g.at}, 0.01);
      REQUIRE_FALSE(point.empty());
      CHECK(least(point) == Approx(gap).margin(1e-12));
      CHECK(glm::length(extent(point).high - extent(point).low) < 1e-9);
    }
}

TEST_CASE("an ellipsoid touches a ground where its normal is upright") {
  Random dice(17);
  const Vec3 radii(0.3, 0.12, 0.2);
  for (const Ground& g : grounds())
    for (int trial = 0; trial < 50; ++trial) {
      const Quat turn = dice.orientation();
      const Vec3 n = glm::conjugate(turn) * Vec3(0, 1, 0);
      const Real height = glm::length(radii * n), gap = dice.between(-0.004, 0.009);
      const Pose at{{dice.between(-0.3, 0.3), height + gap, dice.between(-0.3, 0.3)}, turn};
      const Points found = touching({ellipsoid(radii), at}, {g.shape, g.at}, 0.01);
      CAPTURE(name_of(g.shape.kind), gap);
      REQUIRE_FALSE(found.empty());
      const ContactPoint& p = deepest(found);
      CHECK(p.gap == Approx(gap).margin(1e-12));
      CHECK(glm::distance(p.normal, {0, 1, 0}) < 1e-12);
      CHECK(glm::distance(p.on_a, to_world(at, -radii * radii * n / height)) < 1e-9);
    }
}

TEST_CASE("balls touch cylinders, cones and ellipsoids along the shortest way, however deep") {
  Random dice(17);
  for (const Shape& b : round_kinds())
    for (int trial = 0; trial < 300; ++trial) {
      const Real r = dice.between(0.02, 0.3);
      const Pose here{dice.in_cube(0.6), dice.orientation()},
          there{dice.in_cube(0.1), dice.orientation()};
      const auto near = closest(b, to_local(there, here.position), 10);
      const Points found = touching({ball(r), here}, {b, there}, 10);
      const Points swapped = touching({b, there}, {ball(r), here}, 10);
      REQUIRE(found.size() == 1);
      REQUIRE(swapped.size() == 1);
      CHECK(sound(found));
      CHECK(found[0].gap == Approx(near->distance - r).margin(1e-12));
      CHECK(glm::distance(found[0].on_b, to_world(there, near->point)) < 1e-12);
      CHECK(swapped[0].gap == Approx(found[0].gap).margin(1e-12));
      CHECK(glm::distance(swapped[0].normal, -found[0].normal) < 1e-9);
      CHECK(glm::distance(swapped[0].on_a, found[0].on_b) < 1e-9);
    }
}

TEST_CASE("gaps and depths are those of a search over all directions, in either order") {
  Random dice(17);
  int shallow = 0, deep = 0, apart = 0, longer = 0;
  for (const Shape& a : round_kinds())
    for (const Shape& b : convex_kinds())
      for (int trial = 0; trial < 24; ++trial) {
        const Pose here{dice.in_cube(0.45), dice.orientation()},
            there{dice.in_cube(0.1), dice.orientation()};
        const PlacedShape one{a, here}, two{b, there};
        const Real expected = brute_force_gap(one, two, dice);
        const Real margin = std::max(expected, 0.0) + 0.01;
        const Points found = touching(one, two, margin), swapped = touching(two, one, margin);
        CAPTURE(name_of(a.kind), name_of(b.kind), trial, expected);
        REQUIRE_FALSE(found.empty());
        REQUIRE_FALSE(swapped.empty());
        CHECK((sound(found) && sound(swapped)));
        CHECK(found.size() <= 8);
        // Each is what a direction tells, so never less than the truth; and as good as the best
        // that was found, but for overlaps with several ways out, where it may be another.
        const bool is_shallow = expected > -0.02;
        ++(expected > 0 ? apart : is_shallow ? shallow : deep);
        for (const Points* points : {&found, &swapped}) {
          const ContactPoint& at = deepest(*points);
          const bool turned = points == &swapped;
          CHECK(gap_along(one, two, turned ? -at.normal : at.normal) ==
                Approx(at.gap).margin(1e-6));
          if (expected > 0) CHECK(at.gap > expected - 1e-6);
          if (is_shallow) CHECK(at.gap > 1.5 * std::min(expected, 0.0) - 1e-6);
          longer += at.gap < expected - 1e-6;
        }
        CHECK((expected < 0 || std::abs(least(found) - least(swapped)) < 1e-6));
      }
  CHECK(apart > 100);
  CHECK(shallow > 20);
  CHECK(deep > 100);
  INFO(shallow << " shallow, " << deep << " deep");
  CAPTURE(longer);
  CHECK(longer <= 0.05 * 2 * (shallow + deep));
}

TEST_CASE("cylinders stand on cylinders, lie on boxes and beside one another") {
  const Shape can = cylinder(0.2, 0.3);
  // Whatever the upper one is turned by, they share all of their ends.
  for (const Real angle : {0.0, 0.2, kPi / 8, 1.0}) {
    const Points stacked =
        touching({can, {{0.001, 0.599, 0}, about({0, 1, 0}, angle)}}, {can, {}}, 0.01);
    CAPTURE(angle);
    CHECK(stacked.size() == 4);
    for (const ContactPoint& p : stacked) {
      CHECK(p.gap == Approx(-0.001).margin(1e-12));
      CHECK(glm::distance(p.normal, {0, 1, 0}) < 1e-12);
    }
    CHECK(extent(stacked).high.x - extent(stacked).low.x > 0.28);
    CHECK(extent(stacked).high.z - extent(stacked).low.z > 0.28);
  }
  // Half of it beyond the edge of a box.
  const Points over = touching({can, {{1, 0.799, 0}, kIdentity}}, {kTable, {}}, 0.01);
  CHECK(over.size() >= 3);
  CHECK(extent(over).high.x == Approx(1).margin(1e-9));
  // Side by side, and crossed.
  for (const Real gap : {0.003, -0.003}) {
    const Points beside = touching({can, {{0.4 + gap, 0.1, 0}, kIdentity}}, {can, {}}, 0.01);
    REQUIRE(beside.size() == 2);
    for (const ContactPoint& p : beside) {
      CHECK(p.gap == Approx(gap).margin(1e-9));
      CHECK(glm::distance(p.normal, {1, 0, 0}) < 1e-6);
    }
    CHECK(std::abs(beside[0].on_a.y - beside[1].on_a.y) == Approx(0.5).margin(1e-6));
    const Points crossed =
        touching({can, {{0.4 + gap, 0, 0}, about({1, 0, 0}, kPi / 2)}}, {can, {}}, 0.01);
    REQUIRE(crossed.size() == 1);
    CHECK(crossed[0].gap == Approx(gap).margin(1e-9));
    CHECK(glm::distance(crossed[0].normal, {1, 0, 0}) < 1e-6);
  }
}

TEST_CASE("what stands keeps the numbers of its points while it shifts a little") {
  Random dice(17);
  for (const Shape& a : {cylinder(0.2, 0.3), cone(0.2, 0.3)})
    for (const Ground& g : grounds()) {
      std::vector<std::uint64_t> known;
      for (int trial = 0; trial < 20; ++trial) {
        const Quat lean = from_rotation_vector(1e-7 * dice.in_cube(1));
        const Pose at{Vec3(0.11, 0.3, 0.07) + 1e-6 * dice.in_cube(1), lean};
        std::vector<std::uint64_t> now;
        for (const ContactPoint& p : touching({a, at}, {g.shape, g.at}, 0.01))
          now.push_back(p.feature);
        std::sort(now.begin(), now.end());
        if (trial == 0) known = now;
        CHECK(now == known);
      }
    }
}

TEST_CASE("a solid of revolution is round by its distance from the axis along the normal") {
  const auto rounding = [](const Shape& shape, const Rolling& at) {
    return traits_of(shape.kind).rounding(shape, at);
  };
  const Vec3 along(0, 7, 0);  // about the axis
  CHECK(rounding(cylinder(0.2, 0.3), {{0.2, 0.3, 0}, {1, 0, 0}, along}) == Approx(0.2));
  // Over its rim, and on its end, it has a corner.
  CHECK(rounding(cylinder(0.2, 0.3), {{0.2, 0.3, 0}, {1, 0, 0}, {0, 0, 5}}) == 0);
  CHECK(rounding(cylinder(0.2, 0.3), {{0.2, 0.3, 0}, {0, 1, 0}, along}) == 0);
  // A cone's side: from the rim along the normal to the axis.
  const Real r = 0.3, height = 0.8, slant = std::hypot(r, height);
  CHECK(
      rounding(cone(r, height / 2), {{r, -height / 2, 0}, {height / slant, r / slant, 0}, along}) ==
      Approx(r * slant / height));
  // An ellipsoid on its flat side rolls along circles of its curvature: a^2 / c and b^2 / c.
  const Shape egg = ellipsoid({0.3, 0.2, 0.1});
  CHECK(rounding(egg, {{0, 0, 0.1}, {0, 0, 1}, {0, 1, 0}}) == Approx(0.9));
  CHECK(rounding(egg, {{0, 0, 0.1}, {0, 0, 1}, {1, 0, 0}}) == Approx(0.4));
  CHECK(rounding(ellipsoid(Vec3(0.2)), {{0, 0.2, 0}, {0, 1, 0}, {1, 2, 3}}) == Approx(0.2));
}

TEST_CASE("nothing degenerate between round shapes gives numbers that are not finite") {
  std::vector<Shape> kinds = convex_kinds();
  kinds.push_back(cylinder(1e-6, 0.4)), kinds.push_back(cylinder(0.4, 1e-6));
  kinds.push_back(cone(1e-6, 0.4)), kinds.push_back(cone(0.4, 1e-6));
  kinds.push_back(ellipsoid({0.4, 1e-6, 0.4})), kinds.push_back(ellipsoid({1e-6, 0.4, 1e-6}));
  kinds.push_back(ball(0)), kinds.push_back(rod(0, 0.4));
  for (const Shape& a : kinds)
    for (const Shape& b : kinds)
      for (const Vec3 place : {Vec3(0), Vec3(0.2, 0, 0), Vec3(0, 0.6, 0), Vec3(0, 1e-12, 0)})
        for (const Quat& turn : {kIdentity, about({0, 0, 1}, kPi / 2), about({1, 0, 0}, kPi)}) {
          CAPTURE(name_of(a.kind), name_of(b.kind), place.x, place.y);
          CHECK(sound(touching({a, {place, turn}}, {b, {}}, 0.3)));
        }
  for (const Shape& a : kinds)
    for (const Ground& g : grounds()) CHECK(sound(touching({a, {}}, {g.shape, g.at}, 0.3)));
}
