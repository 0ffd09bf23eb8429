// Where two solids touch: exact places for each pair of kinds, agreement between ways to describe
// one solid, and a reference by brute force.
#include "engine/geometry/collide.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/base/rotation.hpp"
#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::detail;
using test::Random;

namespace {

using Points = std::vector<ContactPoint>;
using Triangle = std::array<std::uint32_t, 3>;

const Shape kPlane{ShapeKind::plane, {10, 0, 0}, {}, 0};

Shape ball(Real r) { return {ShapeKind::sphere, {r, 0, 0}, {}, 0}; }
Shape rod(Real r, Real half) { return {ShapeKind::capsule, {r, half, 0}, {}, 0}; }
Shape box(Vec3 half) { return {ShapeKind::box, half, {}, 0}; }

std::vector<Vec3> corners(Vec3 half) {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i)
    points.push_back(half * Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  return points;
}

Shape hull(Vec3 half) { return {ShapeKind::hull, {}, {}, 0, *make_hull(corners(half))}; }

Shape mesh(Vec3 half) {
  const std::vector<Triangle> sides{{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5},
                                    {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                    {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return {ShapeKind::mesh, {}, {}, 0, *make_mesh(corners(half), sides)};
}

Shape field(std::uint32_t columns, std::uint32_t rows, Real spacing, const auto& height) {
  std::vector<Real> heights;
  for (std::uint32_t r = 0; r < rows; ++r)
    for (std::uint32_t c = 0; c < columns; ++c)
      heights.push_back(
          height((c - (columns - 1) / 2.0) * spacing, (r - (rows - 1) / 2.0) * spacing));
  return {ShapeKind::height_field,
          {},
          {},
          0,
          *make_height_field({columns, rows, spacing, spacing, heights})};
}

Points touching(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b, Real margin) {
  NarrowPhaseScratch room;
  Points out;
  collide({a, at_a}, {b, at_b}, room, {margin, out});
  return out;
}

Pose at(Vec3 position) { return {position, kIdentity}; }
Pose lying(Vec3 position) {
  return {position, from_rotation_vector({0, 0, kPi / 2})};
}  // rods along x

Real least(const Points& points) {
  Real gap = 1e300;
  for (const ContactPoint& p : points) gap = std::min(gap, p.gap);
  return gap;
}

bool sound(const Points& points) {
  return std::all_of(points.begin(), points.end(), [](const ContactPoint& p) {
    return is_finite(p.on_a) && is_finite(p.on_b) && std::abs(glm::length(p.normal) - 1) < 1e-12 &&
           std::abs(glm::dot(p.normal, p.on_a - p.on_b) - p.gap) < 1e-9;
  });
}

bool all_along(const Points& points, Vec3 normal, Real within = 1e-12) {
  return std::all_of(points.begin(), points.end(), [&](const ContactPoint& p) {
    return glm::distance(p.normal, normal) < within;
  });
}

/// A ball of triangles with hills and hollows, about 1 m across.
Shape rough_stone(Random& dice) {
  constexpr std::uint32_t kAround = 12, kRings = 7;
  std::vector<Vec3> points{{0, 0.6, 0}, {0, -0.6, 0}};
  std::vector<Triangle> triangles;
  const auto at_ring = [](std::uint32_t ring, std::uint32_t i) {
    return 2 + ring * kAround + i % kAround;
  };
  for (std::uint32_t r = 0; r < kRings; ++r)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const Real up = kPi * (0.5 - (r + 1.0) / (kRings + 1)), about = 2 * kPi * i / kAround;
      points.push_back(dice.between(0.45, 0.65) * Vec3(std::cos(up) * std::cos(about), std::sin(up),
                                                       -std::cos(up) * std::sin(about)));
    }
  for (std::uint32_t i = 0; i < kAround; ++i) {
    triangles.push_back({0, at_ring(0, i), at_ring(0, i + 1)});
    triangles.push_back({1, at_ring(kRings - 1, i + 1), at_ring(kRings - 1, i)});
    for (std::uint32_t r = 0; r + 1 < kRings; ++r) {
      triangles.push_back({at_ring(r, i), at_ring(r + 1, i), at_ring(r + 1, i + 1)});
      triangles.push_back({at_ring(r, i), at_ring(r + 1, i + 1), at_ring(r, i + 1)});
    }
  }
  return {ShapeKind::mesh, {}, {}, 0, *make_mesh(points, triangles)};
}

}  // namespace

TEST_CASE("each kind touches a plane with all of its corners that are near enough") {
  const Points one = touching(ball(0.3), at({1, 0.5, 2}), kPlane, {}, 1);
  REQUIRE(one.size() == 1);
  CHECK(std::abs(one[0].gap - 0.2) < 1e-15);
  CHECK(glm::distance(one[0].on_a, Vec3(1, 0.2, 2)) < 1e-15);
  CHECK(glm::distance(one[0].on_b, Vec3(1, 0, 2)) < 1e-15);
  CHECK(touching(ball(0.3), at({0, 0.5, 0}), kPlane, {}, 0.1).empty());

  CHECK(touching(rod(0.1, 0.4), lying({0, 0.1, 0}), kPlane, {}, 0.01).size() == 2);
  CHECK(touching(rod(0.1, 0.4), at({0, 0.5, 0}), kPlane, {}, 0.01).size() == 1);
  CHECK(touching(box({1, 2, 3}), at({0, 1.9, 0}), kPlane, {}, 0.01).size() == 4);
  CHECK(touching(hull({1, 2, 3}), at({0, 1.9, 0}), kPlane, {}, 10).size() == 8);
  for (const ContactPoint& p : touching(box({1, 2, 3}), at({0, 1.9, 0}), kPlane, {}, 0.01)) {
    CHECK(std::abs(p.gap + 0.1) < 1e-15);
    CHECK(std::abs(std::abs(p.on_a.x) - 1) + std::abs(std::abs(p.on_a.z) - 3) < 1e-14);
  }
}

TEST_CASE("a rod touches a box with two points along a face and one across an edge") {
  const Shape block = box({1, 1, 1});
  const Points along = touching(rod(0.1, 0.5), lying({0, 1.1, 0}), block, {}, 0.01);
  REQUIRE(along.size() == 2);
  CHECK(all_along(along, {0, 1, 0}));
  CHECK(std::abs(along[0].gap) < 1e-15);
  // Beyond the face only its end counts.
  const Points over = touching(rod(0.1, 0.5), lying({1.2, 1.05, 0}), block, {}, 0.01);
  REQUIRE(over.size() == 2);
  CHECK(std::max(over[0].on_b.x, over[1].on_b.x) == Approx(1));
  // Across an edge, seen from between its faces: the edge turned up.
  const Pose ridge{{0, 0, 0}, from_rotation_vector({0, 0, kPi / 4})};
  const Points across =
      touching(rod(0.1, 0.5), lying({0, std::sqrt(2.0) + 0.08, 0}), block, ridge, 0.01);
  REQUIRE(across.size() == 1);
  CHECK(std::abs(across[0].gap + 0.02) < 1e-14);
  CHECK(glm::distance(across[0].normal, Vec3(0, 1, 0)) < 1e-12);
  // Along that edge there are two.
  const Pose forward{{0, std::sqrt(2.0) + 0.1, 0}, from_rotation_vector({kPi / 2, 0, 0})};
  CHECK(touching(rod(0.1, 0.5), forward, block, ridge, 0.01).size() == 2);
  // A corner, from the outside along the diagonal.
  const Vec3 way = glm::normalize(Vec3(1, 1, 1));
  const Points corner = touching(ball(0.2), at(Vec3(1, 1, 1) + 0.3 * way), block, {}, 1);
  REQUIRE(corner.size() == 1);
  CHECK(std::abs(corner[0].gap - 0.1) < 1e-15);
  CHECK(glm::distance(corner[0].normal, way) < 1e-14);
}

TEST_CASE("rods touch once where they cross and twice side by side") {
  const Points crossed = touching(rod(0.1, 1), lying({0, 0.25, 0}), rod(0.1, 1),
                                  {{0, 0, 0}, from_rotation_vector({kPi / 2, 0, 0})}, 0.1);
  REQUIRE(crossed.size() == 1);
  CHECK(std::abs(crossed[0].gap - 0.05) < 1e-15);
  const Points beside = touching(rod(0.1, 1), at({0.25, 0.5, 0}), rod(0.1, 1), {}, 0.1);
  REQUIRE(beside.size() == 2);
  CHECK(all_along(beside, {1, 0, 0}));
  CHECK(std::abs(beside[0].on_a.y - beside[1].on_a.y) == Approx(1.5));
}

TEST_CASE("boxes touch with the corners of what their faces share, and once where edges cross") {
  const Shape block = box({1, 0.5, 1});
  const Points stacked = touching(box({0.5, 0.5, 0.5}), at({0.8, 0.99, 0}), block, {}, 0.01);
  REQUIRE(stacked.size() == 4);
  CHECK(all_along(stacked, {0, 1, 0}));
  for (const ContactPoint& p : stacked) {
    CHECK(p.gap == Approx(-0.01));
    CHECK((std::abs(p.on_a.x - 0.3) < 1e-12 || std::abs(p.on_a.x - 1) < 1e-12));
  }
  // A square turned by 45 degrees on another shares an octagon.
  const Points eight = touching(box({1, 1, 1}), {{0, 2, 0}, from_rotation_vector({0, kPi / 4, 0})},
                                box({1, 1, 1}), {}, 0.01);
  CHECK(eight.size() == 8);
  // Two ridges at right angles to each other.
  const Real high = std::sqrt(2.0);
  for (Real gap : {0.3, 0.001, -0.001, -0.02}) {
    const Points ridges =
        touching(box({1, 1, 1}), {{0, 2 * high + gap, 0}, from_rotation_vector({kPi / 4, 0, 0})},
                 box({1, 1, 1}), {{0, 0, 0}, from_rotation_vector({0, 0, kPi / 4})}, gap + 1e-4);
    REQUIRE(ridges.size() == 1);
    CHECK(ridges[0].gap == Approx(gap));
    CHECK(glm::distance(ridges[0].normal, Vec3(0, 1, 0)) < 1e-12);
    CHECK(glm::length(ridges[0].on_b - Vec3(0, high, 0)) < 1e-9);
  }
}

TEST_CASE(
    "a board that lies askew on the edge of a block touches it where the edge enters and leaves") {
  const Shape block = box({1, 0.5, 1}), board = box({0.0475, 0.03, 0.125});
  for (const Real roll : {-0.01, 0.0, 0.01})
    for (const Real depth : {0.003, 0.006}) {
      const Quat turn = from_rotation_vector({0.15, 0, 0}) * from_rotation_vector({0, 1.3, 0}) *
                        from_rotation_vector({0, 0, roll});
      const Vec3 up = turn * Vec3(0, 1, 0);
      const Pose on_edge{Vec3(0, 0.5, 1) + (0.03 - depth) * up, turn};
      const Points points = touching(board, on_edge, block, {}, 0);
      Real low = 1, high = -1;
      for (const ContactPoint& p : points)
        low = std::min(low, p.on_a.x), high = std::max(high, p.on_a.x);
      INFO(roll << " " << depth << " " << points.size());
      CHECK(points.size() >= 2);
      CHECK(high - low > 0.15);
    }
}

TEST_CASE("a hull that is a box touches as the box does") {
  Random dice(17);
  const Vec3 half(0.3, 0.5, 0.2);
  const Shape other = box({0.4, 0.25, 0.6});
  for (int i = 0; i < 400; ++i) {
    const Pose here{dice.in_cube(0.8), dice.orientation()},
        there{dice.in_cube(0.3), dice.orientation()};
    const Points as_box = touching(other, here, box(half), there, 0.2);
    const Points as_hull = touching(other, here, hull(half), there, 0.2);
    CHECK(as_box.size() == as_hull.size());
    CHECK((as_box.empty() || std::abs(least(as_box) - least(as_hull)) < 1e-9));
  }
}

TEST_CASE("a mesh that is a box pushes as the box does") {
  Random dice(17);
  const Vec3 half(0.6, 0.4, 0.5);
  int seen = 0, off = 0;
  for (const Shape& a :
       {ball(0.1), rod(0.05, 0.15), box({0.1, 0.15, 0.05}), hull({0.1, 0.15, 0.05})})
    for (int i = 0; i < 1500; ++i) {
      const Pose here{dice.in_cube(0.9), dice.orientation()},
          there{dice.in_cube(0.1), dice.orientation()};
      const Points want = touching(a, here, box(half), there, 0.05);
      const Points got = touching(a, here, mesh(half), there, 0.05);
      CHECK(sound(got));
      CHECK(got.size() <= 16);
      CHECK(want.empty() == got.empty());
      if (want.empty()) continue;
      // Deep inside a mesh counts the middle, so only shallow touches agree in depth.
      if (least(want) < -0.04) {
        CHECK(least(got) < -0.02);
        continue;
      }
      ++seen;
      off += std::abs(least(got) - least(want)) > 0.03 * std::abs(least(want)) + 1e-6;
    }
  CHECK(seen > 500);
  // A limit: a triangle knows its neighbours but not theirs, so at a corner of the mesh an overlap
  // of edges may be left by a longer way than the shortest.
  CHECK(off <= 2);
}

TEST_CASE("distances agree with a search over all directions that can part two solids") {
  // Of faces, pairs of edges, pairs of corners and corners over edges one keeps two cores farthest
  // apart; that is their distance, or the least overlap.
  Random dice(17);
  ConvexScratch room_a, room_b;
  const auto apart = [](const Convex& a, const Convex& b) {
    Real best = -1e300;
    const auto consider = [&](Vec3 n) {
      const Real length = glm::length(n);
      if (length < 1e-9) return;
      n /= length;
      best = std::max(best,
                      glm::dot(n, a.points[a.farthest(-n)]) - glm::dot(n, b.points[b.farthest(n)]));
    };
    const auto edge = [](const Convex& c, const auto& e) {
      return c.points[e[1]] - c.points[e[0]];
    };
    const auto square = [](Vec3 w, Vec3 d) { return w - glm::dot(w, d) / glm::dot(d, d) * d; };
    for (const Face& f : b.faces) consider(f.normal);
    for (const Face& f : a.faces) consider(-f.normal);
    for (const auto& e : a.edges)
      for (const auto& f : b.edges)
        for (Real way : {1.0, -1.0}) consider(way * glm::cross(edge(a, e), edge(b, f)));
    for (Vec3 p : a.points)
      for (Vec3 q : b.points) consider(p - q);
    for (Vec3 p : a.points)
      for (const auto& f : b.edges) consider(square(p - b.points[f[0]], edge(b, f)));
    for (Vec3 q : b.points)
      for (const auto& e : a.edges) consider(square(a.points[e[0]] - q, edge(a, e)));
    return best;
  };
  std::vector<Vec3> cloud;
  for (int i = 0; i < 20; ++i)
    cloud.push_back(dice.orientation() * Vec3(dice.between(0.4, 0.5), 0, 0));
  const Shape stone{ShapeKind::hull, {}, {}, 0, *make_hull(cloud)};
  const std::vector<Shape> kinds{ball(0.2), rod(0.1, 0.4), box({0.2, 0.4, 0.3}), stone};
  for (const Shape& a : kinds)
    for (const Shape& b : kinds)
      for (int i = 0; i < 300; ++i) {
        Pose here{dice.in_cube(1), dice.orientation()};
        const Pose there{dice.in_cube(0.3), i % 4 ? dice.orientation() : here.rotation};
        const Points got = touching(a, here, b, there, 10);
        const Convex ca = convex_piece(a, here, room_a), cb = convex_piece(b, there, room_b);
        const Real core = apart(ca, cb), want = core - ca.radius - cb.radius;
        REQUIRE(!got.empty());
        CHECK(sound(got));
        CHECK(got.size() <= 8);
        const bool faceless = ca.faces.empty() && cb.faces.empty();
        if (core > 1e-6)
          CHECK(std::abs(least(got) - want) < 1e-8);
        else if (!faceless)
          CHECK(std::abs(least(got) - want) < 0.011 * std::abs(core) + 1e-6);
      }
}

TEST_CASE("touching does not depend on where the world's origin is") {
  Random dice(17);
  const std::vector<Shape> kinds{ball(0.2), rod(0.1, 0.4), box({0.2, 0.4, 0.3}),
                                 hull({0.2, 0.3, 0.4}), mesh({0.3, 0.3, 0.3})};
  for (std::size_t i = 0; i < 4; ++i)
    for (const Shape& b : kinds)
      for (int round = 0; round < 30; ++round) {
        const Pose here{dice.in_cube(0.6), dice.orientation()},
            there{dice.in_cube(0.2), dice.orientation()};
        const Pose moved{dice.in_cube(5), dice.orientation()};
        const Points one = touching(kinds[i], here, b, there, 0.1);
        const Points two = touching(kinds[i], compose(moved, here), b, compose(moved, there), 0.1);
        REQUIRE(one.size() == two.size());
        for (std::size_t p = 0; p < one.size(); ++p) {
          CHECK(one[p].feature == two[p].feature);
          CHECK(std::abs(one[p].gap - two[p].gap) < 1e-9);
          CHECK(glm::distance(to_world(moved, one[p].on_a), two[p].on_a) < 1e-6);
        }
      }
}

TEST_CASE("nothing degenerate gives numbers that are not finite") {
  const std::vector<Shape> kinds{ball(0.2),          ball(0),
                                 rod(0.1, 0),        rod(0.1, 0.4),
                                 rod(0, 0.4),        box({0.2, 0.4, 0.3}),
                                 box({0.2, 0, 0.3}), hull({0.2, 0.3, 0.4})};
  const std::vector<Shape> surfaces{kPlane, mesh({0.3, 0.3, 0.3}),
                                    field(4, 4, 0.5, [](Real, Real) { return 0.0; })};
  for (const Shape& a : kinds)
    for (const Vec3 place :
         {Vec3(0), Vec3(0.2, 0, 0), Vec3(0, 0.4, 0), Vec3(0, 0.7, 0), Vec3(0.4, 0.8, 0.6),
          Vec3(0, 1e-12, 0), Vec3(0.3, 0.3, 0.3), Vec3(0, -0.4, 0)})
      for (const Quat& rotation : {kIdentity, from_rotation_vector({0, 0, kPi / 2}),
                                   from_rotation_vector({0.3, 0.2, 0.1})}) {
        for (const Shape& b : kinds) CHECK(sound(touching(a, {place, rotation}, b, {}, 0.3)));
        for (const Shape& b : surfaces) CHECK(sound(touching(a, {place, rotation}, b, {}, 0.3)));
      }
  const Points same = touching(ball(0.2), {}, ball(0.3), {}, 0);
  REQUIRE(same.size() == 1);
  CHECK(same[0].gap == Approx(-0.5));
  CHECK(std::abs(touching(box(Vec3(0.5)), at({0, 1, 0}), box(Vec3(0.5)), {}, 0.1)[0].gap) < 1e-15);
}

TEST_CASE("what slides over flat ground of triangles is only ever pushed up") {
  Random dice(17);
  const Shape ground = field(21, 21, 0.25, [](Real, Real) { return 0.0; });
  const std::vector<Shape> kinds{ball(0.1), rod(0.1, 0.3), box({0.3, 0.1, 0.2}),
                                 hull({0.3, 0.1, 0.2})};
  for (const Shape& a : kinds)
    for (int i = 0; i < 300; ++i) {
      const Vec3 place(dice.between(-2, 2), dice.between(0.08, 0.12), dice.between(-2, 2));
      const Quat rotation =
          from_rotation_vector({0, dice.between(-3, 3), 0}) *
          (a.kind == ShapeKind::capsule ? from_rotation_vector({0, 0, kPi / 2}) : kIdentity);
      const Points got = touching(a, {place, rotation}, ground, {}, 0.05);
      CHECK(all_along(got, {0, 1, 0}));
      REQUIRE(!got.empty());
      CHECK(std::abs(least(got) - (place.y - 0.1)) < 1e-9);
      // As many as the plane has.
      CHECK(got.size() >= touching(a, {place, rotation}, kPlane, {}, 0.05).size());
    }
}

TEST_CASE("a tilted ground of triangles holds as a tilted plane does") {
  Random dice(17);
  const Real slope = 0.3;
  const Shape ground = field(21, 21, 0.25, [&](Real x, Real) { return slope * x; });
  const Pose tilt{{0, 0, 0}, from_rotation_vector({0, 0, std::atan(slope)})};
  for (const Shape& a : {ball(0.1), rod(0.1, 0.3), box({0.3, 0.1, 0.2}), hull({0.3, 0.1, 0.2})})
    for (int i = 0; i < 300; ++i) {
      const Pose here{to_world(tilt, {dice.between(-1.5, 1.5), dice.between(0.05, 0.3),
                                      dice.between(-1.5, 1.5)}),
                      dice.orientation()};
      const Points want = touching(a, here, kPlane, tilt, 0.03);
      const Points got = touching(a, here, ground, {}, 0.03);
      CHECK(want.empty() == got.empty());
      CHECK(all_along(got, tilt.rotation * Vec3(0, 1, 0), 1e-6));
      if (!want.empty()) CHECK(std::abs(least(got) - least(want)) < 1e-6);
    }
}

TEST_CASE("a body below a height field is pushed up, one within a mesh out") {
  const Shape ground = field(9, 9, 0.5, [](Real x, Real z) { return 0.1 * std::sin(3 * x + z); });
  for (const Shape& a : {ball(0.1), rod(0.1, 0.3), box({0.3, 0.1, 0.2}), hull({0.3, 0.1, 0.2})}) {
    const Points deep = touching(a, at({0.3, -3, 0.4}), ground, {}, 0.1);
    REQUIRE(!deep.empty());
    CHECK(least(deep) < -2.5);
    for (const ContactPoint& p : deep) CHECK(p.normal.y > 0.8);
    const Points within = touching(a, at({0.2, 0.9, 0.1}), mesh(Vec3(2)), {}, 0.1);
    REQUIRE(!within.empty());
    CHECK(all_along(within, {0, 1, 0}));
    CHECK(least(within) < -1.1);
  }
  CHECK(touching(ball(0.1), at({0.3, 5, 0.4}), ground, {}, 0.1).empty());
  CHECK(touching(ball(0.1), at({9, 0, 0.4}), ground, {}, 0.1).empty());
}

/// Whether a point lies below a height field or within a mesh: an upward ray meets its triangles an
/// odd number of times.
bool is_inside(const Surface& surface, std::uint32_t triangles, Vec3 point) {
  bool inside = false;
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const auto corner = triangle_of(surface, t);
    // Seen from above: areas of the triangles that the point makes with the sides.
    Real area[3], whole = 0, height = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 p = corner[(i + 1) % 3] - point, q = corner[(i + 2) % 3] - point;
      area[i] = p.z * q.x - p.x * q.z, whole += area[i];
    }
    for (std::size_t i = 0; i < 3; ++i) height += area[i] / whole * corner[i].y;
    const bool met = (area[0] > 0) == (area[1] > 0) && (area[1] > 0) == (area[2] > 0);
    if (met && height > point.y) inside = !inside;
  }
  return inside;
}

TEST_CASE("over rough surfaces the nearest point is found, with a normal along the shortest way") {
  Random dice(17);
  const Shape hills = field(13, 13, 0.3, [&](Real, Real) { return dice.between(-0.15, 0.15); });
  const Shape stone = rough_stone(dice);
  ConvexScratch room;
  for (const Shape& a : {ball(0.1), rod(0.06, 0.2), box({0.2, 0.1, 0.15}), hull({0.1, 0.2, 0.15})})
    for (const Shape& b : {hills, stone}) {
      const bool ground = b.kind == ShapeKind::height_field;
      const std::uint32_t count =
          ground ? 2 * 12 * 12 : static_cast<std::uint32_t>(b.surface->faces.size());
      int seen = 0;
      for (int i = 0; i < 400; ++i) {
        const Vec3 out = dice.orientation() * Vec3(dice.between(0.6, 1.4), 0, 0);
        const Vec3 over(dice.between(-1.2, 1.2), dice.between(0, 0.5), dice.between(-1.2, 1.2));
        const Pose here{ground ? over : out, dice.orientation()};
        const Convex piece = convex_piece(a, here, room);
        Nearest want;
        want.distance = 1e300;
        for (std::uint32_t t = 0; t < count; ++t) {
          const auto corner = triangle_of(*b.surface, t);
          const Convex tile{corner, {}, {}, {}, {}, 0, (corner[0] + corner[1] + corner[2]) / 3.0,
                            1};
          const Nearest n = nearest(piece, tile, 10);
          if (n.state == Nearest::State::overlap) want.distance = 0;
          if (n.distance < want.distance) want = n;
        }
        if (want.distance < 1e-6 || want.distance - piece.radius > 0.1) continue;
        if (is_inside(*b.surface, count, here.position)) continue;  // the shortest way leads out
        ++seen;
        const Points got = touching(a, here, b, {}, 0.1);
        CHECK(sound(got));
        REQUIRE(!got.empty());
        CHECK(std::abs(least(got) - (want.distance - piece.radius)) < 1e-7);
        const auto best = std::min_element(
            got.begin(), got.end(), [](const auto& p, const auto& q) { return p.gap < q.gap; });
        CHECK(glm::dot(best->normal, want.normal) > 1 - 1e-6);
      }
      CHECK(seen > 40);
    }
}

TEST_CASE("features keep their numbers while a body slides") {
  const Shape block = box({1, 0.5, 1});
  const auto keys = [&](Real x, const Shape& b) {
    std::vector<std::uint64_t> all;
    for (const ContactPoint& p : touching(box(Vec3(0.2)), at({x, 0.7, 0.1}), b, {}, 0.01))
      all.push_back(p.feature);
    std::sort(all.begin(), all.end());
    CHECK(std::unique(all.begin(), all.end()) == all.end());
    return all;
  };
  for (const Shape& b : {block, mesh({1, 0.5, 1})}) CHECK(keys(0.31, b) == keys(0.32, b));
}
