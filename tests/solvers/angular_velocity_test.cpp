// Bodies that turn: the lanes' own exponential and logarithm, and tumbling.
#include <catch2/catch.hpp>

#include "tests/solvers/trees.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

/// A sphere that spins freely, stepped kinematically: one step turns it by `rotation` exactly.
struct Spinner {
  Simulation sim;
  Entity body;

  Spinner() {
    World w;
    w.gravity = Vec3(0);
    w.default_settings.solver = Solver::sweep;
    Body b;
    b.drag = 0;
    body = w.add_body(b);
    sim = Simulation(std::move(w), {0.5});
    sim.step();
  }
  /// The rotation after one step from `start`, and what the step made of its own spin.
  Quat rotated(Quat start, Vec3 rotation, Vec3& spin_after) {
    Body& b = sim.world.bodies[body];
    b.pose.rotation = start, b.angular_velocity = rotation / sim.settings.h, b.restart = true;
    sim.step();
    spin_after = b.angular_velocity * sim.settings.h;
    return b.pose.rotation;
  }
};

/// A box 1 x 2 x 3 m spun about its middle axis, which is unstable, a little off it.
Body tumbling_box() {
  Body b;
  b.inertia = box_inertia(1, Vec3(0.5, 1, 1.5));
  b.drag = 0, b.angular_velocity = {0.6, 6, 0.6};
  return b;
}

/// Counts how often the middle axis turns over.
struct Flips {
  int count = 0;
  Real side = 1;
  void note(Vec3 own_spin) {
    if (side * own_spin.y < -3) side = -side, ++count;
  }
};

/// The same by Euler's equations in the body's axes, Runge-Kutta with steps of 0.1 ms.
int exact_flips(const Body& body, Real duration) {
  const auto rate = [&](Vec3 w) { return -glm::cross(w, body.inertia * w) / body.inertia; };
  Vec3 w = body.angular_velocity;
  Flips flips;
  const Real h = 1e-4;
  for (int i = 0; i < static_cast<int>(std::lround(duration / h)); ++i) {
    const Vec3 k1 = rate(w), k2 = rate(w + h / 2 * k1), k3 = rate(w + h / 2 * k2),
               k4 = rate(w + h * k3);
    w += h / 6 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    flips.note(w);
  }
  return flips.count;
}

struct Tumble {
  Real energy_drift = 0;  // relative, largest
  int flips = 0;
};

Tumble tumble(Solver solver, Real rate, Real duration) {
  World w;
  w.gravity = Vec3(0);
  w.default_settings.solver = solver;
  const Entity e = w.add_body(tumbling_box());
  Simulation sim(std::move(w), {1 / rate});
  const auto energy = [&] {
    const Body& b = sim.world.bodies[e];
    return 0.5 * glm::dot(world_inertia(b.pose.rotation, b.inertia) * b.angular_velocity,
                          b.angular_velocity);
  };
  const Real start = energy();
  Tumble t;
  Flips flips;
  for (int i = 0; i < static_cast<int>(rate * duration); ++i) {
    sim.step();
    const Body& b = sim.world.bodies[e];
    flips.note(glm::conjugate(b.pose.rotation) * b.angular_velocity);
    t.energy_drift = std::max(t.energy_drift, std::abs(energy() / start - 1));
  }
  t.flips = flips.count;
  return t;
}

}  // namespace

TEST_CASE("one step turns a free body by its rotation vector to the last bits, any angle") {
  Spinner spinner;
  Random dice(1);
  Real worst_turn = 0, worst_small = 0, worst_spin = 0;
  for (int i = 0; i < 4000; ++i) {
    // Down to angles whose squares vanish, up to several turns.
    const Real angle = i % 4 == 0 ? dice.between(0, 20) : std::pow(10, dice.between(-9, 0.6));
    const Vec3 rotation = angle * dice.direction();
    const Quat start = dice.rotation();
    Vec3 angular_velocity;
    const Quat after = spinner.rotated(start, rotation, angular_velocity);
    const Quat exact = from_rotation_vector(rotation) * start;
    const Quat off = glm::dot(after, exact) < 0 ? after + exact : after - exact;
    const Real miss = glm::length(off);
    if (angle < 1) worst_small = std::max(worst_small, miss);
    worst_turn = std::max(worst_turn, miss / (1 + angle));
    // The spin comes from the shortest way between the two rotations; where that is the way that
    // was taken, it is the spin that was given.
    if (angle < 3.1)
      worst_spin =
          std::max(worst_spin, glm::length(angular_velocity - rotation) / std::max(angle, 1e-3));
    else if (angle > 3.2 && angle < 6)
      CHECK(glm::length(angular_velocity) == Approx(2 * kPi - angle).epsilon(1e-12));
  }
  INFO("small turn " << worst_small << ", any turn " << worst_turn << ", spin " << worst_spin);
  CHECK(worst_small <= 1e-15);
  CHECK(worst_turn <= 2.5e-15);
  CHECK(worst_spin <= 1e-12);
}

TEST_CASE("near half a turn the way stays finite and of the right length") {
  Spinner spinner;
  for (Real off : {0.0, 1e-16, -1e-16, 1e-12, -1e-12, 1e-8, -1e-8}) {
    Vec3 angular_velocity;
    spinner.rotated(kIdentity, (kPi + off) * glm::normalize(Vec3(1, 2, 3)), angular_velocity);
    CHECK(glm::length(angular_velocity) == Approx(kPi - std::abs(off)).epsilon(1e-12));
  }
}

TEST_CASE("a body at rest does not creep") {
  World w;
  w.gravity = Vec3(0);
  Body b;
  b.pose = {{1, 2, 3}, from_rotation_vector({0.3, -0.2, 0.1})}, b.inertia = {1, 2, 2.5};
  const Entity e = w.add_body(b);
  for (Solver solver : {Solver::articulated, Solver::sweep, Solver::shake2, Solver::procedural}) {
    w.default_settings.solver = solver;
    Simulation sim = Simulation::copy_of(w, {1.0 / 60});
    for (int i = 0; i < 100; ++i) sim.step();
    CHECK(sim.world.bodies[e].pose.position == b.pose.position);
    INFO(name_of(solver));
    CHECK(glm::length(sim.world.bodies[e].pose.rotation - b.pose.rotation) <= 2e-14);
    CHECK(sim.world.bodies[e].velocity == Vec3(0));
    CHECK(glm::length(sim.world.bodies[e].angular_velocity) <= 1e-13);
  }
}

TEST_CASE("a box spun about its middle axis tumbles as often as it must and keeps its energy") {
  const int exact = exact_flips(tumbling_box(), 20);
  CHECK(exact == 8);
  // Angular momentum kept, evaluated at mid-step.
  const Tumble mid_60 = tumble(Solver::shake2, 60, 20), mid_240 = tumble(Solver::shake2, 240, 20);
  INFO("mid-step: energy drift " << mid_60.energy_drift << ", " << mid_240.energy_drift);
  CHECK(mid_60.flips == exact);
  CHECK(mid_240.flips == exact);
  CHECK(mid_60.energy_drift < 2e-3);
  CHECK(mid_240.energy_drift < 1.2e-4);
  // The second-order rule dissipates a little, which makes the box turn over sooner.
  const Tumble auto_60 = tumble(Solver::articulated, 60, 20),
               auto_240 = tumble(Solver::articulated, 240, 20);
  INFO("automatic: energy drift " << auto_60.energy_drift << ", " << auto_240.energy_drift);
  CHECK(std::abs(auto_60.flips - exact) <= 1);
  CHECK(auto_240.flips == exact);
  CHECK(auto_60.energy_drift < 1.2e-2);
  CHECK(auto_240.energy_drift < 6e-4);
}

TEST_CASE("the kinematic sweep keeps the spin constant, so that no box tumbles", "[limit]") {
  const Tumble t = tumble(Solver::sweep, 60, 20);
  CHECK(t.flips == 0);
  CHECK(t.energy_drift < 1e-11);
}

TEST_CASE("a body with a stable spin keeps it") {
  World w;
  w.gravity = Vec3(0);
  Body b;
  b.inertia = {1, 2, 3}, b.drag = 0, b.angular_velocity = {0, 0, 8};
  const Entity e = w.add_body(b);
  Simulation sim(std::move(w), {1.0 / 60});
  for (int i = 0; i < 1200; ++i) sim.step();
  CHECK(glm::length(sim.world.bodies[e].angular_velocity - b.angular_velocity) <= 1e-10);
}
