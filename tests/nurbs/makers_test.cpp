// Curves and surfaces by name lie where their equations say.
#include "engine/nurbs/makers.hpp"

#include <catch2/catch.hpp>

#include "engine/nurbs/check.hpp"
#include "engine/nurbs/closest.hpp"
#include "tests/nurbs/data.hpp"
#include "tests/nurbs/samples.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

namespace {

constexpr int kLooks = 64;

// The largest |f| over the surface.
template <class F>
Real most_over(const Surface& s, F&& f) {
  Real most = 0;
  for (int i = 0; i <= kLooks; ++i)
    for (int j = 0; j <= kLooks; ++j) {
      const Real u = s.u.low() + s.u.domain().width() * i / kLooks;
      const Real v = s.v.low() + s.v.domain().width() * j / kLooks;
      most = std::max(most, std::abs(f(evaluate(s, u, v, 0)[0][0])));
    }
  return most;
}

// Whether u x v points away from a place all over, poles left out.
bool looks_away_from(const Surface& s, Vec3 from) {
  for (int i = 1; i < 20; ++i)
    for (int j = 1; j < 20; ++j) {
      const SurfaceDerivatives d = evaluate(s, s.u.low() + s.u.domain().width() * i / 20,
                                            s.v.low() + s.v.domain().width() * j / 20, 1);
      if (glm::dot(glm::cross(d[1][0], d[0][1]), d[0][0] - from) <= 0) return false;
    }
  return true;
}

Frame tilted() {
  const Mat3 r = glm::mat3_cast(glm::normalize(Quat(0.3, 0.5, -0.2, 0.8)));
  return {Vec3(0.4, -0.7, 1.1), r[0], r[1], r[2]};
}

}  // namespace

TEST_CASE("circles, arcs and ellipses are round to the last digits") {
  for (const Real radius : {1.0, 0.37, 250.0}) {
    const Curve ring = circle({}, radius);
    Real most = 0;
    for (int i = 0; i <= 1000; ++i)
      most = std::max(most, std::abs(glm::length(evaluate(ring, i / 1000.0, 0)[0]) / radius - 1));
    CHECK(most <= 1e-15);
  }
  for (const Range angles : {Range{0, 1}, Range{-2, 1.5}, Range{0.3, 6.2}, Range{1, 1 + kPi / 2}}) {
    const Curve bow = arc({}, 2, angles);
    CHECK(bow.knots.is_periodic == false);
    for (int i = 0; i <= 200; ++i)
      CHECK(std::abs(glm::length(evaluate(bow, i / 200.0, 0)[0]) / 2 - 1) < 1e-15);
    const Vec3 first = evaluate(bow, 0, 0)[0], last = evaluate(bow, 1, 0)[0];
    CHECK(glm::distance(first, 2.0 * Vec3(std::cos(angles.low), std::sin(angles.low), 0)) < 1e-15);
    CHECK(glm::distance(last, 2.0 * Vec3(std::cos(angles.high), std::sin(angles.high), 0)) < 2e-15);
  }
  const Frame at = tilted();
  const Curve oval = ellipse(at, 3, 0.5);
  for (int i = 0; i <= 200; ++i) {
    const Vec3 arm = evaluate(oval, i / 200.0, 0)[0] - at.origin;
    const Real x = glm::dot(arm, at.x) / 3, y = glm::dot(arm, at.y) / 0.5;
    CHECK(std::abs(x * x + y * y - 1) < 5e-15);
    CHECK(std::abs(glm::dot(arm, at.z)) < 1e-15);
  }
}

TEST_CASE("a circle's seam is smooth to order 1 and its curvature is everywhere 1 / r") {
  const Curve ring = circle({}, 0.5);
  for (int i = 0; i < 400; ++i) {
    const CurveDerivatives d = evaluate(ring, i / 400.0, 2);
    const Real speed = glm::length(d[1]);
    CHECK(glm::length(glm::cross(d[1], d[2])) / (speed * speed * speed) ==
          Approx(2).epsilon(1e-13));
  }
  const CurveDerivatives begin = evaluate_on(ring, 2, 0, 1),
                         end = evaluate_on(ring, ring.knots.span_at(1), 1, 1);
  CHECK(glm::distance(begin[0], end[0]) == 0);
  CHECK(glm::distance(begin[1], end[1]) < 1e-14);
}

TEST_CASE("surfaces satisfy their equations, and look outwards") {
  const Frame at = tilted();
  const auto local = [&](Vec3 p) {
    const Vec3 d = p - at.origin;
    return Vec3(glm::dot(d, at.x), glm::dot(d, at.y), glm::dot(d, at.z));
  };
  const Surface floor = plane(at, 2, 3), tube = cylinder(at, 0.7, 2), hat = cone(at, {1, 0.25}, 3);
  const Surface ball = sphere(at, 1.5), egg = ellipsoid(at, {1, 2, 0.5}), ring = torus(at, 2, 0.6);
  CHECK(most_over(floor, [&](Vec3 p) { return local(p).z; }) < 1e-15);
  CHECK(most_over(tube, [&](Vec3 p) {
          const Vec3 d = local(p);
          return std::hypot(d.x, d.y) / 0.7 - 1;
        }) < 2e-15);
  CHECK(most_over(hat, [&](Vec3 p) {
          const Vec3 d = local(p);
          return std::hypot(d.x, d.y) - (1 - 0.25 * d.z);
        }) < 2e-15);
  CHECK(most_over(ball, [&](Vec3 p) { return glm::length(local(p)) / 1.5 - 1; }) < 1e-15);
  CHECK(most_over(egg, [&](Vec3 p) { return glm::length(local(p) / Vec3(1, 2, 0.5)) - 1; }) <
        2e-15);
  CHECK(most_over(ring, [&](Vec3 p) {
          const Vec3 d = local(p);
          return std::hypot(std::hypot(d.x, d.y) - 2, d.z) / 0.6 - 1;
        }) < 3e-15);
  for (const Surface* s : {&ball, &egg}) CHECK(looks_away_from(*s, at.origin));
  CHECK(looks_away_from(tube, at.origin + at.z));
  CHECK(looks_away_from(hat, at.origin + 0.5 * at.z));
  CHECK(looks_away_from(floor, at.origin - at.z));
  const SurfaceDerivatives d = evaluate(ring, 0, 0, 1);
  CHECK(glm::dot(glm::cross(d[1][0], d[0][1]), at.x) > 0);
  for (const Surface* s : {&floor, &tube, &hat, &ball, &egg, &ring})
    CHECK(errors_of(*s, "s").empty());
}

TEST_CASE("sphere and torus have the control points of the method's vectors") {
  const Surface ball = sphere({}, 1.5), ring = torus({}, 2, 0.6);
  for (const auto& [made, name] : {std::pair(&ball, "sphere"), std::pair(&ring, "torus")}) {
    const Surface expected = surface_of(name);
    CHECK(made->u.values == expected.u.values);
    CHECK(made->v.values == expected.v.values);
    REQUIRE(made->points.size() == expected.points.size());
    for (std::size_t i = 0; i < expected.points.size(); ++i) {
      CHECK(glm::distance(made->points[i].point(), expected.points[i].point()) < 2e-15);
      CHECK(std::abs(made->points[i].w - expected.points[i].w) < 1e-15);
    }
  }
}

TEST_CASE("the six charts of an ellipsoid lie on it, overlap, and have no pole") {
  const Vec3 half(1, 0.7, 0.5);
  const auto six = charts(half);
  for (const Surface& s : six) {
    CHECK(most_over(s, [&](Vec3 p) { return glm::length(p / half) - 1; }) < 1e-15);
    CHECK(looks_away_from(s, Vec3(0)));
    CHECK(flaws_of(s, "chart").empty());
  }
  Random dice(2);
  Real farthest = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = half * dice.direction();
    const ChartPoint at = chart_point(half, p);
    const Surface& s = six[static_cast<std::size_t>(at.chart)];
    CHECK(glm::distance(evaluate(s, at.u, at.v, 0)[0][0], p) < 1e-15);
    farthest = std::max({farthest, std::abs(at.u), std::abs(at.v)});
  }
  CHECK(farthest < 0.8 * kChartReach);
}

TEST_CASE("extrusions and sweeps are sums of their curves, turning makes circles") {
  Random dice(3);
  const Curve section = random_curve(3, 6, dice), path = random_curve(2, 5, dice);
  const Surface wall = extruded(section, {0, 0, 2}), tube = swept(section, path);
  const Surface vase = revolved(section, {}, 2);
  for (int i = 0; i < 100; ++i) {
    const Real u = dice.between(0, 1), v = dice.between(0, 1);
    const Vec3 s = evaluate(section, v, 0)[0], p = evaluate(path, u, 0)[0];
    CHECK(glm::distance(evaluate(wall, v, u, 0)[0][0], s + Vec3(0, 0, 2 * u)) < 1e-14);
    CHECK(glm::distance(evaluate(tube, u, v, 0)[0][0], s + p) < 1e-14);
    const Vec3 turned = evaluate(vase, u, v, 0)[0][0];
    CHECK(std::abs(std::hypot(turned.x, turned.y) - std::hypot(s.x, s.y)) < 1e-14);
    CHECK(std::abs(turned.z - s.z) < 1e-14);
  }
  const Vec3 end = evaluate(vase, 1, 0.3, 0)[0][0], from = evaluate(section, 0.3, 0)[0];
  const Vec3 by(from.x * std::cos(2.0) - from.y * std::sin(2.0),
                from.x * std::sin(2.0) + from.y * std::cos(2.0), from.z);
  CHECK(glm::distance(end, by) < 1e-14);
}

TEST_CASE("a sweep that turns carries its section across the path, at its stations exactly") {
  const Curve path{uniform_knots(3, 6),
                   {{Vec3(0, 0, 0), 1},
                    {Vec3(1, 0, 1), 1},
                    {Vec3(2, 1, 1), 1},
                    {Vec3(3, 2, 0), 1},
                    {Vec3(4, 2, 1), 1},
                    {Vec3(5, 1, 2), 1}}};
  const Real radius = 0.2;
  Real worst[2] = {};
  for (int round = 0; round < 2; ++round) {
    const int stations = round == 0 ? 9 : 33;
    const Surface pipe = swept_turning(circle({}, radius), path, stations);
    for (int i = 0; i < stations; ++i) {
      const Real t = i / (stations - 1.0);
      const CurveDerivatives p = evaluate(path, t, 1);
      for (int j = 0; j < 8; ++j) {
        const Vec3 arm = evaluate(pipe, t, j / 8.0, 0)[0][0] - p[0];
        CHECK(glm::length(arm) == Approx(radius).epsilon(1e-12));
        CHECK(std::abs(glm::dot(arm, glm::normalize(p[1]))) < 1e-13);
      }
    }
    for (int i = 0; i <= 200; ++i) {
      const Vec3 arm = evaluate(pipe, i / 200.0, 0.1, 0)[0][0] - evaluate(path, i / 200.0, 0)[0];
      worst[round] = std::max(worst[round], std::abs(glm::length(arm) / radius - 1));
    }
  }
  CHECK(worst[1] < worst[0] / 8);  // and between them soon
}

TEST_CASE("interpolation goes through its points, open, periodic and as a surface") {
  Random dice(4);
  for (int degree = 1; degree <= 5; ++degree)
    for (const Ends ends : {Ends::open, Ends::periodic}) {
      std::vector<Vec3> points;
      for (int i = 0; i < 12; ++i) points.push_back(dice.in_cube(1));
      const auto made = interpolated(points, degree, ends);
      REQUIRE(made);
      CHECK(errors_of(*made, "curve").empty());
      const Wire wire(*made);
      for (Vec3 p : points) CHECK(closest_point(wire, p).distance < 1e-13);
    }
  std::vector<Vec3> grid;
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 6; ++j) grid.push_back(Vec3(i, j, 0) + dice.in_cube(0.3));
  const auto sheet = interpolated(PointGrid{grid, 6}, {3, 2});
  REQUIRE(sheet);
  CHECK(errors_of(*sheet, "sheet").empty());
  const Face face(*sheet);
  for (Vec3 p : grid) CHECK(closest_point(face, p).distance < 1e-13);
}

TEST_CASE("interpolation tells what it cannot go through") {
  const std::vector<Vec3> twice{{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const auto doubled = interpolated(twice, 3, Ends::open);
  REQUIRE_FALSE(doubled);
  CHECK(doubled.errors()[0].message ==
        "points 1 and 2: found a distance of 0.000000, expected points that are apart and finite");
  const auto few = interpolated(std::span(twice).first(2), 3, Ends::open);
  REQUIRE_FALSE(few);
  CHECK(few.errors()[0].message == "found 2 points, expected at least 4 for degree 3");
  const auto ragged = interpolated(PointGrid{twice, 3}, {1, 1});
  REQUIRE_FALSE(ragged);
  CHECK(ragged.errors()[0].message == "found 4 points in rows of 3, expected whole rows");
}

TEST_CASE("a closed curve goes through all of 20,000 points, and a long one of degree 25") {
  // A full matrix would take 3.2 GB.
  for (const auto& [count, degree, ends] :
       {std::tuple{20000, 3, Ends::periodic}, {20001, 4, Ends::periodic}, {3000, 25, Ends::open}}) {
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
      const Real t = (ends == Ends::open ? 1.5 : 2) * kPi * i / count;
      points.emplace_back(std::cos(t), std::sin(t), 0.1 * std::sin(5 * t));
    }
    const Curve curve = interpolated(points, degree, ends).value();
    Real whole = 0, at = 0, most = 0;
    for (int i = 0; i < count; ++i)
      if (i + 1 < count || ends == Ends::periodic)
        whole += glm::distance(points[static_cast<std::size_t>(i)],
                               points[static_cast<std::size_t>((i + 1) % count)]);
    for (int i = 0; i < count; ++i) {
      const Vec3 here = points[static_cast<std::size_t>(i)];
      if (i > 0) at += glm::distance(points[static_cast<std::size_t>(i - 1)], here);
      const Real t = std::min(at / whole, 1.0);
      most = std::max(most, glm::distance(evaluate(curve, t, 0)[0], here));
      if (i % 100 == 0) {
        const Real between = std::min(t + 0.5 / count, 1.0);
        const Vec3 p = evaluate(curve, between, 0)[0];
        CHECK(std::abs(std::hypot(p.x, p.y) - 1) < 1e-9);
      }
    }
    INFO("degree " << degree);
    CHECK(most < 1e-12);
  }
}
