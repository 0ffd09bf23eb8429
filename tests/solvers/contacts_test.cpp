#include <catch2/catch.hpp>

#include "engine/solvers/articulated/procedural/push_out.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;
using articulated::HalfSpaces;
using articulated::push_out;

TEST_CASE("one plane is left exactly, a wedge of any opening at once") {
  HalfSpaces plane;
  plane.add({0, 1, 0}, 0.25);
  CHECK(push_out(plane) == Vec3(0, 0.25, 0));
  for (Real degrees : {120.0, 90.0, 60.0, 30.0, 10.0, 1.0}) {
    // Two planes whose normals open by 180 degrees less the wedge.
    const Real a = (kPi - degrees * kPi / 180) / 2;
    HalfSpaces wedge;
    wedge.add({std::sin(a), std::cos(a), 0}, 0.1), wedge.add({-std::sin(a), std::cos(a), 0}, 0.07);
    const Vec3 u = push_out(wedge);
    INFO(degrees);
    for (std::size_t i = 0; i < 2; ++i)
      CHECK(glm::dot(wedge.normals[i], u) >= wedge.depths[i] - 1e-12);
    // Both touch, unless leaving one leaves the other.
    if (degrees < 90) CHECK(glm::dot(wedge.normals[0], u) == Approx(0.1));
  }
}

TEST_CASE("the way out of random half-spaces is the shortest there is") {
  Random dice(4);
  for (int i = 0; i < 500; ++i) {
    HalfSpaces planes;
    const int count = 1 + dice.below(4);
    for (int n = 0; n < count; ++n) {
      Vec3 normal = dice.direction();
      normal.y = std::abs(normal.y);  // there is a way out: up
      planes.add(normal, dice.between(0, 1));
    }
    const Vec3 u = push_out(planes);
    bool out = true;
    for (std::size_t n = 0; n < planes.count; ++n)
      out = out && glm::dot(planes.normals[n], u) >= planes.depths[n] - 1e-9;
    if (!out) continue;  // four planes may meet in no corner of three that leaves the fourth
    for (int trial = 0; trial < 50; ++trial) {
      const Vec3 v = u + dice.in_cube(0.05);
      bool leaves = true;
      for (std::size_t n = 0; n < planes.count; ++n)
        leaves = leaves && glm::dot(planes.normals[n], v) >= planes.depths[n];
      if (leaves) REQUIRE(glm::length(v) >= glm::length(u) * (1 - 1e-8));
    }
  }
}

TEST_CASE("a tumbling box comes to rest on the ground, not in it, and lies dead still") {
  for (Real h : {1.0 / 60, 1.0 / 240}) {
    World w;
    w.default_settings.sleep_speed = 0;  // by its contacts alone
    add_ground(w);
    const Entity e = add_solid(w, box_shape({0.2, 0.1, 0.3}),
                               {{0, 1, 0}, from_rotation_vector({0.3, 0.2, 0.5})}, Motion::dynamic);
    w.bodies[e].angular_velocity = {3, 1, -2};
    Simulation sim = Simulation::copy_of(w, {h});
    const Real start = measure(w).energy();
    for (int i = 0; i < 4 / h; ++i) {
      const StepReport report = sim.step();
      REQUIRE(report.worst_depth <= 1e-12);
      REQUIRE(measure(sim.world).energy() <= start * (1 + 1e-3));
    }
    CHECK(sim.world.bodies[e].pose.position.y <= 0.3 + 1e-9);
    Real acceleration2 = 0;
    for (int i = 0; i < 60; ++i) {
      const Vec3 before = sim.world.bodies[e].velocity;
      sim.step();
      const Vec3 a = (sim.world.bodies[e].velocity - before) / h;
      acceleration2 += glm::dot(a, a) / 60;
    }
    CHECK(std::sqrt(acceleration2) <= 1e-9);
    CHECK(measure(sim.world).kinetic <= 1e-20);
  }
}

TEST_CASE("a box sticks to a slope or slides down it as Coulomb has it") {
  const auto translation = [](Real degrees, Real h) {
    World w;
    w.default_settings.sleep_speed = 0;
    Collision rough;
    rough.friction = 0.5;
    const Quat tilt = from_rotation_vector({0, 0, -degrees * kPi / 180});
    add_ground(w, rough, tilt);
    const Entity e = add_solid(w, box_shape({0.2, 0.1, 0.2}), {tilt * Vec3(0, 0.1, 0), tilt},
                               Motion::dynamic, rough);
    Simulation sim = Simulation::copy_of(w, {h});
    const Vec3 start = w.bodies[e].pose.position;
    for (int i = 0; i < std::lround(1 / h); ++i) sim.step();
    return glm::dot(sim.world.bodies[e].pose.position - start, tilt * Vec3(1, 0, 0));
  };
  CHECK(translation(20, 1.0 / 60) <= 1e-6);  // the slope of slipping is 26.6 degrees
  CHECK(translation(26, 1.0 / 60) <= 1e-4);
  const Real a = 35 * kPi / 180, exact = 0.5 * 9.81 * (std::sin(a) - 0.5 * std::cos(a));
  CHECK(translation(35, 1.0 / 60) == Approx(exact).epsilon(0.025));
  CHECK(translation(35, 1.0 / 240) == Approx(exact).epsilon(0.025));
}

TEST_CASE("a ball gives back what it shall, and comes to rest") {
  World w;
  Collision bouncy;
  bouncy.restitution = 0.8;
  add_ground(w, bouncy);
  const Entity e = add_solid(w, ball_shape(0.1), {{0, 1.1, 0}, kIdentity}, Motion::dynamic, bouncy);
  Simulation sim = Simulation::copy_of(w, {1.0 / 240});
  std::vector<Real> tops;
  for (int i = 0; i < 240 * 8; ++i) {
    const Real before = sim.world.bodies[e].velocity.y;
    sim.step();
    if (before > 0 && sim.world.bodies[e].velocity.y <= 0)
      tops.push_back(sim.world.bodies[e].pose.position.y - 0.1);
  }
  REQUIRE(tops.size() >= 3);
  for (std::size_t i = 0; i < 3; ++i) CHECK(tops[i] == Approx(std::pow(0.64, i + 1)).epsilon(0.08));
  CHECK(std::abs(sim.world.bodies[e].pose.position.y - 0.1) <= 1e-9);
}

TEST_CASE("nothing passes through a wall of two millimetres, at any speed") {
  for (Real speed : {5.0, 50.0, 200.0, 1000.0}) {
    World w;
    w.gravity = Vec3(0);
    add_solid(w, box_shape({0.001, 5, 5}), {}, Motion::fixed);
    const Entity ball = add_solid(w, ball_shape(0.05), {{-1.3, 0, 0}, kIdentity}, Motion::dynamic);
    const Entity box =
        add_solid(w, box_shape({0.05, 0.05, 0.05}),
                  {{-1.7, 1, 0}, from_rotation_vector({0.4, 0.2, 0.7})}, Motion::dynamic);
    w.bodies[ball].velocity = w.bodies[box].velocity = {speed, 0, 0};
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    for (int i = 0; i < 60; ++i) sim.step();
    INFO(speed);
    CHECK(sim.world.bodies[ball].pose.position.x <= -0.05);
    CHECK(sim.world.bodies[box].pose.position.x <= -0.04);
  }
}

TEST_CASE("a fast thin paddle strikes what it would have swept through") {
  World w;
  w.gravity = Vec3(0);
  Body b;
  b.motion = Motion::kinematic, b.pose.position = {-2, 0, 0};
  const Entity paddle = w.add_body(b);
  Shapes shapes;
  shapes.list.push_back(box_shape({0.001, 1, 1}));
  w.shapes.add(paddle, shapes), w.collisions.add(paddle, {});
  KinematicPath drive;
  drive.curve = Keyframes{{{0, {{-2, 0, 0}, kIdentity}}, {0.1, {{2, 0, 0}, kIdentity}}}, false};
  w.paths.add(paddle, drive);
  const Entity ball = add_solid(w, ball_shape(0.1), {}, Motion::dynamic);
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  for (int i = 0; i < 10; ++i) sim.step();
  CHECK(sim.world.bodies[ball].pose.position.x >= 2);
}

TEST_CASE("a tower of boxes stands, each bearing those above") {
  World w;
  Collision solid;
  solid.others = true;
  add_ground(w, solid);
  std::vector<Entity> boxes;
  for (int i = 0; i < 5; ++i)
    boxes.push_back(add_solid(w, box_shape({0.2, 0.1, 0.2}),
                              {{0.01 * i, 0.1 + 0.21 * i, 0}, kIdentity}, Motion::dynamic, solid));
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  for (int i = 0; i < 300; ++i) sim.step();
  for (int i = 0; i < 5; ++i) {
    const Body& b = sim.world.bodies[boxes[static_cast<std::size_t>(i)]];
    CHECK(b.pose.position.y == Approx(0.1 + 0.2 * i).margin(4e-5));
    CHECK(std::abs(b.pose.position.x - 0.01 * i) <= 2e-3);
  }
  CHECK(measure(sim.world).kinetic <= 1e-5);
  // The lowest contacts bear the weight of all five.
  Real borne = 0;
  each_contact(sim.world, [&](const Contact& c) {
    if (sim.world.bodies.values()[c.slot_b].motion == Motion::fixed) borne += c.force.y;
  });
  CHECK(borne == Approx(5 * 32 * 9.81).epsilon(1e-3));
}

TEST_CASE("what strikes another body shares its momentum with it") {
  for (bool jointed : {false, true}) {
    World w;
    w.gravity = Vec3(0);
    Collision solid;
    solid.others = true;
    const Entity a = add_solid(w, ball_shape(0.1), {{-1, 0, 0}, kIdentity}, Motion::dynamic, solid);
    const Entity b =
        add_solid(w, ball_shape(0.1), {{1, 0.03, 0}, kIdentity}, Motion::dynamic, solid, 3000);
    if (jointed) {
      const Entity tail =
          add_solid(w, ball_shape(0.1), {{1.5, 0.03, 0}, kIdentity}, Motion::dynamic);
      add_link(w, {b, tail, {{0.25, 0, 0}, {-0.25, 0, 0}}});
    }
    w.bodies[a].velocity = {3, 0, 0};
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    const Measures start = measure(w);
    for (int i = 0; i < 120; ++i) sim.step();
    const Measures end = measure(sim.world);
    CHECK(glm::length(end.momentum - start.momentum) <= 1e-12 * glm::length(start.momentum));
    CHECK(end.kinetic < start.kinetic);
    CHECK(sim.world.bodies[b].velocity.x > 0.3);
  }
}

TEST_CASE("a chain dragged over the ground stays above it") {
  const auto depth_at = [](int rate) {
    World w;
    add_ground(w);
    Collision spares_own;
    spares_own.self = false;
    Body hand;
    hand.motion = Motion::kinematic, hand.pose.position = {0, 0.05, 0};
    Entity before = w.add_body(hand);
    const Entity handle = before;
    for (int i = 0; i < 10; ++i) {
      Shape rod = rod_shape(0.02, 0.05);
      const Entity e =
          add_solid(w, rod, {{-0.05 - 0.1 * i, 0.05, 0}, from_rotation_vector({0, 0, kPi / 2})},
                    Motion::dynamic, spares_own);
      // A capsule lies along its y, which points along -x here.
      add_link(w, {before, e, {before == handle ? Vec3(0) : Vec3(0, 0.05, 0), {0, -0.05, 0}}});
      before = e;
    }
    Simulation sim = Simulation::copy_of(w, {1.0 / rate});
    sim.settings.measure = true;
    Real depth = 0;
    for (int i = 0; i < 4 * rate; ++i) {
      Body& b = sim.world.bodies[handle];
      b.velocity = {2, 0, 2 * std::sin(6.0 * i / rate)};
      b.pose.position += b.velocity / Real(rate);
      const StepReport report = sim.step();
      CHECK(report.measures.worst_gap <= 1e-13);
      if (2 * i > rate) depth = std::max(depth, report.worst_depth);
    }
    return depth;
  };
  for (const int rate : {60, 120, 240}) CHECK(depth_at(rate) <= 1.5e-3);  // of a radius of 20 mm
}

TEST_CASE("what lies still is let lie, and stirred by a push, a hand or a ball") {
  for (int way = 0; way < 3; ++way) {
    World w;
    Collision solid;
    solid.others = true;
    add_ground(w, solid);
    const Entity box =
        add_solid(w, box_shape({0.2, 0.1, 0.2}), {{0, 0.1, 0}, kIdentity}, Motion::dynamic);
    const Entity ball =
        add_solid(w, ball_shape(0.1), {{0, 30, 0}, kIdentity}, Motion::dynamic, solid);
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    StepReport report;
    for (int i = 0; i < 60; ++i) report = sim.step();
    REQUIRE(report.asleep == 1);
    REQUIRE(report.contacts >= 3);
    if (way == 0) sim.world.push(box, {0, 8000, 0}, sim.world.bodies[box].pose.position);
    if (way == 1) sim.world.bodies[box].velocity = {0, 2, 0}, sim.world.bodies[box].restart = true;
    if (way == 2) sim.world.teleport(ball, {{0.1, 0.35, 0}, kIdentity});
    for (int i = 0; i < 6; ++i) report = sim.step();
    CHECK(report.asleep == 0);
    if (way < 2) CHECK(sim.world.bodies[box].pose.position.y > 0.11);
  }
}

TEST_CASE("contacts go the same way whatever the threads, and in a copy") {
  World w;
  Collision solid;
  solid.others = solid.self = true;
  add_ground(w, solid);
  Random dice(12);
  for (int i = 0; i < 12; ++i) {
    const Vec3 at = dice.in_box(0.3, 1.5) * Vec3(1, 2, 1);
    const Entity a =
        add_solid(w, box_shape({0.1, 0.05, 0.1}), {at, dice.rotation()}, Motion::dynamic, solid);
    const Entity b =
        add_solid(w, ball_shape(0.08), {at + Vec3(0.25, 0, 0), kIdentity}, Motion::dynamic, solid);
    add_link(w, {a, b, {to_local(w.bodies[a].pose, at + Vec3(0.12, 0, 0)), {-0.13, 0, 0}}});
  }
  Simulation one = Simulation::copy_of(w, {1.0 / 60}),
             four = Simulation::copy_of(w, {1.0 / 60, 1, 4});
  for (int i = 0; i < 60; ++i) one.step(), four.step();
  CHECK(state_hash(one.world) == state_hash(four.world));
  Simulation copy = Simulation::copy_of(one.world, {1.0 / 60});
  for (int i = 0; i < 60; ++i) one.step(), copy.step();
  CHECK(state_hash(one.world) == state_hash(copy.world));
}
