// Units do not matter: lengths, masses and times in other units give the same motion, and the same
// bits where the factors are powers of two.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/chains.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// How many of the new units the old ones are.
struct Units {
  Real length = 1, mass = 1, time = 1;
};

World in_units(const World& from, const Units& u) {
  World w = from;
  const Real speed = u.length / u.time;
  w.gravity *= u.length / (u.time * u.time);
  for (Body& b : w.bodies.values()) {
    b.pose.position *= u.length, b.velocity *= speed, b.angular_velocity /= u.time;
    b.mass *= u.mass, b.inertia *= u.mass * u.length * u.length;
    b.drag /= u.time;
  }
  for (Link& l : w.links.values()) l.joint.anchor_a *= u.length, l.joint.anchor_b *= u.length;
  for (Cable& s : w.cables.values()) {
    s.joint.anchor_a *= u.length, s.joint.anchor_b *= u.length, s.joint.length *= u.length;
    s.joint.compliance *= u.time * u.time / u.mass;
  }
  for (Pin& p : w.pins.values()) {
    p.anchor *= u.length, p.target *= u.length;
    p.stiffness *= u.mass / (u.time * u.time);
  }
  return w;
}

/// Largest difference between the poses of two Worlds, positions brought back to the first's units.
Real difference(const World& a, const World& b, Real length) {
  Real worst = 0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    const Pose &p = a.bodies.values()[i].pose, &q = b.bodies.values()[i].pose;
    worst = std::max(worst, glm::length(q.position / length - p.position));
    worst = std::max(worst, glm::length(q.rotation - p.rotation));
  }
  return worst;
}

/// Steps both for a while; the largest difference on the way.
Real worst_difference(const World& start, const Units& u, int steps) {
  Simulation one = Simulation::copy_of(start, {1.0 / 64}), other(in_units(start, u), {u.time / 64});
  Real worst = 0;
  for (int i = 0; i < steps; ++i) {
    REQUIRE(one.step().status == Status::ok);
    REQUIRE(other.step().status == Status::ok);
    worst = std::max(worst, difference(one.world, other.world, u.length));
  }
  return worst;
}

/// A swinging tree with some drag, or a free one in a tumble.
World moving_tree(Solver solver, bool held, std::uint64_t seed) {
  Random dice(seed);
  TreeSpec spec;
  spec.bodies = 9, spec.drag = 0.25, spec.held = held;
  RandomTree t = random_tree(spec, dice);
  t.world.default_settings.solver = solver;
  for (Entity e : t.bodies) t.world.bodies[e].angular_velocity = 2.0 * dice.in_cube(1);
  return t.world;
}

/// Two bodies on cables from a wall, tied to one another, one of them held or drawn by a spring.
World hung_pair(PinKind grip) {
  World w;
  Body wall;
  wall.motion = Motion::fixed;
  const Entity top = w.add_body(wall);
  Body b;
  b.inertia = Vec3(0.01, 0.02, 0.015), b.pose.position = {0.5, -1, 0};
  const Entity left = w.add_body(b);
  b.pose.position = {1.5, -1, 0.25};
  const Entity right = w.add_body(b);
  add_cable(w, {top, left, {Vec3(0), {0, 0.25, 0}, 0.75, 0}});
  add_cable(w, {top, right, {{1.5, 0, 0}, {0, 0.25, 0}, 1, 0.001}});
  add_link(w, {left, right, {{0.5, 0, 0}, {-0.5, 0, -0.25}}});
  Pin pin;
  pin.body = right, pin.target = {1.75, -0.75, 0.5}, pin.kind = grip, pin.stiffness = 30;
  w.add_pin(pin);
  return w;
}

const Units kPowersOfTwo[] = {{8, 1, 1},        {1, 16, 1},       {1, 1, 4},  {0.125, 1, 1},
                              {1, 1.0 / 64, 1}, {1, 1, 1.0 / 32}, {4, 0.5, 2}};

}  // namespace

TEST_CASE("units that are powers of two of the others give the same bits") {
  const Solver solver = GENERATE(Solver::articulated, Solver::sweep, Solver::shake2);
  const bool held = GENERATE(true, false);
  const World start = moving_tree(solver, held, 3);
  for (const Units& u : kPowersOfTwo) {
    INFO(name_of(solver) << (held ? ", held" : ", free") << ", length x" << u.length << ", mass x"
                         << u.mass << ", time x" << u.time);
    CHECK(worst_difference(start, u, 240) == 0);
  }
}

TEST_CASE("strings and pins keep their bits in other units too") {
  for (const Units& u : kPowersOfTwo) {
    INFO("length x" << u.length << ", mass x" << u.mass << ", time x" << u.time);
    CHECK(worst_difference(hung_pair(PinKind::exact), u, 240) == 0);
    // The damping of a spring pin is a time in seconds.
    if (u.time == 1) CHECK(worst_difference(hung_pair(PinKind::spring), u, 240) == 0);
  }
}

TEST_CASE("units by any factor give the same motion to rounding") {
  const World start = moving_tree(Solver::articulated, true, 4);
  // 240 steps of a swinging tree multiply the rounding errors of the first ones.
  for (const Units& u : {Units{3, 1, 1}, {1, 0.7, 1}, {1, 1, 1.3}, {39.37, 2.2046, 0.6}})
    CHECK(worst_difference(start, u, 240) <= 1e-9);
}

TEST_CASE("the rotation rule as printed in [Lee 2000] depends on the unit of time") {
  World start = moving_tree(Solver::procedural, true, 3);
  start.default_settings.procedural_reluctance = ProceduralReluctance::literal_step;
  CHECK(worst_difference(start, {8, 1, 1}, 60) <= 1e-9);
  CHECK(worst_difference(start, {1, 1, 4}, 60) > 0.01);
}
