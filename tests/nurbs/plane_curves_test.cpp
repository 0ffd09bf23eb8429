// Outlines: what they are made of, how long they are, which pairs of them face one another.
#include "engine/nurbs/plane_curves.hpp"

#include <catch2/catch.hpp>

#include "engine/nurbs/check.hpp"
#include "engine/nurbs/curve_pair.hpp"
#include "engine/nurbs/makers.hpp"
#include "tests/nurbs/samples.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

namespace {

const Vec3 kRoom[] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};

bool is_smooth(const Curve& curve) {
  for (const Flaw& flaw : flaws_of(curve, "c"))
    if (flaw.kind == FlawKind::crease || flaw.kind == FlawKind::singular_point) return false;
  return errors_of(curve, "c").empty();
}

}  // namespace

TEST_CASE("a rounded polygon is smooth, of arcs and lines, as long as they are") {
  const Real r = 0.2;
  const Curve curve = rounded_polygon(kRoom, r).value();
  REQUIRE(is_smooth(curve));
  CHECK(curve.knots.is_periodic);
  for (const Flaw& flaw : flaws_of(curve, "c")) CHECK(flaw.kind == FlawKind::jump_of_bend);
  // Five corners to the left, one to the right; each takes 2 r from the sides and gives a quarter.
  const Real length = 10 - 6 * 2 * r + 6 * r * kPi / 2;
  const CurvePieces pieces(curve);
  const Range domain = pieces.knots().domain();
  CHECK(pieces.way(domain.low, domain.low + 0.3 * domain.width()) +
            pieces.way(domain.low + 0.3 * domain.width(), domain.low + 0.7 * domain.width()) +
            pieces.way(domain.low + 0.7 * domain.width(), domain.low) ==
        Approx(length).epsilon(1e-11));
  CHECK(area_around(curve) == Approx(4 - 4 * r * r * (1 - kPi / 4)).epsilon(2e-3));
  CHECK(area_around(reversed(curve)) == Approx(-area_around(curve)).epsilon(1e-9));
  CHECK_FALSE(crossing_of(curve));
}

TEST_CASE("outlines that cannot be are refused by the number of the point") {
  const auto told = [](std::vector<Vec3> points, Real radius) {
    const Result<Curve> made = rounded_polygon(points, radius);
    REQUIRE_FALSE(made);
    return made.errors()[0].message;
  };
  CHECK(told({{0, 0, 0}, {1, 0, 0}}, 0.1) == "found 2 points, expected at least 3");
  CHECK(told({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 0.1).find("point 1 twice") !=
        std::string::npos);
  CHECK(told({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 0.6).find("side of 1 m after point 0") !=
        std::string::npos);
  CHECK(told({{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {0, 1, 0}}, 0).find("runs back on itself") !=
        std::string::npos);
  const std::vector<Vec3> eight = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  const Curve crossing = rounded_polygon(eight, 0.05).value();
  const auto at = crossing_of(crossing);
  REQUIRE(at);
  CHECK(glm::distance(evaluate(crossing, (*at)[0], 0)[0], evaluate(crossing, (*at)[1], 0)[0]) <
        0.1);
}

TEST_CASE("curves are joined in order, speeds meet, and the ring closes") {
  const Frame right{.origin = {1, 0, 0}}, left{.origin = {-1, 0, 0}};
  const std::vector<Curve> stadium = {
      line({-1, -0.5, 0}, {1, -0.5, 0}), arc(right, 0.5, {-kPi / 2, kPi / 2}),
      line({1, 0.5, 0}, {-1, 0.5, 0}), arc(left, 0.5, {kPi / 2, 3 * kPi / 2})};
  const Curve ring = joined(stadium).value();
  REQUIRE(is_smooth(ring));
  CHECK(ring.knots.is_periodic);
  CHECK(area_around(ring) == Approx(2 + kPi / 4).epsilon(2e-3));
  for (const Flaw& flaw : flaws_of(ring, "c")) CHECK(flaw.kind == FlawKind::jump_of_bend);
  const Result<Curve> apart = joined(std::vector{stadium[0], stadium[2]});
  REQUIRE_FALSE(apart);
  CHECK(apart.errors()[0].message.find("curve 1 to begin 1 m from the end") != std::string::npos);
  // A circle cut open is closed again, whatever its knots were.
  Curve open = circle({}, 2);
  open.knots.is_periodic = false;
  CHECK(closed_up(open).knots.is_periodic);
  CHECK_FALSE(closed_up(stadium[1]).knots.is_periodic);
}

TEST_CASE("pieces of curves are evaluated as by their knots, and measured") {
  Random dice(4);
  std::vector<Vec3> points;
  for (int i = 0; i < 12; ++i) {
    const Real angle = 2 * kPi * i / 12, r = dice.between(0.7, 1.3);
    points.push_back({r * std::cos(angle), r * std::sin(angle), 0});
  }
  for (const Curve& curve :
       {ellipse({}, 0.6, 0.3), interpolated(points, 3, Ends::periodic).value(),
        interpolated(points, 5, Ends::open).value(), line({0, 1, 0}, {3, 4, 0})}) {
    const CurvePieces pieces(curve);
    const Range domain = curve.knots.domain();
    for (int i = 0; i <= 200; ++i) {
      const Real t = domain.low + domain.width() * i / 200;
      const CurveDerivatives by_knots = evaluate(curve, t, 2);
      const auto by_powers = pieces.at(t);
      for (std::size_t k = 0; k < 3; ++k)
        CHECK(glm::distance(by_knots[k], by_powers[k]) <= 1e-12 * (1 + glm::length(by_knots[k])));
    }
  }
  const CurvePieces round(circle({}, 0.5));
  CHECK(round.way(0, 0.25) == Approx(kPi / 4).epsilon(1e-12));
  CHECK(round.way(0.9, 0.15) == Approx(round.way(0.15, 0.4)).epsilon(1e-12));  // over the seam
  CHECK(round.way(0.15, 0.9) == -round.way(0.9, 0.15));
}

TEST_CASE("a search of two outlines finds every place where they are nearest") {
  Random dice(11);
  const Wire room(rounded_polygon(kRoom, 0.15).value());
  for (int n = 0; n < 200; ++n) {
    const Wire pin(n % 2 == 0 ? ellipse({}, dice.between(0.1, 0.4), dice.between(0.1, 0.4))
                              : circle({}, dice.between(0.1, 0.4)));
    const Pose pose{{dice.between(-1, 3), dice.between(-1, 4), 0},
                    from_rotation_vector({0, 0, dice.between(-3, 3)})};
    // Dense: places of the room's outline, right of which the pin's outline is at its least.
    const int most = 2000;
    const CurvePieces outline(room.curve());
    const Range domain = room.knots().domain();
    Real nearest = 1e9;
    for (int i = 0; i < most; ++i) {
      const auto q = outline.at(domain.low + domain.width() * i / most);
      const Vec3 out = glm::normalize(Vec3(q[1].y, -q[1].x, 0));
      const NearestPoint p = closest_point(pin, to_local(pose, q[0]));
      const Vec3 d = to_world(pose, p.point) - q[0];
      if (glm::dot(d, out) > 0) nearest = std::min(nearest, glm::length(d));
    }
    std::vector<CurveContact> found(16);
    const std::size_t count = find_planar(pin, room, pose, {5, found});
    const bool overlaps = glm::length(pose.position) < 5 && count > 0 && found[0].gap < 0;
    INFO(n << ", " << count);
    if (overlaps || nearest > 4) continue;
    REQUIRE(count > 0);
    CHECK(std::abs(found[0].gap) <= nearest + 1e-9);
    for (std::size_t i = 0; i < count; ++i) {
      CHECK(found[i].least_curvature > 0);
      CHECK(glm::distance(found[i].on_a - found[i].on_b, found[i].gap * found[i].normal) < 1e-9);
      if (i > 0) CHECK(std::abs(found[i].gap) >= std::abs(found[i - 1].gap));
    }
  }
  // A pin between two walls touches both.
  const Curve slot =
      reversed(rounded_polygon(
                   std::vector<Vec3>{{-1, -0.1, 0}, {1, -0.1, 0}, {1, 0.1, 0}, {-1, 0.1, 0}}, 0.05)
                   .value());
  std::vector<CurveContact> found(8);
  REQUIRE(find_planar(Wire(circle({}, 0.09)), Wire(slot), Pose{{0.3, 0, 0}, kIdentity},
                      {0.05, found}) == 2);
  CHECK(found[0].gap == Approx(0.01).epsilon(1e-9));
  CHECK(found[0].normal.y * found[1].normal.y == Approx(-1));
}

TEST_CASE("a search of a curve over a face finds where they are nearest") {
  Random dice(12);
  const Skin ball = Skin::ellipsoid({0.5, 0.3, 0.4});
  for (int n = 0; n < 60; ++n) {
    const Wire ring(circle({}, 0.3));
    const Pose pose{dice.direction() * dice.between(0.9, 1.2),
                    from_rotation_vector(3.0 * dice.direction())};
    std::vector<CurveContact> found(8);
    const std::size_t count = find_on_face(ring, ball, pose, {2, found});
    Real nearest = 1e9;
    for (int i = 0; i < 720; ++i) {
      const Vec3 p = to_world(pose, evaluate(ring.curve(), i / 720.0, 0)[0]);
      for (const Face& face : ball.faces())
        nearest = std::min(nearest, closest_point(face, p).distance);
    }
    INFO(n << ", " << count);
    REQUIRE(count > 0);
    CHECK(found[0].gap <= nearest + 1e-9);
    CHECK(found[0].gap >= nearest - 1e-3);
  }
}

TEST_CASE("the first crossing of a curve is the one that all pairs of chords tell") {
  Random dice(13);
  int crossings = 0;
  for (int trial = 0; trial < 200; ++trial) {
    // Polygons, so that chords are sides; those of few points often cross themselves.
    std::vector<Vec3> at;
    const int count = 3 + dice.below(12);
    for (int i = 0; i < count; ++i) {
      const Real angle = 2 * kPi * (i + dice.between(0, 3)) / count;
      at.push_back(dice.between(0.5, 1) * Vec3(std::cos(angle), std::sin(angle), 0));
    }
    Curve polygon{uniform_knots(1, count + 1), {}};
    for (int i = 0; i <= count; ++i)
      polygon.points.emplace_back(at[static_cast<std::size_t>(i % count)], 1);
    polygon.knots.is_periodic = true;
    const auto is_cut = [&](int i, int k) {
      const auto point = [&](int j) { return at[static_cast<std::size_t>(j % count)]; };
      const auto side = [&](Vec3 a, Vec3 b, Vec3 p) {
        return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
      };
      const Vec3 a = point(i), b = point(i + 1), c = point(k), d = point(k + 1);
      return side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0;
    };
    std::optional<std::array<int, 2>> expected;
    for (int i = 0; i < count && !expected; ++i)
      for (int k = i + 2; k < count && !expected; ++k)
        if (!(i == 0 && k + 1 == count) && is_cut(i, k)) expected = {i, k};
    const auto found = crossing_of(polygon);
    REQUIRE(found.has_value() == expected.has_value());
    if (!found) continue;
    ++crossings;
    CHECK(static_cast<int>((*found)[0] * count) == (*expected)[0]);
    CHECK(static_cast<int>((*found)[1] * count) == (*expected)[1]);
  }
  CHECK(crossings > 20);
}
