// Cables pull and never push.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/chains.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

Entity wall(World& w) {
  Body b;
  b.motion = Motion::fixed;
  return w.add_body(b);
}

Body ball(Vec3 position, Real mass = 1, Real drag = 0) {
  Body b;
  b.mass = mass, b.drag = drag;
  b.inertia = Vec3(0.4 * mass * 0.05 * 0.05);
  b.pose.position = position;
  return b;
}

Real span_of(const World& w, Entity string) {
  const Cable& s = w.cables[string];
  return glm::length(to_world(w.bodies[s.b].pose, s.joint.anchor_b) -
                     to_world(w.bodies[s.a].pose, s.joint.anchor_a));
}

}  // namespace

TEST_CASE("a slack string does nothing at all") {
  World near, far;
  const Vec3 start(0.1, -0.2, 0), velocity(0.3, 1, -0.2);
  const auto throw_ball = [&](World& w, Real length) {
    const Entity top = wall(w);
    Body b = ball(start);
    b.velocity = velocity, b.angular_velocity = {1, 2, 3};
    const Entity e = w.add_body(b);
    add_cable(w, {top, e, {Vec3(0), {0, 0.05, 0}, length, 0}});
    return e;
  };
  const Entity a = throw_ball(near, 5), b = throw_ball(far, 50);
  Simulation sim = Simulation::copy_of(near, {1.0 / 60}),
             other = Simulation::copy_of(far, {1.0 / 60});
  for (int i = 0; i < 50; ++i) {
    sim.step(), other.step();
    const Body &p = sim.world.bodies[a], &q = other.world.bodies[b];
    REQUIRE(glm::length(p.pose.position - q.pose.position) <= 1e-14);
    REQUIRE(glm::length(p.velocity - q.velocity) <= 1e-13);
    REQUIRE(glm::length(p.angular_velocity - q.angular_velocity) <= 1e-13);
    REQUIRE(sim.world.cables.values()[0].tension == 0);
  }
}

TEST_CASE("a taut string is never longer than it is, and its pull is never a push") {
  // Balls thrown about on cables of all lengths, light and heavy, tied to the wall or in pairs.
  Random dice(5);
  World w;
  const Entity top = wall(w);
  std::vector<Entity> cables;
  for (int i = 0; i < 12; ++i) {
    const Real length = dice.between(0.2, 1.5);
    const Vec3 at = 0.8 * length * dice.direction();
    Body b = ball(at, std::pow(10, dice.between(-1, 1)));
    b.velocity = 3.0 * dice.in_cube(1);
    const Entity first = w.add_body(b);
    cables.push_back(add_cable(w, {top, first, {Vec3(0), 0.05 * dice.direction(), length, 0}}));
    if (i % 2 == 0) continue;
    b = ball(at + Vec3(0, -0.3, 0), std::pow(10, dice.between(-1, 1)));
    const Entity second = w.add_body(b);
    cables.push_back(add_cable(w, {first, second, {{0, -0.05, 0}, {0, 0.05, 0}, 0.4, 0}}));
  }
  Simulation sim(std::move(w), {1.0 / 60});
  const Real start = measure(sim.world).energy();
  Real longest = 0, least = 0;
  int slack = 0, taut = 0;
  for (int i = 0; i < 600; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    for (Entity s : cables) {
      const Cable& string = sim.world.cables[s];
      longest = std::max(longest, span_of(sim.world, s) / string.joint.length - 1);
      least = std::min(least, string.tension);
      if (string.tension == 0) {
        ++slack;
      } else {
        ++taut;
        // It pulls only where it is drawn tight.
        REQUIRE(span_of(sim.world, s) >= 0.98 * string.joint.length);
      }
    }
    REQUIRE(measure(sim.world).energy() <= start + 0.02 * std::abs(start));
  }
  CHECK(longest <= 2e-4);
  CHECK(least == 0);
  CHECK(slack > 100);
  CHECK(taut > 100);
}

TEST_CASE("a weight hangs at the end of its string, with tension m g") {
  for (Real mass : {0.01, 1.0, 300.0}) {
    World w;
    const Entity top = wall(w);
    const Entity e = w.add_body(ball({0.3, -0.5, 0.1}, mass, 1.5));
    const Entity s = add_cable(w, {top, e, {Vec3(0), {0, 0.05, 0}, 0.8, 0}});
    Simulation sim(std::move(w), {1.0 / 60});
    for (int i = 0; i < 60 * 40; ++i) sim.step();
    CHECK(glm::length(sim.world.bodies[e].pose.position - Vec3(0, -0.85, 0)) <= 1e-5);
    CHECK(span_of(sim.world, s) == Approx(0.8).epsilon(1e-6));
    CHECK(sim.world.cables[s].tension == Approx(mass * 9.81).epsilon(1e-6));
  }
}

TEST_CASE("two strings share a weight as statics demand") {
  // From (-0.3, 0) and (0.5, 0) with lengths 0.5 and sqrt(0.5): the ball hangs at (0, -0.4)...
  World w;
  const Entity top = wall(w);
  const Entity e = w.add_body(ball({0.05, -0.35, 0.02}, 2, 1.5));
  const Real right = std::hypot(0.5, 0.4);
  const Entity a = add_cable(w, {top, e, {{-0.3, 0, 0}, Vec3(0), 0.5, 0}});
  const Entity b = add_cable(w, {top, e, {{0.5, 0, 0}, Vec3(0), right, 0}});
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 60 * 40; ++i) sim.step();
  CHECK(glm::length(sim.world.bodies[e].pose.position - Vec3(0, -0.4, 0)) <= 1e-5);
  // ... and the pulls T_a (-0.6, 0.8) + T_b (0.5, 0.4) / right = (0, m g).
  const Real ta = 2 * 9.81 / (0.8 + 0.6 * 0.8), tb = 0.6 * ta * right / 0.5;
  CHECK(sim.world.cables[a].tension == Approx(ta).epsilon(1e-5));
  CHECK(sim.world.cables[b].tension == Approx(tb).epsilon(1e-5));
}

TEST_CASE("an elastic string stretches by its compliance times the weight") {
  World w;
  const Entity top = wall(w);
  const Entity e = w.add_body(ball({0, -0.5, 0}, 2, 1));
  const Entity s = add_cable(w, {top, e, {Vec3(0), Vec3(0), 0.5, 0.004}});
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 60 * 40; ++i) sim.step();
  CHECK(span_of(sim.world, s) - 0.5 == Approx(0.004 * 2 * 9.81).epsilon(1e-5));
  CHECK(sim.world.cables[s].tension == Approx(2 * 9.81).epsilon(1e-5));
}

TEST_CASE("a string between two free bodies conserves their momentum") {
  World w;
  w.gravity = Vec3(0);
  Body b = ball({-0.2, 0, 0}, 1);
  b.velocity = {-1, 0.4, 0};
  const Entity left = w.add_body(b);
  b = ball({0.2, 0, 0}, 3);
  b.velocity = {1.5, 0, 0.2};
  const Entity right = w.add_body(b);
  const Entity s = add_cable(w, {left, right, {{-0.03, 0, 0}, {0.02, 0.01, 0}, 1, 0}});
  Simulation sim(std::move(w), {1.0 / 60});
  const Measures start = measure(sim.world);
  int taut = 0;
  for (int i = 0; i < 600; ++i) {
    sim.step();
    taut += sim.world.cables[s].tension > 0;
    const Measures now = measure(sim.world);
    // The stiffness of a loaded cable takes its other end for fixed: a little is lost there.
    REQUIRE(glm::length(now.momentum - start.momentum) <= 2e-5 * glm::length(start.momentum));
    REQUIRE(glm::length(now.angular_momentum - start.angular_momentum) <=
            0.1 * glm::length(start.angular_momentum));
    REQUIRE(now.energy() <= 1.001 * start.energy());
  }
  CHECK(taut > 5);
}

TEST_CASE("a string that is just slack under a resting puppet does not tremble") {
  // The lower cable of a ball that hangs from an upper one is a hair too long to be taut.
  World w;
  const Entity top = wall(w);
  const Entity e = w.add_body(ball({0, -0.5, 0}, 1, 0.5));
  add_cable(w, {top, e, {Vec3(0), Vec3(0), 0.5, 0}});
  const Entity loose = add_cable(w, {top, e, {{0, -1, 0}, Vec3(0), 0.5 + 1e-9, 0}});
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 60; ++i) sim.step();
  const Vec3 at = sim.world.bodies[e].pose.position;
  Real worst = 0;
  for (int i = 0; i < 600; ++i) {
    sim.step();
    worst = std::max(worst, glm::length(sim.world.bodies[e].pose.position - at));
    REQUIRE(sim.world.cables[loose].tension <= 1e-6);
  }
  CHECK(worst <= 1e-6);
}

TEST_CASE("a puppet hung from four strings comes to rest, hands slack or not") {
  World w;
  const Entity bar = wall(w);
  w.bodies[bar].pose.position = {0, 1, 0};
  Body torso = ball({0, 0, 0}, 2, 0.8);
  torso.inertia = box_inertia(2, {0.1, 0.2, 0.08});
  const Entity body = w.add_body(torso);
  std::vector<Entity> hands;
  for (Real side : {-1.0, 1.0}) {
    Entity before = body;
    Vec3 out(0.1 * side, 0.15, 0);
    for (int i = 0; i < 2; ++i) {
      Body arm = ball({side * (0.2 + 0.2 * i), 0.15, 0}, 0.2, 0.8);
      arm.inertia = box_inertia(0.2, {0.1, 0.02, 0.02});
      const Entity e = w.add_body(arm);
      add_link(w, {before, e, {out, {-0.1 * side, 0, 0}}});
      before = e, out = {0.1 * side, 0, 0};
    }
    hands.push_back(before);
    add_cable(w, {bar, body, {{0.1 * side, 0, 0}, {0.1 * side, 0.2, 0}, 0.8, 0}});
    // The left hand is lifted, the right one's cable is too long to be felt.
    add_cable(w, {bar, before, {{0.5 * side, 0, 0}, {0.1 * side, 0, 0}, side < 0 ? 0.85 : 3, 0}});
  }
  Simulation sim(std::move(w), {1.0 / 60, 1, 1, true});
  StepReport report;
  for (int i = 0; i < 60 * 30; ++i) {
    report = sim.step();
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.measures.worst_gap_rel <= 1e-13);
  }
  CHECK(report.measures.kinetic <= 1e-8);
  CHECK(report.unreached == 0);
  Real carried = 0;
  for (const Cable& s : sim.world.cables.values()) carried += s.tension;
  CHECK(carried > 2 * 9.81);
  CHECK(sim.world.cables.values()[3].tension == 0);
  const Real left = sim.world.bodies[hands[0]].pose.position.y;
  CHECK(left > sim.world.bodies[hands[1]].pose.position.y + 0.2);
}

TEST_CASE("strings carry an upper body that whirls as long as they are short of their length") {
  // A conical pendulum: tan(angle) = w^2 l sin(angle) / g.
  World w;
  const Entity top = wall(w);
  const Real angle = 0.6, length = 1, rate = std::sqrt(9.81 / (length * std::cos(angle)));
  Body b = ball(length * Vec3(std::sin(angle), -std::cos(angle), 0));
  b.velocity = {0, 0, -rate * length * std::sin(angle)};
  b.angular_velocity = {0, rate, 0};
  const Entity e = w.add_body(b);
  const Entity s = add_cable(w, {top, e, {Vec3(0), Vec3(0), length, 0}});
  Simulation sim(std::move(w), {1.0 / 240});
  Real worst = 0;
  for (int i = 0; i < 240 * 4; ++i) {
    sim.step();
    worst = std::max(worst, std::abs(sim.world.bodies[e].pose.position.y + std::cos(angle)));
  }
  CHECK(worst <= 5e-3);
  CHECK(sim.world.cables[s].tension == Approx(9.81 / std::cos(angle)).epsilon(0.01));
}

TEST_CASE("a handle that moves at once pulls a taut string without a spring back") {
  // Plastic, least kinetic energy: the eye of the string gets the speed of the handle.
  for (const Real arm : {0.0, 0.3})
    for (const Real h : {1e-5, 1e-4, 1e-3, 1.0 / 240, 1.0 / 60}) {
      if (arm > 0 && h > 1e-4) continue;  // it turns within the step
      World w;
      w.gravity = Vec3(0);
      Body b;
      b.drag = 0, b.mass = 2, b.inertia = Vec3(0.1);
      const Entity body = w.add_body(b);
      Body lead;
      lead.motion = Motion::kinematic, lead.pose.position = {1, arm, 0};
      const Entity handle = w.add_body(lead);
      add_cable(w, {handle, body, {Vec3(0), {0, arm, 0}, 1, 0}});
      Simulation sim(std::move(w), {h});
      sim.world.bodies[handle].pose.position.x += 3 * h;
      sim.world.bodies[handle].velocity = {3, 0, 0};
      sim.step();
      const Real share = (1 / 2.0) / (1 / 2.0 + arm * arm / 0.1);
      INFO("arm " << arm << ", step " << h);
      CHECK(std::abs(sim.world.bodies[body].velocity.x / (3 * share) - 1) <
            (arm > 0 ? 20 * h : 1e-6));
    }
}

TEST_CASE("a ball swings on a taut string as on a rod, to second order") {
  // From the horizontal, 1 s. The reference is the pendulum, by Runge-Kutta steps of 1e-4 s.
  Real angle = 0, speed = 0;
  const auto fall = [](Real x) { return 9.81 * std::cos(x); };
  for (int i = 0; i < 10000; ++i) {
    const Real d = 1e-4, k1 = fall(angle), k2 = fall(angle + d / 2 * speed),
               k3 = fall(angle + d / 2 * speed + d * d / 4 * k1),
               k4 = fall(angle + d * speed + d * d / 2 * k2);
    angle += d * speed + d * d / 6 * (k1 + k2 + k3);
    speed += d / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  const Vec3 right(std::cos(angle), -std::sin(angle), 0);
  for (const Real rate : {60.0, 240.0}) {
    World w;
    Body nail;
    nail.motion = Motion::fixed;
    const Entity top = w.add_body(nail);
    Body b;
    b.drag = 0, b.mass = 1, b.inertia = Vec3(1e-3), b.pose.position = {1, 0, 0};
    const Entity ball = w.add_body(b);
    add_cable(w, {top, ball, {Vec3(0), Vec3(0), 1, 0}});
    Simulation sim(std::move(w), {1 / rate});
    for (int i = 0; i < static_cast<int>(rate); ++i) sim.step();
    const Body& end = sim.world.bodies[ball];
    const Real energy = 0.5 * glm::dot(end.velocity, end.velocity) + 9.81 * end.pose.position.y;
    INFO(rate << " Hz: " << glm::length(end.pose.position - right) << " m, " << energy << " J");
    CHECK(glm::length(end.pose.position - right) < (rate > 100 ? 2e-2 : 8e-2));
    CHECK(std::abs(energy) < (rate > 100 ? 0.05 : 0.3));
  }
}
