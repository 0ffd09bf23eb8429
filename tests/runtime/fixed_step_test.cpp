// Wall time in, whole steps out. Step and wall times are dyadic here, so that sums are exact.
#include <catch2/catch.hpp>
#include <limits>

#include "engine/runtime/simulation.hpp"
#include "tests/runtime/puppets.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kStep = 1.0 / 64;

struct Falling {
  Simulation simulation;
  Entity body;
};

Falling falling_body() {
  World world;
  Body body;
  body.velocity = {1, 0, 0};
  const Entity e = world.add_body(body);
  StepSettings settings;
  settings.h = kStep;
  return {Simulation(std::move(world), settings), e};
}

}  // namespace

TEST_CASE("wall time becomes whole steps, and what is left waits") {
  auto [simulation, body] = falling_body();
  Advance a = simulation.advance(0.75 * kStep);
  CHECK(a.steps == 0);
  CHECK(a.fraction == 0.75);
  CHECK(simulation.world.tick == 0);
  a = simulation.advance(0.75 * kStep);
  CHECK(a.steps == 1);
  CHECK(a.fraction == 0.5);
  a = simulation.advance(2.5 * kStep);
  CHECK(a.steps == 3);
  CHECK(a.fraction == 0);
  CHECK(a.dropped == 0);
  CHECK(simulation.world.tick == 4);
}

TEST_CASE("a long pause is caught up with to a cap, and the rest is reported as dropped") {
  auto [simulation, body] = falling_body();
  const Advance a = simulation.advance(10.25 * kStep);
  CHECK(a.steps == 4);
  CHECK(a.dropped == 6 * kStep);
  CHECK(a.fraction == 0.25);
  const Advance next = simulation.advance(0.75 * kStep);
  CHECK(next.steps == 1);
  CHECK(next.dropped == 0);
  simulation.most_steps = 100;
  CHECK(simulation.advance(10 * kStep).steps == 10);
}

TEST_CASE("no wall time is lost: steps, what is dropped and what is left add up") {
  auto [simulation, body] = falling_body();
  Real wall = 0, dropped = 0;
  int steps = 0;
  for (int i = 1; i < 200; ++i) {
    const Real slice = kStep * ((i * 37) % 41) / 8;
    wall += slice;
    const Advance a = simulation.advance(slice);
    steps += a.steps, dropped += a.dropped;
    REQUIRE(a.steps <= simulation.most_steps);
    REQUIRE(a.fraction >= 0);
    REQUIRE(a.fraction < 1);
    REQUIRE(steps * kStep + dropped + a.fraction * kStep == wall);
  }
  CHECK(dropped > 0);
  CHECK(simulation.world.tick == static_cast<std::uint64_t>(steps));
}

TEST_CASE("wall time that is none is no time") {
  auto [simulation, body] = falling_body();
  const Real none = GENERATE(0.0, -1.0, std::numeric_limits<Real>::quiet_NaN());
  simulation.advance(0.5 * kStep);
  const Advance a = simulation.advance(none);
  CHECK(a.steps == 0);
  CHECK(a.fraction == 0.5);
  CHECK(simulation.advance(0.5 * kStep).steps == 1);
}

TEST_CASE("an endless pause does not stop the clock for good") {
  auto [simulation, body] = falling_body();
  const Advance a = simulation.advance(std::numeric_limits<Real>::infinity());
  CHECK(a.steps <= simulation.most_steps);
  CHECK(a.fraction >= 0);
  CHECK(a.fraction < 1);
  const Advance next = simulation.advance(kStep);
  CHECK(next.steps == 1);
  CHECK(next.dropped == 0);
}

TEST_CASE("advancing takes the same steps as stepping") {
  Simulation walked(swaying_puppet().world), timed(swaying_puppet().world);
  walked.settings.h = timed.settings.h = kStep;
  for (int i = 0; i < 30; ++i) walked.step();
  while (timed.world.tick < 30) timed.advance(0.75 * kStep);
  CHECK(state_hash(walked.world) == state_hash(timed.world));
}

TEST_CASE("a body is drawn between its last two poses") {
  auto [simulation, body] = falling_body();
  simulation.world.bodies[body].angular_velocity = {0, 0, 8};
  simulation.advance(3 * kStep);
  const Pose last = simulation.world.bodies[body].pose;
  simulation.advance(kStep);
  const Pose now = simulation.world.bodies[body].pose;
  REQUIRE(glm::length(now.position - last.position) > 1e-3);

  const Pose start = simulation.interpolated(body, 0), end = simulation.interpolated(body, 1);
  const Pose mid = simulation.interpolated(body, 0.5);
  CHECK(glm::length(start.position - last.position) < 1e-15);
  CHECK(glm::length(end.position - now.position) < 1e-15);
  CHECK(glm::length(mid.position - 0.5 * (last.position + now.position)) < 1e-15);
  const Real whole = std::abs(glm::dot(last.rotation, now.rotation));
  const Real half = std::abs(glm::dot(last.rotation, mid.rotation));
  CHECK(2 * half * half - 1 == Approx(whole).epsilon(1e-12));  // cosine of the double angle
  CHECK(glm::length(mid.rotation) == Approx(1).epsilon(1e-14));
}

TEST_CASE("before the first step a body is drawn where it is") {
  auto [simulation, body] = falling_body();
  simulation.advance(0.5 * kStep);
  CHECK(simulation.interpolated(body, 0.5).position == Vec3(0));
}

TEST_CASE("a body added after the last step is drawn where it is") {
  auto [simulation, body] = falling_body();
  simulation.advance(kStep);
  simulation.world.destroy(body);
  Body later;
  later.pose.position = {5, 5, 5};
  const Entity e = simulation.world.add_body(later);
  REQUIRE(e.index == body.index);
  CHECK(simulation.interpolated(e, 0.5).position == Vec3(5, 5, 5));
}

TEST_CASE("bodies that come and go leave the others where they are drawn") {
  auto [simulation, body] = falling_body();
  const Entity first = body;
  const Entity second = simulation.world.add_body(simulation.world.bodies[first]);
  simulation.world.bodies[second].velocity = {0, 3, 0};
  simulation.advance(2 * kStep);
  const Vec3 last = simulation.world.bodies[second].pose.position;
  const auto is_between = [&, &sim = simulation] {
    const Vec3 now = sim.world.bodies[second].pose.position;
    return glm::length(sim.interpolated(second, 0.5).position - 0.5 * (last + now)) < 1e-12;
  };
  SECTION("before the step") {
    simulation.world.add_body({});
    simulation.world.destroy(first);
    simulation.advance(kStep);
    CHECK(is_between());
  }
  SECTION("within the step, before bodies move and after") {
    for (const Stage stage : {Stage::before_drive, Stage::after_step})
      simulation.insert(stage, [&, stage](World& w, Real) {
        stage == Stage::before_drive ? w.destroy(first) : void(w.add_body({}));
      });
    simulation.advance(kStep);
    CHECK(is_between());
  }
  SECTION("after the step") {
    simulation.advance(kStep);
    simulation.world.destroy(first);
    simulation.world.add_body({});
    CHECK(is_between());
  }
  SECTION("a teleported one behind one that goes") {
    simulation.insert(Stage::before_update, [&](World& w, Real) {
      if (!w.is_alive(first)) return;
      w.destroy(first);
      w.teleport(second, {{100, 0, 0}, kIdentity});
    });
    simulation.advance(kStep);
    CHECK(simulation.interpolated(second, 0.5).position.x == 100);
  }
}

TEST_CASE("nothing is drawn on the way of a teleported body") {
  auto [simulation, body] = falling_body();
  const Vec3 far{100, 0, 0};
  simulation.advance(2 * kStep);

  SECTION("between two steps") {
    simulation.world.teleport(body, {far, kIdentity});
    CHECK(simulation.interpolated(body, 0.5).position == far);
    simulation.advance(kStep);
    for (Real fraction : {0.0, 0.5, 1.0})
      CHECK(simulation.interpolated(body, fraction).position.x >= 100);
  }
  SECTION("by a system in the middle of a step") {
    const Entity who = body;
    bool now = true;
    simulation.insert(Stage::before_update, [&, who](World& w, Real) {
      if (now) w.teleport(who, {far, kIdentity});
      now = false;
    });
    simulation.advance(kStep);
    for (Real fraction : {0.0, 0.5, 1.0})
      CHECK(simulation.interpolated(body, fraction).position.x >= 100);
  }
}

TEST_CASE("a teleported body is drawn moving again from the next step on") {
  auto [simulation, body] = falling_body();
  simulation.advance(kStep);
  simulation.world.teleport(body, {{100, 0, 0}, kIdentity});
  simulation.advance(kStep);
  const Vec3 last = simulation.world.bodies[body].pose.position;
  simulation.advance(kStep);
  const Vec3 now = simulation.world.bodies[body].pose.position;
  REQUIRE(now != last);
  CHECK(glm::length(simulation.interpolated(body, 0.5).position - 0.5 * (last + now)) < 1e-12);
}

TEST_CASE("a teleported body keeps its velocity and forgets the jump") {
  auto [simulation, body] = falling_body();
  simulation.advance(kStep);
  const Vec3 before = simulation.world.bodies[body].velocity;
  simulation.world.teleport(body, {{100, 0, 0}, kIdentity});
  simulation.advance(kStep);
  CHECK(glm::length(simulation.world.bodies[body].velocity - before) < 1);
}
