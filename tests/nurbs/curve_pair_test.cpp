// Common normals of curves: closed forms, orders of differences, ends.
#include "engine/nurbs/curve_pair.hpp"

#include <catch2/catch.hpp>

#include "engine/nurbs/makers.hpp"
#include "tests/nurbs/samples.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

TEST_CASE("two circles in a plane face one another on the line of their centres") {
  Random dice(1);
  const Wire a(circle({}, 0.5)), b(circle({}, 2));
  for (const Real gap : {1.0, 0.0, -0.2})
    for (int i = 0; i < 50; ++i) {
      const Real angle = dice.between(0, 2 * kPi), turn = dice.between(0, 2 * kPi);
      const Vec3 way(std::cos(angle), std::sin(angle), 0);
      const Pose pose{(2.5 + gap) * way, from_rotation_vector({0, 0, turn})};
      const Real start = closest_point(b, pose.position).u;
      const Real other = closest_point(a, to_local(pose, Vec3(0))).u;
      const CurveContact pair = track_planar(a, b, pose, {other + 0.02, start - 0.02});
      REQUIRE(pair.status == ContactStatus::found);
      CHECK(std::abs(pair.gap - gap) < 2e-15);
      CHECK(glm::distance(pair.normal, way) < 1e-14);
      CHECK(glm::distance(pair.on_b, 2.0 * way) < 1e-14);
      // 1 / (the sum of both radii and the gap), as b follows: 1/0.5 + 1/(2 + gap) along a,
      // reduced.
      CHECK(pair.least_curvature == Approx(1 / 0.5 + 1 / (2 + gap)).epsilon(1e-7));
    }
}

TEST_CASE("elliptic cams stay on a common normal all the way around") {
  const Wire a(ellipse({}, 0.6, 0.3)), b(ellipse({}, 1, 0.4));
  std::array<Real, 2> places{0.5, 0};
  for (int i = 0; i <= 360; ++i) {
    const Real angle = i * kPi / 180;
    const Pose pose{{2, 0, 0}, from_rotation_vector({0, 0, -angle})};
    const CurveContact pair = track_planar(a, b, pose, places);
    REQUIRE(pair.status == ContactStatus::found);
    const Vec3 tangent = evaluate(b.curve(), pair.b.u, 1)[1];
    const Vec3 d = pair.on_a - pair.on_b;
    CHECK(std::abs(glm::dot(d, tangent)) < 1e-12);
    CHECK(glm::distance(d, pair.gap * pair.normal) < 1e-13);
    // No point of a is nearer.
    CHECK(closest_point(b, pair.on_a).distance == Approx(pair.gap).epsilon(1e-12));
    places = {pair.t, pair.b.u};
  }
}

TEST_CASE("at the end of a curve that is open the pair is gone; equal circles within are told") {
  const Wire ball(circle({}, 0.3)), rail(line({1, 0, 0}, {0, 0, 0}));  // right of it is up
  const auto at = [](Real x) { return Pose{{x, 0.5, 0}, kIdentity}; };
  const CurveContact on = track_planar(ball, rail, at(0.4), {0.74, 0.5});
  REQUIRE(on.status == ContactStatus::found);
  CHECK(on.gap == Approx(0.2).epsilon(1e-13));
  CHECK(track_planar(ball, rail, at(-0.2), {0.74, 0.9}).status == ContactStatus::left_patch);
  // A ring that looks inwards, of nearly and of exactly the ball's radius.
  const auto ring = [](Real r) {
    return Wire(
        arc({Vec3(0), Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, -1)}, r, {0, 2 * kPi - 0.1}));
  };
  const Real facing = 0.25, same = 1 - 0.25 * 2 * kPi / (2 * kPi - 0.1);
  const Pose near{{0, 0.05, 0}, kIdentity};
  CHECK(track_planar(ball, ring(0.4), near, {facing, same}).status == ContactStatus::found);
  const Pose centred{};
  CHECK(track_planar(ball, ring(0.3), centred, {facing, same}).status == ContactStatus::degenerate);
}

TEST_CASE("a wire over an ellipsoid ends on the normal, across charts") {
  const Vec3 half(1, 0.7, 0.5);
  const Skin egg = Skin::ellipsoid(half);
  const Wire wire(arc({}, 0.4, {0.2, 2.9}));
  Real t = 0.5;
  Place place;
  for (int i = 0; i <= 90; ++i) {
    const Real angle = i * kPi / 90;
    const Vec3 centre(1.6 * std::cos(angle), 0.2, 1.6 * std::sin(angle));
    // Its middle looks at the ellipsoid.
    const Quat turn =
        from_rotation_vector({0, -angle, 0}) * from_rotation_vector({0, 0, kPi - 1.55});
    const Pose pose{centre, turn};
    if (i == 0) {
      const ChartPoint first = chart_point(half, centre);
      place = {first.chart, first.u, first.v};
      t = closest_point(wire, to_local(pose, Vec3(0))).u;
    }
    const CurveContact pair = track_on_face(wire, egg, pose, {t, place});
    REQUIRE(pair.status == ContactStatus::found);
    const Vec3 tangent = pose.rotation * evaluate(wire.curve(), pair.t, 1)[1];
    CHECK(std::abs(glm::dot(tangent, pair.normal)) < 1e-12);
    CHECK(glm::distance(pair.on_a - pair.on_b, pair.gap * pair.normal) < 1e-12);
    CHECK(glm::length(pair.on_b / half) == Approx(1).epsilon(1e-13));
    t = pair.t, place = pair.b;
  }
}
