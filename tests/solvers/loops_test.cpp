// Loops of joints: closed, counted in the report, and stepped without a loss of energy.
#include <catch2/catch.hpp>

#include "engine/world/ties.hpp"
#include "tests/solvers/chains.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kMesh = 0.2;  // m

enum class Hung { by_four_corners, by_two_corners, by_one_corner, by_corners_that_move_in };

/// A net of rods between knots, all of 0.02 kg.
struct Net {
  World world;
  std::vector<Entity> knots;
  int side;

  Net(int n, Hung hung, Solver solver = Solver::articulated) : side(n) {
    world.default_settings.solver = solver;
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < n; ++k) add_knot(i, k, hung);
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < n; ++k) {
        if (i + 1 < n) add_rod(i * n + k, i * n + n + k, Vec3(1, 0, 0));
        if (k + 1 < n) add_rod(i * n + k, i * n + k + 1, Vec3(0, 0, 1));
      }
  }
  Body part(Vec3 position, Vec3 inertia) const {
    Body b;
    b.mass = 0.02, b.drag = 0, b.inertia = inertia;
    b.pose.position = position;
    return b;
  }
  void add_knot(int i, int k, Hung hung) {
    const Real middle = 0.5 * (side - 1);
    Body b = part(kMesh * Vec3(i - middle, 0, k - middle), Vec3(3.2e-6));
    const bool corner = i % (side - 1) == 0 && k % (side - 1) == 0;
    const bool held =
        hung == Hung::by_two_corners ? i == 0 : hung != Hung::by_one_corner || i + k == 0;
    const bool moves = hung == Hung::by_corners_that_move_in;
    if (corner && held) b.motion = moves ? Motion::kinematic : Motion::fixed;
    knots.push_back(world.add_body(b));
    if (!corner || !held || !moves) return;
    Lissajous in;
    in.centre.position = b.pose.position;
    in.amplitude = -0.1 * b.pose.position, in.frequency = Vec3(0.125);
    world.paths.add(knots.back(), KinematicPath{in});
  }
  void add_rod(int from, int to, Vec3 along) {
    const Vec3 a = at(from), b = at(to);
    Body rod = part(0.5 * (a + b), 0.02 / 12 * kMesh * kMesh * Vec3(1));
    const int axis = along.x > 0 ? 0 : 2;
    rod.inertia[axis] = 0.02 / 2 * 0.012 * 0.012;
    const Entity e = world.add_body(rod);
    add_link(world, {knots[static_cast<std::size_t>(from)], e, {Vec3(0), -0.5 * kMesh * along}});
    add_link(world, {e, knots[static_cast<std::size_t>(to)], {0.5 * kMesh * along, Vec3(0)}});
  }
  Vec3 at(int knot) const {
    return world.bodies[knots[static_cast<std::size_t>(knot)]].pose.position;
  }
};

/// Largest gap of any joint, from the poses.
Real open_by(const World& w) {
  Real worst = 0;
  for (const Link& l : w.links.values())
    worst = std::max(worst, glm::length(residual(l.joint, w.bodies[l.a].pose, w.bodies[l.b].pose)));
  return worst;
}

struct Told {
  Real gap = 0, untold = 0;       // m
  Real least = 1e9, most = -1e9;  // J, energy
  Real removed = 0;               // J
};

Told follow(Simulation& sim, Real duration) {
  Told all;
  const int steps = static_cast<int>(std::lround(duration / sim.settings.h));
  for (int i = 0; i < steps; ++i) {
    const StepReport r = sim.step();
    REQUIRE(r.status == Status::ok);
    const Real gap = open_by(sim.world);
    all.gap = std::max(all.gap, gap);
    all.untold = std::max(all.untold, std::abs(gap - r.measures.worst_gap));
    all.least = std::min(all.least, r.measures.energy());
    all.most = std::max(all.most, r.measures.energy());
    all.removed += r.energy_removed;
  }
  return all;
}

}  // namespace

TEST_CASE("a loop that is open counts in the worst gap") {
  Net net(3, Hung::by_one_corner);
  Body& corner = net.world.bodies[net.knots.back()];
  corner.pose.position.y += 0.3;
  const Measures m = measure(net.world);
  CHECK(m.worst_gap == Approx(0.3));
  CHECK(m.worst_gap_rel > 0.1);
  CHECK(m.worst_link);
}

TEST_CASE("a net hung by its corners hangs, its loops closed") {
  // By four corners it is stretched flat: no finite tension carries it there.
  for (const int side : {3, 5})
    for (const Hung hung : {Hung::by_four_corners, Hung::by_two_corners, Hung::by_one_corner})
      for (const Real rate : {60.0, 240.0}) {
        Net net(side, hung);
        const Real fall = 9.81 * 0.02 * static_cast<Real>(net.world.bodies.size()) * kMesh;
        Simulation sim(std::move(net.world), {1 / rate, 1, 1, true});
        const Real start = measure(sim.world).energy();
        const Told told = follow(sim, 3);
        INFO(side << " x " << side << ", hung " << static_cast<int>(hung) << ", " << rate
                  << " Hz: gap " << told.gap << " m, energy by " << (told.least - start) / fall
                  << ".." << (told.most - start) / fall << " of a fall by a mesh");
        CHECK(told.gap < 1e-5 * side * kMesh);
        CHECK(told.untold < 1e-12);
        CHECK(told.most - start < 2e-2 * fall);
        CHECK(told.least - start > -5e-2 * fall);
        CHECK(told.removed == 0);
      }
}

TEST_CASE(
    "a net whose corners move in gives way at first, is told to, and sags with closed loops") {
  // Stretched flat it can neither follow at once nor be pushed together.
  for (const Real rate : {60.0, 240.0}) {
    Net net(5, Hung::by_corners_that_move_in);
    const Entity middle = net.knots[12];
    Simulation sim(std::move(net.world), {1 / rate, 1, 1, true});
    const Told first = follow(sim, 0.1), later = follow(sim, 2.9);
    INFO(rate << " Hz: gap " << first.gap << " m, then " << later.gap << " m, energy to "
              << std::max(first.most, later.most) << " J");
    CHECK(first.gap < 1e-2);
    CHECK(later.gap < 1e-5 * 5 * kMesh);
    CHECK(first.untold + later.untold < 1e-12);
    CHECK(first.removed + later.removed == 0);
    CHECK(std::max(first.most, later.most) < 1);  // a fall by a mesh is worth 2.5 J
    CHECK(sim.world.bodies[middle].pose.position.y < -0.1);
  }
}

TEST_CASE("a loop of rods moves as the equations of motion have it, to second order") {
  const auto run = [](Solver solver, Real rate) {
    Net net(2, Hung::by_one_corner, solver);
    for (Body& b : net.world.bodies.values())
      b.velocity = glm::cross(Vec3(0, 3, 0), b.pose.position + Vec3(0.5 * kMesh, 0, 0.5 * kMesh)),
      b.angular_velocity = Vec3(0, 3, 0);
    const Entity far = net.knots.back();
    net.world.default_settings.integrator = Integrator::rk4;
    Simulation sim(std::move(net.world), {1 / rate, 1, 1, true});
    for (int i = 0; i < static_cast<int>(0.5 * rate); ++i) sim.step();
    return sim.world.bodies[far].pose.position;
  };
  const Vec3 exact = run(Solver::lagrangian, 2000);
  const Real coarse = glm::length(run(Solver::articulated, 240) - exact);
  const Real fine = glm::length(run(Solver::articulated, 960) - exact);
  INFO("off by " << coarse << " m at 240 Hz, " << fine << " m at 960 Hz");
  CHECK(coarse < 1e-3);
  CHECK(fine < coarse / 12);
}
