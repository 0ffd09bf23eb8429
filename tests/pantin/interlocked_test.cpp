// Ragdolls that start within one another: what pushes them apart makes no energy.
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>

using namespace pantin;

namespace {

Collision solid() {
  Collision collision;
  collision.friction = 0.5, collision.others = true;
  return collision;
}

void add_block(World& world, Vec3 size, Vec3 at) {
  REQUIRE(world.add(RigidBody{
      .motion = Motion::fixed, .shape = BoxShape{size}, .position = at, .collision = solid()}));
}

}  // namespace

TEST_CASE("ragdolls that start interlocked come apart without energy, and to rest") {
  World world;
  add_block(world, {20, 1, 20}, {0, -0.5, 0});
  for (const Real side : {-1.0, 1.0}) {
    add_block(world, {0.2, 6, 3.2}, {1.5 * side, 3, 0});
    add_block(world, {3.2, 6, 0.2}, {0, 3, 1.5 * side});
  }
  for (int i = 0; i < 8; ++i) {
    const Quat turn = glm::angleAxis(1.3 * i + 0.4, glm::normalize(Vec3(0.3, 0.2 * i, 1)));
    REQUIRE(build_ragdoll(world, {.position = {0.05 * i - 0.2, 2.2 + 0.15 * i, 0.1 - 0.03 * i},
                                  .rotation = turn,
                                  .collision = solid()}));
  }
  Simulation simulation(std::move(world), {.h = 1.0 / 60});
  const Real start = measure(simulation.world).energy();
  StepReport report;
  Real removed = 0, deepest = 0;
  for (int i = 0; i < 720; ++i) {
    report = simulation.step();
    REQUIRE(report.status == Status::ok);
    removed += report.energy_removed, deepest = std::max(deepest, report.worst_depth);
    REQUIRE(measure(simulation.world).energy() <=
            start * (1 + 1e-3));  // walls lift what is in them
  }
  CAPTURE(deepest, report.worst_depth, removed);
  CHECK(deepest > 0.08);  // else nothing was interlocked
  CHECK(removed < 0.01 * start);
  CHECK(report.worst_depth < 0.01);
  CHECK(measure(simulation.world).kinetic < 1);
}
