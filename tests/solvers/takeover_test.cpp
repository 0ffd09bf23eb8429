// Bodies of different solvers that touch: one solver steps them, as if they had all asked for it.
#include "engine/solvers/takeover.hpp"

#include <catch2/catch.hpp>

#include "engine/runtime/save.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

constexpr Solver kAll[] = {Solver::articulated, Solver::lagrangian, Solver::planar};

Entity add_solid(World& w, Solver solver, const Shape& shape, Vec3 at, Real mass,
                 const Collision& how) {
  Body b;
  b.drag = 0, b.mass = mass, b.inertia = mass * Vec3(0.0067), b.pose.position = at;
  const Entity e = w.add_body(b);
  SolverSettings settings;
  settings.solver = solver;
  w.settings.add(e, settings);
  w.shapes.add(e, {{shape}});
  w.collisions.add(e, how);
  return e;
}

Shape box_of(Real half) {
  Shape s;
  s.kind = ShapeKind::box, s.size = Vec3(half);
  return s;
}

World tower(Solver low, Solver high, Real ratio) {
  World w;
  Body ground;
  ground.motion = Motion::fixed, ground.pose.position = {0, -0.5, 0};
  const Entity g = w.add_body(ground);
  Shape slab = box_of(0.5);
  slab.size = {2, 0.5, 2};
  w.shapes.add(g, {{slab}});
  w.collisions.add(g, {});
  for (int i = 0; i < 4; ++i)
    add_solid(w, i % 2 ? high : low, box_of(0.1), {0, 0.1 + 0.2 * i, 0}, i % 2 ? ratio : 1, {});
  return w;
}

}  // namespace

TEST_CASE("towers of boxes of alternating solvers stand as those of one") {
  for (const Solver low : kAll)
    for (const Solver high : kAll)
      for (const Real h : {1.0 / 60, 1.0 / 240}) {
        if (low == high) continue;
        Simulation sim(tower(low, high, 1), {h});
        for (int i = 0; i < 2 / h; ++i) REQUIRE(sim.step().status == Status::ok);
        INFO(name_of(low) << " under " << name_of(high) << " at " << 1 / h << " Hz");
        for (std::size_t i = 1; i < sim.world.bodies.size(); ++i) {
          const Vec3 at(0, 0.1 + 0.2 * static_cast<Real>(i - 1), 0);
          CHECK(glm::length(sim.world.bodies.values()[i].pose.position - at) < 1e-4);
        }
        CHECK(takeover_lines(sim.world).size() >= 2);
      }
}

TEST_CASE("balls of two solvers bounce off each other by their restitution, momentum kept") {
  Shape ball;
  ball.size = {0.1, 0, 0};
  for (const Solver one : kAll)
    for (const Solver two : kAll)
      for (const Real e : {0.0, 0.5, 1.0})
        for (const Real mass : {0.01, 2.0, 100.0}) {
          if (one == two) continue;
          World w;
          w.gravity = Vec3(0);
          Collision how;
          how.restitution = e, how.friction = 0;
          const Entity a = add_solid(w, one, ball, {-1, 0, 0}, 1, how);
          const Entity b = add_solid(w, two, ball, {0.2, 0, 0}, mass, how);
          w.bodies[a].velocity = {2, 0, 0};
          Simulation sim(std::move(w), {1.0 / 240});
          for (int i = 0; i < 240; ++i) REQUIRE(sim.step().status == Status::ok);
          const Real va = sim.world.bodies[a].velocity.x, vb = sim.world.bodies[b].velocity.x;
          INFO(name_of(one) << " and " << name_of(two) << ", e " << e << ", mass " << mass);
          CHECK(vb - va == Approx(2 * e).margin(1e-3));
          CHECK(va + mass * vb == Approx(2).margin(1e-10));
          if (e > 0) CHECK(takeover_lines(sim.world).empty());  // they have parted
        }
}

TEST_CASE("a World saved while one solver has taken over goes on with the same bits") {
  Simulation sim(tower(Solver::articulated, Solver::lagrangian, 1), {1.0 / 120});
  for (int i = 0; i < 30; ++i) sim.step();
  REQUIRE(takeover_lines(sim.world).size() == 2);
  const Result<std::string> bytes = world_to_bytes(sim.world);
  REQUIRE(bytes);
  Result<World> loaded = world_from_bytes(*bytes);
  REQUIRE(loaded);
  Simulation again(std::move(*loaded), {1.0 / 120}),
      copy = Simulation::copy_of(sim.world, {1.0 / 120});
  for (int i = 0; i < 60; ++i) sim.step(), again.step(), copy.step();
  CHECK(state_hash(again.world) == state_hash(sim.world));
  CHECK(state_hash(copy.world) == state_hash(sim.world));
}

TEST_CASE("a body tied to one of another solver is told that its own is not used") {
  World w;
  const Entity a = add_solid(w, Solver::articulated, box_of(0.1), {0, 0, 0}, 1, {}),
               b = add_solid(w, Solver::lagrangian, box_of(0.1), {0.5, 0, 0}, 1, {}),
               c = add_solid(w, Solver::articulated, box_of(0.1), {1, 0, 0}, 1, {});
  w.names.add(a, "arm"), w.names.add(b, "hand");
  CHECK(check(w).empty());
  add_link(w, {b, c, {{0.25, 0, 0}, {-0.25, 0, 0}}});
  add_link(w, {a, b, {{0.25, 0, 0}, {-0.25, 0, 0}}});
  const std::vector<StructureFault> faults = check(w);
  REQUIRE(faults.size() == 1);
  CHECK(faults[0].link == b);
  CHECK_FALSE(faults[0].is_minor);
  CHECK(faults[0].reason ==
        "asks for the solver \"lagrangian\", but is tied to arm, whose solver \"auto\" steps both");
}
