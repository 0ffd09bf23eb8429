// The Lagrangian solver where stops, cables, contacts and fast turns meet: no integrator makes
// energy, and each goes where a finer step has it go.
#include <catch2/catch.hpp>
#include <random>

#include "engine/joints/kinds.hpp"
#include "engine/scene/scene.hpp"
#include "engine/world/ties.hpp"
#include "tests/paths.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  Real any(Real from, Real to) { return std::uniform_real_distribution<Real>(from, to)(random_); }
  Vec3 in_cube(Real half) { return {any(-half, half), any(-half, half), any(-half, half)}; }
  Quat turn() { return glm::normalize(Quat(any(-1, 1), any(-1, 1), any(-1, 1), any(-1, 1))); }

 private:
  std::mt19937 random_;
};

void solve_by(World& w, const char* integrator) {
  w.default_settings.solver = Solver::lagrangian;
  w.default_settings.sleep_speed = 0;
  REQUIRE(integrator_from_name(integrator, w.default_settings.integrator));
}

/// Three boxes on hinges with near stops, falling on a rough floor.
World stopped_drop(unsigned seed) {
  Dice dice(seed);
  World w;
  Collision rough;
  rough.friction = 0.4;
  add_ground(w, rough);
  Entity last;
  Vec3 before(0);
  for (int i = 0; i < 3; ++i) {
    const Vec3 at(0.42 * i, dice.any(0.25, 0.4), dice.any(-0.05, 0.05));
    const Vec3 half(dice.any(0.05, 0.1), dice.any(0.05, 0.1), dice.any(0.05, 0.1));
    const Entity e = add_solid(w, box_shape(half), {at, dice.turn()}, Motion::dynamic, rough);
    w.bodies[e].velocity = {0, -1, 0};
    if (i > 0) {
      const Quat axes = dice.turn();
      const Pose &a = w.bodies[last].pose, &b = w.bodies[e].pose;
      Joint j;
      j.kind = JointKind::hinge;
      j.anchor_a = to_local(a, 0.5 * (at + before)), j.anchor_b = to_local(b, 0.5 * (at + before));
      j.frames.set(glm::conjugate(a.rotation) * axes, glm::conjugate(b.rotation) * axes);
      JointLimits limits;
      limits.angle = {.on = true, .low = -dice.any(0.03, 0.25), .high = dice.any(0.03, 0.25)};
      j.limits = limits;
      add_link(w, {last, e, j});
    }
    last = e, before = at;
  }
  return w;
}

/// Four rods on ball joints with cones about them, each on one before it, swing freely.
World coned_tree(unsigned seed) {
  Dice dice(seed);
  World w;
  Body world_body;
  world_body.motion = Motion::fixed;
  std::vector<Entity> bodies{w.add_body(world_body)};
  std::vector<Vec3> tips{Vec3(0)};
  for (int i = 0; i < 4; ++i) {
    const std::size_t parent = i == 0 ? 0 : 1 + std::size_t(dice.any(0, Real(i)));
    const Quat turn = dice.turn();
    const Real length = dice.any(0.2, 0.4);
    const Vec3 way = turn * Vec3(length, 0, 0);
    Body b;
    b.drag = 0, b.mass = dice.any(0.3, 1.5);
    b.pose = {tips[parent] + 0.5 * way, turn};
    b.inertia = b.mass * length * length / 12 * Vec3(0.03, 1, 1);
    const Entity e = w.add_body(b);
    const Pose& a = w.bodies[bodies[parent]].pose;
    Joint j;
    j.anchor_a = to_local(a, tips[parent]), j.anchor_b = {-0.5 * length, 0, 0};
    j.frames.set(glm::conjugate(a.rotation) * turn, kIdentity);
    JointLimits limits;
    limits.swing.on = true, limits.swing.y = limits.swing.z = dice.any(0.25, 0.85);
    j.limits = limits;
    add_link(w, {bodies[parent], e, j});
    bodies.push_back(e), tips.push_back(tips[parent] + way);
  }
  return w;
}

std::vector<Vec3> places_after(World w, Real time, int rate) {
  Simulation sim(std::move(w), {1.0 / rate});
  for (int i = 0; i < std::lround(time * rate); ++i) REQUIRE(sim.step().status == Status::ok);
  std::vector<Vec3> places;
  for (const Body& b : sim.world.bodies.values()) places.push_back(b.pose.position);
  return places;
}

/// The most energy a World has in a time, and what it has at the end, J.
struct Energies {
  Real start = 0, most = 0, end = 0;
};
Energies energies_in(World w, Real time, Real rate) {
  Simulation sim(std::move(w), {1 / rate});
  Energies found;
  found.start = found.most = measure(sim.world).energy();
  for (int i = 0; i < std::lround(time * rate); ++i) {
    REQUIRE(sim.step().status == Status::ok);
    found.end = measure(sim.world).energy();
    found.most = std::max(found.most, found.end);
  }
  return found;
}

}  // namespace

TEST_CASE("boxes on hinges with stops gain nothing where they fall on a floor") {
  const char* integrator = GENERATE("euler", "rattle", "rk4", "implicit", "radau");
  const int rate = GENERATE(60, 240);
  for (unsigned seed = 1; seed <= 10; ++seed) {
    World w = stopped_drop(seed);
    solve_by(w, integrator);
    const Energies found = energies_in(std::move(w), 0.6, rate);
    INFO(integrator << " at " << rate << " Hz, seed " << seed);
    CHECK(found.most <= found.start + 1e-3 * std::abs(found.start));
  }
}

TEST_CASE("a puppet on stairs gains nothing where its stops meet the stairs") {
  SolverChoices rattle;
  rattle.solver = Solver::lagrangian, rattle.integrator = Integrator::rattle;
  const auto read = load_scene(asset("scenes/stairs.json"), {}, rattle);
  REQUIRE(read);
  // 1.3 kJ are the work of what pushes it.
  CHECK(energies_in(read->world, 0.8, 240).most < 4200);
}

TEST_CASE("limits that contacts open are left to open by every integrator") {
  std::vector<Vec3> first;
  for (const Integrator integrator :
       {Integrator::radau, Integrator::rk4, Integrator::rattle, Integrator::implicit}) {
    SolverChoices choices;
    choices.solver = Solver::lagrangian, choices.integrator = integrator;
    const auto read = load_scene(asset("scenes/stairs.json"), {}, choices);
    REQUIRE(read);
    const std::vector<Vec3> places = places_after(read->world, 0.25, 960);
    if (first.empty()) first = places;
    for (std::size_t i = 0; i < places.size(); ++i)
      CHECK(glm::distance(places[i], first[i]) < 2e-4);
  }
}

TEST_CASE("trees with cones swing to where a finer step has them") {
  constexpr std::array<int, 2> kRates{240, 960};
  constexpr std::array<Real, 2> kBounds{12e-3, 2e-3};  // m
  std::array<std::vector<Real>, 2> errors;
  for (unsigned seed = 1; seed <= 9; ++seed) {
    World w = coned_tree(seed);
    solve_by(w, "rk4");
    const std::vector<Vec3> to = places_after(w, 0.8, 7680);
    for (std::size_t k = 0; k < kRates.size(); ++k) {
      const std::vector<Vec3> places = places_after(w, 0.8, kRates[k]);
      Real most = 0;
      for (std::size_t i = 0; i < to.size(); ++i)
        most = std::max(most, glm::distance(places[i], to[i]));
      errors[k].push_back(most);
    }
  }
  for (std::size_t k = 0; k < kRates.size(); ++k) {
    std::sort(errors[k].begin(), errors[k].end());
    INFO(kRates[k] << " Hz");
    CHECK(errors[k][4] <= kBounds[k]);
  }
}

TEST_CASE("a body that spins fast keeps energy and angular momentum") {
  const char* integrator = GENERATE("euler", "rattle", "rk4", "implicit", "radau");
  const Real rate = GENERATE(60, 240);
  const Vec3 spin = GENERATE(Vec3(20, 1, 40), Vec3(60, 3, 120), Vec3(200, 10, 400));
  World w;
  w.gravity = Vec3(0);
  solve_by(w, integrator);
  const Entity e = add_solid(w, box_shape({0.2, 0.1, 0.05}), {Vec3(0), kIdentity}, Motion::dynamic);
  w.bodies[e].angular_velocity = spin;
  Simulation sim(std::move(w), {1 / rate});
  const Measures before = measure(sim.world);
  for (int i = 0; i < 20 * rate; ++i) REQUIRE(sim.step().status == Status::ok);
  const Measures after = measure(sim.world);
  INFO(integrator << " at " << rate << " Hz, " << glm::length(spin) << " rad/s");
  CHECK(after.energy() == Approx(before.energy()).epsilon(2e-3));
  CHECK(glm::length(after.angular_momentum - before.angular_momentum) <=
        2e-3 * glm::length(before.angular_momentum));
}

TEST_CASE("a ball that bounces without loss keeps its energy with every integrator") {
  const char* integrator = GENERATE("euler", "rattle", "rk4", "implicit", "radau");
  const Real rate = GENERATE(60, 240);
  World w;
  Collision bouncy;
  bouncy.friction = 0, bouncy.restitution = 1;
  add_ground(w, bouncy);
  add_solid(w, ball_shape(0.1), {{0, 1, 0}, kIdentity}, Motion::dynamic, bouncy);
  solve_by(w, integrator);
  const Energies found = energies_in(std::move(w), 20, rate);
  INFO(integrator << " at " << rate << " Hz");
  CHECK(found.end == Approx(found.start).epsilon(1e-6));
  CHECK(found.most <= found.start * (1 + 1e-9));
}

TEST_CASE(
    "a ball that a cable whips round keeps its energy with every method of order 2 and more") {
  const char* integrator = GENERATE("rattle", "rk4", "implicit", "radau");
  const Real rate = GENERATE(60, 240, 960, 3840);
  const auto read = parse_scene(R"({"version": 1, "bodies": [
  {"name": "rod", "position": [0.5, 0, 0], "rotation_deg": [0, 0, 90], "mass": 1,
   "shape": {"type": "capsule", "radius": 0.02, "length": 0.9}},
  {"name": "ball", "position": [1.5, 0, 0], "mass": 1, "shape": {"type": "sphere", "radius": 0.1}}],
  "joints": [{"a": "world", "b": "rod", "anchor": [0, 0, 0]}],
  "cables": [{"a": "rod", "b": "ball", "anchor_a": [1, 0, 0], "anchor_b": [1.5, 0, 0]}]})",
                                "whip");
  REQUIRE(read);
  World w = read->world;
  solve_by(w, integrator);
  const Energies found = energies_in(std::move(w), 1, rate);
  INFO(integrator << " at " << rate << " Hz");
  // By radau with a tolerance of 1e-8 and 1e-10.
  const Real margin = std::string(integrator) == "implicit" ? 0.15 : 0.05;
  CHECK(found.end - found.start == Approx(-1.0104).margin(margin));
  CHECK(found.most <= found.start + 1e-4);
}
