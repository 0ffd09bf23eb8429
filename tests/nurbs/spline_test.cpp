// Curves and surfaces against the values of other packages, and against themselves on other knots.
#include "engine/nurbs/spline.hpp"

#include <catch2/catch.hpp>

#include "engine/nurbs/makers.hpp"
#include "tests/nurbs/data.hpp"
#include "tests/nurbs/samples.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

namespace {

constexpr Real kRelative = 1e-13;

// Difference relative to what is expected, or to 1 if that is less.
Real error_of(Vec3 found, const json& expected) {
  const Vec3 e = vector_of(expected);
  return glm::distance(found, e) / std::max(1.0, glm::length(e));
}

Curve curve_of(const json& j) {
  Curve curve{{j["degree"], j["knots"]}, {}};
  for (std::size_t i = 0; i < j["points"].size(); ++i)
    curve.points.push_back({vector_of(j["points"][i]), j["weights"][i]});
  return curve;
}

Real net_error(const std::vector<Weighted>& points, const json& expected) {
  if (points.size() != expected.size()) return 1e300;
  Real most = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const json& e = expected[i];
    const Weighted w = points[i] - Weighted(e[0], e[1], e[2], Real(e[3]));
    most = std::max({most, std::abs(w.x), std::abs(w.y), std::abs(w.z), std::abs(w.w)});
  }
  return most;
}

}  // namespace

TEST_CASE("curves and their derivatives are those of geomdl and splipy") {
  for (const json& j : nurbs_data()["curves"]) {
    const Curve curve = curve_of(j);
    for (std::size_t i = 0; i < j["at"].size(); ++i) {
      const CurveDerivatives d = evaluate(curve, j["at"][i]["t"], 3);
      for (std::size_t k = 0; k <= 3; ++k)
        CHECK(error_of(d[k], j["at"][i]["derivatives"][k]) < kRelative);
      for (std::size_t k = 0; k < 3; ++k) CHECK(error_of(d[k], j["splipy"][i][k]) < kRelative);
    }
  }
}

TEST_CASE("knots inserted and degrees raised give the control points of splipy") {
  for (const json& j : nurbs_data()["curves"]) {
    const Curve curve = curve_of(j);
    const Curve finer = with_knot(curve, j["with_knot"]["knot"], 1);
    CHECK(net_error(finer.points, j["with_knot"]["points"]) < kRelative);
    const Curve higher = elevated(curve);
    CHECK(net_error(higher.points, j["elevated"]["points"]) < kRelative);
    CHECK(higher.knots.values == j["elevated"]["knots"].get<std::vector<Real>>());
  }
}

TEST_CASE("surfaces and their derivatives to order 3 are those of geomdl") {
  for (const json& j : nurbs_data()["patches"]) {
    Surface s{{j["p"], j["U"]}, {j["q"], j["V"]}, {}};
    for (std::size_t i = 0; i < j["points"].size(); ++i)
      s.points.push_back({vector_of(j["points"][i]), j["weights"][i]});
    for (const json& at : j["at"]) {
      const SurfaceDerivatives d = evaluate(s, at["u"], at["v"], 3);
      for (std::size_t k = 0; k <= 3; ++k)
        for (std::size_t l = 0; k + l <= 3; ++l)
          CHECK(error_of(d[k][l], at["derivatives"][k][l]) < kRelative);
    }
  }
}

TEST_CASE("surfaces are those of the method's vectors, which 50 digits confirmed") {
  for (const json& j : nurbs_data()["nurbs_eval"]) {
    const SurfaceDerivatives d = evaluate(surface_of(j["surface"]), j["u"], j["v"], 3);
    for (const auto& [key, expected] : j["derivs"].items()) {
      const auto k = static_cast<std::size_t>(key[0] - '0'),
                 l = static_cast<std::size_t>(key[1] - '0');
      CHECK(error_of(d[k][l], expected) < kRelative);
    }
  }
}

TEST_CASE("basis functions add up to 1 and their derivatives to 0, on any knots") {
  Random dice(3);
  for (int degree = 1; degree <= 12; ++degree)
    for (const bool is_open : {false, true}) {
      const Knots knots =
          is_open ? open_knots(degree, degree + 6, dice) : random_knots(degree, degree + 6, dice);
      for (int i = 0; i <= 20; ++i) {
        const Real t = knots.low() + knots.domain().width() * i / 20;
        Basis basis;
        write_basis(knots, {knots.span_at(t), t}, 3, basis);
        for (std::size_t k = 0; k <= 3; ++k) {
          Real sum = 0, size = 1;
          for (int j = 0; j <= degree; ++j) {
            sum += basis[k][static_cast<std::size_t>(j)];
            size = std::max(size, std::abs(basis[k][static_cast<std::size_t>(j)]));
            if (k == 0) CHECK(basis[k][static_cast<std::size_t>(j)] >= 0);
          }
          CHECK(std::abs(sum - (k == 0 ? 1 : 0)) < 1e-14 * size);
        }
      }
    }
}

TEST_CASE("derivatives are what differences tend to") {
  Random dice(4);
  for (int degree = 2; degree <= 7; ++degree) {
    const Surface s = random_surface(degree, 2 + degree % 3, degree + 3, 6, dice);
    const Real u = dice.between(0.1, 0.9), v = dice.between(0.1, 0.9), h = 1e-5;
    const Cell cell{s.u.span_at(u), s.v.span_at(v)};
    const auto at = [&](Real du, Real dv) {
      return evaluate_on(s, cell, {u + du, v + dv}, 3);  // of one polynomial, past its knots too
    };
    const SurfaceDerivatives d = at(0, 0), right = at(h, 0), left = at(-h, 0), up = at(0, h),
                             down = at(0, -h);
    for (std::size_t k = 0; k <= 2; ++k)
      for (std::size_t l = 0; k + l <= 2; ++l) {
        const Vec3 by_u = (right[k][l] - left[k][l]) / (2 * h),
                   by_v = (up[k][l] - down[k][l]) / (2 * h);
        CHECK(glm::distance(by_u, d[k + 1][l]) < 2e-5 * (1 + glm::length(d[k + 1][l])));
        CHECK(glm::distance(by_v, d[k][l + 1]) < 2e-5 * (1 + glm::length(d[k][l + 1])));
      }
  }
}

TEST_CASE("affine maps of control points are affine maps of the surface") {
  Random dice(5);
  for (int trial = 0; trial < 20; ++trial) {
    const Surface s = random_surface(3, 2, 6, 5, dice);
    const Pose pose{dice.in_cube(3), dice.orientation()};
    const Surface moved = transformed(s, affine_of(pose));
    const Real u = dice.between(0, 1), v = dice.between(0, 1);
    const SurfaceDerivatives a = evaluate(s, u, v, 1), b = evaluate(moved, u, v, 1);
    CHECK(glm::distance(to_world(pose, a[0][0]), b[0][0]) < 2e-14);
    CHECK(glm::distance(pose.rotation * a[1][0], b[1][0]) < 1e-13 * (1 + glm::length(b[1][0])));
  }
}

TEST_CASE("knots inserted, degrees raised, parts and pieces leave a curve where it is") {
  Random dice(6);
  for (int degree = 1; degree <= 8; ++degree)
    for (const bool is_open : {false, true}) {
      Curve curve = random_curve(degree, degree + 5, dice);
      if (is_open) curve.knots = open_knots(degree, degree + 5, dice);
      const Range range = curve.knots.domain();
      const Real t = range.low + range.width() * dice.between(0.2, 0.8);
      const Curve finer = with_knot(curve, t, degree);
      CHECK(finer.points.size() == curve.points.size() + static_cast<std::size_t>(degree));
      CHECK(largest_difference(curve, finer) < 2e-14);
      CHECK(largest_difference(curve, elevated(curve)) < 5e-14);
      CHECK(elevated(curve).knots.degree == degree + 1);
      CHECK(largest_difference(curve, part_of(curve, {range.low, t})) < 2e-14);
      CHECK(largest_difference(curve, part_of(curve, {t, range.high})) < 2e-14);
      for (const Curve& piece : bezier_pieces(curve)) {
        CHECK(piece.points.size() == static_cast<std::size_t>(degree + 1));
        CHECK(largest_difference(curve, piece) < 2e-14);
      }
    }
}

TEST_CASE("so do they with a surface, along both ways") {
  Random dice(7);
  for (int trial = 0; trial < 10; ++trial) {
    const Surface s = random_surface(1 + trial % 4, 1 + trial % 3, 7, 6, dice);
    for (const Along way : {Along::u, Along::v}) {
      CHECK(largest_difference(s, with_knot(s, way, dice.between(0.1, 0.9), 1)) < 2e-14);
      CHECK(largest_difference(s, elevated(s, way)) < 3e-14);
      CHECK(largest_difference(s, part_of(s, way, {0.3, 0.7})) < 2e-14);
    }
    std::size_t pieces = 0;
    for (const Surface& piece : bezier_pieces(s)) {
      CHECK(largest_difference(s, piece) < 2e-14);
      ++pieces;
    }
    CHECK(pieces == s.u.spans().size() * s.v.spans().size());
    const Curve line = isoline(s, Along::u, 0.37);
    CHECK(glm::distance(evaluate(line, 0.61, 0)[0], evaluate(s, 0.37, 0.61, 0)[0][0]) < 1e-14);
  }
}

TEST_CASE("a periodic curve whose knots run on takes knots anywhere, its seam too") {
  std::vector<Vec3> points;
  for (int i = 0; i < 9; ++i)
    points.push_back(
        {std::cos(0.7 * i), std::sin(0.7 * i) * (1 + 0.1 * (i % 3)), 0.05 * i * (8 - i)});
  for (int degree = 1; degree <= 5; ++degree) {
    const Curve ring = interpolated(points, degree, Ends::periodic).value();
    const Range range = ring.knots.domain();
    for (const Real share : {0.0, 0.01, 0.3, 0.5, 0.99}) {
      if (degree == 1 && share == 0) continue;  // there already, as often as may be
      const Curve finer = with_knot(ring, range.low + share * range.width(), 1);
      CHECK(finer.points.size() == ring.points.size() + 1);
      CHECK(finer.knots.low() == Approx(range.low).margin(1e-15));
      CHECK(finer.knots.high() == Approx(range.high));
      CHECK(largest_difference(ring, finer) < 1e-14);
      // What closes it is still there: the first control points again at the end.
      for (std::size_t i = 0; i < static_cast<std::size_t>(degree); ++i) {
        const Weighted off =
            finer.points[i] -
            finer.points[finer.points.size() - static_cast<std::size_t>(degree) + i];
        CHECK(glm::length(off.product()) + std::abs(off.w) < 1e-13);
      }
    }
  }
}

TEST_CASE("a periodic parameter goes around, another stays at its end") {
  const Curve ring = circle({}, 2);
  const auto at = [&](Real t) { return evaluate(ring, t, 0)[0]; };
  CHECK(glm::distance(at(0.3), at(-2.7)) < 1e-14);
  CHECK(glm::distance(at(0.3), at(5.3)) < 1e-14);
  const Curve rod = line({0, 0, 0}, {1, 0, 0});
  CHECK(evaluate(rod, 1.5, 0)[0].x == 1);
  CHECK(evaluate(rod, -3, 0)[0].x == 0);
}

TEST_CASE("the ball of the control points is around the surface") {
  Random dice(8);
  for (int trial = 0; trial < 20; ++trial) {
    const Surface s = random_surface(3, 3, 5, 5, dice);
    const Ball ball = bounding_ball(s.points);
    for (int i = 0; i < 100; ++i) {
      const Real u = dice.between(0, 1), v = dice.between(0, 1);
      CHECK(glm::distance(evaluate(s, u, v, 0)[0][0], ball.centre) <= ball.radius);
    }
  }
}
