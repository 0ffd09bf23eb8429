// The search for contacts: who may touch whom, what is carried over, and agreement with a look at
// every pair.
#include "engine/contact/detect.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <tuple>

#include "engine/geometry/collide.hpp"
#include "engine/solvers/solver.hpp"
#include "engine/world/ties.hpp"
#include "engine/world/world.hpp"
#include "tests/base/random.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

struct Stage {
  World world;
  test::Random dice{23};
  std::vector<Real> reach;

  Entity body(const Shape& shape, Vec3 at, Motion motion = Motion::dynamic,
              Collision collision = {}) {
    Body b;
    b.pose.position = at;
    b.motion = motion;
    const Entity e = world.add_body(b);
    world.shapes.add(e, Shapes{{shape}});
    world.collisions.add(e, collision);
    return e;
  }
  std::size_t search(Real by = 0) {
    compile_if_changed(world);
    reach.assign(world.bodies.size(), by);
    contact::find_contacts(world, reach);
    return contacts_of(world).size();
  }
};

Shape ball(Real r) { return {ShapeKind::sphere, {r, 0, 0}, {}, 0}; }
Shape box(Vec3 half) { return {ShapeKind::box, half, {}, 0}; }
const Shape kPlane{ShapeKind::plane, {10, 0, 0}, {}, 0};

Collision social() {
  Collision c;
  c.others = c.self = true;
  return c;
}

auto order(const Contact& c) { return std::tie(c.slot_a, c.slot_b, c.key); }

}  // namespace

TEST_CASE("a body touches the ground within its reach, at places in its own frame") {
  Stage s;
  s.body(kPlane, {0, 1, 0}, Motion::fixed);
  const Entity e = s.body(box(Vec3(0.5)), {2, 1.52, 3});
  CHECK(s.search(0.001) == 0);
  CHECK(s.search(0.02) == 4);
  for (const Contact& c : contacts_of(s.world)) {
    CHECK(c.slot_a == s.world.bodies.slot(e));
    CHECK(c.slot_b == 0);
    CHECK(c.gap == Approx(0.02));
    CHECK(c.normal == Vec3(0, 1, 0));
    CHECK(c.point_a.y == -0.5);
    CHECK(std::abs(c.point_b.x - 2) == Approx(0.5));
  }
}

TEST_CASE("without solid bodies there are no contacts") {
  Stage s;
  contacts_of(s.world).resize(3);
  CHECK(s.search(1) == 0);
}

TEST_CASE("fixed and kinematic bodies do not touch each other; groups have to agree both ways") {
  Stage s;
  Collision ground;
  ground.groups = 2;
  s.body(kPlane, {}, Motion::fixed, ground);
  s.body(ball(1), {0, 0.5, 0}, Motion::kinematic);
  CHECK(s.search() == 0);
  const Entity e = s.body(ball(1), {5, 0.5, 0});
  CHECK(s.search() == 1);
  s.world.collisions[e].with = 1;
  CHECK(s.search() == 0);
  s.world.collisions[e].with = 2;
  CHECK(s.search() == 1);
  s.world.collisions.values()[0].with = 4;
  CHECK(s.search() == 0);
  s.world.collisions[e].groups = 4;
  CHECK(s.search() == 1);
}

TEST_CASE("moving bodies touch where one asks for others, or both for their own") {
  Stage s;
  Collision spared;
  spared.others = spared.self = false;
  const auto add = [&](Vec3 at) { return s.body(ball(1), at, Motion::dynamic, spared); };
  const Entity a = add({}), b = add({1.5, 0, 0}), c = add({0.7, 1, 0});
  CHECK(s.search() == 0);
  s.world.collisions[c].others = true;
  CHECK(s.search() == 2);
  add_link(s.world, {a, b, Joint{}});
  add_link(s.world, {b, c, Joint{}});
  CHECK(s.search() == 0);  // one island now
  s.world.collisions[a].self = true;
  CHECK(s.search() == 0);
  s.world.collisions[b].self = s.world.collisions[c].self = true;
  CHECK(s.search() == 1);  // a and b, b and c are joined
  CHECK(contacts_of(s.world)[0].slot_a == s.world.bodies.slot(a));
  CHECK(contacts_of(s.world)[0].slot_b == s.world.bodies.slot(c));
}

TEST_CASE("friction is the geometric mean, restitution the larger") {
  Stage s;
  Collision ice, ball_like;
  ice.friction = 0.04, ice.restitution = 0.1;
  ball_like.friction = 0.25, ball_like.restitution = 0.8;
  s.body(kPlane, {}, Motion::fixed, ice);
  s.body(ball(1), {0, 0.9, 0}, Motion::dynamic, ball_like);
  REQUIRE(s.search() == 1);
  CHECK(contacts_of(s.world)[0].friction == Approx(0.1));
  CHECK(contacts_of(s.world)[0].restitution == 0.8);
}

TEST_CASE("contacts keep what they bore as long as they last") {
  Stage s;
  s.body(box({5, 0.5, 5}), {0, -0.5, 0}, Motion::fixed);
  s.body(box(Vec3(0.5)), {0, 0.5, 0});
  s.body(ball(0.5), {3, 0.5, 0});
  REQUIRE(s.search() == 5);
  for (std::size_t i = 0; i < 5; ++i)
    contacts_of(s.world)[i].lambda = Vec3(0, static_cast<Real>(i + 1), 0);
  s.world.bodies.values()[1].pose.position.x += 0.01;
  s.world.bodies.values()[2].pose.position.y += 1;
  REQUIRE(s.search() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(contacts_of(s.world)[i].lambda.y == static_cast<Real>(i + 1));
    CHECK(!contacts_of(s.world)[i].active);
  }
  s.world.bodies.values()[2].pose.position.y -= 1;
  REQUIRE(s.search() == 5);
  CHECK(contacts_of(s.world)[4].lambda == Vec3(0));
}

TEST_CASE("the search finds what a look at all pairs of shapes finds, in order, moved or not") {
  Stage s;
  std::vector<Real> heights(21 * 21);
  for (Real& h : heights) h = s.dice.between(-1.5, -1);
  const auto ground = *make_height_field({21, 21, 0.5, 0.5, heights});
  s.body({ShapeKind::height_field, {}, {}, 0, ground}, {}, Motion::fixed);
  s.body(kPlane, {0, -1.4, 0}, Motion::fixed);
  for (int i = 0; i < 150; ++i) {
    const Shape shape =
        i % 3 == 0
            ? ball(s.dice.between(0.1, 0.4))
            : box({s.dice.between(0.1, 0.4), s.dice.between(0.1, 0.4), s.dice.between(0.1, 0.4)});
    const Entity e =
        s.body(shape, {s.dice.between(-4, 4), s.dice.between(-2, 1), s.dice.between(-4, 4)},
               i % 5 == 0   ? Motion::fixed
               : i % 7 == 0 ? Motion::kinematic
                            : Motion::dynamic,
               i % 2 ? social() : Collision{});
    s.world.shapes[e].list.push_back(
        {ShapeKind::capsule, {0.1, 0.2, 0}, {{0, 0.4, 0.1}, s.dice.orientation()}, 0});
  }
  for (int round = 0; round < 3; ++round) {
    for (Body& b : s.world.bodies.values()) {
      if (b.motion == Motion::fixed) continue;
      b.pose = {b.pose.position + Vec3(s.dice.between(-0.5, 0.5), s.dice.between(-0.5, 0.5), 0),
                s.dice.orientation()};
    }
    s.search(0.05);
    using Place = std::tuple<std::uint32_t, std::uint32_t, Real>;
    std::vector<Place> got, want;
    for (const Contact& c : contacts_of(s.world)) got.emplace_back(c.slot_a, c.slot_b, c.gap);
    const auto contacts = contacts_of(s.world);
    for (std::size_t i = 1; i < contacts.size(); ++i)
      CHECK(order(contacts[i - 1]) < order(contacts[i]));

    NarrowPhaseScratch room;
    std::vector<ContactPoint> points;
    const auto bodies = s.world.bodies.values();
    const auto owners = s.world.bodies.owners();
    for (std::uint32_t a = 0; a < bodies.size(); ++a)
      for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        if (a == b || bodies[a].motion != Motion::dynamic) continue;
        const bool both = bodies[b].motion == Motion::dynamic;
        const Collision &ca = s.world.collisions[owners[a]], &cb = s.world.collisions[owners[b]];
        if (both && (b < a || !(ca.others || cb.others))) continue;
        for (const Shape& p : s.world.shapes[owners[a]].list)
          for (const Shape& q : s.world.shapes[owners[b]].list) {
            points.clear();
            collide({p, compose(bodies[a].pose, p.local)}, {q, compose(bodies[b].pose, q.local)},
                    room, {0.1, points});
            for (const ContactPoint& t : points) want.emplace_back(a, b, t.gap);
          }
      }
    // The search reaches a little farther; the rest is the same.
    std::erase_if(got, [](const Place& p) { return std::get<2>(p) > 0.099; });
    std::erase_if(want, [](const Place& p) { return std::get<2>(p) > 0.099; });
    std::sort(got.begin(), got.end());
    std::sort(want.begin(), want.end());
    CHECK(got.size() > 200);
    CHECK(got == want);
  }
}

TEST_CASE("a copy of a world finds the same contacts") {
  Stage s;
  s.body(kPlane, {}, Motion::fixed);
  for (int i = 0; i < 40; ++i)
    s.body(box(Vec3(0.2)), {s.dice.between(-1, 1), s.dice.between(0, 0.5), s.dice.between(-1, 1)},
           Motion::dynamic, social());
  s.search(0.1);
  World copy = s.world;
  contact::find_contacts(copy, s.reach);
  contact::find_contacts(s.world, s.reach);
  REQUIRE(contacts_of(copy).size() == contacts_of(s.world).size());
  for (std::size_t i = 0; i < contacts_of(copy).size(); ++i) {
    CHECK(order(contacts_of(copy)[i]) == order(contacts_of(s.world)[i]));
    CHECK(contacts_of(copy)[i].gap == contacts_of(s.world)[i].gap);
    CHECK(contacts_of(copy)[i].point_a == contacts_of(s.world)[i].point_a);
  }
}

TEST_CASE("a fast body sees a thin wall before it, and nothing where it does not go") {
  Stage s;
  s.body(box({0.001, 1, 1}), {}, Motion::fixed);
  s.body(ball(0.05), {-0.5, 0, 0});
  CHECK(s.search(0.1) == 0);
  REQUIRE(s.search(0.6) == 1);
  CHECK(contacts_of(s.world)[0].gap == Approx(0.449));
  CHECK(contacts_of(s.world)[0].normal == Vec3(-1, 0, 0));
}
