// Nearest points against dense samples and closed forms. A million queries: soak/closest_soak.cpp
#include "engine/nurbs/closest.hpp"

#include <catch2/catch.hpp>

#include "engine/nurbs/makers.hpp"
#include "tests/nurbs/dense.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::detail::nurbs;
using namespace pantin::test;

TEST_CASE("ten thousand nearest points are those of dense samples") {
  const Tally tally = ask_around(100, 100, 1);
  CHECK(tally.unexplained == 0);
  CHECK(tally.uncertain == 0);
  CHECK(tally.brute_missed < 20);  // its samples are too far apart
  CHECK(tally.at_creases < 1000);
  CHECK(tally.looks < 100u * static_cast<unsigned>(tally.queries));
  INFO(tally.looks);
  CHECK(tally.queries == 10000);
}

TEST_CASE("nearest points of a sphere, a torus and a plate are those of the equations") {
  Random dice(3);
  const Face ball(sphere({}, 1.5)), ring(torus({}, 2, 0.6)), plate(plane({}, 2, 2));
  for (int i = 0; i < 300; ++i) {
    const Vec3 p = dice.in_cube(3);
    CHECK(closest_point(ball, p).distance == Approx(std::abs(glm::length(p) - 1.5)).margin(1e-13));
    const Real across = std::hypot(std::hypot(p.x, p.y) - 2, p.z);
    CHECK(closest_point(ring, p).distance == Approx(std::abs(across - 0.6)).margin(1e-13));
    const Vec3 out(std::max(std::abs(p.x) - 1, 0.0), std::max(std::abs(p.y) - 1, 0.0), p.z);
    const NearestPoint on = closest_point(plate, p);
    CHECK(on.distance == Approx(glm::length(out)).margin(1e-13));
    CHECK(on.is_on_edge == (out.x > 0 || out.y > 0));
  }
}

TEST_CASE("where all places are as near as one another, the answer says that it is not certain") {
  const Face ball(sphere({}, 1.5));
  const NearestPoint centre = closest_point(ball, Vec3(0));
  CHECK(centre.distance == Approx(1.5).epsilon(1e-14));
  CHECK_FALSE(centre.is_certain);
  // On the pole u means nothing, yet the distance is right.
  CHECK(closest_point(ball, {0, 0, 1.5}).distance < 1e-12);
  CHECK(closest_point(ball, {0, 0, 4}).distance == Approx(2.5).epsilon(1e-13));
}

TEST_CASE("nearest points of curves are those of dense samples") {
  Random dice(4);
  for (int trial = 0; trial < 60; ++trial) {
    const Curve curve = random_curve(1 + trial % 5, 8, dice);
    const Wire wire(curve);
    for (int i = 0; i < 50; ++i) {
      const Vec3 p = dice.in_cube(1.5);
      const NearestPoint found = closest_point(wire, p);
      Real least = 1e300, farthest = 0;
      for (int k = 0; k <= 2000; ++k)
        least = std::min(least, glm::distance(evaluate(curve, k / 2000.0, 0)[0], p));
      CHECK(found.is_certain);
      CHECK(found.distance <= least + 1e-14);
      for (int k = 0; k < 2000; ++k)
        farthest = std::max(farthest, glm::distance(evaluate(curve, k / 2000.0, 0)[0],
                                                    evaluate(curve, (k + 1) / 2000.0, 0)[0]));
      CHECK(found.distance > least - farthest);
      CHECK(glm::distance(evaluate(curve, found.u, 0)[0], p) == Approx(found.distance));
    }
  }
}

TEST_CASE("curves of absurd weights are searched, and the answer says that it is not certain") {
  Random dice(5);
  int uncertain = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Curve curve = random_curve(2 + trial % 3, 6, dice);
    Weighted& one = curve.points[static_cast<std::size_t>(trial) % curve.points.size()];
    const Real weight = std::pow(10.0, dice.between(-200, 200));
    one = Weighted(one.point(), weight);
    const Wire wire(curve);
    for (int i = 0; i < 5; ++i) {
      const NearestPoint found = closest_point(wire, dice.in_cube(1.5));
      uncertain += !found.is_certain;
      CHECK((!found.is_certain || found.distance >= 0));
    }
  }
  CHECK(uncertain > 0);
}
