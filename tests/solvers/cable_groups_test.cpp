// Bodies on inextensible cables near one another, stepped as groups in contact: a cable that
// becomes taut only removes energy, a taut one does no work.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;
using nlohmann::json;

namespace {

json ball(const char* name, Vec3 at, Real mass) {
  return {{"name", name},
          {"position", {at.x, at.y, at.z}},
          {"shape", {{"type", "sphere"}, {"radius", 0.08}}},
          {"mass", mass}};
}

json cable(const char* a, const char* b, Real slack) {
  return {{"a", a}, {"b", b}, {"anchor_a", {0, 0, 0}}, {"anchor_b", {0, 0, 0}}, {"slack", slack}};
}

/// Balls in a row, 0.3 m apart; the last ones on ball joints. The first hangs from the world.
json row(const std::vector<Real>& masses, std::size_t on_cables, Real slack) {
  json scene = {{"version", 1}, {"collision", {{"friction", 0.3}, {"restitution", 0}}}};
  json top = cable("world", "b0", slack);
  top.erase("anchor_a"), top["point_a"] = {0, 2.7, 0};
  scene["cables"] = json::array({top});
  scene["joints"] = json::array();
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const Real x = 0.3 * static_cast<Real>(i);
    const std::string name = "b" + std::to_string(i), before = "b" + std::to_string(i - 1);
    scene["bodies"].push_back(ball(name.c_str(), {x, 2, 0}, masses[i]));
    if (i == 0) continue;
    if (i < on_cables)
      scene["cables"].push_back(cable(before.c_str(), name.c_str(), slack));
    else
      scene["joints"].push_back(
          {{"kind", "ball"}, {"a", before}, {"b", name}, {"anchor", {x - 0.15, 2, 0}}});
  }
  return scene;
}

Simulation start(json scene, Real h) {
  const auto read = parse_scene(scene.dump(), "cable_groups");
  REQUIRE(read);
  return Simulation::copy_of(read->world, {h});
}

/// J: from the start to the highest energy in some seconds.
Real rise(Simulation& sim, Real seconds, Real h) {
  const Real before = measure(sim.world).energy();
  Real most = 0;
  for (Real t = 0; t < seconds; t += h) {
    REQUIRE(sim.step().status == Status::ok);
    most = std::max(most, measure(sim.world).energy() - before);
  }
  return most;
}

/// A row of balls, each on two cables of 1.118 m in a V; the first is pulled aside.
json cradle(int count, Real restitution) {
  json scene = {{"version", 1},
                {"collision", {{"friction", 0}, {"restitution", restitution}}},
                {"bodies", json::array()},
                {"cables", json::array()}};
  for (int i = 0; i < count; ++i) {
    const Real x = 0.2 * i, aside = i == 0 ? 0.6 : 0;
    const std::string name = "b" + std::to_string(i);
    json b = ball(name.c_str(), {x - std::sin(aside), 1 - std::cos(aside), 0}, 1);
    b["shape"]["radius"] = 0.1;
    scene["bodies"].push_back(b);
    for (const Real z : {-0.5, 0.5}) {
      json c = cable("world", name.c_str(), 1);
      c.erase("anchor_a"), c["point_a"] = {x, 1, z}, c["length"] = std::sqrt(1.25),
                           c.erase("slack");
      scene["cables"].push_back(c);
    }
  }
  return scene;
}

}  // namespace

TEST_CASE("slack cables between colliding bodies add no energy when they become taut") {
  const Real h = 1 / GENERATE(30.0, 60.0, 120.0, 240.0, 480.0);
  const std::vector<Real> masses =
      GENERATE(std::vector<Real>{1, 0.1, 4}, std::vector<Real>{1, 0.1, 0.1, 4},
               std::vector<Real>{4, 0.1, 1}, std::vector<Real>{0.5, 0.2, 0.1, 0.4, 4});
  const std::size_t on_cables = GENERATE(1, 2, 5);
  const Real slack = GENERATE(1.02, 1.2);
  Simulation sim = start(row(masses, on_cables, slack), h);
  Real moved = 0;  // J, of a fall by a metre
  for (const Real m : masses) moved += m * 9.81;
  INFO(h << " s, " << masses.size() << " bodies, " << on_cables << " on cables, slack " << slack);
  CHECK(rise(sim, 3, h) < 1e-3 * moved);
}

TEST_CASE(
    "balls on cables that hit without restitution go on together with a third of the energy") {
  const Real h = 1 / GENERATE(60.0, 240.0);
  Simulation sim = start(cradle(3, 0), h);
  const Real start_energy = 9.81 * (1 - std::cos(0.6));
  const auto swing = [&] { return measure(sim.world).energy(); };
  CHECK(rise(sim, 1, h) < 1e-3 * start_energy);
  CHECK(swing() == Approx(start_energy / 3).epsilon(3e-3));
  rise(sim, 30, h);
  CHECK(swing() == Approx(start_energy / 3).epsilon(3e-3));
}

TEST_CASE("a pendulum on a cable swings along a smooth wall as without it") {
  const Real h = 1 / GENERATE(60.0, 240.0);
  json scene = {{"version", 1},
                {"gravity", {0, -9.81, -2}},
                {"collision", {{"friction", 0}, {"restitution", 0}}}};
  scene["bodies"] = json::array({ball("b", {std::sin(1.0), -std::cos(1.0), -0.1}, 1)});
  scene["bodies"][0]["shape"]["radius"] = 0.1;
  scene["bodies"].push_back({{"name", "wall"},
                             {"motion", "fixed"},
                             {"position", {0, 0, -0.2}},
                             {"rotation_deg", {90, 0, 0}},
                             {"shape", {{"type", "plane"}}}});
  json c = cable("world", "b", 1);
  c.erase("anchor_a"), c["point_a"] = {0, 0, -0.1};
  scene["cables"] = json::array({c});
  Simulation sim = start(scene, h);
  const Real motion = 9.81 * (1 - std::cos(1.0));
  const Real before = measure(sim.world).energy();
  CHECK(rise(sim, 30, h) < 1e-4 * motion);
  CHECK(measure(sim.world).energy() > before - 3e-3 * motion);
}

TEST_CASE("an elastic rope between bodies in contact adds no energy, however stiff and loaded") {
  for (const Real ratio : {10.0, 100.0, 1000.0})
    for (const Real sag : {1e-4, 2e-3})
      for (const Real h : {1.0 / 60, 1.0 / 240}) {
        CAPTURE(ratio, sag, h);
        World w;
        Collision how;
        how.friction = 0.5;
        add_solid(w, box_shape({0.5, 0.05, 0.25}), {{0, 0.95, 0}, kIdentity}, Motion::fixed, how);
        const Entity box = add_solid(w, box_shape({0.075, 0.05, 0.05}), {{0.1, 1.05, 0}, kIdentity},
                                     Motion::dynamic, how);
        const Entity ball =
            add_solid(w, ball_shape(0.05), {{0.65, 1.05, 0}, kIdentity}, Motion::dynamic, how);
        for (const auto& [e, mass] : {std::pair(box, Real(1)), std::pair(ball, ratio)})
          w.bodies[e].inertia *= mass / w.bodies[e].mass, w.bodies[e].mass = mass;
        Cable rope;
        rope.a = box, rope.b = ball;
        rope.joint.anchor_a = {0.075, 0, 0}, rope.joint.anchor_b = {-0.05, 0, 0};
        rope.joint.length = 1.1 * 0.425, rope.joint.compliance = sag / (ratio * 9.81);
        add_cable(w, rope);
        Simulation sim = Simulation::copy_of(w, {h});
        const Real first = measure(sim.world).energy();
        for (int i = 0; i < std::lround(2 / h); ++i) {
          REQUIRE(sim.step().status == Status::ok);
          CHECK(measure(sim.world).energy() <= (1 + 1e-3) * first);
        }
      }
}
