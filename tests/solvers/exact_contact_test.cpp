// Bodies of the exact solver in contact, against closed forms.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "engine/world/ties.hpp"
#include "tests/base/random.hpp"
#include "tests/solvers/exact.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kGravity = 9.81;

Shape ball_of(Real radius) {
  Shape s;
  s.size = {radius, 0, 0};
  return s;
}
Shape box_of(Vec3 half) {
  Shape s;
  s.kind = ShapeKind::box, s.size = half;
  return s;
}

/// A solid body with the mass of water.
Entity put(World& w, const Shape& shape, const Pose& at, const Collision& c,
           Motion motion = Motion::dynamic) {
  Body b;
  b.drag = 0, b.pose = at, b.motion = motion;
  if (motion == Motion::dynamic) {
    const MassProperties m = mass_properties(shape, 1000);
    b.mass = m.mass, b.inertia = {m.inertia[0][0], m.inertia[1][1], m.inertia[2][2]};
  }
  const Entity e = w.add_body(b);
  w.shapes.add(e, {{shape}});
  w.collisions.add(e, c);
  return e;
}

Entity put_floor(World& w, const Collision& c, Quat rotation = kIdentity) {
  Shape s;
  s.kind = ShapeKind::plane, s.size = {5, 0, 0};
  return put(w, s, {Vec3(0), rotation}, c, Motion::fixed);
}

/// A round rod between two points.
Entity put_rod(World& w, Vec3 from, Vec3 to, const Collision& c) {
  const Vec3 along = glm::normalize(to - from), axis = glm::cross(Vec3(0, 1, 0), along);
  const Real sine = glm::length(axis), angle = std::atan2(sine, along.y);
  Shape s;
  s.kind = ShapeKind::capsule, s.size = {0.02, glm::length(to - from) / 2, 0};
  const Vec3 turn = sine > 0 ? angle / sine * axis : Vec3(0, 0, along.y > 0 ? 0 : kPi);
  return put(w, s, {0.5 * (from + to), from_rotation_vector(turn)}, c);
}

Entity hinge(World& w, Entity a, Entity b, Vec3 at) {
  return add_link(w, {a, b, joint_at(w, a, b, JointKind::hinge, at, frame_along({0, 0, 1}))});
}

Collision surface(Real friction, Real restitution = 0) {
  Collision c;
  c.friction = friction, c.restitution = restitution, c.others = true;
  return c;
}

/// How high a ball jumps after a fall of a metre, of the height due.
Real excess_of_jump(Integrator by, Real restitution, Real hz) {
  World w = exact_world(by);
  put_floor(w, surface(0, restitution));
  const Entity ball = put(w, ball_of(0.1), {{0, 1.1, 0}, kIdentity}, surface(0, restitution));
  Simulation sim = Simulation::copy_of(w, {1 / hz});
  Real highest = 0;
  bool hit = false;
  for (int i = 0; i < 0.9 * hz; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    for (const Contact& c : contacts_of(sim.world)) hit = hit || c.active;
    if (hit) highest = std::max(highest, sim.world.bodies[ball].pose.position.y - 0.1);
  }
  REQUIRE(hit);
  return highest - restitution * restitution;
}

/// Force of all contacts on the bodies of the exact solver, by the floor.
Vec3 force_of_floor(const World& w) {
  Vec3 sum(0);
  for (const Contact& c : contacts_of(w))
    if (w.bodies.values()[c.slot_b].motion == Motion::fixed) sum += c.force;
  return sum;
}

Vec3 momentum_of(const World& w) {
  Vec3 sum(0);
  for (const Body& b : w.bodies.values())
    if (b.motion == Motion::dynamic) sum += b.mass * b.velocity;
  return sum;
}

}  // namespace

TEST_CASE("an exact ball jumps to the height that restitution leaves it") {
  for (const Integrator by : kAll)
    for (const Real e : {1.0, 0.5, 0.0}) {
      INFO(name_of(by) << ", restitution " << e);
      CHECK(std::abs(excess_of_jump(by, e, 60)) < 3e-3);
      CHECK(std::abs(excess_of_jump(by, e, 240)) < 1e-3);
    }
}

TEST_CASE("an exact box sticks to a slope below the angle of friction and slides above it") {
  for (const Integrator by : kAll)
    for (const Real beyond : {-0.05, 0.05, 5.0}) {  // degrees
      const Real angle = std::atan(0.5) + beyond * kPi / 180;
      World w = exact_world(by);
      const Quat tilt = from_rotation_vector({0, 0, -angle});
      put_floor(w, surface(0.5), tilt);
      const Vec3 start = tilt * Vec3(0, 0.05, 0), down = tilt * Vec3(1, 0, 0);
      const Entity box = put(w, box_of({0.1, 0.05, 0.1}), {start, tilt}, surface(0.5));
      Simulation sim = Simulation::copy_of(w, {1.0 / 60});
      for (int i = 0; i < 60; ++i) REQUIRE(sim.step().status == Status::ok);
      const Body& b = sim.world.bodies[box];
      INFO(name_of(by) << ", " << beyond << " degrees beyond");
      const Real due = std::max(Real(0), kGravity * (std::sin(angle) - 0.5 * std::cos(angle)));
      CHECK(glm::dot(b.velocity, down) == Approx(due).epsilon(1e-3).margin(1e-9));
      const Real way = glm::dot(b.pose.position - start, down);
      CHECK(way == Approx(due / 2).epsilon(by == Integrator::euler ? 0.02 : 1e-3).margin(1e-9));
      CHECK(std::abs(glm::dot(b.pose.position - start, tilt * Vec3(0, 1, 0))) < 1e-9);
    }
}

TEST_CASE("an exact ball rolls down a slope and is carried by a belt") {
  for (const Integrator by : kAll) {
    INFO(name_of(by));
    const Real angle = kPi / 18;
    World w = exact_world(by);
    const Quat tilt = from_rotation_vector({0, 0, -angle});
    put_floor(w, surface(0.5), tilt);
    const Entity ball = put(w, ball_of(0.1), {tilt * Vec3(0, 0.1, 0), tilt}, surface(0.5));
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    for (int i = 0; i < 60; ++i) REQUIRE(sim.step().status == Status::ok);
    const Body& b = sim.world.bodies[ball];
    CHECK(glm::length(b.velocity) == Approx(5.0 / 7 * kGravity * std::sin(angle)).epsilon(1e-9));
    CHECK(glm::length(b.velocity) == Approx(0.1 * glm::length(b.angular_velocity)).epsilon(1e-12));

    World moving = exact_world(by);
    const Entity belt = put(moving, box_of({5, 0.1, 5}), {{0, -0.1, 0}, kIdentity}, surface(0.5),
                            Motion::kinematic);
    const Entity carried = put(moving, ball_of(0.1), {{0, 0.1, 0}, kIdentity}, surface(0.5));
    Simulation run = Simulation::copy_of(moving, {1.0 / 60});
    for (int i = 0; i < 60; ++i) {
      Body& under = run.world.bodies[belt];
      under.velocity = {1, 0, 0}, under.pose.position.x += 1.0 / 60;
      REQUIRE(run.step().status == Status::ok);
    }
    CHECK(run.world.bodies[carried].velocity.x == Approx(2.0 / 7).epsilon(1e-9));
  }
}

TEST_CASE("the floor bears the weight of exact bodies, and joints what is left of it") {
  for (const Integrator by : kAll) {
    INFO(name_of(by));
    World w = exact_world(by);
    put_floor(w, surface(0.8));
    const Entity hook = add_ground(w);
    const Vec3 hip{0, 1.2, 0}, knee{0.5, 0.8, 0}, foot{0.4, 0.02, 0};
    const Entity thigh = put_rod(w, hip, knee, surface(0.8)),
                 shin = put_rod(w, knee, foot, surface(0.8));
    hinge(w, hook, thigh, hip);
    hinge(w, thigh, shin, knee);
    const Entity box = put(w, box_of({0.1, 0.05, 0.1}),
                           {{2, 0.3, 0}, from_rotation_vector({0.2, 0.1, 0.3})}, surface(0.5));
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    for (int i = 0; i < 240; ++i) REQUIRE(sim.step().unsolved == 0);
    const World& now = sim.world;
    for (const Entity e : {thigh, shin, box}) CHECK(glm::length(now.bodies[e].velocity) < 1e-6);
    for (const Contact& c : contacts_of(now)) CHECK(c.depth < 1e-9);
    const auto& islands = lagrangian::islands_of(now);
    const Vec3 at_hip = lagrangian::joint_wrench(islands[0], 0).force;
    Vec3 legs(0), below(0);
    for (const Contact& c : contacts_of(now))
      (c.slot_a == now.bodies.slot(box) ? below : legs) += c.force;
    CHECK(below.y == Approx(kGravity * now.bodies[box].mass).epsilon(1e-6));
    CHECK(legs.y > 0);
    if (by == Integrator::implicit || by == Integrator::euler) continue;  // told at another time
    const Real weight = kGravity * (now.bodies[thigh].mass + now.bodies[shin].mass);
    CHECK(std::abs(legs.y + at_hip.y - weight) < 1e-6 * weight);
    CHECK(std::abs(legs.x + at_hip.x) < 1e-6 * weight);
  }
}

TEST_CASE("exact bodies hand on momentum when they meet") {
  for (const Integrator by : kAll) {
    INFO(name_of(by));
    World w = exact_world(by, Vec3(0));
    const Entity a = put(w, ball_of(0.1), {}, surface(0.3, 1)),
                 b = put(w, ball_of(0.1), {{0.5, 0, 0}, kIdentity}, surface(0.3, 1));
    w.bodies[a].velocity = {2, 0, 0};
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    for (int i = 0; i < 60; ++i) sim.step();
    CHECK(std::abs(sim.world.bodies[a].velocity.x) < 1e-12);
    CHECK(sim.world.bodies[b].velocity.x == Approx(2).epsilon(1e-12));

    World skew = exact_world(by, Vec3(0));
    Entity last = put_rod(skew, {0, 0, 0}, {0.4, 0, 0}, surface(0.5, 0.4));
    const Entity more = put_rod(skew, {0.4, 0, 0}, {0.8, 0.1, 0}, surface(0.5, 0.4));
    add_link(skew, {last, more, joint_at(skew, last, more, JointKind::ball, {0.4, 0, 0})});
    const Entity flying =
        put(skew, box_of({0.1, 0.05, 0.07}), {{0.3, 0.5, 0.02}, kIdentity}, surface(0.5, 0.4));
    skew.bodies[flying].velocity = {0.3, -2, 0.1}, skew.bodies[flying].angular_velocity = {1, 2, 3};
    const Vec3 before = momentum_of(skew);
    Simulation run = Simulation::copy_of(skew, {1.0 / 240});
    bool hit = false;
    for (int i = 0; i < 240; ++i) {
      REQUIRE(run.step().status == Status::ok);
      for (const Contact& c : contacts_of(run.world)) hit = hit || c.active;
    }
    CHECK(hit);
    CHECK(glm::length(momentum_of(run.world) - before) < 1e-12 * glm::length(before));
  }
}

TEST_CASE("a row of exact pendulums passes a blow on") {
  for (const Real apart : {0.0, 1e-3}) {
    World w = exact_world(Integrator::rk4);
    const Entity hook = add_ground(w);
    std::vector<Entity> balls;
    for (int i = 0; i < 5; ++i) {
      const Real x = i * (0.2 + apart);
      balls.push_back(put(w, ball_of(0.1), {{x, -1, 0}, kIdentity}, surface(0, 1)));
      if (i == 0) {
        const Quat lift = from_rotation_vector({0, 0, -0.5});
        w.bodies[balls[0]].pose = {lift * Vec3(0, -1, 0), lift};
      }
      Joint j;
      j.kind = JointKind::hinge, j.anchor_a = {x, 0, 0}, j.anchor_b = {0, 1, 0};
      j.frames.set(frame_along({0, 0, 1}), frame_along({0, 0, 1}));
      add_link(w, {hook, balls.back(), j});
    }
    Simulation sim = Simulation::copy_of(w, {1.0 / 240});
    Real first = 0, last = 0, energy = 0;
    sim.settings.measure = true;
    for (int i = 0; i < 150; ++i) {
      const StepReport r = sim.step();
      if (i == 0) energy = r.measures.energy();
      CHECK(r.measures.energy() < energy + 1e-5);
      first = std::max(first, sim.world.bodies[balls[0]].velocity.x);
      last = std::max(last, sim.world.bodies[balls[4]].velocity.x);
    }
    INFO("apart " << apart);
    CHECK(last == Approx(first).epsilon(0.01));
    for (int i = 0; i < 4; ++i)
      CHECK(std::abs(sim.world.bodies[balls[i]].velocity.x) < 0.01 * first);
  }
}

TEST_CASE("a four-bar linkage whose coupler strikes the floor keeps its joints and gains nothing") {
  for (const Integrator by : kAll)
    for (const Collision& c : {surface(0.5, 0), surface(0.5, 0.5), surface(0, 0.8)}) {
      INFO(name_of(by) << ", restitution " << c.restitution);
      World w = exact_world(by);
      put_floor(w, c);
      const Entity hook = add_ground(w);
      const Vec3 p[] = {{0, 1, 0}, {0.2, 1.5, 0}, {1, 1.6, 0}, {1.2, 1, 0}};
      const Entity crank = put_rod(w, p[0], p[1], c), coupler = put_rod(w, p[1], p[2], c),
                   rocker = put_rod(w, p[2], p[3], c);
      Shape foot;
      foot.kind = ShapeKind::capsule, foot.size = {0.03, 0.5, 0};
      const Pose at = w.bodies[coupler].pose;
      foot.local.position = glm::conjugate(at.rotation) * (Vec3(0.6, 0.85, 0) - at.position);
      foot.local.rotation = glm::conjugate(at.rotation);
      w.shapes[coupler].list.push_back(foot);
      hinge(w, hook, crank, p[0]);
      hinge(w, crank, coupler, p[1]);
      hinge(w, coupler, rocker, p[2]);
      hinge(w, rocker, hook, p[3]);
      Simulation sim = Simulation::copy_of(w, {1.0 / 240});
      sim.settings.measure = true;
      bool hit = false;
      Real start = 0, lowest = 1e300, worst_rise = 0;
      for (int i = 0; i < 480; ++i) {
        const StepReport r = sim.step();
        REQUIRE(r.status == Status::ok);
        CHECK(r.unsolved == 0);
        CHECK(r.measures.worst_gap < 1e-9);
        CHECK(r.worst_depth < 1e-6);
        hit = hit || r.contacts > 0;
        const Real energy = r.measures.energy();
        if (i == 0) start = energy;
        CHECK(energy < start + 1e-3);
        worst_rise = std::max(worst_rise, energy - lowest), lowest = std::min(lowest, energy);
      }
      CHECK(hit);
      // What the integrator itself errs by between blows.
      CHECK(worst_rise < (by == Integrator::euler ? 1e-7 : 1e-2));
    }
}

TEST_CASE("an exact chain laid on the floor comes to rest there") {
  for (const Integrator by : kAll) {
    INFO(name_of(by));
    Collision c = surface(0.5);
    c.self = true;
    World w = exact_world(by);
    put_floor(w, c);
    std::vector<Entity> links;
    Real weight = 0;
    for (int i = 0; i < 10; ++i) {
      const Vec3 from{0.08 * i, 0.3 + 0.06 * i, 0};
      links.push_back(put_rod(w, from, from + Vec3(0.08, 0.06, 0), c));
      weight += kGravity * w.bodies[links.back()].mass;
      if (i > 0)
        add_link(w, {links[i - 1], links[i],
                     joint_at(w, links[i - 1], links[i], JointKind::ball, from)});
    }
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    sim.settings.measure = true;
    for (int i = 0; i < 240; ++i) {
      const StepReport r = sim.step();
      REQUIRE(r.status == Status::ok);
      CHECK(r.measures.worst_gap < 1e-10);
    }
    for (const Entity e : links) CHECK(glm::length(sim.world.bodies[e].velocity) < 1e-9);
    CHECK(force_of_floor(sim.world).y == Approx(weight).epsilon(1e-6));
  }
}

TEST_CASE("exact boxes stand on one another, a hundred times heavier ones too") {
  for (const Integrator by : kAll) {
    INFO(name_of(by));
    World w = exact_world(by);
    put_floor(w, surface(0.5));
    std::vector<Entity> boxes;
    for (int i = 0; i < 4; ++i)
      boxes.push_back(put(w, box_of(Vec3(0.1)), {{0, 0.1 + 0.2 * i, 0}, kIdentity}, surface(0.5)));
    w.bodies[boxes[3]].mass *= 100, w.bodies[boxes[3]].inertia *= 100;
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    for (int i = 0; i < 60; ++i) REQUIRE(sim.step().unsolved == 0);
    for (int i = 0; i < 4; ++i)
      CHECK(glm::length(sim.world.bodies[boxes[i]].pose.position - Vec3(0, 0.1 + 0.2 * i, 0)) <
            1e-8);
    CHECK(force_of_floor(sim.world).y == Approx(kGravity * 8 * 103).epsilon(1e-6));
  }
}

TEST_CASE("the exact and the default solver agree on a rod that strikes a ball") {
  const auto speed = [](Solver solver, Real hz) {
    World w;
    w.default_settings.solver = solver;
    const Entity hook = add_ground(w);
    const Entity rod = put_rod(w, {0, 0, 0}, {1, 0, 0}, surface(0));
    Joint j = joint_at(w, hook, rod, JointKind::hinge, Vec3(0), frame_along({0, 0, 1}));
    add_link(w, {hook, rod, j});
    const Entity post = put(w, ball_of(0.05), {{0.1, -0.8, 0}, kIdentity}, surface(0));
    w.bodies[post].gravity_scale = 0;
    Simulation sim = Simulation::copy_of(w, {1 / hz});
    for (int i = 0; i < 0.8 * hz - 0.5; ++i) REQUIRE(sim.step().status == Status::ok);
    return sim.world.bodies[post].velocity.x;
  };
  const Real coarse = speed(Solver::lagrangian, 120), fine = speed(Solver::lagrangian, 960);
  CHECK(fine < -0.5);
  CHECK(coarse == Approx(fine).epsilon(0.02));
  CHECK(speed(Solver::articulated, 960) == Approx(fine).epsilon(0.005));
}

TEST_CASE("a limit holds when a contact pushes a joint against it") {
  for (const Integrator by : kAll) {
    INFO(name_of(by));
    World w = exact_world(by);
    put_floor(w, surface(0.5));
    const Entity hook = add_ground(w);
    // A knee that must not bend the other way, let down on its foot by a vertical guide.
    const Vec3 hip{0, 1.1, 0}, knee{0.02, 0.6, 0}, foot{0, 0.1, 0};
    const Entity thigh = put_rod(w, hip, knee, surface(0.5)),
                 shin = put_rod(w, knee, foot, surface(0.5));
    const Quat up = frame_along({0, 1, 0});
    add_link(w, {hook, thigh, joint_at(w, hook, thigh, JointKind::prismatic, hip, up)});
    Joint j = joint_at(w, thigh, shin, JointKind::hinge, knee, frame_along({0, 0, 1}));
    j.limits.edit().angle = {true, -0.001, 1};
    const Entity bend = add_link(w, {thigh, shin, j});
    Simulation sim = Simulation::copy_of(w, {1.0 / 120});
    Real least = 1;
    for (int i = 0; i < 240; ++i) {
      REQUIRE(sim.step().status == Status::ok);
      least = std::min(least, coordinate_of(sim.world, bend, Coordinate::angle));
    }
    CHECK(least > -0.002);
    CHECK(worst_gap(sim.world) < 1e-10);
  }
}

TEST_CASE("random mechanisms that fall on the floor and a block keep their joints, gain nothing") {
  for (unsigned seed = 0; seed < 8; ++seed) {
    Random random(seed);
    const auto within = [&](Real low, Real high) { return random.between(low, high); };
    const Real friction = within(0, 1.2), restitution = seed % 3 == 0 ? within(0, 1) : 0;
    Collision c = surface(friction, restitution);
    c.self = seed % 2 == 0;
    World w = exact_world(kAll[seed % 4]);
    put_floor(w, c);
    put(w, box_of({0.3, 0.2, 0.3}), {{0.2, 0.2, 0}, kIdentity}, c, Motion::fixed);
    const JointKind kinds[] = {JointKind::ball, JointKind::hinge, JointKind::universal,
                               JointKind::fixed};
    Real start = 0;
    for (int tree = 0; tree < 2; ++tree) {
      Vec3 from = random.in_cube(0.4) + Vec3(0, 1.5 + tree, 0);
      Entity last;
      for (int i = 0; i < 4; ++i) {
        const Vec3 way = random.in_cube(1) + Vec3(0, 1.2, 0);
        const Vec3 to = from + within(0.15, 0.4) * glm::normalize(way);
        const Entity e = put_rod(w, from, to, c);
        if (i > 0)
          add_link(w, {last, e,
                       joint_at(w, last, e, kinds[(seed + i) % 4], from,
                                frame_along(random.in_cube(1) + Vec3(0, 0, 2)))});
        start += kGravity * w.bodies[e].mass * w.bodies[e].pose.position.y;
        last = e, from = to;
      }
    }
    Simulation sim = Simulation::copy_of(w, {1.0 / 120});
    sim.settings.measure = true;
    INFO("seed " << seed << ", " << name_of(kAll[seed % 4]));
    bool hit = false;
    for (int i = 0; i < 240; ++i) {
      const StepReport r = sim.step();
      REQUIRE(r.status == Status::ok);
      REQUIRE(r.measures.energy() < 1.001 * start);
      REQUIRE(r.measures.worst_gap < 1e-10);
      hit = hit || r.contacts > 0;
    }
    CHECK(hit);
  }
}

TEST_CASE("exact contacts repeat to the bit, from a copy too") {
  Collision c = surface(0.5, 0.3);
  World w = exact_world(Integrator::rk4);
  put_floor(w, c);
  for (int i = 0; i < 4; ++i)
    put(w, box_of({0.1, 0.05, 0.07}),
        {{0.03 * i, 0.2 + 0.25 * i, 0}, from_rotation_vector({0.1 * i, 0.2, 0.3})}, c);
  Simulation one = Simulation::copy_of(w, {1.0 / 60}), two = Simulation::copy_of(w, {1.0 / 60});
  for (int i = 0; i < 40; ++i) one.step(), two.step();
  CHECK(state_hash(one.world) == state_hash(two.world));
  Simulation copy = Simulation::copy_of(one.world, {1.0 / 60});
  for (int i = 0; i < 40; ++i) one.step(), two.step(), copy.step();
  CHECK(state_hash(one.world) == state_hash(two.world));
  CHECK(state_hash(copy.world) == state_hash(one.world));
}
