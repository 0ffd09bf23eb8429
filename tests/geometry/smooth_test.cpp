// Shapes known by their support functions alone, against the same shapes with corners.
#include "engine/geometry/smooth.hpp"

#include <catch2/catch.hpp>

#include "tests/geometry/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// The same shape without its corners.
Convex smooth(const Shape& shape, const Pose& at) {
  Convex c;
  const Aabb box = bounds_of(shape, Pose{});
  c.smooth = &shape, c.rotation = glm::mat3_cast(at.rotation), c.origin = c.centre = at.position;
  c.size = glm::length(box.high - box.low) / 2;
  return c;
}

std::vector<Shape> convex_shapes() {
  std::vector<Shape> shapes;
  for (const Sample& s : samples())
    if (is_convex(s.shape.kind)) shapes.push_back(s.shape);
  return shapes;
}

/// Those that have corners too.
std::vector<Shape> cornered_shapes() {
  std::vector<Shape> shapes = convex_shapes();
  std::erase_if(shapes, [](const Shape& s) { return !traits_of(s.kind).convex_piece; });
  return shapes;
}

Real least_gap(const std::vector<ContactPoint>& points) {
  Real least = 1e300;
  for (const ContactPoint& p : points) least = std::min(least, p.gap);
  return least;
}

}  // namespace

TEST_CASE("support functions reach as far as corners do") {
  Random dice(7);
  for (const Shape& shape : cornered_shapes()) {
    ConvexScratch room;
    const Pose at{dice.in_cube(1), dice.orientation()};
    const Convex with = convex_piece(shape, at, room), without = smooth(shape, at);
    for (int i = 0; i < 100; ++i) {
      const Vec3 d = dice.direction();
      CHECK(glm::dot(d, without.extreme(d)) ==
            Approx(glm::dot(d, with.extreme(d)) + with.radius).epsilon(1e-12));
    }
  }
}

TEST_CASE("smooth pieces are as far apart, and overlap as deep, as those with corners") {
  Random dice(7);
  int apart = 0, overlaps = 0;
  for (const Shape& a : cornered_shapes())
    for (const Shape& b : cornered_shapes())
      for (int trial = 0; trial < 60; ++trial) {
        const Pose at{dice.in_cube(1.1), dice.orientation()}, to{Vec3(0), dice.orientation()};
        std::vector<ContactPoint> expected;
        ConvexScratch room_a, room_b;
        const Convex with_a = convex_piece(a, at, room_a), with_b = convex_piece(b, to, room_b);
        collide_convex(with_a, with_b, nullptr, {100, expected});
        REQUIRE_FALSE(expected.empty());
        const Real gap = least_gap(expected);
        const Separation found = separate(smooth(a, at), smooth(b, to), 1e300);
        CAPTURE(name_of(a.kind), name_of(b.kind), gap, found.distance);
        CHECK(glm::length(found.normal) == Approx(1).epsilon(1e-12));
        CHECK(glm::distance(found.on_a - found.on_b, found.distance * found.normal) < 1e-6);
        if (gap > 0) {
          ++apart;
          CHECK(found.distance == Approx(gap).margin(1e-7));
        } else {
          // The least way out: where the pieces with corners know only that of their cores, or
          // prefer a face, less may do.
          ++overlaps;
          CHECK(found.distance >= gap - 1e-7);
          ConvexScratch moved;
          const Pose out{at.position - (found.distance - 1e-6) * found.normal, at.rotation};
          CHECK(separate(smooth(a, out), smooth(b, to), 1e300).distance > 0);
          if (with_a.radius == 0 && with_b.radius == 0) CHECK(found.distance <= 0.98 * gap);
        }
      }
  CHECK(apart > 200);
  CHECK(overlaps > 200);
}

TEST_CASE("a smooth block touches planes, blocks and grounds as the block does") {
  Random dice(7);
  const Shape block{ShapeKind::box, {0.3, 0.2, 0.4}, {}, 0};
  const Shape other{ShapeKind::box, {1, 0.5, 1}, {}, 0};
  for (int trial = 0; trial < 200; ++trial) {
    const Real margin = 0.01;
    // Flat on it, or turned about the upright; a little above or below.
    const Quat rotation = glm::angleAxis(dice.between(0, 2 * kPi), Vec3(0, 1, 0));
    const Real gap = dice.between(-0.005, 0.009);
    std::vector<ContactPoint> on_plane, on_block, expected;
    ConvexScratch room, room_b;
    const Pose at{{dice.between(-0.9, 0.9), 0.7 + gap, dice.between(-0.9, 0.9)}, rotation};
    collide_plane(smooth(block, at), {0, 1, 0}, 0.5, {margin, on_plane});
    CHECK(on_plane.size() == 4);
    for (const ContactPoint& p : on_plane) CHECK(p.gap == Approx(gap).margin(1e-12));
    collide_convex(smooth(block, at), convex_piece(other, {}, room), nullptr, {margin, on_block});
    collide_convex(convex_piece(block, at, room_b), convex_piece(other, {}, room), nullptr,
                   {margin, expected});
    CAPTURE(gap, at.position.x, at.position.z, on_block.size(), expected.size());
    REQUIRE_FALSE(on_block.empty());
    CHECK(least_gap(on_block) == Approx(least_gap(expected)).margin(1e-9));
    // The same extent bears.
    const auto bounds = [](const std::vector<ContactPoint>& points) {
      Aabb box;
      for (const ContactPoint& p : points) box.add(p.on_b);
      return box;
    };
    const Aabb mine = bounds(on_block), theirs = bounds(expected);
    CHECK(glm::distance(mine.low, theirs.low) < 0.02);
    CHECK(glm::distance(mine.high, theirs.high) < 0.02);
    for (const ContactPoint& p : on_block) CHECK(p.normal.y > 1 - 1e-6);
  }
}

TEST_CASE("rays and nearest points by support functions agree with the kinds' own") {
  Random dice(7);
  int met = 0;
  for (const Shape& shape : convex_shapes())
    for (int trial = 0; trial < 300; ++trial) {
      const Vec3 from = dice.in_cube(1.5);
      const Vec3 way = glm::normalize(dice.in_cube(0.6) - from);
      CAPTURE(name_of(shape.kind), from.x, from.y, from.z, way.x, way.y, way.z);
      const auto expected = closest(shape, from, 100);
      const auto found = closest_of(smooth(shape, {}), from, 100);
      REQUIRE(found);
      CHECK(found->distance == Approx(expected->distance).margin(1e-8));
      if (expected->distance < 1e-3) continue;
      const auto entry = cast(shape, from, way, 3), same = cast_at(smooth(shape, {}), from, way, 3);
      // A ray that only grazes may go either way.
      if (bool(entry) != bool(same)) {
        const auto& one = entry ? entry : same;
        CHECK(std::abs(glm::dot(one->normal, way)) < 1e-3);
        continue;
      }
      if (!entry) continue;
      ++met;
      CHECK(same->distance == Approx(entry->distance).margin(1e-7));
    }
  CHECK(met > 200);
}
