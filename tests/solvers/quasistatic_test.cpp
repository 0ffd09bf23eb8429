// Laminas as bodies of a World: moved by contact modes, left to dynamics where there is no answer.
#include <catch2/catch.hpp>
#include <set>
#include <sstream>

#include "engine/runtime/save.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"
#include "engine/solvers/quasistatic/island.hpp"
#include "engine/world/flat.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

/// A thin rod on two fingers that approach each other at 0.01 m/s from 0.4 and 0.25 m.
std::string rod(double roll, double slide) {
  std::ostringstream text;
  const auto finger = [&](const char* name, double x, double velocity) {
    text << R"({"name": ")" << name << R"(", "point": [)" << x << R"(, 0], "velocity": [)"
         << velocity << R"(, 0], "friction": [)" << roll << ", " << slide << "]}";
  };
  text << R"({"version": 1, "gravity": [0, -10, 0], "laminas": [
    {"name": "rod", "centre_of_mass": [0, 0.01],
     "outline": [[-0.6, 0], [0.6, 0], [0.6, 0.02], [-0.6, 0.02]], "fingers": [)";
  finger("left", -0.4, 0.01), text << ", ", finger("right", 0.25, -0.01);
  text << "]}]}";
  return text.str();
}

World world_of(const std::string& text) {
  const auto scene = parse_scene(text, "test");
  if (!scene) FAIL(scene.errors().front().message);
  return scene->world;
}

/// What of a run is told by its reports.
struct Told {
  int switches = 0, by_dynamics = 0;
  std::vector<std::string> to_dynamics;
  std::vector<Real> back;  // s
};

Told run(Simulation& sim, Real until) {
  Told told;
  while (sim.world.time < until - 1e-9) {
    const StepReport r = sim.step();
    REQUIRE(r.status == Status::ok);
    told.switches += r.mode_switches, told.by_dynamics += r.handed_over > 0;
    if (!r.lamina) continue;
    CHECK(sim.world.name_of(r.lamina) == "rod");
    if (*r.changed)
      told.to_dynamics.push_back(r.changed);
    else
      told.back.push_back(r.time);
  }
  return told;
}

const quasistatic::Island& island(const World& world) {
  return quasistatic::islands_of(world).front();
}

}  // namespace

TEST_CASE("A rod of a World switches modes where the closed form says, whatever the step") {
  const std::string text = R"({"version": 1, "gravity": [0, -10, 0], "laminas": [
    {"name": "rod", "centre_of_mass": [0, 0.01],
     "outline": [[-1.2, 0], [1.2, 0], [1.2, 0.02], [-1.2, 0.02]],
     "fingers": [
       {"name": "left", "point": [-0.8, 0], "velocity": [0.01, 0],
        "friction": [0.45, 0.3]},
       {"name": "right", "point": [0.5, 0], "velocity": [-0.01, 0], "friction": [0.45, 0.3]}]}]})";
  for (const Real h : {1.0 / 60, 0.11}) {
    CAPTURE(h);
    Simulation sim(world_of(text), {h});
    // The left one slides until 0.45 l = 0.3 * 0.5: from 0.8 to a third, 70 / 3 s at 0.02 m/s.
    Told told = run(sim, 23.2);
    CHECK(told.switches == 0);
    CHECK(told.to_dynamics.empty());
    const Entity body = sim.world.find("rod");
    CHECK(sim.world.bodies[body].pose.position.x == Approx(-0.01 * sim.world.time).epsilon(1e-9));
    CHECK(sim.world.bodies[body].pose.position.y == Approx(0.01).epsilon(1e-9));
    told = run(sim, 23.5);
    CHECK(told.switches == 1);
    const Real after = -0.7 / 3 + 0.01 * (sim.world.time - 70.0 / 3);
    CHECK(sim.world.bodies[body].pose.position.x == Approx(after).epsilon(1e-8));
  }
}

TEST_CASE("Where two modes hold dynamics decides, and modes take over") {
  Simulation sim(world_of(rod(0.5, 0.3)), {1.0 / 60});
  const Told told = run(sim, 14);
  CHECK(told.to_dynamics ==
        std::vector<std::string>{quasistatic::word_for(quasistatic::Why::ambiguous)});
  REQUIRE(told.back.size() == 1);
  CHECK(told.back[0] < 0.2);
  CHECK(told.switches == 1);
  // As by modes from the start: a switch at 12.5 s, 0.125 m to the left.
  const Vec3 at = sim.world.bodies[sim.world.find("rod")].pose.position;
  CHECK(at.x == Approx(-0.125 + 0.015).margin(2e-3));
  CHECK(at.y == Approx(0.01).margin(1e-6));
}

TEST_CASE("Where modes switch without end dynamics slides on both fingers") {
  Simulation sim(world_of(rod(0.3, 0.3)), {1.0 / 60});
  const Told told = run(sim, 15);
  REQUIRE(told.to_dynamics.size() >= 1);
  CHECK(told.to_dynamics.front() == quasistatic::word_for(quasistatic::Why::zeno));
  CHECK(told.by_dynamics > 100);
  // Arms stay alike: the middle of the fingers, which has moved by nothing, is 0.075 to the left.
  CHECK(sim.world.bodies[sim.world.find("rod")].pose.position.x == Approx(-0.075).margin(6e-3));
}

TEST_CASE("A rod that loses a finger falls, and no step is silent of it") {
  const std::string text = R"({"version": 1, "gravity": [0, -10, 0], "laminas": [
    {"name": "rod", "outline": [[-0.6, 0], [0.6, 0], [0.6, 0.02], [-0.6, 0.02]],
     "fingers": [
       {"name": "left", "point": [-0.4, 0]},
       {"name": "right", "point": [0.4, 0], "waypoints": [[0.5, 0.4, 0], [0.52, 0.4, -2]]}]}]})";
  Simulation sim(world_of(text), {1.0 / 60});
  const Told told = run(sim, 0.8);
  REQUIRE(told.to_dynamics.size() == 1);
  CHECK(told.back.empty());
  CHECK(told.by_dynamics >= 17);
  // A rod about its held end begins to turn with 0.4 g / (1/12 1.2^2 + 0.4^2).
  const Body& b = sim.world.bodies[sim.world.find("rod")];
  const Real since = sim.world.time - 0.5;
  CHECK(b.angular_velocity.z < -0.5 * since * 0.4 * 10 / 0.28);
  CHECK(b.pose.position.y < -0.1);
}

TEST_CASE("Copies, saved and loaded Worlds of laminas go on with the same bits") {
  // In modes, in dynamics for want of an answer, and between.
  const Real at = GENERATE(0.05, 0.5, 12.45, 12.9);
  const double slide = GENERATE(0.3, 0.5);
  CAPTURE(at, slide);
  Simulation sim(world_of(rod(0.5, slide)), {1.0 / 60});
  while (sim.world.time < at) sim.step();
  Simulation copy = Simulation::copy_of(sim.world, {1.0 / 60, 1, 3});
  const auto bytes = world_to_bytes(sim.world);
  REQUIRE(bytes);
  auto loaded = world_from_bytes(*bytes);
  REQUIRE(loaded);
  Simulation again(std::move(*loaded), {1.0 / 60});
  std::set<std::uint64_t> seen;
  for (int i = 0; i < 90; ++i) {
    sim.step(), copy.step(), again.step();
    REQUIRE(state_hash(copy.world) == state_hash(sim.world));
    REQUIRE(state_hash(again.world) == state_hash(sim.world));
    seen.insert(state_hash(sim.world));
  }
  CHECK(seen.size() == 90);
}

TEST_CASE("Several laminas are islands of their own, by any number of threads") {
  std::ostringstream text;
  text << R"({"version": 1, "gravity": [0, -10, 0], "laminas": [)";
  for (int i = 0; i < 5; ++i) {
    const auto at = [&](double x, double dy) { text << "[" << x << ", " << i + dy << "]"; };
    text << (i ? "," : "") << R"({"name": "rod)" << i << R"(", "outline": [)";
    at(-0.6, 0), text << ",", at(0.6, 0), text << ",", at(0.6, 0.02), text << ",", at(-0.6, 0.02);
    text << R"(], "fingers": [{"point": )";
    at(-0.4, 0), text << R"(, "friction": [0.5, 0.3], "velocity": [0.0)" << i + 1 << R"(, 0]})";
    text << R"(, {"friction": [0.5, 0.3], "velocity": [-0.01, 0], "point": )";
    at(0.25, 0), text << "}]}";
  }
  text << "]}";
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 3, 1}) {
    Simulation sim(world_of(text.str()), {1.0 / 60, 1, threads});
    for (int i = 0; i < 120; ++i) REQUIRE(sim.step().status == Status::ok);
    CHECK(quasistatic::islands_of(sim.world).size() == 5);
    hashes.insert(state_hash(sim.world));
  }
  CHECK(hashes.size() == 1);
}

TEST_CASE("A push, a teleport and fingers that the caller moves are taken as they are") {
  World world = world_of(rod(0.45, 0.3));
  for (Lamina& lamina : laminas_of(world).values())
    for (LaminaFinger& f : lamina.fingers) f.path.clear();
  for (const char* name : {"rod/left", "rod/right"})
    world.bodies[world.find(name)].velocity = Vec3(0);
  Simulation sim(std::move(world), {0.01});
  const Entity rod = sim.world.find("rod");
  const auto place = [&] { return sim.world.bodies[rod].pose.position; };
  for (int i = 0; i < 50; ++i) sim.step();
  CHECK(place().x == Approx(0).margin(1e-9));
  CHECK(island(sim.world).phase == quasistatic::Phase::modes);
  // Both fingers carry it along.
  for (int i = 0; i < 50; ++i) {
    for (const char* name : {"rod/left", "rod/right"}) {
      Body& finger = sim.world.bodies[sim.world.find(name)];
      finger.velocity = {0.1, 0.2, 0}, finger.pose.position += 0.01 * finger.velocity;
    }
    sim.step();
  }
  CHECK(place().x == Approx(0.05).epsilon(1e-6));
  CHECK(place().y == Approx(0.11).epsilon(1e-6));
  for (const char* name : {"rod/left", "rod/right"})
    sim.world.bodies[sim.world.find(name)].velocity = Vec3(0);
  // A push within what friction bears (0.45 of 10 N) does nothing, a stronger one drives it off.
  const auto push = [&](Real force) {
    for (int i = 0; i < 20; ++i) sim.world.push(rod, {force, 0, 0}, place()), sim.step();
  };
  push(4);
  CHECK(place().x == Approx(0.05).epsilon(1e-6));
  push(20);
  CHECK(place().x > 0.06);
  // Lifted off its fingers it falls.
  REQUIRE(sim.world.teleport(rod, {{0, 1, 0}, {1, 0, 0, 0}}));
  for (int i = 0; i < 30; ++i) sim.step();
  CHECK(place().y == Approx(1 - 5 * 0.3 * 0.3).margin(0.02));
}

TEST_CASE("What is no lamina, or is tied, is named and not moved") {
  World world = world_of(rod(0.45, 0.3));
  const Entity rod_body = world.find("rod");
  const auto reasons = [](const World& w) {
    std::string all;
    for (const StructureFault& f : check(w)) all += w.name_of(f.link) + ": " + f.reason + '\n';
    return all;
  };
  CHECK(reasons(world).empty());
  Body loose;
  loose.pose.position = {0, 3, 0};
  const Entity ball = world.add_body(loose, "ball");
  SolverSettings slow;
  slow.solver = Solver::quasistatic;
  world.settings.add(ball, slow);
  CHECK(reasons(world) == "ball: is solved by \"quasistatic\", which moves laminas only\n");
  Simulation sim = Simulation::copy_of(world, {0.01});
  const StepReport report = sim.step();
  CHECK(report.faults == 1);
  CHECK(sim.world.bodies[ball].pose.position.y == 3);
  world.destroy(ball);
  Pin pin;
  pin.body = rod_body;
  const Entity held = world.add_pin(pin, "nail");
  CHECK(reasons(world).find("nail: ties a lamina") == 0);
  world.destroy(held);
  laminas_of(world)[rod_body].fingers[0].slide = -1, world.mark_dirty();
  CHECK(reasons(world) ==
        "rod: is a lamina with a finger that has a number that is not finite or out of range\n");
  laminas_of(world)[rod_body].fingers[0].slide = 0.1;
  std::swap(laminas_of(world)[rod_body].outline[0], laminas_of(world)[rod_body].outline[1]);
  std::swap(laminas_of(world)[rod_body].outline[2], laminas_of(world)[rod_body].outline[3]);
  world.mark_dirty();
  CHECK(reasons(world) == "rod: is a lamina whose outline encloses no area\n");
}

TEST_CASE("A lamina goes on when a finger is destroyed") {
  Simulation sim(world_of(rod(0.45, 0.3)), {1.0 / 60});
  for (int i = 0; i < 30; ++i) sim.step();
  sim.world.destroy(sim.world.find("rod/right"));
  for (int i = 0; i < 30; ++i) REQUIRE(sim.step().status == Status::ok);
  CHECK(island(sim.world).phase == quasistatic::Phase::dynamics);
  CHECK(sim.world.bodies[sim.world.find("rod")].angular_velocity.z < -0.1);
}

TEST_CASE("The same scene by the solver planar slides on the finger with less load") {
  SolverChoices planar;
  planar.solver = Solver::planar;
  const auto scene = parse_scene(rod(0.3, 0.3), "test", {}, planar);
  REQUIRE(scene);
  Simulation sim = Simulation::copy_of(scene->world, {1.0 / 240});
  for (int i = 0; i < 480; ++i) sim.step();
  CHECK(sim.world.bodies[sim.world.find("rod")].pose.position.x == Approx(-0.02).margin(2e-3));
}
