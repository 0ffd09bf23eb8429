// Edges and corners of skins: where they are, and where they touch.
#include "tests/geometry/creased.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/base/rotation.hpp"
#include "engine/geometry/collide.hpp"
#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

const SkinFeatures& features(const Creased& c) { return c.skin.surface->model->features; }

/// Not convex: a plate 0.1 m thick with a wall along one side.
const Creased& table() {
  static const Creased made = grown_together(
      {{{-0.5, -0.05, -0.5}, {0.5, 0.05, 0.5}}, {{-0.5, -0.05, -0.5}, {-0.45, 0.2, 0.5}}});
  return made;
}
Shape box_of(Vec3 half) {
  Shape s;
  s.kind = ShapeKind::box, s.size = half;
  return s;
}

/// How far a point is from the surface itself.
Real off(const Creased& c, Vec3 p) { return std::abs(c.distance(p)); }

}  // namespace

TEST_CASE("edges and corners of a skin lie where its faces meet", "[creased]") {
  const Creased cube = block_of(Vec3(0.1)), angle = bracket(), plate = disc(0.1, 0.03);
  CHECK(features(cube).corners.size() == 8);
  CHECK(features(cube).edges.size() == 12);
  for (const Corner& c : features(cube).corners) {
    CHECK(c.count == 3);
    CHECK(glm::distance(glm::abs(c.point), Vec3(0.1)) < 1e-12);
  }
  // Twelve corners of the L; its hollow edge is none of the edges.
  CHECK(features(angle).corners.size() >= 12);
  const auto is_hollow = [](Vec3 p) {
    return std::abs(p.x + 0.07) < 1e-9 && std::abs(p.y + 0.02) < 1e-9;
  };
  for (const EdgePart& e : features(angle).edges) CHECK_FALSE(is_hollow((e.from + e.to) / 2.0));
  for (const Creased* c : {&cube, &angle, &plate}) {
    REQUIRE(!features(*c).edges.empty());
    for (const Corner& k : features(*c).corners) CHECK(off(*c, k.point) < 1e-9);
    for (const EdgePart& e : features(*c).edges)
      for (const Real share : {0.0, 0.3, 1.0}) {
        const EdgePoint at = point_of(*c->skin.surface->skin, e, share);
        CHECK(off(*c, at.point) < 1e-9);
        for (const Vec3 into : e.into) CHECK(std::abs(glm::length(into) - 1) < 1e-9);
        for (int k = 0; k < 2; ++k) CHECK(glm::dot(e.normals[1 - k], e.into[k]) < -0.9);
      }
  }
  // Two circles of parts that turn by a quarter of a radian at most.
  CHECK(features(plate).edges.size() >= 2 * 26);
  for (const Corner& c : features(plate).corners)
    CHECK(std::abs(std::hypot(c.point.x, c.point.z) - 0.1) < 1e-9);
}

TEST_CASE("smooth skins have no edges, tips and creases within a face count", "[creased]") {
  const auto made = [](std::vector<nurbs::Surface> faces) { return skin_shape(std::move(faces)); };
  const auto of = [](const Shape& s) -> const SkinFeatures& { return s.surface->model->features; };
  const Shape ring = made({nurbs::torus({}, 0.5, 0.2)}), ball = made({nurbs::sphere({}, 0.5)});
  CHECK(of(ring).edges.empty());
  CHECK(of(ring).corners.empty());
  CHECK(of(ball).edges.empty());
  CHECK(of(ball).corners.empty());
  // A cone's side alone: its tip, and the rim below.
  const Shape cone = made({nurbs::cone({}, {0.2, 0}, 0.3)});
  const auto& tips = of(cone).corners;
  CHECK(std::count_if(tips.begin(), tips.end(), [](const Corner& c) {
          return glm::distance(c.point, {0, 0, 0.3}) < 1e-9;
        }) == 1);
  CHECK(!of(cone).edges.empty());
  // A square tube, one face: four creases, two square rims, eight corners.
  nurbs::Curve square{{1, {0, 0, 1, 2, 3, 4, 4}}, {}};
  for (const Vec3 p : {Vec3(0.1, -0.1, 0), Vec3(0.1, 0.1, 0), Vec3(-0.1, 0.1, 0),
                       Vec3(-0.1, -0.1, 0), Vec3(0.1, -0.1, 0)})
    square.points.push_back({p, 1});
  const Shape tube = made({nurbs::extruded(square, {0, 0, 0.4})});
  CHECK(of(tube).corners.size() == 8);
  CHECK(of(tube).edges.size() == 12);
}

TEST_CASE("a block of faces on a plate that is not convex touches as blocks do", "[creased]") {
  const Creased cube = block_of({0.1, 0.07, 0.12});
  const Shape same = box_of({0.1, 0.07, 0.12}), plate = box_of({0.5, 0.05, 0.5});
  Random dice{11};
  Found ours, theirs;
  int touched = 0;
  for (int i = 0; i < 2000; ++i) {
    Pose at{{dice.between(-0.1, 0.45), 0, dice.between(-0.55, 0.45)}, dice.rotation()};
    if (i % 2 == 0) at.rotation = from_rotation_vector(dice.in_cube(0.02));
    Vec3 lowest(0);
    for (int k = 0; k < 8; ++k) {
      const Vec3 corner(k & 1 ? 0.1 : -0.1, k & 2 ? 0.07 : -0.07, k & 4 ? 0.12 : -0.12);
      if ((at.rotation * corner).y < lowest.y) lowest = at.rotation * corner;
    }
    at.position.y = 0.05 - lowest.y - dice.between(-1e-3, 2e-3);
    const ContactPoint* q = theirs.touch({same, at}, {plate, Pose{}}, 2e-3);
    const ContactPoint* p = ours.touch({cube.skin, at}, {table().skin, Pose{}}, 2e-3);
    // Beside the plate, another way out may be as short.
    lowest = to_world(at, glm::conjugate(at.rotation) * lowest);
    const bool is_over = lowest.x < 0.499 && std::abs(lowest.z) < 0.499;
    if (!q || !is_over || glm::distance(q->normal, {0, 1, 0}) > 1e-9) continue;
    INFO(i << ": " << q->gap);
    REQUIRE(p);
    ++touched;
    REQUIRE(std::abs(p->gap - q->gap) < 1e-9);
    REQUIRE(glm::distance(p->normal, q->normal) < 1e-6);
    // The other way round.
    p = ours.touch({table().skin, Pose{}}, {cube.skin, at}, 2e-3);
    REQUIRE(p);
    REQUIRE(std::abs(p->gap - q->gap) < 1e-9);
    REQUIRE(glm::distance(p->normal, -q->normal) < 1e-6);
    // A block of the other kind on the same skin.
    p = ours.touch({same, at}, {table().skin, Pose{}}, 2e-3);
    REQUIRE(p);
    REQUIRE(std::abs(p->gap - q->gap) < 1e-9);
  }
  CHECK(touched > 1500);
}

TEST_CASE("the lowest place of a round edge touches, and all of one that lies flat", "[creased]") {
  const Creased plate = disc(0.1, 0.03);
  Found found;
  for (const Real tilt : {0.1, 0.4, 0.9, 1.4}) {
    const Real low = 0.1 * std::sin(tilt) + 0.03 * std::cos(tilt);
    const Pose at{{0.03, 0.05 + low - 1e-3, 0.02},
                  from_rotation_vector({0.8 * tilt, 0, 0.6 * tilt})};
    const ContactPoint* p = found.touch({plate.skin, at}, {table().skin, Pose{}}, 1e-3);
    INFO(tilt);
    REQUIRE(p);
    CHECK(std::abs(p->gap + 1e-3) < 1e-9);
    CHECK(glm::distance(p->normal, {0, 1, 0}) < 1e-9);
  }
  const ContactPoint* p =
      found.touch({plate.skin, Pose{{0.03, 0.079, 0.02}}}, {table().skin, Pose{}}, 1e-3);
  REQUIRE(p);
  CHECK(found.points.size() == 8);
  Vec3 sum(0);
  for (const ContactPoint& one : found.points) {
    CHECK(std::abs(one.gap + 1e-3) < 1e-9);
    sum += one.on_a - Vec3(0.03, 0.049, 0.02);
  }
  CHECK(glm::length(sum) < 0.1);  // of eight times 0.1: all around
}

TEST_CASE("edges across edges touch where they cross", "[creased]") {
  const Creased angle = bracket();
  Found found;
  // The upright's thin top edge, across another's that hangs head down; faces against faces first,
  // then rolled by 45 degrees so that ridge lies on ridge.
  const Quat over = from_rotation_vector({0, 0, kPi}) * from_rotation_vector({0, kPi / 2, 0});
  const Pose flat{{-0.085, 0.3 - 1e-3, -0.085}, over};
  const ContactPoint* p = found.touch({angle.skin, flat}, {angle.skin, Pose{}}, 1e-3);
  REQUIRE(p);
  CHECK(std::abs(p->gap + 1e-3) < 1e-9);
  CHECK(glm::distance(p->normal, {0, 1, 0}) < 1e-9);
  CHECK(found.points.size() >= 4);
  const Creased bar = block_of({0.05, 0.05, 0.5});
  const Quat roll = from_rotation_vector({0, 0, kPi / 4});
  const Quat across = from_rotation_vector({0, kPi / 2, 0}) * roll;
  const Real reach = 0.05 * std::sqrt(2.0);
  // The table's wall has a sharp top edge where the bar lies across it, rolled about its length.
  const Pose ridge{{-0.45, 0.2 + reach - 1e-3, 0}, from_rotation_vector({0, 0, -0.3}) * across};
  p = found.touch({bar.skin, ridge}, {table().skin, Pose{}}, 1e-3);
  REQUIRE(p);
  CHECK(p->normal.y > 0.9);
}

TEST_CASE("round faces that fit one another along a ring touch all around", "[creased]") {
  const Shape one = skin_shape({nurbs::torus({}, 0.5, 0.2)}),
              two = skin_shape({nurbs::torus({}, 0.5, 0.2)});
  Found found;
  const ContactPoint* p = found.touch({one, Pose{{0, 0, 0.399}}}, {two, Pose{}}, 0.01);
  REQUIRE(p);
  CHECK(std::abs(p->gap + 1e-3) < 1e-9);
  CHECK(found.points.size() >= 4);
  Vec3 sum(0);
  for (const ContactPoint& c : found.points) {
    CHECK(std::abs(std::hypot(c.on_a.x, c.on_a.y) - 0.5) < 1e-6);
    CHECK(std::abs(c.gap + 1e-3) < 1e-9);
    sum += Vec3(c.on_a.x, c.on_a.y, 0);
  }
  CHECK(glm::length(sum) < 0.5);
}

TEST_CASE("in a slot each wall keeps its points", "[creased]") {
  const Creased rail = t_slot(), block = slider();
  Found found;
  REQUIRE(found.touch({block.skin, Pose{{0, 0.0394, 0}}}, {rail.skin, Pose{}}, 3e-3));
  CHECK(found.points.size() <= 16);
  int below = 0, above = 0, beside[2] = {0, 0};
  for (const ContactPoint& p : found.points) {
    below += p.normal.y > 0.99, above += p.normal.y < -0.99;
    beside[0] += p.normal.x > 0.99, beside[1] += p.normal.x < -0.99;
  }
  CHECK(below >= 3);
  CHECK(above >= 2);
  CHECK(beside[0] >= 2);
  CHECK(beside[1] >= 2);
}
