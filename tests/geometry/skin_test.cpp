// NURBS skins as shapes: what they weigh, where rays and bodies meet them, against closed forms.
#include <catch2/catch.hpp>
#include <ctime>
#include <iostream>
#include <random>

#include "engine/geometry/collide.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/geometry/sweep.hpp"
#include "engine/nurbs/makers.hpp"
#include "tests/geometry/creased.hpp"

using namespace pantin;
using namespace pantin::detail;

using pantin::test::Found;

namespace {

Shape shape_of(nurbs::Skin skin) {
  Shape shape;
  shape.kind = ShapeKind::nurbs;
  shape.surface = *make_skin(std::make_shared<nurbs::Skin>(std::move(skin)));
  return shape;
}
Shape shape_of(nurbs::Surface face) { return shape_of(nurbs::Skin({std::move(face)}, 1e-9)); }

Shape plain(ShapeKind kind, Vec3 size) {
  Shape shape;
  shape.kind = kind, shape.size = size;
  return shape;
}

const Shape& ball() {
  static const Shape shape = shape_of(nurbs::sphere({}, 0.5));
  return shape;
}
const Shape& ring() {
  static const Shape shape = shape_of(nurbs::torus({}, 0.5, 0.2));
  return shape;
}
/// A sheet 2 by 2 m about the origin, z = (x^2 + y^2) / 2, its outer side up.
Shape bowl() {
  nurbs::Surface s;
  s.u = s.v = {2, {-1, -1, -1, 1, 1, 1}};
  const Real square[3] = {1, -1, 1};  // the blossom of t^2 on [-1, 1]
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      s.points.push_back({Vec3(i - 1, j - 1, (square[i] + square[j]) / 2), 1});
  return shape_of(std::move(s));
}

/// Uniform numbers from a fixed start.
struct Dice {
  std::mt19937_64 engine{7};
  Real operator()(Real low, Real high) {
    return low + (high - low) * static_cast<Real>(engine() >> 11) * 0x1p-53;
  }
  Vec3 in_cube(Real half) {
    return {(*this)(-half, half), (*this)(-half, half), (*this)(-half, half)};
  }
  Quat turn() {
    const Vec3 v = in_cube(1);
    return glm::normalize(Quat((*this)(-1, 1), v));
  }
};

/// Distance from a torus about z, and the outward normal there.
struct Far {
  Real distance;
  Vec3 normal;
};
Far from_ring(Vec3 p) {
  const Real out = std::hypot(p.x, p.y);
  const Vec3 middle = out > 0 ? Vec3(p.x, p.y, 0) * (0.5 / out) : Vec3(0.5, 0, 0);
  const Real apart = glm::distance(p, middle);
  return {apart - 0.2, (p - middle) / apart};
}

}  // namespace

TEST_CASE("a closed skin weighs what its closed form does, an open one nothing", "[skin]") {
  const MassProperties m = mass_properties(ball(), 1000);
  const Real mass = 1000 * 4 * kPi / 3 * 0.125;
  CHECK(std::abs(m.mass - mass) < 1e-9 * mass);
  CHECK(glm::length(m.centre) < 1e-12);
  for (int k = 0; k < 3; ++k) CHECK(std::abs(m.inertia[k][k] - 0.1 * mass) < 1e-9 * mass);
  const MassProperties r = mass_properties(ring(), 1);
  const Real whole = 2 * kPi * kPi * 0.5 * 0.04;
  CHECK(std::abs(r.mass - whole) < 1e-9 * whole);
  CHECK(std::abs(r.inertia[2][2] - whole * (0.25 + 0.03)) < 1e-9 * whole);
  const MassProperties e = mass_properties(shape_of(nurbs::ellipsoid({}, {0.5, 0.3, 0.2})), 1);
  const Real own = 4 * kPi / 3 * 0.03;
  CHECK(std::abs(e.mass - own) < 1e-9 * own);
  CHECK(std::abs(e.inertia[0][0] - own * 0.13 / 5) < 1e-9 * own);
  CHECK(volume(bowl()) == 0);
  CHECK(is_convex(ball()));
  CHECK_FALSE(is_convex(ring()));
  CHECK_FALSE(is_convex(bowl()));
}

TEST_CASE("a skin that is inside out is an open one, and one read as another kind is refused",
          "[skin]") {
  for (const auto& inside :
       {nurbs::Skin(std::vector{nurbs::inside_out(nurbs::sphere({}, 0.5))}, 1e-9),
        nurbs::Skin::ellipsoid_cavity(Vec3(0.5))}) {
    const auto made = make_skin(std::make_shared<nurbs::Skin>(inside));
    REQUIRE(made);
    CHECK_FALSE((*made)->model->is_closed);
    CHECK_FALSE((*made)->model->is_convex);
    CHECK((*made)->model->enclosed.mass == 0);
  }
  Shape shape = ball();
  CHECK(shape.restored() == nullptr);
  shape.kind = ShapeKind::hull;
  CHECK(shape.restored() != nullptr);
  shape.kind = ShapeKind::nurbs, shape.surface = nullptr;
  CHECK(shape.restored() != nullptr);
}

TEST_CASE("bounds, rays and nearest points of skins agree with closed forms", "[skin]") {
  CHECK(glm::distance(ring().surface->low, {-0.7, -0.7, -0.2}) < 1e-12);
  CHECK(glm::distance(ring().surface->high, {0.7, 0.7, 0.2}) < 1e-12);
  Dice dice;
  const Shape same = plain(ShapeKind::sphere, {0.5, 0, 0});
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 from = 2.0 * glm::normalize(dice.in_cube(1)),
               way = glm::normalize(dice.in_cube(0.6) - from);
    const auto ours = cast(ball(), from, way, 10), exact = cast(same, from, way, 10);
    REQUIRE(bool(ours) == bool(exact));
    if (!ours) continue;
    ++hits;
    REQUIRE(std::abs(ours->distance - exact->distance) < 1e-9);
    REQUIRE(glm::distance(ours->normal, exact->normal) < 1e-7);
  }
  CHECK(hits > 800);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = dice.in_cube(0.9);
    const Far exact = from_ring(p);
    const auto near = closest(ring(), p, 10);
    REQUIRE(near);
    REQUIRE(std::abs(near->distance - exact.distance) < 1e-11);
    if (std::abs(exact.distance) > 1e-3 && std::hypot(p.x, p.y) > 1e-2 && exact.distance > -0.19)
      REQUIRE(glm::distance(near->normal, exact.normal) < 1e-7);
    REQUIRE(contains(ring(), p) == (exact.distance < 0));
  }
  // Through the hole nothing is met; from beside it the tube is, where the quartic says.
  CHECK_FALSE(cast(ring(), {0.1, 0.1, 3}, {0, 0, -1}, 10));
  const auto tube = cast(ring(), {0.5, 0, 3}, {0, 0, -1}, 10);
  REQUIRE(tube);
  CHECK(std::abs(tube->distance - 2.8) < 1e-10);
}

TEST_CASE("a convex skin touches as the shape that it is", "[skin]") {
  Dice dice;
  const Shape same = plain(ShapeKind::sphere, {0.5, 0, 0});
  const Shape others[] = {
      plain(ShapeKind::sphere, {0.3, 0, 0}), plain(ShapeKind::capsule, {0.2, 0.4, 0}),
      plain(ShapeKind::box, {0.3, 0.2, 0.4}), plain(ShapeKind::plane, {1, 0, 0})};
  Found ours, exact;
  Real worst = 0;
  int touched = 0;
  for (const Shape& other : others)
    for (int i = 0; i < 300; ++i) {
      const Pose at{glm::normalize(dice.in_cube(1)) * dice(0.55, 1.0), dice.turn()};
      const Pose turned{Vec3(0), dice.turn()};
      const ContactPoint* p = ours.touch({ball(), turned}, {other, at}, 0.05);
      const ContactPoint* q = exact.touch({same, turned}, {other, at}, 0.05);
      if (!q || q->gap < -0.1) continue;  // of deep overlaps several ways out are as good
      REQUIRE(p);
      ++touched;
      if (q->gap > -0.01) worst = std::max(worst, std::abs(p->gap - q->gap));
      // As for every smooth kind: deep overlaps are found to the polytope's accuracy.
      REQUIRE(std::abs(p->gap - q->gap) < (q->gap > -0.01 ? 5e-6 : 1e-4));
      REQUIRE(glm::distance(p->normal, q->normal) < 1e-4);
    }
  CHECK(touched > 200);
  std::cout << "convex skin against the sphere: gaps to " << worst << " m, " << touched
            << " contacts\n";
}

TEST_CASE("a ball in the hole of a torus touches it all round, or not at all", "[skin]") {
  Found found;
  const Shape small = plain(ShapeKind::sphere, {0.25, 0, 0}),
              fits = plain(ShapeKind::sphere, {0.29, 0, 0});
  CHECK_FALSE(found.touch({small, Pose{}}, {ring(), Pose{}}, 0.01));
  const ContactPoint* p = found.touch({fits, Pose{{0.02, 0, 0}}}, {ring(), Pose{}}, 0.01);
  REQUIRE(p);
  CHECK(std::abs(p->gap + 0.01) < 1e-12);
  CHECK(glm::distance(p->normal, {-1, 0, 0}) < 1e-9);
  Dice dice;
  Real worst = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pose ring_at{dice.in_cube(1), dice.turn()};
    const Vec3 local = dice.in_cube(0.8);
    const Far exact = from_ring(local);
    const Real gap = exact.distance - 0.1;
    p = found.touch({plain(ShapeKind::sphere, {0.1, 0, 0}), Pose{to_world(ring_at, local)}},
                    {ring(), ring_at}, 0.05);
    REQUIRE(bool(p) == (gap <= 0.05));
    if (!p) continue;
    REQUIRE(std::abs(p->gap - gap) < 1e-9);
    worst = std::max(worst, std::abs(p->gap - gap));
    if (exact.distance > -0.19)
      REQUIRE(glm::distance(p->normal, ring_at.rotation * exact.normal) < 1e-6);
  }
  std::cout << "ball against torus: gaps to " << worst << " m\n";
}

TEST_CASE("capsules, boxes and planes touch a torus where its closed form says", "[skin]") {
  Found found;
  // A bar through the hole, against the inner side of the tube.
  const Shape bar = plain(ShapeKind::capsule, {0.05, 0.6, 0});
  const Quat upright = glm::normalize(Quat(1, 1, 0, 0));  // its axis along z
  const ContactPoint* p =
      found.touch({bar, Pose{{0.255, 0, 0.2}, upright}}, {ring(), Pose{}}, 0.01);
  REQUIRE(p);
  CHECK(std::abs(p->gap + 0.005) < 1e-9);
  CHECK(glm::distance(p->normal, {-1, 0, 0}) < 1e-6);
  // A corner of a box from above, on the tube's top.
  const Shape box = plain(ShapeKind::box, {0.1, 0.1, 0.1});
  p = found.touch({box, Pose{{0.6, 0.1, 0.3 - 0.001}}}, {ring(), Pose{}}, 0.01);
  REQUIRE(p);
  const Far corner = from_ring({0.5, 0, 0.199});
  CHECK(p->gap <= corner.distance + 1e-9);
  CHECK(p->normal.z > 0.99);
  const auto all_face_the_ring = [&] {
    for (const ContactPoint& one : found.points)
      CHECK(glm::distance(one.normal, from_ring(one.on_b).normal) < 0.06);
  };
  all_face_the_ring();
  // Its face across the tube's top: the tube's highest places are within.
  p = found.touch({plain(ShapeKind::box, {0.3, 0.3, 0.1}), Pose{{0.5, 0, 0.295}}}, {ring(), Pose{}},
                  0.01);
  REQUIRE(p);
  CHECK(std::abs(p->gap + 0.005) < 1e-9);
  CHECK(glm::distance(p->normal, {0, 0, 1}) < 1e-6);
  CHECK(found.points.size() >= 3);
  all_face_the_ring();
  // An edge that cuts into its shoulder: the skin tells the way out, not the box's faces.
  p = found.touch({box, Pose{{0.73, 0, 0.23}}}, {ring(), Pose{}}, 0.01);
  REQUIRE(p);
  CHECK(std::abs(p->gap - from_ring({0.63, 0, 0.13}).distance) < 1e-9);
  all_face_the_ring();
  // Lying flat on a plane, it is held at three places at least, apart from one another.
  const Pose flat{{0, 0.199, 0}, glm::normalize(Quat(1, -1, 0, 0))};  // z up to y
  p = found.touch({ring(), flat}, {plain(ShapeKind::plane, {1, 0, 0}), Pose{}}, 0.01);
  REQUIRE(p);
  CHECK(std::abs(p->gap + 0.001) < 1e-9);
  CHECK(glm::distance(p->normal, {0, 1, 0}) < 1e-12);
  CHECK(found.points.size() >= 3);
  Real widest = 0;
  for (const ContactPoint& one : found.points)
    for (const ContactPoint& two : found.points)
      widest = std::max(widest, glm::distance(one.on_a, two.on_a));
  CHECK(widest > 0.8);
  // Two rings, one through the hole of the other, its tube 0.4 m from the other's middle.
  const Pose through{{0.4, 0, 0}, glm::normalize(Quat(1, 1, 0, 0))};
  p = found.touch({ring(), through}, {ring(), Pose{}}, 0.2);
  REQUIRE(p);
  CHECK(std::abs(p->gap) < 1e-12);
}

TEST_CASE("an open patch is touched from its outer side only", "[skin]") {
  const Shape dish = bowl(), small = plain(ShapeKind::sphere, {0.1, 0, 0});
  Found found;
  const ContactPoint* p = found.touch({small, Pose{{0, 0, 0.09}}}, {dish, Pose{}}, 0.02);
  REQUIRE(p);
  CHECK(std::abs(p->gap + 0.01) < 1e-12);
  CHECK(glm::distance(p->normal, {0, 0, 1}) < 1e-9);
  CHECK_FALSE(found.touch({small, Pose{{0, 0, -0.5}}}, {dish, Pose{}}, 0.02));
  CHECK_FALSE(found.touch({small, Pose{{1.5, 0, 0.5}}}, {dish, Pose{}}, 0.02));
}

TEST_CASE("what slides at a torus meets it where its closed form says", "[skin]") {
  const Shape small = plain(ShapeKind::sphere, {0.1, 0, 0});
  const auto hit = sweep({small, Pose{{0.5, 0, 2}}}, {ring(), Pose{}}, {0, 0, -1}, 5);
  REQUIRE(hit);
  CHECK(std::abs(hit->distance - 1.7) < 1e-8);
  CHECK_FALSE(sweep({small, Pose{{0, 0, 2}}}, {ring(), Pose{}}, {0, 0, -1}, 5));
}

namespace {

/// Of one pair, the least CPU time of nine rounds.
void tell_cost(const char* what, const PlacedShape& a, const PlacedShape& b, Real margin) {
  Found found;
  double least = 1e300;
  for (int round = 0; round < 9; ++round) {
    const std::clock_t start = std::clock();
    constexpr int kTimes = 100;
    for (int i = 0; i < kTimes; ++i) found.touch(a, b, margin);
    least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / kTimes);
  }
  std::cout << what << ": " << 1e6 * least << " us, " << found.points.size() << " points\n";
}

}  // namespace

TEST_CASE("skins: what contacts cost", "[.][skin_cost]") {
  const auto time = [](const char* what, const PlacedShape& a, const PlacedShape& b) {
    tell_cost(what, a, b, 0.02);
  };
  const Shape sphere = plain(ShapeKind::sphere, {0.1, 0, 0}),
              box = plain(ShapeKind::box, Vec3(0.1)),
              capsule = plain(ShapeKind::capsule, {0.1, 0.2, 0}),
              ground = plain(ShapeKind::plane, {1, 0, 0});
  const Pose near{{0.5, 0, 0.295}}, beside{{0.59, 0, 0}};
  time("ball on torus", {sphere, near}, {ring(), Pose{}});
  time("capsule on torus", {capsule, near}, {ring(), Pose{}});
  time("box on torus", {box, near}, {ring(), Pose{}});
  time("torus on plane", {ring(), Pose{{0, 0.699, 0}}}, {ground, Pose{}});
  time("torus flat on plane", {ring(), Pose{{0, 0.199, 0}, glm::normalize(Quat(1, -1, 0, 0))}},
       {ground, Pose{}});
  time("ball on convex skin", {sphere, beside}, {ball(), Pose{}});
  time("box on convex skin", {box, beside}, {ball(), Pose{}});
  time("convex skin on plane", {ball(), Pose{{0, 0.499, 0}}}, {ground, Pose{}});
}

TEST_CASE("skins on skins: what contacts cost", "[.][skin_cost]") {
  using namespace pantin::test;
  const auto time = [](const char* what, const PlacedShape& a, const PlacedShape& b) {
    tell_cost(what, a, b, 0.002);
  };
  const Creased table = grown_together(
      {{{-0.5, -0.05, -0.5}, {0.5, 0.05, 0.5}}, {{-0.5, -0.05, -0.5}, {-0.45, 0.2, 0.5}}});
  const Creased angle = bracket(), rail = t_slot(), block = slider(), vessel = cup(), bowl = dish(),
                ring_plate = washer(0.0505, 0.15, 0.05), peg = disc(0.05, 0.1),
                plate = disc(0.1, 0.03);
  const Shape box = plain(ShapeKind::box, Vec3(0.1));
  time("box on a table of faces", {box, Pose{{0.03, 0.1499, 0}}}, {table.skin, Pose{}});
  time("bracket on table", {angle.skin, Pose{{0.03, 0.0999, 0}}}, {table.skin, Pose{}});
  time("slider in slot", {block.skin, Pose{{0, 0.0395, -0.15}}}, {rail.skin, Pose{}});
  time("disc flat on table", {plate.skin, Pose{{0.03, 0.0799, 0}}}, {table.skin, Pose{}});
  time("peg in hole", {peg.skin, Pose{{1e-4, 0.08, 0}}}, {ring_plate.skin, Pose{}});
  time("cup on table", {vessel.skin, Pose{{0.03, 0.04999, 0.01}}}, {table.skin, Pose{}});
  time("cup on dish", {vessel.skin, Pose{{0.03, 0.00743, 0.01}}}, {bowl.skin, Pose{}});
  time("torus through torus", {ring(), Pose{{0.4, 0, 0}, glm::normalize(Quat(1, 1, 0, 0))}},
       {ring(), Pose{}});
  time("torus flat on torus", {ring(), Pose{{0, 0, 0.399}}}, {ring(), Pose{}});
}
