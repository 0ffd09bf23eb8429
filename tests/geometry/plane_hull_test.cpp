#include "engine/geometry/plane_hull.hpp"

#include <catch2/catch.hpp>
#include <random>

using namespace pantin;
using namespace pantin::detail;

namespace {

/// Of b beyond the line from a to c, by the length of that.
Real turn(Vec3 a, Vec3 b, Vec3 c) { return glm::cross(b - a, c - a).z; }

}  // namespace

TEST_CASE("plane_hull: no point lies outside, and no corner on a straight side") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<Real> some(-1, 1);
  for (int round = 0; round < 200; ++round) {
    std::vector<Vec3> points;
    for (int i = 0; i < 3 + round; ++i)
      // Every other round on a coarse grid: many points in a line, and many twice.
      points.push_back(round % 2
                           ? Vec3(std::round(3 * some(random)), std::round(3 * some(random)), 0)
                           : Vec3(some(random), some(random), 0));
    const std::vector<Vec3> hull = plane_hull(points);
    INFO("round " << round);
    if (hull.size() < 3) continue;
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const Vec3 a = hull[i], b = hull[(i + 1) % hull.size()], c = hull[(i + 2) % hull.size()];
      CHECK(turn(a, b, c) > 0);
      CHECK(std::find(points.begin(), points.end(), a) != points.end());
      for (const Vec3& p : points) CHECK(turn(a, b, p) >= -1e-12);
    }
  }
}

TEST_CASE("plane_hull: points that are one to rounding are one corner") {
  const Vec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<Vec3> points;
  for (const Vec3& p : corners)
    for (const Real off : {0.0, 1e-16, -1e-16, 3e-16})
      points.insert(points.end(),
                    {p + Vec3(off, 0, 0), p + Vec3(0, off, 0), p + Vec3(off, off, 0)});
  const std::vector<Vec3> hull = plane_hull(points);
  REQUIRE(hull.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(glm::distance(hull[i], corners[i]) < 1e-15);
}

TEST_CASE("plane_hull: a tip stays, however sharp, and a line has none") {
  CHECK(plane_hull({{-0.1, 1e9, 0}, {0.1, -0.1, 0}, {0.1, 0.1, 0}, {-0.1, 0.1, 0}}).size() == 4);
  CHECK(plane_hull({{0, 0, 0}, {1e12, 1, 0}, {0, 2, 0}}).size() == 3);
  CHECK(plane_hull({{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {0.5, 0.5, 0}}).empty());
  CHECK(plane_hull({{0, 1, 0}, {1e-17, 0, 0}, {2e-17, 0.5, 0}, {3e-17, 0.7, 0}}).empty());
  CHECK(plane_hull({{1, 1, 0}, {1, 1, 0}, {1, 1, 0}}).empty());
  CHECK(plane_hull({{1, 2, 0}}).empty());
  CHECK(plane_hull({}).empty());
}
