// What the rules of the paper do with bodies that enter something: translated out of it along its
// normals, jointed or free, and held across them by friction.
#include <catch2/catch.hpp>

#include "engine/contact/contact.hpp"
#include "engine/joints/joint.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// Solved by sweeps, undamped.
World swept_world() {
  World w;
  w.default_settings.solver = Solver::sweep;
  return w;
}

/// Ten rods of 0.1 m that hang from a body led along, over a floor that the last ones lie on.
struct LedChain {
  World world = swept_world();
  Entity hand;
  std::vector<Entity> links;

  LedChain() {
    add_ground(world, {.friction = 0.5});
    Body b;
    b.motion = Motion::kinematic, b.pose.position = {0, 0.7, 0};
    hand = world.add_body(b);
    Entity before = hand;
    Vec3 top = b.pose.position;
    for (int i = 0; i < 10; ++i) {  // an arc from the hand to the floor
      const Quat turn = from_rotation_vector({0, 0, -0.16 * i});
      const Entity e =
          add_solid(world, rod_shape(0.01, 0.04), {top - turn * Vec3(0, 0.05, 0), turn},
                    Motion::dynamic, {.friction = 0.5});
      world.bodies[e].drag = 10;
      add_link(world, {before, e, {i == 0 ? Vec3(0) : Vec3(0, -0.05, 0), Vec3(0, 0.05, 0)}});
      top -= turn * Vec3(0, 0.1, 0);
      before = e, links.push_back(e);
    }
  }

  /// The lowest point of any rod, m above the floor.
  static Real lowest(const World& w, const std::vector<Entity>& links) {
    Real low = 1;
    for (const Entity e : links) {
      const Pose& pose = w.bodies[e].pose;
      low = std::min(low, pose.position.y - std::abs((pose.rotation * Vec3(0, 0.04, 0)).y) - 0.01);
    }
    return low;
  }
};

/// Two legs of two rods each, on ball joints below hips that are led; the feet are the ends of the
/// shins, 0.05 m round.
struct LedLegs {
  World world = swept_world();
  Entity hips;
  std::vector<Entity> shins;

  explicit LedLegs(Real friction) {
    add_ground(world, {.friction = friction});
    Body b;
    b.motion = Motion::kinematic, b.pose.position = {0, 0.95, 0};
    hips = world.add_body(b);
    for (const Real side : {-0.1, 0.1}) {
      const Vec3 hip{0, 0.95, side}, knee{0.15, 0.5, side}, ankle{0, 0.05, side};
      const Entity thigh = add_rod(hip, knee, friction), shin = add_rod(knee, ankle, friction);
      const Vec3 half{0, glm::length(hip - knee) / 2, 0};
      add_link(world, {hips, thigh, {{0, 0, side}, half}});
      add_link(world, {thigh, shin, {-half, half}});
      shins.push_back(shin);
    }
  }

  Entity add_rod(Vec3 from, Vec3 to, Real friction) {
    const Vec3 up = glm::normalize(from - to);
    const Quat turn = from_rotation_vector({0, 0, -std::atan2(up.x, up.y)});
    const Entity e =
        add_solid(world, rod_shape(0.05, glm::length(from - to) / 2),
                  {Real(0.5) * (from + to), turn}, Motion::dynamic, {.friction = friction});
    world.bodies[e].drag = 5;
    return e;
  }
};

/// The angle of a shin from upright, rad, and the middle of its foot.
Real lean_of(const Body& shin) {
  const Vec3 up = shin.pose.rotation * Vec3(0, 1, 0);
  return std::atan2(up.x, up.y);
}
Vec3 foot_of(const Body& shin) {
  return shin.pose.position - shin.pose.rotation * Vec3(0, std::hypot(0.15, 0.45) / 2, 0);
}

}  // namespace

TEST_CASE("a chain that is led over a floor lies on it, and stays joined") {
  for (const Real h : {1.0 / 60, 1.0 / 240}) {
    LedChain c;
    Simulation sim = Simulation::copy_of(c.world, {h});
    Real below_hand = 1;
    for (int i = 0; i < 3 / h; ++i) {
      Body& hand = sim.world.bodies[c.hand];
      hand.velocity = {0.3, 0, 0};
      hand.pose.position.x += 0.3 * h;
      const StepReport report = sim.step();
      REQUIRE(report.status == Status::ok);
      REQUIRE(report.measures.worst_gap <= 1e-12);
      REQUIRE(LedChain::lowest(sim.world, c.links) >= -1e-4);
      below_hand = std::min(below_hand, LedChain::lowest(sim.world, c.links));
    }
    CHECK(below_hand <= 1e-6);  // it did lie there
    CHECK(sim.world.bodies[c.links.back()].velocity.x > 0.2);
  }
}

TEST_CASE("a box pushed out of a slope stands or slides as its friction says") {
  const Real slope = 0.4;
  const Quat tilt = from_rotation_vector({0, 0, -slope});
  for (const Real h : {1.0 / 60, 1.0 / 240})
    for (const Real friction : {0.0, 0.3, 0.43}) {
      World w = swept_world();
      add_ground(w, {.friction = friction}, tilt);
      const Vec3 start = tilt * Vec3(0, 0.1, 0);
      const Entity e = add_solid(w, box_shape({0.2, 0.1, 0.2}), {start, tilt}, Motion::dynamic,
                                 {.friction = friction});
      Simulation sim = Simulation::copy_of(w, {h});
      for (int i = 0; i < std::lround(1 / h); ++i) sim.step();
      const Real pull = std::sin(slope) - friction * std::cos(slope);
      const Real way = glm::length(sim.world.bodies[e].pose.position - start);
      CHECK(std::abs(way - std::max(Real(0), 9.81 / 2 * pull)) <= 1e-9);
    }
}

TEST_CASE("feet hold the floor by friction while the hips are led, and roll there") {
  LedLegs legs(1);
  Simulation sim = Simulation::copy_of(legs.world, {1.0 / 60});
  const Entity shin = legs.shins.front();
  const Vec3 start = foot_of(sim.world.bodies[shin]);
  const Real lean = lean_of(sim.world.bodies[shin]);
  for (int i = 0; i < 180; ++i) {
    sim.world.bodies[legs.hips].velocity = {0.05, 0, 0};
    sim.world.bodies[legs.hips].pose.position.x += 0.05 / 60;
    const StepReport report = sim.step();
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.measures.worst_gap <= 1e-12);
    REQUIRE(report.worst_depth <= 1e-4);
    const Body& now = sim.world.bodies[shin];
    const Real rolled = 0.05 * (lean_of(now) - lean);
    REQUIRE(std::abs(foot_of(now).x - start.x - rolled) <= 5e-4);
  }
  CHECK(sim.world.bodies[legs.hips].pose.position.x > 0.149);
}

TEST_CASE("feet without friction slip", "[limit]") {
  LedLegs legs(0);
  Simulation sim = Simulation::copy_of(legs.world, {1.0 / 60});
  const Real start = foot_of(sim.world.bodies[legs.shins.front()]).x;
  for (int i = 0; i < 60; ++i) sim.step();
  CHECK(std::abs(foot_of(sim.world.bodies[legs.shins.front()]).x - start) > 0.05);
}

TEST_CASE("what starts deep in a floor is pushed out slowly") {
  World w = swept_world();
  add_ground(w);
  const Entity e = add_solid(w, ball_shape(0.1), {{0, 0.05, 0}}, Motion::dynamic);
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  for (int i = 0; i < 300; ++i) {
    sim.step();
    REQUIRE(sim.world.bodies[e].pose.position.y <= 0.1 + 0.02);
  }
  CHECK(std::abs(sim.world.bodies[e].pose.position.y - 0.1) <= 1e-9);
}

TEST_CASE("a ball that rolls or spins stays on the floor, however fast it turns") {
  for (const Real spin : {5.0, 50.0}) {
    World w = swept_world();
    add_ground(w);
    const Entity e = add_solid(w, ball_shape(0.1), {{0, 0.1, 0}}, Motion::dynamic);
    w.bodies[e].angular_velocity = {0, 0, spin};
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    for (int i = 0; i < 180; ++i) sim.step();
    CHECK(std::abs(sim.world.bodies[e].pose.position.y - 0.1) <= 1e-9);
  }
}

TEST_CASE("the forces of what is pushed out are those that carry it, and belts and lifts do work") {
  for (const Vec3 belt : {Vec3(0), Vec3(1, 0, 0)}) {
    World w = swept_world();
    const Entity lift = add_solid(w, box_shape({20, 0.05, 2}), {{0, -0.05, 0}}, Motion::kinematic,
                                  {.friction = 0.5, .surface_velocity = belt});
    const Entity e =
        add_solid(w, box_shape({0.1, 0.1, 0.1}), {{0, 0.1, 0}}, Motion::dynamic, {.friction = 0.5});
    const Real mass = w.bodies[e].mass, h = 1.0 / 60;
    Simulation sim(std::move(w), {h, 1, 1, false, true});
    const auto height = [&](int i) { return 0.1 * (1 - std::cos(3 * h * i)); };
    for (int i = 0; i < 180; ++i) {
      sim.world.bodies[lift].velocity.y = (height(i + 1) - height(i)) / h;
      sim.world.bodies[lift].pose.position.y = height(i + 1) - 0.05;
      sim.step();
      if (i == 0) continue;
      Vec3 force(0);
      for (const Contact& c : contacts_of(sim.world)) force += c.force;
      const Real gained = (height(i + 1) - 2 * height(i) + height(i - 1)) / (h * h);
      CHECK(std::abs(force.y - mass * (9.81 + gained)) <= 1e-9 * mass * 9.81);
    }
    CHECK(sim.findings().empty());
  }
}

TEST_CASE("a chain that becomes solid while it swings is pushed out from then on") {
  LedChain c;
  std::vector<Collision> solid;
  for (const Entity e : c.links)
    solid.push_back(c.world.collisions[e]), c.world.collisions.remove(e);
  const Entity ground = c.world.collisions.owners().front();
  const Collision on_ground = c.world.collisions[ground];
  c.world.collisions.remove(ground);
  Simulation sim = Simulation::copy_of(c.world, {1.0 / 60});
  sim.step();
  sim.world.collisions.add(ground, on_ground);
  for (std::size_t i = 0; i < solid.size(); ++i) sim.world.collisions.add(c.links[i], solid[i]);
  for (int i = 0; i < 120; ++i) sim.step();
  CHECK(LedChain::lowest(sim.world, c.links) >= -1e-4);
}
