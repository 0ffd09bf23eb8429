// Which bodies are joined, and so do not touch as shapes.
#include "engine/world/joined.hpp"

#include <catch2/catch.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/world/ties.hpp"
#include "engine/world/world.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

/// Two bodies that move, and one that does not.
struct Three {
  World world;
  Entity a = world.add_body({}), b = world.add_body({}), ground;

  Three() {
    Body fixed;
    fixed.motion = Motion::fixed;
    ground = world.add_body(fixed);
  }
  bool are(Entity one, Entity two) const {
    std::vector<std::uint64_t> pairs;
    list_joined(world, pairs);
    const std::uint32_t p = world.bodies.slot(one), q = world.bodies.slot(two);
    CHECK(are_joined(pairs, p, q) == are_joined(pairs, q, p));
    return are_joined(pairs, p, q);
  }
  Entity hinge(Entity one, Entity two) {
    Joint joint;
    joint.kind = JointKind::hinge;
    return add_link(world, {one, two, joint});
  }
};

}  // namespace

TEST_CASE("joined: bodies of a link") {
  Three t;
  CHECK_FALSE(t.are(t.a, t.b));
  const std::uint64_t before = joined_version(t.world);
  t.hinge(t.b, t.a);
  CHECK(t.are(t.a, t.b));
  CHECK_FALSE(t.are(t.a, t.ground));
  CHECK(joined_version(t.world) != before);
}

TEST_CASE("joined: bodies of an exact pin, not those of a spring pin or of a cable") {
  for (const PinKind kind : {PinKind::exact, PinKind::spring}) {
    Three t;
    Pin pin;
    pin.body = t.a, pin.to = t.b, pin.kind = kind;
    t.world.add_pin(pin);
    CHECK(t.are(t.a, t.b) == (kind == PinKind::exact));
  }
  Three t;
  add_cable(t.world, {t.a, t.b, {}});
  CHECK_FALSE(t.are(t.a, t.b));
}

TEST_CASE("joined: partners of a joint of surfaces, until it has let go") {
  Three t;
  const auto plane = std::make_shared<const nurbs::Skin>(std::vector{nurbs::plane({}, 4, 4)}, 1e-9);
  const auto ball = std::make_shared<const nurbs::Skin>(nurbs::Skin::ellipsoid(Vec3(0.1)));
  SurfaceContact c;
  c.a = t.a, c.b = t.ground, c.on_a.skin = ball, c.on_b.skin = plane;
  const Entity joint = add_surface_contact(t.world, c);
  CHECK(t.are(t.a, t.ground));
  CHECK_FALSE(t.are(t.b, t.ground));
  const std::uint64_t before = joined_version(t.world);
  t.world.surface_contacts[joint].over = true;
  CHECK(joined_version(t.world) != before);
  CHECK_FALSE(t.are(t.a, t.ground));
}

TEST_CASE("joined: the wheels of a gear, not those of a belt") {
  Three t;
  Gear gear;
  gear.first = t.hinge(t.ground, t.a), gear.second = t.hinge(t.b, t.ground);
  CHECK_FALSE(t.are(t.a, t.b));
  add_gear(t.world, gear);
  CHECK(t.are(t.a, t.b));
  Three s;
  Belt belt;
  belt.pulleys.resize(2);
  belt.pulleys[0].body = s.a, belt.pulleys[1].body = s.b;
  add_belt(s.world, belt);
  CHECK_FALSE(s.are(s.a, s.b));
}
