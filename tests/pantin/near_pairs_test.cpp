// Which bodies that come near each other collide: a program's filter, one-way surfaces.
#include <atomic>
#include <catch2/catch.hpp>
#include <pantin/pantin.hpp>
#include <thread>

#include "tests/pantin/bodies.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

constexpr Real kStep = 1.0 / 240;
constexpr Solver kSolvers[] = {Solver::articulated, Solver::lagrangian, Solver::planar};

World world_of(Solver solver) {
  World world;
  world.default_settings.solver = solver;
  return world;
}

/// A plate of 2 m by 0.2 m, its top at y = `top`.
Entity add_plate(World& world, Vec3 top, Vec3 one_way = Vec3(0), Quat rotation = kIdentity) {
  return world
      .add(RigidBody{.motion = Motion::fixed,
                     .shape = BoxShape{{1, 0.1, 1}},
                     .position = top - Vec3(0, 0.1, 0),
                     .rotation = rotation,
                     .collision = Collision{.friction = 0, .one_way = one_way}})
      .value();
}

Entity add_crate(World& world, Vec3 at, Vec3 velocity = Vec3(0)) {
  return world
      .add(RigidBody{.shape = BoxShape{{0.2, 0.2, 0.2}},
                     .position = at,
                     .velocity = velocity,
                     .collision = Collision{.friction = 0}})
      .value();
}

void run(Simulation& sim, int steps) {
  for (int i = 0; i < steps; ++i) REQUIRE(sim.step().status == Status::ok);
}

Vec3 place(const Simulation& sim, Entity e) { return sim.world.bodies[e].pose.position; }

}  // namespace

TEST_CASE("A filter decides once for each pair that comes near") {
  for (const Solver solver : kSolvers) {
    CAPTURE(name_of(solver));
    World world = world_of(solver);
    const Entity plate = add_plate(world, {0, 0, 0});
    const Entity ghost = add_ball(world, {-0.5, 0.5, 0}), ball = add_ball(world, {0.5, 0.5, 0});
    std::vector<ContactPair> asked;
    const ContactFilter filter = [&](const ContactPair& p) {
      asked.push_back(p);
      return p.a != ghost && p.b != ghost;
    };
    Simulation sim(std::move(world), {.h = kStep, .filter = filter});
    run(sim, 72);
    Simulation loaded(world_from_bytes(world_to_bytes(sim.world).value()).value(), sim.settings);
    run(sim, 48);
    CHECK(place(sim, ghost).y < -0.5);
    CHECK(place(sim, ball).y == Approx(0.1).margin(5e-3));
    REQUIRE(asked.size() == 2);
    for (const ContactPair& p : asked) {
      CHECK(p.a == plate);
      CHECK(p.normal.y == Approx(-1));
      CHECK(p.point.y == Approx(p.gap).margin(0.02));
    }
    // What was answered is in a saved World.
    run(loaded, 48);
    CHECK(asked.size() == 2);
    CHECK(state_hash(loaded.world) == state_hash(sim.world));
    // Both have parted and come again: they are asked about again.
    for (const Entity e : {ghost, ball}) {
      sim.world.teleport(e, {{place(sim, e).x, 0.5, 0}, kIdentity});
      sim.world.bodies[e].velocity = Vec3(0);
    }
    run(sim, 120);
    CHECK(asked.size() == 4);
    CHECK(place(sim, ghost).y < -0.5);
  }
}

TEST_CASE("What a filter throws ends the step") {
  World world;
  add_plate(world, {0, 0, 0});
  add_ball(world, {0, 0.1, 0});
  Simulation sim(std::move(world), {kStep});
  sim.settings.filter = [](const ContactPair&) -> bool { throw 1; };
  CHECK(sim.step().status == Status::aborted);
}

TEST_CASE("A one-way platform lets pass what jumps from below, and then bears it") {
  for (const Solver solver : kSolvers)
    for (const bool turned : {false, true}) {  // the direction turns with its body
      CAPTURE(name_of(solver), turned);
      World world = world_of(solver);
      const Quat rotation = turned ? glm::angleAxis(kPi, Vec3(0, 0, 1)) : kIdentity;
      const Vec3 up{0, turned ? -1 : 1, 0};
      add_plate(world, {0, 0, 0}, 3.0 * up, rotation);
      const Entity jumps = add_crate(world, {-0.5, -0.6, 0}, {0, 5, 0}),
                   falls = add_crate(world, {0.5, 0.6, 0}),
                   low = add_crate(world, {0, -0.6, 0}, {0, 2.5, 0});  // not high enough
      Simulation sim(std::move(world), {kStep});
      Real highest = -1;
      for (int i = 0; i < 480; ++i) {
        run(sim, 1);
        highest = std::max(highest, place(sim, jumps).y);
        if (i >= 60) continue;
        const Real free = 2.5 - 9.81 * sim.world.time;
        CHECK(sim.world.bodies[low].velocity.y == Approx(free).margin(1e-4));
      }
      CHECK(highest == Approx(-0.6 + 12.5 / 9.81).margin(0.02));  // nothing has held it
      CHECK(place(sim, jumps).y == Approx(0.2).margin(5e-3));
      CHECK(place(sim, falls).y == Approx(0.2).margin(5e-3));
      CHECK(place(sim, low).y < -3);
    }
}

TEST_CASE("Flying through a one-way plate from below is not told, and from above it stops") {
  for (const Real speed : {5.0, 40.0, 300.0}) {
    World world;
    world.gravity = Vec3(0);
    add_plate(world, {0, 2, 0}, {0, 1, 0});
    const Entity up = add_ball(world, {-0.5, 0.5, 0}), down = add_ball(world, {0.5, 3.5, 0});
    world.bodies[up].velocity = {0, speed, 0}, world.bodies[down].velocity = {0, -speed, 0};
    Simulation sim(std::move(world), {1.0 / 60});
    run(sim, 60);
    CAPTURE(speed);
    CHECK(place(sim, up).y > 3);
    CHECK(place(sim, down).y > 2);
    CHECK(sim.findings().empty());
  }
}

TEST_CASE("A body drops through a one-way platform on demand") {
  for (const Solver solver : kSolvers) {
    CAPTURE(name_of(solver));
    World world = world_of(solver);
    const Entity plate = add_plate(world, {0, 0, 0}, {0, 1, 0});
    const Entity crate = add_crate(world, {0, 0.2, 0});
    Simulation sim(std::move(world), {kStep});
    run(sim, 60);
    CHECK(place(sim, crate).y == Approx(0.2).margin(5e-3));
    // When they no longer ignore each other it is still within the platform.
    REQUIRE(ignore(sim.world, crate, plate, 0.1));
    run(sim, 120);
    CHECK(place(sim, crate).y < -0.9);
  }
}

TEST_CASE("A program's own threads step islands to the same bits") {
  const auto hash_after = [](RunJobs run_jobs, int& calls) {
    World world;
    add_plate(world, {0, 0, 0});
    for (int i = 0; i < 6; ++i)
      build_chain(world, {.from = {Real(i), 3, 0}, .to = {i + 1.0, 3, 0}, .links = 5}).value();
    for (int i = 0; i < 6; ++i) add_crate(world, {0.3 * i - 0.8, 0.5 + 0.5 * i, 0});
    StepSettings how;
    if (run_jobs)
      how.run_jobs = [&calls, run_jobs](std::size_t count, Job job) {
        ++calls, run_jobs(count, job);
      };
    Simulation sim(std::move(world), how);
    run(sim, 60);
    return state_hash(sim.world);
  };
  int calls = 0;
  const std::uint64_t alone = hash_after({}, calls);
  const auto backwards = [](std::size_t count, Job job) {
    for (std::size_t i = count; i-- > 0;) job(i);
  };
  CHECK(hash_after(backwards, calls) == alone);
  CHECK(calls > 60);
  const auto threads = [](std::size_t count, Job job) {
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t i; (i = next++) < count;) job(i);
    };
    std::thread other(work);
    work(), other.join();
  };
  CHECK(hash_after(threads, calls) == alone);
}

TEST_CASE("A simulation takes a World over, or steps a copy that it is asked for") {
  World world;
  const Entity ball = add_ball(world, {0, 1, 0});
  Simulation copy = Simulation::copy_of(world);
  run(copy, 10);
  CHECK(world.tick == 0);
  CHECK(copy.world.tick == 10);
  const Body* before = world.bodies.find(ball);
  const Simulation sim(std::move(world));
  CHECK(sim.world.bodies.find(ball) == before);  // no copy was made
}
