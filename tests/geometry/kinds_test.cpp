// What holds for every kind of shape in the table: rays, nearest points and mass against formulas
// and samples of the test's own.
#include "engine/geometry/kinds.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "tests/geometry/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

TEST_CASE("the samples hold every kind of the table, and names tell kinds apart") {
  std::set<ShapeKind> kinds;
  for (const Sample& s : samples()) kinds.insert(s.shape.kind);
  CHECK(kinds.size() == std::size(kShapeNames));
  CHECK(std::set<std::string_view>(std::begin(kShapeNames), std::end(kShapeNames)).size() ==
        std::size(kShapeNames));
}

TEST_CASE("every kind says what its class needs") {
  for (std::size_t i = 0; i < std::size(kShapeNames); ++i) {
    CAPTURE(kShapeNames[i]);
    const ShapeTraits& kind = *kShapeTraits[i];
    CHECK_FALSE(kind.about.empty());
    if (kind.shape_class == ShapeClass::convex) {
      CHECK(kind.support);
      CHECK((kind.enclosed || (kind.volume && kind.unit_moments)));
    } else {
      CHECK(kind.bounds);
      CHECK(kind.cast);
      CHECK(kind.closest);
    }
    CHECK((kind.source != SurfaceSource::none || !kind.sizes.empty()));
    for (const SizeKey& size : kind.sizes) {
      CHECK((size.count == 1 || (size.count == 3 && size.first == 0)));
      CHECK((size.first >= 0 && size.first + size.count <= 3));
    }
  }
}

TEST_CASE("a ray enters every kind where samples along it first get inside") {
  Random dice(7);
  for (const Sample& s : samples()) {
    CAPTURE(name_of(s.shape.kind));
    int met = 0;
    for (int trial = 0; trial < 400; ++trial) {
      const Vec3 from = dice.in_cube(1.6), way = glm::normalize(dice.in_cube(0.8) - from);
      if (s.inside(from)) continue;
      constexpr int kSteps = 3000;
      constexpr Real kLimit = 3;
      Real expected = -1;
      for (int i = 1; i <= kSteps && expected < 0; ++i) {
        Real low = kLimit * (i - 1) / kSteps, high = kLimit * i / kSteps;
        if (!s.inside(from + high * way)) continue;
        for (int k = 0; k < 50; ++k) {
          const Real middle = (low + high) / 2;
          (s.inside(from + middle * way) ? high : low) = middle;
        }
        expected = high;
      }
      // What is solid below a field is not entered from its sides or from below.
      const bool ground = s.shape.kind == ShapeKind::height_field;
      const Vec3 at = from + expected * way;
      if (ground && expected >= 0 && std::abs(at.y - slope(at.x, at.z)) > 1e-6) continue;
      const auto found = cast(s.shape, from, way, kLimit);
      CAPTURE(from.x, from.y, from.z, way.x, way.y, way.z, expected);
      if (expected < 0) {  // a chord shorter than a step may be missed by the samples
        if (found && !ground)
          CHECK_FALSE(s.inside(from + (found->distance + 2 * kLimit / kSteps) * way));
        continue;
      }
      ++met;
      REQUIRE(found);
      if (found->distance < expected - 1e-9) {
        CHECK_FALSE(s.inside(from + (found->distance + 2 * kLimit / kSteps) * way));
        continue;
      }
      CHECK(found->distance == Approx(expected).margin(1e-9));
      CHECK(glm::length(found->normal) == Approx(1).epsilon(1e-12));
      CHECK(glm::dot(found->normal, way) <= 1e-12);
      CHECK_FALSE(s.inside(at + 1e-6 * found->normal));
      CHECK_FALSE(cast(s.shape, from, way, 0.99 * expected));
    }
    CHECK(met > 30);
  }
}

TEST_CASE("no sampled place of the surface of any kind is nearer than its closest point") {
  Random dice(7);
  for (const Sample& s : samples()) {
    CAPTURE(name_of(s.shape.kind));
    for (int trial = 0; trial < 200; ++trial) {
      const Vec3 p = dice.in_cube(1.5);
      const auto near = closest(s.shape, p, 100);
      REQUIRE(near);
      CAPTURE(p.x, p.y, p.z, near->distance);
      const bool inside = s.inside(p);
      CHECK((near->distance < 0) == inside);
      CHECK(glm::distance(near->point, p) == Approx(std::abs(near->distance)).margin(1e-12));
      CHECK(glm::distance(near->point + near->distance * near->normal, p) < 1e-9);
      CHECK(contains(s.shape, p) == inside);
      // A field is solid to the side and below: only its upper surface is meant.
      const bool ground = s.shape.kind == ShapeKind::height_field;
      for (int i = 0; i < 50 && !ground; ++i) {
        const Vec3 beside = p + 0.999 * std::abs(near->distance) * dice.direction();
        CHECK(s.inside(beside) == inside);
      }
      if (!inside) CHECK_FALSE(closest(s.shape, p, 0.999 * near->distance));
    }
  }
}

TEST_CASE("the closest point of a field is the nearest of its triangles") {
  Random dice(7);
  const Sample field = samples().back();
  const Surface& s = *field.shape.surface;
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3 p = dice.in_cube(2);
    Real expected = 1e300;
    for (std::uint32_t t = 0; t < 2 * (s.columns - 1) * (s.rows - 1); ++t)
      expected = std::min(expected, glm::distance(p, nearest_in(triangle_of(s, t), p)));
    const auto near = closest(field.shape, p, 100);
    REQUIRE(near);
    CHECK(std::abs(near->distance) == Approx(expected).epsilon(1e-12));
  }
}

TEST_CASE("rays meet balls, rods, blocks and planes where the closed forms say") {
  const Shape ball{ShapeKind::sphere, {0.5, 0, 0}, {}, 0};
  const Shape rod{ShapeKind::capsule, {0.2, 0.3, 0}, {}, 0};
  const Shape block{ShapeKind::box, {1, 2, 3}, {}, 0}, plane{ShapeKind::plane, {1, 0, 0}, {}, 0};
  CHECK(cast(ball, {-2, 0.3, 0}, {1, 0, 0}, 10)->distance == Approx(2 - 0.4).epsilon(1e-14));
  CHECK(cast(ball, {-2, 0.3, 0}, {1, 0, 0}, 10)->normal.y == Approx(0.6).epsilon(1e-14));
  CHECK_FALSE(cast(ball, {-2, 0.3, 0}, {-1, 0, 0}, 10));
  CHECK_FALSE(cast(ball, {-2, 0.51, 0}, {1, 0, 0}, 10));
  CHECK(cast(rod, {1, 0.2, 0}, {-1, 0, 0}, 10)->distance == Approx(0.8).epsilon(1e-14));
  CHECK(cast(rod, {0, 2, 0}, {0, -1, 0}, 10)->distance == Approx(1.5).epsilon(1e-14));
  CHECK(cast(rod, {0.12, 2, 0}, {0, -1, 0}, 10)->distance == Approx(2 - 0.3 - 0.16).epsilon(1e-14));
  CHECK(cast(block, {0, 5, 0}, {0, -1, 0}, 10)->distance == 3);
  CHECK(cast(block, {0, 5, 0}, {0, -1, 0}, 10)->normal == Vec3(0, 1, 0));
  CHECK_FALSE(cast(block, {0, 5, 0}, {1, 0, 0}, 10));
  CHECK(cast(plane, {300, 4, 0}, glm::normalize(Vec3(0, -1, 1)), 10)->distance ==
        Approx(4 * std::sqrt(2.0)).epsilon(1e-14));
  CHECK_FALSE(cast(plane, {0, 4, 0}, {1, 0, 0}, 1e9));   // along it
  CHECK_FALSE(cast(plane, {0, 4, 0}, {0, 1, 0}, 1e9));   // away from it
  CHECK_FALSE(cast(plane, {0, -1, 0}, {0, 1, 0}, 1e9));  // from within
}

TEST_CASE("bounds, reach and inner radius hold every kind") {
  Random dice(7);
  for (const Sample& s : samples()) {
    CAPTURE(name_of(s.shape.kind));
    if (is_unbounded(s.shape.kind)) continue;
    const Pose at{dice.in_cube(2), dice.orientation()};
    const Aabb box = bounds_of(s.shape, at);
    const Real reach = reach_of(s.shape), inner = inner_radius(s.shape);
    for (int i = 0; i < 20000; ++i) {
      const Vec3 p = dice.in_cube(1.6), q = to_world(at, p);
      if (s.inside(p)) {
        CHECK((box.overlaps({q, q}) && glm::length(p) <= reach));
      } else {
        CHECK(glm::length(p) >= inner * (1 - 1e-12));
      }
    }
  }
}
