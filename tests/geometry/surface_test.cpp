// Hulls, meshes and height fields: what is made of points, and what is refused.
#include "engine/geometry/surface.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "engine/geometry/shape.hpp"
#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::detail;
using test::Random;

namespace {

using Triangle = std::array<std::uint32_t, 3>;

const std::vector<Vec3> kCube{{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                              {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
const std::vector<Triangle> kCubeSides{{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5},
                                       {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                       {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};

template <class T>
bool complains(const Result<T>& result, const std::string& part) {
  if (result) return false;
  return std::any_of(result.errors().begin(), result.errors().end(), [&](const Error& e) {
    return e.message.find(part) != std::string::npos && e.message.find('\n') == std::string::npos;
  });
}

}  // namespace

TEST_CASE("the hull of a grid of points is a cube of whole faces, turned or not") {
  Random dice(3);
  for (int rotation = 0; rotation < 20; ++rotation) {
    std::vector<Vec3> points;
    const Quat q = rotation == 0 ? kIdentity : dice.orientation();
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j)
        for (int k = 0; k < 5; ++k)
          points.push_back(q * (0.1 * Vec3(i, j, k)) + Vec3(3, -2, rotation));
    const auto hull = make_hull(points);
    REQUIRE(hull);
    CHECK((*hull)->points.size() == 8);
    CHECK((*hull)->faces.size() == 6);
    CHECK((*hull)->edges.size() == 12);
    CHECK(volume({ShapeKind::hull, {}, {}, 0, *hull}) == Approx(0.064).epsilon(1e-12));
  }
}

TEST_CASE("a hull has all points on its inner side, whole edges and Euler's number of faces") {
  Random dice(5);
  for (int count : {4, 5, 8, 30, 120, 400}) {
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i)
      points.push_back(dice.orientation() * Vec3(dice.between(0.2, 1), 0, 0));
    const auto made = make_hull(points);
    REQUIRE(made);
    const Surface& hull = **made;
    CHECK(hull.points.size() + hull.faces.size() == hull.edges.size() + 2);
    for (const Face& f : hull.faces) {
      CHECK(glm::length(f.normal) == Approx(1).epsilon(1e-14));
      for (Vec3 p : points) CHECK(glm::dot(f.normal, p) <= f.offset + 1e-9);
    }
    for (const auto& side : hull.sides) CHECK(side[0] != side[1]);
  }
}

TEST_CASE("hulls without volume, with too few points or wrong numbers are refused") {
  CHECK(complains(make_hull(std::vector<Vec3>(3)), "expected at least 4"));
  CHECK(complains(make_hull(std::vector<Vec3>(9, Vec3(1, 2, 3))), "no volume"));
  std::vector<Vec3> flat;
  for (int i = 0; i < 9; ++i) flat.push_back({i % 3, 0.5 * i, i * i % 5});
  for (Vec3& p : flat) p.z = p.x + 2 * p.y;
  CHECK(complains(make_hull(flat), "no volume"));
  for (const Real length : {3e4, 99992.0, 1e6, 1e8}) {
    INFO(length);
    const std::vector<Vec3> needle = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 1, length}};
    const auto made = make_hull(needle);
    if (!made) CHECK((complains(made, "too thin") || complains(made, "no volume")));
  }
  CHECK(complains(make_hull(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 1, 99992}}),
                  "too thin"));
  std::vector<Vec3> wrong = kCube;
  wrong[3].y = std::numeric_limits<Real>::quiet_NaN();
  CHECK(complains(make_hull(wrong), "point 3"));
  Random dice(7);
  std::vector<Vec3> ball;
  for (int i = 0; i < 600; ++i) ball.push_back(dice.orientation() * Vec3(1, 0, 0));
  CHECK(complains(make_hull(ball), "at most 256"));
}

TEST_CASE("meshes that are open, twisted, flat or inside out are refused by name") {
  CHECK(make_mesh(kCube, kCubeSides));
  std::vector<Triangle> t = kCubeSides;
  t.pop_back();
  CHECK(complains(make_mesh(kCube, t), "mesh is not closed"));
  t = kCubeSides;
  std::swap(t[4][0], t[4][1]);
  CHECK(complains(make_mesh(kCube, t), "has the wrong orientation"));
  t = kCubeSides;
  t.push_back(t[0]);
  CHECK(complains(make_mesh(kCube, t), "belongs to 3 triangles"));
  t = kCubeSides;
  t[5][2] = 8;
  CHECK(complains(make_mesh(kCube, t), "triangle 5 names point 8, expected one below 8"));
  t = kCubeSides;
  t[7] = {2, 7, 7};
  CHECK(complains(make_mesh(kCube, t), "triangle 7 has no area"));
  t = kCubeSides;
  for (Triangle& each : t) std::swap(each[0], each[1]);
  CHECK(complains(make_mesh(kCube, t), "mesh is inside out"));
  std::vector<Vec3> wrong = kCube;
  wrong[2].x = std::numeric_limits<Real>::infinity();
  CHECK(complains(make_mesh(wrong, kCubeSides), "point 2"));
  CHECK(complains(make_mesh({}, {}), "no triangles"));
}

TEST_CASE("neighbours of triangles share the edge they are named for") {
  const auto mesh = make_mesh(kCube, kCubeSides);
  const std::vector<Real> heights(12, 0.5);
  const auto field = make_height_field({4, 3, 1, 2, heights});
  REQUIRE(mesh);
  REQUIRE(field);
  int rim = 0;
  for (const auto& [surface, count] : {std::pair{*mesh, 12u}, std::pair{*field, 12u}})
    for (std::uint32_t i = 0; i < count; ++i)
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t other = neighbour_of(*surface, i, e);
        if (other == UINT32_MAX) {
          ++rim;
          continue;
        }
        const auto mine = triangle_of(*surface, i), its = triangle_of(*surface, other);
        int shared = 0;
        for (std::uint32_t f = 0; f < 3; ++f)
          shared += its[f] == mine[(e + 1) % 3] && its[(f + 1) % 3] == mine[e];
        CHECK(shared == 1);
      }
  CHECK(rim == 10);
}

TEST_CASE("wrong height fields are refused") {
  const std::vector<Real> four(4, 0.0);
  CHECK(make_height_field({2, 2, 1, 1, four}));
  CHECK(complains(make_height_field({1, 4, 1, 1, four}), "at least 2 of each"));
  CHECK(complains(make_height_field({2, 3, 1, 1, four}), "expected columns times rows, 6"));
  CHECK(complains(make_height_field({2, 2, 0, 1, four}), "above 0"));
  CHECK(complains(make_height_field({2, 2, 1, 1, std::vector<Real>{0, 0, NAN, 0}}), "height 2"));
}

TEST_CASE("hull and mesh of a box weigh what the box weighs") {
  const Pose aside{{0.3, -1, 2}, glm::normalize(Quat(0.3, 0.5, -0.2, 0.7))};
  std::vector<Vec3> points = kCube;
  for (Vec3& p : points) p = p * Vec3(0.3, 0.5, 0.2) + Vec3(0.4, 0.1, -0.3);
  const Pose placed{to_world(aside, {0.4, 0.1, -0.3}), aside.rotation};
  const MassProperties want = mass_properties({ShapeKind::box, {0.3, 0.5, 0.2}, placed, 0}, 700);
  for (const Shape& shape :
       {Shape{ShapeKind::hull, {}, aside, 0, *make_hull(points)},
        Shape{ShapeKind::mesh, {}, aside, 0, *make_mesh(points, kCubeSides)}}) {
    const MassProperties got = mass_properties(shape, 700);
    CHECK(got.mass == Approx(want.mass).epsilon(1e-13));
    CHECK(glm::distance(got.centre, want.centre) < 1e-14);
    for (int i = 0; i < 3; ++i) CHECK(glm::distance(got.inertia[i], want.inertia[i]) < 1e-12);
  }
  CHECK(mass_properties({ShapeKind::plane, {10, 0, 0}, {}, 0}, 700).mass == 0);
}
