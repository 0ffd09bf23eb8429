// Rays, slides, overlaps and nearest points over a whole World.
#include "engine/world/queries.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "engine/geometry/collide.hpp"
#include "engine/world/world.hpp"
#include "tests/geometry/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kNaN = std::numeric_limits<Real>::quiet_NaN();

Shape ball(Real r) { return {ShapeKind::sphere, {r, 0, 0}, {}, 0}; }
Shape block(Vec3 half) { return {ShapeKind::box, half, {}, 0}; }
const Shape kGround{ShapeKind::plane, {10, 0, 0}, {}, 0};

Entity add(World& world, const Shape& shape, const Pose& at, const Collision& collision = {}) {
  Body body;
  body.pose = at;
  const Entity e = world.add_body(body);
  world.shapes.add(e, Shapes{{shape}});
  world.collisions.add(e, collision);
  return e;
}

/// Many shapes of all kinds, of which a few have no end.
World crowd(Random& dice, int count) {
  World world;
  const std::vector<Sample> all = samples();
  for (int i = 0; i < count; ++i) {
    Shape shape = all[static_cast<std::size_t>(i) % all.size()].shape;
    if (shape.kind == ShapeKind::plane) shape = ball(0.2);
    if (i % 3 == 0) shape.local = {dice.in_cube(0.3), dice.orientation()};
    add(world, shape, {dice.in_cube(6), dice.orientation()});
  }
  add(world, kGround, {{0, -5, 0}, kIdentity});
  return world;
}

/// Calls `look(entity, shape, pose)` for every shape.
template <class Look>
void each(const World& world, Look&& look) {
  for (Entity e : world.bodies.owners())
    for (const Shape& s : world.shapes[e].list) look(e, s, compose(world.bodies[e].pose, s.local));
}

}  // namespace

TEST_CASE("a ray meets the nearest of several bodies, with point, normal, fraction and shape") {
  World world;
  const Entity near = add(world, ball(0.5), {{0, 1, 0}, kIdentity});
  const Entity far = add(world, ball(0.5), {{0, 1, -4}, kIdentity});
  world.shapes[far].list.push_back(block({0.1, 2, 0.1}));
  const Entity ground = add(world, kGround, {});
  const Queries queries(world);
  const RayAnswer seen = queries.cast_ray({{0, 1, 5}, {0, 0, -10}});
  REQUIRE(seen);
  CHECK(seen.status == QueryStatus::ok);
  CHECK(seen.hit->body == near);
  CHECK(seen.hit->shape == 0);
  CHECK(seen.hit->fraction == Approx(0.45).epsilon(1e-14));
  CHECK(glm::distance(seen.hit->point, {0, 1, 0.5}) < 1e-14);
  CHECK(glm::distance(seen.hit->normal, {0, 0, 1}) < 1e-14);
  CHECK(queries.cast_ray({{0, 2.9, -2}, {0, 0, -10}}).hit->shape == 1);
  CHECK(queries.cast_ray({{7, 3, 0}, {0, -4, 0}}).hit->body == ground);
  CHECK(queries.cast_ray({{7, 3, 0}, {0, -4, 0}}).hit->fraction == Approx(0.75).epsilon(1e-14));
  CHECK_FALSE(queries.cast_ray({{7, 3, 0}, {0, -2.9, 0}}));
  CHECK_FALSE(queries.cast_ray({{7, 3, 0}, {1e6, 0, 0}}));

  std::vector<RayHit> all;
  CHECK(queries.cast_ray_through({{0, 1, 5}, {0, 0, -10}}, {}, all) == QueryStatus::ok);
  REQUIRE(all.size() == 3);
  CHECK((all[0].body == near && all[1].body == far && all[2].body == far));
  CHECK((all[1].shape == 0 && all[2].shape == 1));
  CHECK(std::is_sorted(all.begin(), all.end(),
                       [](const RayHit& a, const RayHit& b) { return a.fraction < b.fraction; }));
}

TEST_CASE("a ray that starts inside is met at once, or passes, as it is asked") {
  for (const Sample& s : samples()) {
    CAPTURE(name_of(s.shape.kind));
    World world;
    const Entity body = add(world, s.shape, {{2, 0, 0}, kIdentity});
    const Queries queries(world);
    const Vec3 inside = Vec3(2, 0, 0) + Vec3(0.05, -0.05, 0.07);
    REQUIRE(s.inside(inside - Vec3(2, 0, 0)));
    const RayAnswer met = queries.cast_ray({inside, {0, -3, 0}});
    REQUIRE(met);
    CHECK((met.hit->body == body && met.hit->fraction == 0 && met.hit->point == inside));
    CHECK(glm::length(met.hit->normal) == Approx(1).epsilon(1e-12));
    CHECK_FALSE(queries.cast_ray({inside, {0, -3, 0}, StartInside::pass}));
    // No way at all: a point is met by what it is inside of, and by nothing else.
    const RayAnswer point = queries.cast_ray({inside, Vec3(0)});
    REQUIRE(point);
    CHECK((point.hit->body == body && point.hit->fraction == 0));
    CHECK_FALSE(queries.cast_ray({{0, 5, 0}, Vec3(0)}));
  }
}

TEST_CASE("questions with numbers that are not finite are answered with nothing, and told") {
  World world;
  add(world, ball(1), {});
  add(world, kGround, {});
  const Queries queries(world);
  std::vector<RayHit> hits(1);
  std::vector<Overlap> overlaps(1);
  for (Real bad : {kNaN, std::numeric_limits<Real>::infinity()}) {
    const Ray rays[] = {{{0, bad, 0}, {0, 0, 1}}, {{0, 2, 0}, {bad, 0, 1}}};
    for (const Ray& ray : rays) {
      CHECK_FALSE(queries.cast_ray(ray));
      CHECK(queries.cast_ray(ray).status == QueryStatus::not_finite);
      CHECK(queries.cast_ray_through(ray, {}, hits) == QueryStatus::not_finite);
      CHECK(hits.empty());
      const RayAnswer slid = queries.cast_shape(ball(0.1), {ray.origin, kIdentity}, ray.way);
      CHECK((!slid && slid.status == QueryStatus::not_finite));
    }
    CHECK(queries.overlap(ball(1), {{bad, 0, 0}, kIdentity}, {}, overlaps) ==
          QueryStatus::not_finite);
    CHECK(queries.overlap(ball(bad), {}, {}, overlaps) == QueryStatus::not_finite);
    CHECK(overlaps.empty());
    CHECK(queries.closest_point({0, 0, bad}, 1).status == QueryStatus::not_finite);
  }
  CHECK(queries.closest_point({0, 0, 0}, kNaN).status == QueryStatus::not_finite);
  CHECK(queries.closest_point({0, 0, 0}, -1).status == QueryStatus::not_finite);
  CHECK(queries.overlap(kGround, {}, {}, overlaps) == QueryStatus::bad_shape);
  CHECK(queries.cast_shape(kGround, {}, {0, 1, 0}).status == QueryStatus::bad_shape);
  CHECK(queries.cast_shape({ShapeKind::hull, {}, {}, 0}, {}, {0, 1, 0}).status ==
        QueryStatus::bad_shape);
  CHECK(queries.closest_point({0, 3, 0}, std::numeric_limits<Real>::infinity()));
}

TEST_CASE("bodies with poses that are not finite and shapes without surface are left out") {
  World world;
  add(world, ball(1), {{kNaN, 0, 0}, kIdentity});
  add(world, {ShapeKind::mesh, {}, {}, 0}, {});
  const Entity seen = add(world, ball(1), {});
  const Queries queries(world);
  CHECK(queries.left_out() == 2);
  CHECK(queries.cast_ray({{0, 5, 0}, {0, -9, 0}}).hit->body == seen);
}

TEST_CASE("groups, masks, solidity and exceptions say what a query sees") {
  World world;
  Collision first, second;
  first.groups = 1, first.with = 4;
  second.groups = 2;
  const Entity a = add(world, ball(0.5), {{0, 4, 0}, kIdentity}, first);
  const Entity b = add(world, ball(0.5), {{0, 2, 0}, kIdentity}, second);
  const Entity c = add(world, ball(0.5), {{0, 0, 0}, kIdentity});
  world.collisions.remove(c);
  const Queries queries(world);
  const Ray ray{{0, 9, 0}, {0, -20, 0}};
  const auto met = [&](const QueryFilter& filter) {
    const RayAnswer seen = queries.cast_ray(ray, filter);
    std::vector<RayHit> all;
    queries.cast_ray_through(ray, filter, all);
    CHECK(all.empty() != bool(seen));
    if (seen) CHECK(all.front().body == seen.hit->body);
    return seen ? seen.hit->body : Entity{};
  };
  QueryFilter filter;
  CHECK(met(filter) == a);
  filter.groups = 2;  // a wants group 4 only
  CHECK(met(filter) == b);
  filter.groups = 4;
  CHECK(met(filter) == a);
  filter.with = 2;
  CHECK(met(filter) == b);
  filter.with = 8;
  CHECK(met(filter) == Entity{});
  filter.bodies = QueryBodies::all;
  CHECK(met(filter) == c);
  filter = {};
  filter.except = a;
  CHECK(met(filter) == b);
  std::vector<Overlap> overlaps;
  queries.overlap(block({1, 9, 1}), {}, filter, overlaps);
  CHECK((overlaps.size() == 1 && overlaps[0].body == b));
  CHECK(queries.closest_point({0, 9, 0}, 99, filter).hit->body == b);
  CHECK(queries.cast_shape(ball(0.1), {{0, 9, 0}, kIdentity}, {0, -20, 0}, filter).hit->body == b);
}

TEST_CASE("overlaps tell how deep and which way out, for balls, rods and blocks") {
  World world;
  const Entity ground = add(world, kGround, {});
  const Entity one = add(world, ball(0.5), {{0, 0.4, 0}, kIdentity});
  const Queries queries(world);
  std::vector<Overlap> found;
  CHECK(queries.overlap(ball(0.3), {{0.6, 0.4, 0}, kIdentity}, {}, found) == QueryStatus::ok);
  REQUIRE(found.size() == 1);
  CHECK(found[0].body == one);
  CHECK(found[0].depth == Approx(0.2).epsilon(1e-12));
  CHECK(glm::distance(found[0].normal, {1, 0, 0}) < 1e-12);
  CHECK(glm::distance(found[0].point, {0.5, 0.4, 0}) < 1e-12);
  queries.overlap({ShapeKind::capsule, {0.1, 0.5, 0}, {}, 0}, {{3, 0.55, 0}, kIdentity}, {}, found);
  REQUIRE(found.size() == 1);
  CHECK((found[0].body == ground && found[0].normal == Vec3(0, 1, 0)));
  CHECK(found[0].depth == Approx(0.05).epsilon(1e-12));
  queries.overlap(block({0.5, 0.5, 0.5}), {{0.7, 0.4, 0}, kIdentity}, {}, found);
  REQUIRE(found.size() == 2);
  CHECK((found[0].body == ground && found[1].body == one));
  CHECK(found[0].depth == Approx(0.1).epsilon(1e-12));
  CHECK(found[1].depth == Approx(0.3).epsilon(1e-12));
  queries.overlap(ball(0.1), {{5, 5, 5}, kIdentity}, {}, found);
  CHECK(found.empty());
}

TEST_CASE("nearest points: outside, inside, out of reach") {
  World world;
  const Entity one = add(world, block({1, 1, 1}), {{0, 3, 0}, kIdentity});
  const Entity two = add(world, ball(0.5), {{4, 3, 0}, kIdentity});
  const Queries queries(world);
  const auto at = [&](Vec3 p, Real within) { return queries.closest_point(p, within); };
  CHECK(at({2, 3, 0}, 5).hit->body == one);
  CHECK(at({2, 3, 0}, 5).hit->distance == Approx(1).epsilon(1e-14));
  CHECK(at({2, 3, 0}, 5).hit->point == Vec3(1, 3, 0));
  CHECK(at({2.5, 3, 0}, 5).hit->body == two);
  CHECK_FALSE(at({2, 3, 0}, 0.99));
  CHECK(at({0.8, 3, 0.1}, 5).hit->distance == Approx(-0.2).epsilon(1e-12));
  CHECK(at({0.8, 3, 0.1}, 0).hit->normal == Vec3(1, 0, 0));
}

TEST_CASE("a tree of shapes answers as a look at every shape does") {
  Random dice(7);
  World world = crowd(dice, 120);
  Queries queries(world);
  for (int round = 0; round < 3; ++round) {
    int rays_met = 0;
    for (int trial = 0; trial < 300; ++trial) {
      const Ray ray{dice.in_cube(8), 16.0 * dice.direction(), StartInside::pass};
      const Real length = glm::length(ray.way);
      Real first = 1e300;
      std::size_t count = 0;
      each(world, [&](Entity, const Shape& s, const Pose& at) {
        const auto entry = cast(s, to_local(at, ray.origin),
                                glm::conjugate(at.rotation) * (ray.way / length), length);
        if (entry) ++count, first = std::min(first, entry->distance / length);
      });
      const RayAnswer seen = queries.cast_ray(ray);
      std::vector<RayHit> all;
      queries.cast_ray_through(ray, {}, all);
      REQUIRE(bool(seen) == (count > 0));
      CHECK(all.size() == count);
      if (!seen) continue;
      ++rays_met;
      CHECK(seen.hit->fraction == Approx(first).epsilon(1e-12));
      CHECK(all.front().fraction == seen.hit->fraction);

      const Vec3 p = ray.origin;
      Real nearest = 1e300;
      each(world, [&](Entity, const Shape& s, const Pose& at) {
        if (const auto near = closest(s, to_local(at, p), 20))
          nearest = std::min(nearest, near->distance);
      });
      const ClosestAnswer near = queries.closest_point(p, 20);
      REQUIRE(bool(near) == (nearest < 1e300));
      if (near) CHECK(near.hit->distance == Approx(nearest).margin(1e-10));
    }
    CHECK(rays_met > 60);
    // Bodies move a little, then one comes and one goes.
    for (Body& b : world.bodies.values()) b.pose.position += dice.in_cube(0.5);
    if (round == 1) world.destroy(world.bodies.owners()[5]), add(world, ball(1), {});
    queries.refit(world);
  }
}

TEST_CASE("overlap and touch agree, and a slide ends where overlaps begin") {
  Random dice(7);
  const World world = crowd(dice, 60);
  const Queries queries(world);
  int met = 0, inside = 0;
  for (int trial = 0; trial < 150; ++trial) {
    const Shape shapes[] = {
        ball(0.3), block({0.2, 0.3, 0.1}), {ShapeKind::capsule, {0.1, 0.3, 0}, {}, 0}};
    const Shape& shape = shapes[trial % 3];
    const Pose from{dice.in_cube(7), dice.orientation()};
    std::vector<Overlap> found;
    REQUIRE(queries.overlap(shape, from, {}, found) == QueryStatus::ok);
    std::size_t expected = 0;
    NarrowPhaseScratch room;
    each(world, [&](Entity, const Shape& s, const Pose& at) {
      std::vector<ContactPoint> points;
      collide({shape, from}, {s, at}, room, {0, points});
      expected += !points.empty();
    });
    CHECK(found.size() == expected);
    const Vec3 way = 6.0 * dice.direction();
    const RayAnswer slid = queries.cast_shape(shape, from, way);
    if (!found.empty()) {
      ++inside;
      REQUIRE(slid);
      CHECK(slid.hit->fraction == 0);
      continue;
    }
    // Halfway to the contact, and just before it, there is none; just behind it there is.
    const Real end = slid ? slid.hit->fraction : 1;
    for (Real part : {0.25, 0.5, 0.75, 0.999}) {
      queries.overlap(shape, {from.position + part * end * way, from.rotation}, {}, found);
      // What slides in below a field is not stopped by it.
      std::erase_if(found, [&](const Overlap& o) {
        return is_unbounded(world.shapes[o.body].list[o.shape].kind);
      });
      CHECK(found.empty());
    }
    if (!slid) continue;
    ++met;
    CHECK(glm::dot(slid.hit->normal, way) <= 1e-9);
    // Over the rim of a field only what is above it touches.
    const Shape& other = world.shapes[slid.hit->body].list[slid.hit->shape];
    if (is_unbounded(other.kind) && other.surface) {
      const Pose at = compose(world.bodies[slid.hit->body].pose, other.local);
      const Vec3 local = to_local(at, from.position + end * way);
      const Surface& field = *other.surface;
      if (std::abs(local.x) > field.high.x || std::abs(local.z) > field.high.z) continue;
    }
    queries.overlap(shape, {from.position + end * way - 1e-5 * slid.hit->normal, from.rotation}, {},
                    found);
    CHECK_FALSE(found.empty());
  }
  CHECK(met > 20);
  CHECK(inside > 5);
}
