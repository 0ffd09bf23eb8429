// What contacts and joints of the plane bear, as it is asked for by users.
#include <catch2/catch.hpp>
#include <pantin/contacts.hpp>
#include <pantin/joints.hpp>
#include <pantin/measure.hpp>

#include "engine/contact/contact.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/planar.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

Vec3 lift_on(const World& w, Entity body) {
  Vec3 sum(0);
  for (const Contact& c : contacts_of(w)) {
    if (w.bodies.owners()[c.slot_a] == body) sum += c.force;
    if (w.bodies.owners()[c.slot_b] == body) sum -= c.force;
  }
  return sum;
}

}  // namespace

TEST_CASE("contacts of the plane are listed with their forces, points and normals") {
  World w = planar_stack(3);
  w.default_settings.sleep_speed = 0;
  run(w, 1.0 / 60, 120);
  const auto slots = w.bodies.owners();
  for (std::size_t i = 1; i < w.bodies.size(); ++i) {
    const Real weight = w.bodies.values()[i].mass * 9.81;
    const Vec3 lift = lift_on(w, slots[i]);
    CHECK(lift.y == Approx(weight).epsilon(0.01));
    CHECK(std::abs(lift.x) < 0.02 * weight);
  }
  for (const Contact& c : contacts_of(w)) {
    const Vec3 a = to_world(w.bodies.values()[c.slot_a].pose, c.point_a),
               b = to_world(w.bodies.values()[c.slot_b].pose, c.point_b);
    CHECK(glm::length(a - b) < 1e-3);
    CHECK(std::abs(c.normal.y) == Approx(1).margin(1e-3));
    CHECK(w.bodies.values()[c.slot_a].motion == Motion::dynamic);
  }
  CHECK(contacts_of(w).size() == 6);
}

TEST_CASE("contact events of the plane begin, last and end, and tell the momentum of an impact") {
  World w = planar_world();
  Collision bouncy;
  bouncy.restitution = 0.8;
  add_slope(w, 0, bouncy);
  const Entity ball =
      add_solid(w, ShapeKind::sphere, Vec3(0.1, 0, 0), {{0, 0.5, 0}, kIdentity}, bouncy);
  ContactEvents events(w);
  int begun = 0, ended = 0;
  Real gained = 0, told = 0, before = 0;
  for (int i = 0; i < 60; ++i) {
    before = w.bodies[ball].velocity.y;
    run(w, 1.0 / 60, 1);
    for (const ContactEvent& e : events.update(w)) {
      begun += e.phase == ContactPhase::begin, ended += e.phase == ContactPhase::end;
      if (e.phase == ContactPhase::end || told > 0) continue;
      told = e.a == ball ? e.impulse.y : -e.impulse.y;
      gained = w.bodies[ball].mass * (w.bodies[ball].velocity.y - before + 9.81 / 60);
    }
  }
  CHECK(begun >= 1);
  CHECK(ended >= 1);
  CHECK(told == Approx(gained).epsilon(1e-3));
}

TEST_CASE("joints of the plane tell their reactions, those of belts included") {
  World w = planar_world();
  w.default_settings.sleep_speed = 0;
  const Entity frame = add_fixed(w), rod = add_rod(w, {0, 0, 0}, {1, 0, 0});
  const Entity weld =
      add_link(w, {frame, rod, planar_joint(w, frame, rod, JointKind::fixed, {0, 0, 0})});
  const Entity bob = add_rod(w, {2, 0, 0}, {2, -1, 0});
  const Entity hinge = add_hinge(w, frame, bob, {2, 0, 0});
  run(w, 1.0 / 60, 60);
  const auto held = joint_reaction(w, weld), hung = joint_reaction(w, hinge);
  REQUIRE((held && hung));
  CHECK(held->force.y == Approx(9.81).epsilon(1e-3));
  CHECK(held->torque.z == Approx(0.5 * 9.81).epsilon(1e-3));
  CHECK(hung->force.y == Approx(9.81).epsilon(1e-3));
  CHECK(hung->torque.z == Approx(0).margin(1e-6));

  World belts = planar_world({0, 0, 0});
  const Entity ground = add_fixed(belts);
  Entity wheels[2], axles[2];
  for (int i = 0; i < 2; ++i) {
    Body b;
    b.mass = 1, b.inertia = Vec3(0.1), b.drag = 0, b.pose.position = {2.0 * i, 0, 0};
    wheels[i] = belts.add_body(b);
    axles[i] = add_hinge(belts, ground, wheels[i], {2.0 * i, 0, 0});
  }
  const auto belt =
      belts.add(BeltJoint{.pulleys = {{.body = wheels[0], .radius = 0.3},
                                      {.body = wheels[1], .point = {2, 0, 0}, .radius = 0.3}}});
  REQUIRE(belt);
  belts.forces.add(wheels[0], {Vec3(0), {0, 0, 6}});
  run(belts, 1.0 / 240, 1);
  // The torque is shared, so the belt bears half of it: 3 N m at 0.3 m.
  const BeltState state = *belt_state(belts, *belt);
  CHECK(std::abs(state.tensions[0]) == Approx(10).epsilon(1e-3));
  const auto on_axle = joint_reaction(belts, axles[1]);
  REQUIRE(on_axle);
  CHECK(std::abs(on_axle->force.x) == Approx(10).epsilon(1e-3));
}
