// Numbers that no step can be computed with: told with the body, and kept to its own island.
#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "engine/world/ties.hpp"
#include "tests/runtime/puppets.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();
constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
constexpr Real kBad[] = {kNan, kInfinity, -kInfinity};

bool is_sound(const Body& b) {
  return is_finite(b.pose) && is_finite(b.velocity) && is_finite(b.angular_velocity);
}

/// A puppet that is to be spoiled, and a chain far from it that is not.
struct Pair {
  Puppet puppet = swaying_puppet();
  std::vector<Entity> rods;
  Entity hook;

  explicit Pair(Solver solver) {
    World& w = puppet.world;
    w.default_settings.solver = solver;
    Body fixed;
    fixed.motion = Motion::fixed, fixed.pose.position = {50, 0, 0};
    hook = w.add_body(fixed);
    Entity above = hook;
    Vec3 end(0);
    for (int i = 0; i < 6; ++i) {
      rods.push_back(w.add_body(rod({50 + kHalfLink * (2 * i + 1), 0, 0})));
      add_link(w, {above, rods.back(), {end, {-kHalfLink, 0, 0}}});
      above = rods.back(), end = {kHalfLink, 0, 0};
    }
  }
};

struct Spoil {
  std::string what;
  std::function<void(Pair&)> apply;
};

/// Steps a spoiled World beside a sound one. Every step that leaves the puppet unsound, or that
/// cannot use what it was given, has to say so; the chain has to end in the same bits.
void expect_told(Solver solver, const Spoil& spoil, bool from_the_start) {
  INFO(name_of(solver) << ", " << spoil.what << (from_the_start ? ", from the start" : ", later"));
  Pair sick(solver);
  Simulation well(Pair(solver).puppet.world);
  if (from_the_start) spoil.apply(sick);
  Simulation sim = Simulation::copy_of(sick.puppet.world);
  const int before = from_the_start ? 0 : 5;
  for (int i = 0; i < before; ++i) REQUIRE(sim.step().status != Status::diverged);
  if (!from_the_start) {
    sick.puppet.world = std::move(sim.world);
    spoil.apply(sick);
    sim.world = std::move(sick.puppet.world);
    sim.world.mark_dirty();
  }
  std::vector<bool> sound;
  for (const Body& b : sim.world.bodies.values()) sound.push_back(is_sound(b));
  bool told = false;
  for (int i = before; i < 12; ++i) {
    const StepReport report = sim.step();
    if (report.status == Status::diverged) {
      CHECK(sim.world.bodies.find(report.body));
      told = true;
    }
  }
  CHECK(told);
  for (std::size_t i = 0; i < sound.size(); ++i)
    if (sound[i]) CHECK(is_sound(sim.world.bodies.values()[i]));
  if (!from_the_start) return;  // the touch is felt by both
  for (int i = 0; i < 12; ++i) well.step();
  for (Entity e : sick.rods) {
    CHECK(sim.world.bodies[e].pose.position == well.world.bodies[e].pose.position);
    CHECK(sim.world.bodies[e].velocity == well.world.bodies[e].velocity);
  }
}

void expect_told(const Spoil& spoil) {
  for (Solver solver :
       {Solver::articulated, Solver::sweep, Solver::shake2, Solver::procedural, Solver::lagrangian})
    for (bool from_the_start : {true, false}) expect_told(solver, spoil, from_the_start);
}

}  // namespace

TEST_CASE("a path of numbers that are not finite is told with its body, which stays") {
  for (Real bad : kBad) {
    expect_told({"sway", [=](Pair& p) {
                   std::get<Lissajous>(p.puppet.world.paths[p.puppet.bar].curve).amplitude.y = bad;
                 }});
    expect_told({"sway that turns", [=](Pair& p) {
                   auto& path = std::get<Lissajous>(p.puppet.world.paths[p.puppet.bar].curve);
                   path.turn_amplitude.z = bad;
                 }});
    expect_told({"key pose", [=](Pair& p) {
                   Keyframes keys;
                   keys.keys = {{0, {{0, 1, 0}}}, {0.05, {{bad, 1, 0}}}, {1, {{0, 1, 0}}}};
                   p.puppet.world.paths[p.puppet.bar].curve = keys;
                 }});
    expect_told({"key turn", [=](Pair& p) {
                   Keyframes keys;
                   keys.keys = {{0, {{0, 1, 0}}}, {0.05, {{0, 1, 0}, {bad, 0, 0, 0}}}};
                   p.puppet.world.paths[p.puppet.bar].curve = keys;
                 }});
  }
  expect_told({"key time", [](Pair& p) {
                 Keyframes keys;
                 keys.keys = {{0, {{0, 1, 0}}}, {kNan, {{0.1, 1, 0}}}, {0.3, {{0, 1, 0}}}};
                 p.puppet.world.paths[p.puppet.bar].curve = keys;
               }});
}

TEST_CASE("a kinematic body that nothing hangs on is told as well") {
  World w;
  Body b;
  b.motion = Motion::kinematic;
  const Entity e = w.add_body(b), free = w.add_body(rod({1, 0, 0}));
  Lissajous sway;
  sway.amplitude = {kNan, 0, 0}, sway.frequency = {1, 0, 0};
  w.paths.add(e, {sway});
  Simulation sim(std::move(w));
  const StepReport report = sim.step();
  CHECK(report.status == Status::diverged);
  CHECK(report.body == e);
  CHECK(is_sound(sim.world.bodies[e]));
  CHECK(sim.world.bodies[free].velocity.y < 0);
}

TEST_CASE("masses that no body can have are told with the body") {
  for (Real bad : {0.0, -0.0, -1.0, kNan, kInfinity, -kInfinity, 1e-320}) {
    const std::string number = std::to_string(bad);
    expect_told(
        {"mass " + number, [=](Pair& p) { p.puppet.world.bodies[p.puppet.trunk].mass = bad; }});
    for (int axis = 0; axis < 3; ++axis)
      expect_told({"inertia " + number,
                   [=](Pair& p) { p.puppet.world.bodies[p.puppet.left].inertia[axis] = bad; }});
    expect_told({"mass of a free body " + number,
                 [=](Pair& p) { p.puppet.world.bodies[p.puppet.free].mass = bad; }});
  }
}

TEST_CASE("the body with an impossible mass is the one that is named") {
  for (Solver solver : {Solver::articulated, Solver::sweep, Solver::lagrangian}) {
    Pair p(solver);
    p.puppet.world.bodies[p.puppet.right].mass = -2;
    Simulation sim = Simulation::copy_of(p.puppet.world);
    const StepReport report = sim.step();
    INFO(name_of(solver));
    CHECK(report.status == Status::diverged);
    CHECK(report.body == p.puppet.right);
  }
}

TEST_CASE("other numbers of bodies, joints, cables and pins that are not finite are told") {
  for (Real bad : kBad) {
    expect_told({"drag", [=](Pair& p) { p.puppet.world.bodies[p.puppet.trunk].drag = bad; }});
    expect_told({"gravity scale",
                 [=](Pair& p) { p.puppet.world.bodies[p.puppet.trunk].gravity_scale = bad; }});
    expect_told({"anchor of a joint",
                 [=](Pair& p) { p.puppet.world.links[p.puppet.link].joint.anchor_b.y = bad; }});
    expect_told({"anchor of a cable",
                 [=](Pair& p) { p.puppet.world.cables[p.puppet.string].joint.anchor_b.y = bad; }});
    expect_told(
        {"anchor of a pin", [=](Pair& p) { p.puppet.world.pins[p.puppet.pin].anchor.y = bad; }});
    expect_told(
        {"target of a pin", [=](Pair& p) { p.puppet.world.pins[p.puppet.pin].target.y = bad; }});
    expect_told(
        {"pose", [=](Pair& p) { p.puppet.world.bodies[p.puppet.trunk].pose.position.x = bad; }});
    expect_told(
        {"velocity", [=](Pair& p) { p.puppet.world.bodies[p.puppet.trunk].velocity.x = bad; }});
    expect_told(
        {"spin", [=](Pair& p) { p.puppet.world.bodies[p.puppet.trunk].angular_velocity.x = bad; }});
    expect_told({"place of a kinematic body", [=](Pair& p) {
                   p.puppet.world.paths.remove(p.puppet.bar);
                   p.puppet.world.bodies[p.puppet.bar].pose.position.y = bad;
                 }});
  }
  expect_told({"length of a cable",
               [](Pair& p) { p.puppet.world.cables[p.puppet.string].joint.length = kNan; }});
  expect_told({"compliance of a cable",
               [](Pair& p) { p.puppet.world.cables[p.puppet.string].joint.compliance = kNan; }});
}

TEST_CASE("a gravity that is not finite is told") {
  for (Solver solver : {Solver::articulated, Solver::sweep, Solver::lagrangian})
    for (Real bad : kBad) {
      Pair p(solver);
      p.puppet.world.gravity.y = bad;
      Simulation sim = Simulation::copy_of(p.puppet.world);
      CHECK(sim.step().status == Status::diverged);
      for (const Body& b : sim.world.bodies.values()) CHECK(is_sound(b));
    }
}

TEST_CASE("a clock that is not finite stops the step, and is told") {
  for (Real bad : kBad)
    for (bool in_a_system : {false, true}) {
      Simulation sim(Pair(Solver::articulated).puppet.world);
      for (int i = 0; i < 3; ++i) sim.step();
      if (in_a_system)
        sim.insert(Stage::before_drive, [=](World& w, Real) { w.time = bad; });
      else
        sim.world.time = bad;
      const World before = sim.world;
      const StepReport report = sim.step();
      CHECK(report.status == Status::bad_clock);
      for (std::size_t i = 0; i < before.bodies.size(); ++i) {
        CHECK(sim.world.bodies.values()[i].pose.position ==
              before.bodies.values()[i].pose.position);
        CHECK(sim.world.bodies.values()[i].velocity == before.bodies.values()[i].velocity);
      }
    }
}

TEST_CASE("a step too short or too long to compute with is not taken, and told") {
  for (Solver solver : {Solver::articulated, Solver::sweep, Solver::lagrangian})
    for (Real h : {5e-324, 1e-300, 1e-100, 1e-14, 1e12, 1e300}) {
      Simulation sim(Pair(solver).puppet.world);
      for (int i = 0; i < 3; ++i) sim.step();
      const std::uint64_t before = state_hash(sim.world);
      sim.settings.h = h;
      const StepReport report = sim.step();
      INFO(name_of(solver) << " " << h);
      CHECK(report.status == Status::bad_clock);
      CHECK(state_hash(sim.world) == before);
      sim.settings.h = 1.0 / 60;
      const Status next = sim.step().status;
      CHECK((next != Status::bad_clock && next != Status::diverged));
    }
  Simulation sim(Pair(Solver::articulated).puppet.world);
  sim.settings.substeps = 1'000'000'000;
  sim.settings.h = 1e-5;
  CHECK(sim.step().status == Status::bad_clock);
}

TEST_CASE("steps from a nanosecond to a second are taken") {
  for (Real h : {1e-9, 1e-6, 1e-3, 1.0}) {
    Simulation sim(Pair(Solver::articulated).puppet.world);
    sim.settings.h = h;
    INFO(h);
    for (int i = 0; i < 3; ++i) CHECK(sim.step().status == Status::ok);
  }
}

TEST_CASE("what is asked of an entity that is not there does nothing, and says so") {
  Pair p(Solver::articulated);
  World& w = p.puppet.world;
  const Entity gone = p.puppet.free, none{}, beyond{4'000'000'000u, 0}, string = p.puppet.string;
  w.destroy(gone);
  Simulation sim = Simulation::copy_of(w);
  for (int i = 0; i < 3; ++i) sim.step();
  const std::uint64_t before = state_hash(sim.world);
  const std::size_t forces = sim.world.forces.size();
  for (Entity e : {gone, none, beyond, string}) {
    CHECK_FALSE(sim.world.push(e, {1, 2, 3}, Vec3(0)));
    CHECK_FALSE(sim.world.teleport(e, {}));
    CHECK_THROWS_AS(sim.world.bodies[e], std::out_of_range);
    const World& fixed = sim.world;
    CHECK_THROWS_AS(fixed.bodies[e], std::out_of_range);
    CHECK_THROWS_AS(fixed.origin_pose(e), std::out_of_range);
    CHECK(sim.interpolated(e, 0.5).position == Vec3(0));
  }
  CHECK(sim.world.forces.size() == forces);
  CHECK(state_hash(sim.world) == before);
  CHECK(sim.world.push(p.puppet.trunk, {1, 2, 3}, Vec3(0)));
  CHECK(sim.world.teleport(p.puppet.trunk, {}));
  // One that got the place of another is not taken for it.
  const Entity heir = sim.world.add_body(rod({3, 0, 0}));
  CHECK(heir.index == gone.index);
  CHECK_FALSE(sim.world.push(gone, {1, 0, 0}, Vec3(0)));
  CHECK_THROWS_AS(sim.world.bodies[gone], std::out_of_range);
}

TEST_CASE("a system that asks for an entity that is not there fails, and the step goes on") {
  Pair p(Solver::articulated);
  const Entity gone = p.puppet.free;
  p.puppet.world.destroy(gone);
  Simulation sim = Simulation::copy_of(p.puppet.world);
  sim.insert(Stage::before_update, [=](World& w, Real) { w.bodies[gone].velocity = Vec3(1); });
  const StepReport report = sim.step();
  CHECK(report.status == Status::system_failed);
  CHECK(sim.world.tick == 1);
}
