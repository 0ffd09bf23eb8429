// Points held or drawn in the world: what can be reached is reached, what cannot is reported.
#include <catch2/catch.hpp>

#include "engine/solvers/articulated/island.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/chains.hpp"
#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// A chain of `count` links, 1 m in all, from a wall at the origin along +x; its last end pinned.
struct Pinned {
  Simulation sim;
  std::vector<Entity> links;
  Entity pin;
  Real length = 1;

  Pinned(int count, Vec3 target, Solver solver = Solver::articulated, Real drag = 2) {
    World w;
    Body wall;
    wall.motion = Motion::fixed;
    Entity before = w.add_body(wall);
    const Real l = length / count;
    for (int i = 0; i < count; ++i) {
      Body b;
      b.mass = 1.0 / count, b.drag = drag;
      b.inertia = b.mass * l * l / 12 * Vec3(0.02, 1, 1);
      // Zigzag: a straight chain has no way to fold.
      const Real bend = 0.3 * (i % 2 == 0 ? 1 : -1);
      b.pose.rotation = from_rotation_vector({0, 0, bend});
      const Vec3 start = i == 0 ? Vec3(0) : to_world(w.bodies[before].pose, {l / 2, 0, 0});
      b.pose.position = start - b.pose.rotation * Vec3(-l / 2, 0, 0);
      const Entity e = w.add_body(b);
      add_link(w, {before, e, {i == 0 ? Vec3(0) : Vec3(l / 2, 0, 0), {-l / 2, 0, 0}}});
      before = e;
      links.push_back(e);
    }
    Pin p;
    p.body = before, p.anchor = {l / 2, 0, 0}, p.target = target;
    pin = w.add_pin(p);
    w.default_settings.solver = solver;
    sim = Simulation(std::move(w), {1.0 / 60, 1, 1, true});
  }
  const Pin& state() const { return sim.world.pins[pin]; }
  Vec3 tip() const {
    const Real l = length / static_cast<Real>(links.size());
    return to_world(sim.world.bodies[links.back()].pose, {l / 2, 0, 0});
  }
};

}  // namespace

TEST_CASE("a pin within reach is met, whatever the solver") {
  const Solver solver =
      GENERATE(Solver::articulated, Solver::sweep, Solver::shake2, Solver::procedural);
  INFO(name_of(solver));
  Pinned p(12, {0.3, -0.2, 0.4}, solver);
  StepReport report;
  for (int i = 0; i < 240; ++i) {
    report = p.sim.step();
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.sweeps_used <= p.sim.world.default_settings.sweeps);
    REQUIRE(report.measures.worst_gap <= 1e-13);
  }
  CHECK(p.state().reachable);
  CHECK(p.state().residual <= 1e-4);
  CHECK(report.unreached == 0);
  CHECK(glm::length(p.tip() - p.state().target) == Approx(p.state().residual).margin(1e-14));
}

TEST_CASE("a pin out of reach settles stretched towards it and is reported with its distance") {
  const Solver solver = GENERATE(Solver::articulated, Solver::sweep);
  const Real far = GENERATE(1.02, 1.2, 2.0, 30.0);
  const int links = GENERATE(5, 20);
  INFO(name_of(solver) << ", " << links << " links, target at " << far << " of the length");
  Pinned p(links, {0.6 * far, -0.8 * far, 0}, solver);
  StepReport report;
  for (int i = 0; i < 300; ++i) {
    report = p.sim.step();
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.sweeps_used <= p.sim.world.default_settings.sweeps);
  }
  CHECK_FALSE(p.state().reachable);
  CHECK(report.unreached == 1);
  CHECK(report.worst_residual_at == p.pin);
  CHECK(report.worst_residual == p.state().residual);
  // Just beyond the reach sweeps straighten the chain slowly.
  CHECK(std::abs(p.state().residual - (far - 1)) <= (far < 1.1 ? 2e-3 : 1e-3));
  // It does not tremble either.
  const Vec3 before = p.tip();
  Real sway = 0;
  for (int i = 0; i < 120; ++i) {
    report = p.sim.step();
    sway = std::max(sway, glm::length(p.tip() - before));
    REQUIRE(report.measures.worst_gap <= 1e-13);
  }
  CHECK(sway <= 1e-3);
}

TEST_CASE("a pin too near for a long link is out of reach too") {
  // Links of 0.7 and 0.1 m: no point nearer than 0.6 m to the wall can be met.
  World w;
  Body wall;
  wall.motion = Motion::fixed;
  const Entity top = w.add_body(wall);
  Body b;
  b.inertia = Vec3(0.02), b.drag = 2, b.pose.position = {0.35, 0, 0};
  const Entity upper = w.add_body(b);
  b.mass = 0.1, b.inertia = Vec3(2e-4), b.pose.position = {0.75, 0, 0};
  const Entity lower = w.add_body(b);
  add_link(w, {top, upper, {Vec3(0), {-0.35, 0, 0}}});
  add_link(w, {upper, lower, {{0.35, 0, 0}, {-0.05, 0, 0}}});
  Pin p;
  p.body = lower, p.anchor = {0.05, 0, 0}, p.target = {0.1, -0.4, 0};
  const Entity pin = w.add_pin(p);
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 400; ++i) sim.step();
  CHECK_FALSE(sim.world.pins[pin].reachable);
  CHECK(sim.world.pins[pin].residual == Approx(0.6 - std::hypot(0.1, 0.4)).margin(5e-3));
}

TEST_CASE("relaxation stops within its cap wherever the target jumps") {
  Random dice(7);
  int steps = 0, at_cap = 0;
  for (int trial = 0; trial < 60; ++trial) {
    Pinned p(3 + trial % 18, {0.5, -0.3, 0}, trial % 2 ? Solver::articulated : Solver::sweep);
    for (int i = 0; i < 20; ++i) {
      // Inside, at the rim, beyond, in the wall itself, and absurdly far.
      const Real reach[] = {0.0, 1e-9, 0.5, 0.99, 1, 1 + 1e-12, 1.01, 3, 1e6};
      p.sim.world.pins[p.pin].target = reach[dice.below(9)] * dice.direction();
      const StepReport report = p.sim.step();
      REQUIRE(report.status == Status::ok);
      REQUIRE(report.sweeps_used <= 16);
      REQUIRE(report.measures.worst_gap <= 1e-13);
      ++steps, at_cap += report.sweeps_used == 16;
    }
  }
  CHECK(at_cap < steps / 2);
}

TEST_CASE("of two exact pins that contradict one another the one of higher priority is met") {
  const bool first_wins = GENERATE(true, false);
  World w;
  Body b;
  b.inertia = Vec3(0.1, 0.01, 0.1), b.drag = 2;
  const Entity e = w.add_body(b);
  Pin p;
  p.body = e, p.anchor = {0, 0.5, 0}, p.target = {0, 2, 0}, p.priority = first_wins ? 2 : 1;
  const Entity first = w.add_pin(p);
  p.anchor = {0, -0.5, 0}, p.target = {0, -2, 0}, p.priority = first_wins ? 1 : 2;
  const Entity second = w.add_pin(p);
  Simulation sim(std::move(w), {1.0 / 60});
  StepReport report;
  for (int i = 0; i < 120; ++i) report = sim.step();
  const Pin &met = sim.world.pins[first_wins ? first : second],
            &missed = sim.world.pins[first_wins ? second : first];
  CHECK(met.residual <= 1e-14);
  CHECK_FALSE(missed.reachable);
  CHECK(missed.residual == Approx(3).margin(1e-3));  // 4 m apart, the body spans 1
  CHECK(report.worst_residual_at == (first_wins ? second : first));
}

TEST_CASE("an inner body is dragged exactly, and everything else follows from there") {
  std::vector<Entity> bodies;
  ChainSpec spec;
  spec.links = 9, spec.held = false;
  Simulation sim(chain(spec, &bodies), {1.0 / 60, 1, 1, true});
  Pin hand;
  hand.body = bodies[4], hand.anchor = {0.01, 0.02, 0};
  hand.target = to_world(sim.world.bodies[bodies[4]].pose, hand.anchor);
  const Entity pin = sim.world.add_pin(hand);
  Real worst = 0;
  for (int i = 0; i < 200; ++i) {
    sim.world.pins[pin].target += Vec3(0.05 * std::sin(0.1 * i), 0.02, 0.03 * std::cos(0.07 * i));
    const StepReport report = sim.step();
    worst = std::max({worst, worst_pin_gap(sim.world), report.measures.worst_gap});
    REQUIRE(articulated::islands_of(sim.world)[0].bodies[0] ==
            bodies[4]);  // the tree hangs on the hand now
  }
  CHECK(worst <= 2e-14);

  // Letting go: the chain flies on with the momentum it had.
  const Vec3 momentum = measure(sim.world).momentum;
  sim.world.destroy(pin);
  sim.step();
  const Vec3 change = measure(sim.world).momentum - momentum - 9.0 / 60 * sim.world.gravity;
  CHECK(glm::length(change) <= 1e-3 * glm::length(momentum));
}

TEST_CASE("grabbing and letting go moves nothing by itself") {
  std::vector<Entity> bodies;
  ChainSpec spec;
  spec.angle = 0;
  World w = chain(spec, &bodies);
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 30; ++i) sim.step();
  Pin hand;
  hand.body = bodies[6], hand.anchor = {0, 0.02, 0};
  hand.target = to_world(sim.world.bodies[bodies[6]].pose, hand.anchor);
  const Entity pin = sim.world.add_pin(hand);
  for (int i = 0; i < 60; ++i) sim.step();
  sim.world.destroy(pin);
  for (int i = 0; i < 60; ++i) sim.step();
  CHECK(glm::length(tip_of(sim.world, bodies.back(), spec) - Vec3(0, -1, 0)) <= 1e-9);
  CHECK(measure(sim.world).kinetic <= 1e-12);
}

TEST_CASE("a spring pin carries a weight at the offset m g / k") {
  for (Real stiffness : {50.0, 200.0, 3000.0}) {
    World w;
    Body b;
    b.mass = 2, b.inertia = Vec3(0.02);
    const Entity e = w.add_body(b);
    Pin p;
    p.body = e, p.kind = PinKind::spring, p.stiffness = stiffness;
    p.damping = std::sqrt(2 * stiffness);  // half the critical one
    w.add_pin(p);
    Simulation sim(std::move(w), {1.0 / 60});
    for (int i = 0; i < 60 * 60; ++i) sim.step();
    const Vec3 at = sim.world.bodies[e].pose.position;
    CHECK(at.y == Approx(-2 * 9.81 / stiffness).epsilon(1e-6));
    CHECK(glm::length(sim.world.bodies[e].velocity) <= 1e-6);
  }
}

TEST_CASE("a chain pinned at both ends hangs as the balance of forces demands") {
  // Uniform rods: tan(angle_i) = w l (i + 1/2 - n/2) / T, one unknown T.
  const int n = 20;
  const Real length = 1.2, span = 1, l = length / n;
  const auto angle = [&](int i, Real pull) {
    return std::atan(9.81 * l * (i + 0.5 - n / 2.0) / pull);
  };
  Real low = 1e-3, high = 100;
  for (int round = 0; round < 200; ++round) {
    const Real mid = 0.5 * (low + high);
    Real x = 0;
    for (int i = 0; i < n; ++i) x += l * std::cos(angle(i, mid));
    (x > span ? high : low) = mid;
  }
  std::vector<Entity> bodies;
  ChainSpec spec;
  spec.links = n, spec.length = length, spec.mass = l, spec.angle = kPi / 2;
  World w = chain(spec, &bodies);
  for (Entity e : bodies) w.bodies[e].drag = 1.5;
  Pin p;
  p.body = bodies.back(), p.anchor = {0, -l / 2, 0}, p.target = {length, 0, 0};
  const Entity pin = w.add_pin(p);
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 60 * 40; ++i) {
    Vec3& target = sim.world.pins[pin].target;
    target.x = std::max(span, target.x - 0.002);
    sim.step();
  }
  Vec3 joint(0);
  Real worst = 0;
  for (int i = 0; i < n; ++i) {
    joint += l * Vec3(std::cos(angle(i, low)), std::sin(angle(i, low)), 0);
    const Vec3 found =
        to_world(sim.world.bodies[bodies[static_cast<std::size_t>(i)]].pose, {0, -l / 2, 0});
    worst = std::max(worst, glm::length(found - joint));
  }
  INFO("horizontal pull " << low << " N, worst joint " << worst << " m");
  CHECK(low == Approx(4.602824574562021).epsilon(1e-9));  // the reference set's own value
  CHECK(worst <= 1e-4);
  CHECK(sim.world.pins[pin].residual <= 1e-4);
}

TEST_CASE("several pins hold a puppet at once") {
  // A body with four limbs of two links; the torso and all four hands are held within reach.
  Random dice(3);
  World w;
  Body torso;
  torso.inertia = Vec3(0.05), torso.drag = 1;
  const Entity centre = w.add_body(torso);
  std::vector<Entity> pins;
  Pin p;
  p.body = centre, p.priority = 1;
  pins.push_back(w.add_pin(p));
  for (int limb = 0; limb < 4; ++limb) {
    const Vec3 way = glm::normalize(Vec3(limb % 2 ? 1 : -1, limb / 2 ? 1 : -1, 0.1 * limb));
    Entity before = centre;
    Vec3 out = 0.2 * way;
    for (int i = 0; i < 2; ++i) {
      Body b;
      b.mass = 0.3, b.inertia = Vec3(0.003), b.drag = 1;
      b.pose.position = (0.35 + 0.3 * i) * way;
      const Entity e = w.add_body(b);
      add_link(w, {before, e, {out, -0.15 * way}});
      before = e, out = 0.15 * way;
    }
    p = Pin{};
    p.body = before, p.anchor = out, p.target = 0.6 * way + 0.05 * dice.in_cube(1);
    pins.push_back(w.add_pin(p));
  }
  Simulation sim(std::move(w), {1.0 / 60});
  StepReport report;
  for (int i = 0; i < 900; ++i) report = sim.step();
  CHECK(report.unreached == 0);
  CHECK(sim.world.pins[pins[0]].residual <= 1e-13);
  for (Entity e : pins) CHECK(sim.world.pins[e].reachable);
  CHECK(measure(sim.world).kinetic <= 1e-6);
}
