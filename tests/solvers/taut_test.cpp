// Taut chains between two pins, and pins on other bodies.
#include <catch2/catch.hpp>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/ties.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

/// A chain of `links` rods, 1 m together, hanging as an arc between pins `chord` apart.
struct Arc {
  World world;
  Entity pin;
};

Arc arc(int links, Real chord) {
  const Real l = 1.0 / links;
  Real low = 1e-9, high = 2 * kPi / links;
  for (int i = 0; i < 200; ++i) {
    const Real bend = 0.5 * (low + high);
    (l * std::sin(links * bend / 2) / std::sin(bend / 2) > chord ? low : high) = bend;
  }
  Arc made;
  World& w = made.world;
  w.default_settings.tolerance = 1e-6;
  Body wall;
  wall.motion = Motion::fixed;
  Entity before = w.add_body(wall);
  Vec3 at(0);
  Real angle = -(links - 1) * low / 2;
  for (int i = 0; i < links; ++i, angle += low) {
    const Vec3 way(std::cos(angle), std::sin(angle), 0);
    Body b;
    b.mass = l, b.inertia = l * l * l * Vec3(0.01, 1.0 / 12, 1.0 / 12);
    b.pose = {at + 0.5 * l * way, from_rotation_vector({0, 0, angle})};
    const Entity e = w.add_body(b);
    add_link(w, {before, e, {i == 0 ? Vec3(0) : Vec3(l / 2, 0, 0), {-l / 2, 0, 0}}});
    before = e, at += l * way;
  }
  Pin pin;
  pin.body = before, pin.anchor = {l / 2, 0, 0}, pin.target = {chord, 0, 0};
  made.pin = w.add_pin(pin);
  return made;
}

}  // namespace

TEST_CASE("a hundred links drawn taut reach their pin within ten rounds") {
  for (Real span : {0.9, 0.99, 0.999}) {
    Arc a = arc(100, span - 0.05);
    Simulation sim = Simulation::copy_of(a.world, {1.0 / 60});
    for (int i = 0; i < 60; ++i) sim.step();
    sim.world.pins[a.pin].target.x = span;  // five links' length at once
    const StepReport report = sim.step();
    INFO(span << ": " << report.sweeps_used << " rounds, residual " << report.worst_residual);
    CHECK(report.sweeps_used <= 10);
    CHECK(report.worst_residual <= 1e-6);
    CHECK(measure(sim.world).worst_gap_rel <= 1e-14);
    // The blow runs along the chain for a while; then the pin is met again at every step.
    for (int i = 0; i < 60; ++i) REQUIRE(sim.step().worst_residual <= 1e-2);
    for (int i = 0; i < 60; ++i) REQUIRE(sim.step().worst_residual <= 1e-6);
  }
}

TEST_CASE("a target out of reach is told, and the chain settles straight towards it") {
  Arc a = arc(20, 0.9);
  Simulation sim = Simulation::copy_of(a.world, {1.0 / 60});
  sim.world.pins[a.pin].target.x = 1.2;
  StepReport report;
  for (int i = 0; i < 120; ++i) report = sim.step();
  CHECK_FALSE(sim.world.pins[a.pin].reachable);
  CHECK(report.unreached == 1);
  CHECK(report.sweeps_used <= sim.world.default_settings.sweeps);
  CHECK(report.worst_residual == Approx(0.2).epsilon(0.02));
}

TEST_CASE("a ring of links is closed by a joint like any other") {
  World w;
  constexpr int kLinks = 24;
  const Real l = 0.1, radius = l / (2 * std::sin(kPi / kLinks));
  std::vector<Entity> ring;
  for (int i = 0; i < kLinks; ++i) {
    const Real angle = 2 * kPi * (i + 0.5) / kLinks;
    Body b;
    b.mass = 0.1, b.inertia = {1e-5, 1e-4, 1e-4}, b.drag = 0;
    const Real inner = radius * std::cos(kPi / kLinks);
    b.pose = {inner * Vec3(std::cos(angle), std::sin(angle), 0),
              from_rotation_vector({0, 0, angle + kPi / 2})};
    b.angular_velocity = {0, 0, 2}, b.velocity = glm::cross(b.angular_velocity, b.pose.position);
    ring.push_back(w.add_body(b));
  }
  for (std::size_t i = 0; i < kLinks; ++i)
    add_link(w, {ring[i], ring[(i + 1) % kLinks], {{l / 2, 0, 0}, {-l / 2, 0, 0}}});
  Pin pin;
  pin.body = ring[0];
  const Entity nail = w.add_pin(pin);
  w.pins[nail].target = w.bodies[ring[0]].pose.position;
  Simulation sim = Simulation::copy_of(w, {1.0 / 120});
  for (int i = 0; i < 480; ++i) {
    const StepReport report = sim.step();
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.worst_residual <= 1e-4);
    // The joint that closes the ring counts; those of the tree are closed to rounding errors.
    REQUIRE(measure(sim.world).worst_gap_rel <= 1e-7);
    int open = 0;
    for (const Link& link : sim.world.links.values()) {
      const Pose &pa = sim.world.bodies[link.a].pose, &pb = sim.world.bodies[link.b].pose;
      open += glm::length(residual(link.joint, pa, pb)) > 1e-12;
    }
    REQUIRE(open <= 1);
  }
  CHECK(partition_of(sim.world).faults.empty());
}

TEST_CASE("a four-bar of hinges keeps its loop to second order, whatever it has too many of") {
  const auto residual = [](Real h) {
    World w;
    Body wall;
    wall.motion = Motion::fixed;
    const Entity ground = w.add_body(wall);
    const Vec3 p[] = {{0, 0, 0}, {0, 0.8, 0}, {1.5, 1.5, 0}, {2, 0, 0}};
    Entity bars[3];
    Real length[3];
    for (int i = 0; i < 3; ++i) {
      const Vec3 way = p[i + 1] - p[i];
      length[i] = glm::length(way);
      Body b;
      b.drag = 0, b.mass = length[i];
      const Real across = b.mass * length[i] * length[i] / 12;
      b.inertia = {0.01 * across, across, across};
      b.pose = {0.5 * (p[i] + p[i + 1]), from_rotation_vector({0, 0, std::atan2(way.y, way.x)})};
      bars[i] = w.add_body(b);
    }
    const auto tie = [&](Entity a, Entity b, Vec3 at_a, Vec3 at_b) {
      Joint j;
      j.anchor_a = at_a, j.anchor_b = at_b, j.kind = JointKind::hinge;
      const Quat axes = from_rotation_vector({0, -kPi / 2, 0});
      j.frames.set(axes, axes);
      add_link(w, {a, b, j});
    };
    tie(ground, bars[0], p[0], {-length[0] / 2, 0, 0});
    tie(bars[0], bars[1], {length[0] / 2, 0, 0}, {-length[1] / 2, 0, 0});
    tie(bars[1], bars[2], {length[1] / 2, 0, 0}, {-length[2] / 2, 0, 0});
    tie(ground, bars[2], p[3], {length[2] / 2, 0, 0});
    Simulation sim = Simulation::copy_of(w, {h});
    Real worst = 0;
    for (int i = 0; i < std::lround(2 / h); ++i) {
      const StepReport report = sim.step();
      worst = std::max(worst, report.worst_residual);
      if (report.status != Status::ok || measure(sim.world).worst_violation > 1e-12) return 1e9;
    }
    return worst;
  };
  const Real coarse = residual(1.0 / 60), fine = residual(1.0 / 240);
  CHECK(coarse <= 1e-3);
  CHECK(fine <= coarse / 10);
}

TEST_CASE("a hand holds on to another body, and lets go") {
  World w;
  w.gravity = Vec3(0);
  Body b;
  b.drag = 0, b.inertia = Vec3(0.1);
  b.velocity = {1, 0, 0};
  const Entity carrier = w.add_body(b);
  b.pose.position = {0, 1, 0}, b.velocity = Vec3(0);
  const Entity load = w.add_body(b);
  Pin pin;
  pin.body = load, pin.anchor = {0, -0.5, 0}, pin.to = carrier, pin.target = {0, 0.5, 0};
  const Entity hand = w.add_pin(pin);
  Simulation sim = Simulation::copy_of(w, {1.0 / 60});
  const Vec3 momentum = measure(w).momentum;
  for (int i = 0; i < 120; ++i) {
    sim.step();
    const Vec3 gap = to_world(sim.world.bodies[load].pose, {0, -0.5, 0}) -
                     to_world(sim.world.bodies[carrier].pose, {0, 0.5, 0});
    REQUIRE(glm::length(gap) <= 1e-4);
  }
  CHECK(glm::length(measure(sim.world).momentum - momentum) <= 1e-9);
  sim.world.destroy(hand);
  for (int i = 0; i < 120; ++i) sim.step();
  const Vec3 apart = sim.world.bodies[load].pose.position - sim.world.bodies[carrier].pose.position;
  CHECK(glm::length(apart) > 1.05);
  // Destroying the body a pin holds on to destroys the pin.
  const Entity again = sim.world.add_pin({load, {0, -0.5, 0}, {0, 0.5, 0}, carrier});
  sim.world.destroy(carrier);
  CHECK_FALSE(sim.world.is_alive(again));
  CHECK(sim.step().status == Status::ok);
}
