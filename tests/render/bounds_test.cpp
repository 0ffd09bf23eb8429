#include "engine/render/bounds.hpp"

#include <catch2/catch.hpp>

#include "engine/base/rotation.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

Real length_of(const std::vector<Vec3>& points) {
  Real sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += glm::length(points[i] - points[i - 1]);
  return sum;
}

}  // namespace

TEST_CASE("a taut string is a straight line of two points") {
  std::vector<Vec3> points;
  add_curve({{0, 1, 0}, {0.3, 0, 0.2}, 1.0, {0, -1, 0}}, 24, points);
  REQUIRE(points.size() == 2);
  CHECK(points[0] == Vec3(0, 1, 0));
  CHECK(points[1] == Vec3(0.3, 0, 0.2));
}

TEST_CASE("a slack string hangs down and keeps its length, whichever way its ends lie") {
  const Vec3 ends[][2] = {{{0, 1, 0}, {1, 1, 0}},
                          {{0, 2, 0}, {0.01, 1, 0}},
                          {{0, 2, 0}, {0, 1, 0}},
                          {{0, 1, 0}, {0, 1, 0}},
                          {{-3, 5, 2}, {4, 1, -1}}};
  for (const auto& e : ends) {
    for (Real factor : {1.001, 1.1, 2.0, 5.0}) {
      const Real length = std::max(glm::length(e[1] - e[0]), 0.5) * factor;
      std::vector<Vec3> points;
      add_curve({e[0], e[1], length, {0, -1, 0}}, 24, points);
      REQUIRE(points.size() == 25);
      CHECK(length_of(points) == Approx(length).epsilon(1e-3));
      CHECK(glm::length(points.front() - e[0]) < 1e-12);
      CHECK(glm::length(points.back() - e[1]) < 1e-12);
      CHECK(points[12].y < (e[0].y + e[1].y) / 2);
    }
  }
}

TEST_CASE("balls enclose the shape they stand for") {
  const Pose pose{{1, 2, 3}, from_rotation_vector({0.3, -0.2, 0.9})};
  std::vector<Ball> balls;
  add_balls({ShapeKind::sphere, {0.3, 0, 0}, {{0, 1, 0}, kIdentity}, 0}, pose, balls);
  REQUIRE(balls.size() == 1);
  CHECK(glm::length(balls[0].centre - to_world(pose, {0, 1, 0})) < 1e-12);
  CHECK(balls[0].radius == 0.3);
  balls.clear();
  add_balls({ShapeKind::capsule, {0.1, 0.5, 0}, {}, 0}, pose, balls);
  REQUIRE(balls.size() == 2);
  CHECK(glm::length(balls[0].centre - balls[1].centre) == Approx(1.0));
  balls.clear();
  add_balls({ShapeKind::box, {0.1, 0.2, 0.3}, {}, 0}, pose, balls);
  REQUIRE(balls.size() == 8);
  for (const Ball& b : balls)
    CHECK(glm::length(b.centre - pose.position) == Approx(std::sqrt(0.14)));
}

TEST_CASE("down is where gravity points, and -y without gravity") {
  World world;
  world.gravity = {3, 0, 4};
  CHECK(glm::length(down_of(world) - Vec3{0.6, 0, 0.8}) < 1e-12);
  world.gravity = Vec3{0};
  CHECK(down_of(world) == Vec3(0, -1, 0));
}
