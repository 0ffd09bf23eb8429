// How much the watches of a run let pass: rounding, blows and what has come to rest are no finding.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

#include "engine/geometry/surface.hpp"
#include "engine/nurbs/makers.hpp"
#include "engine/runtime/monitor.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/watches.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

TEST_CASE("what stays as deep as a thin thing is thick is told while it moves, a blow is not") {
  struct Case {
    Real depth, seconds, until;  // m; s; s, of the start that it lies there from
    bool told;
  };
  // Of 0.02 m; a whole thickness for 0.15 s; what begins so has 0.25 s more.
  for (const Case& c :
       {Case{0.02, 0.16, 0.1, true}, Case{0.02, 0.14, 0.1, false}, Case{0.04, 0.08, 0.1, true},
        Case{0.009, 5, 0.1, false}, Case{0.02, 0.39, 0, false}, Case{0.02, 0.42, 0, true}}) {
    World w;
    const Entity plate = add_box(w, Vec3(0), {1, 0.01, 1});
    const Entity box = add_box(w, {0, 0.1, 0}, Vec3(0.1));
    w = built(std::move(w));
    w.bodies[box].velocity = {0, -3, 0};
    Contact touch;
    touch.slot_a = w.bodies.slot(box), touch.slot_b = w.bodies.slot(plate);
    touch.active = true;
    ContactWatch watch;
    FindingList found;
    found.open();
    watch.compile(w);
    for (int i = 0; i < std::lround((c.until + c.seconds) / kStep); ++i) {
      touch.depth = i < std::lround(c.until / kStep) ? 0 : c.depth;
      contacts_of(w).assign(1, touch);
      watch.end_step(w, kStep, found);
    }
    const Finding* sunk = find(found, FindingKind::sunk);
    INFO(c.depth << " " << c.seconds << " " << c.until);
    REQUIRE((sunk != nullptr) == c.told);
    if (sunk) CHECK(sunk->amount == c.depth);
  }
}

TEST_CASE("what is not convex lies too deep, too: its box is no thinner than it is") {
  World w;
  const Entity floor = add_box(w, {0, -1, 0}, {5, 1, 5}, Motion::fixed);
  std::vector<nurbs::Surface> faces{nurbs::torus({}, 0.12, 0.04)};
  Shape torus;
  torus.kind = ShapeKind::nurbs;
  torus.surface = *make_skin(std::make_shared<nurbs::Skin>(std::move(faces), 1e-9));
  const Entity ring = add_solid(w, torus, {{0, 0.2, 0}, kIdentity}, Motion::dynamic, Collision{});
  w = built(std::move(w));
  w.gravity = {0, -9.81, 0};
  Contact touch;
  touch.slot_a = w.bodies.slot(ring), touch.slot_b = w.bodies.slot(floor);
  touch.active = true;
  for (const Real depth : {3e-3, 4.1e-3}) {
    touch.depth = depth;
    contacts_of(w).assign(1, touch);
    ContactWatch watch;
    FindingList found;
    found.open();
    watch.compile(w);
    for (int i = 0; i < 52; ++i) watch.end_step(w, kStep, found);
    INFO(depth);
    // A hundredth of 0.32 m, but no more than a twentieth of 0.08 m.
    CHECK((find(found, FindingKind::sunk) != nullptr) == (depth > 4e-3));
  }
}

TEST_CASE("a wheel that a joint holds at its centre has a size, and rounding is no gap") {
  World w;
  const Entity wheel = w.add(RigidBody{.mass = 1.0, .inertia = Mat3(0.04)}).value();
  const Entity base = w.add(RigidBody{.motion = Motion::fixed}).value();
  add_link(w, {base, wheel, {{}, {}}});
  const World start = built(std::move(w));
  for (const Real gap : {1e-12, 1.9e-4, 2.1e-4}) {  // a thousandth of 0.2 m
    const FindingList found =
        gaps_after(start, [&](World& now) { now.bodies[wheel].pose.position.x += gap; });
    INFO(gap);
    CHECK((find(found, FindingKind::joint_open) != nullptr) == (gap > 2e-4));
  }
}

TEST_CASE("what a solver takes from a wheel that its stop has brought to rest is not told") {
  for (const Real speed : {5, 50, 150, 500}) {
    const Real h = 1.0 / 30;
    World w;
    w.gravity = Vec3(0);
    const Entity wheel =
        w.add(RigidBody{
                  .mass = 1.0, .inertia = Mat3(0.02), .angular_velocity = {0, 0, speed}, .drag = 0})
            .value();
    const Entity base = w.add(RigidBody{.motion = Motion::fixed}).value();
    w.add(HingeJoint{.a = base, .b = wheel, .axis = {0, 0, 1}, .limits = Interval{-1, 1}}).value();
    Simulation sim(std::move(w), {h, 1, 1, false, true});
    while (sim.world.time < 2) sim.step();
    INFO(speed);
    CHECK(sim.findings().empty());
  }
}
