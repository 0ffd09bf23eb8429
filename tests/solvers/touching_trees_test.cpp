// Jointed bodies that touch or nearly touch: what their joints and loops must leave alone.
#include <catch2/catch.hpp>

#include "engine/base/rotation.hpp"
#include "engine/contact/memory.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// Rods in a row along x, or in a square that the last one closes, 3 mm above the ground, turning
/// about the vertical and moving along.
World rods(bool closed) {
  World w;
  w.gravity = Vec3(0);
  add_ground(w);
  const Real reach = 0.12, radius = 0.02;
  const Vec3 spin(0, 3, 0), drift(0.5, 0, 0.2);
  std::vector<Entity> made;
  for (int i = 0; i < 4; ++i) {
    const Real angle = closed ? kPi / 2 * i : 0;
    const Quat turn = from_rotation_vector({0, -angle, 0});
    const Vec3 middle =
        closed ? turn * Vec3(0, radius + 3e-3, -reach) : Vec3(2 * reach * i, radius + 3e-3, 0);
    // A capsule lies along its y.
    const Entity e =
        add_solid(w, rod_shape(radius, reach - radius),
                  {middle, turn * from_rotation_vector({0, 0, -kPi / 2})}, Motion::dynamic);
    Body& b = w.bodies[e];
    b.drag = 0, b.angular_velocity = spin, b.velocity = drift + glm::cross(spin, middle);
    if (i > 0) add_link(w, {made.back(), e, {{0, reach, 0}, {0, -reach, 0}}});
    made.push_back(e);
  }
  if (closed) add_link(w, {made.back(), made.front(), {{0, reach, 0}, {0, -reach, 0}}});
  return w;
}

}  // namespace

TEST_CASE("what turns close above the ground keeps its motion, in a row and in a ring") {
  const bool closed = GENERATE(false, true);
  CAPTURE(closed);
  Simulation sim(rods(closed), {1.0 / 60, 1, 1, true});
  const Measures start = measure(sim.world);
  REQUIRE(start.worst_gap < 1e-12);
  for (int i = 0; i < 60; ++i) {
    const StepReport report = sim.step();
    REQUIRE(report.contacts == 0);
    REQUIRE(!contacts_of(sim.world).empty());
    CHECK(report.measures.worst_gap < 1e-7);
  }
  const Measures end = measure(sim.world);
  CHECK(glm::length(end.momentum - start.momentum) <= 1e-12 * glm::length(start.momentum));
  CHECK(end.kinetic <= (1 + 1e-9) * start.kinetic);
  CHECK(end.kinetic >= 0.98 * start.kinetic);
}

TEST_CASE("the floor below a body is looked for as far as a striker may take the body") {
  World w;
  w.gravity = Vec3(0);
  const Entity floor = add_ground(w);
  const Entity box = add_solid(w, box_shape({0.1, 0.02, 0.1}), {{0, 0.12, 0}}, Motion::dynamic);
  const Entity ball = add_solid(w, ball_shape(0.05), {{0, 0.12 + 0.07 + 0.25, 0}}, Motion::dynamic);
  w.bodies[ball].velocity = {0, -12, 0};  // 0.2 m a step: it strikes in the second one
  Simulation sim(std::move(w), {1.0 / 60});
  const auto is_listed = [&] {
    const auto slot = [&](Entity e) { return sim.world.bodies.slot(e); };
    const auto& contacts = contacts_of(sim.world);
    return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) {
      return c.slot_a == slot(box) && c.slot_b == slot(floor);
    });
  };
  sim.step();
  CHECK_FALSE(is_listed());  // 0.1 m below a body at rest
  sim.step();
  CHECK(is_listed());
}
