// Blows of inextensible cables: the velocities of least kinetic energy that joints and cables allow
// (Gauss's principle of least constraint), and what a cable loses and keeps after it.
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"
#include "tests/paths.hpp"

using namespace pantin;
using nlohmann::json;

namespace {

Vec3 vector(const json& from) { return {from[0], from[1], from[2]}; }

/// Velocities of the bodies of a scene after one step of length h: two vectors a body of `after`.
std::vector<Vec3> velocities_after(json scene, const json& after, Real h, const char* solver) {
  scene["step"] = scene["duration"] = h, scene["solver"]["type"] = solver;
  const auto read = parse_scene(scene.dump(), "cable_blows");
  REQUIRE(read);
  Simulation sim = Simulation::copy_of(read->world, {h});
  REQUIRE(sim.step().status == Status::ok);
  std::vector<Vec3> velocities;
  for (const auto& [name, of] : after.items()) {
    const Body& b = sim.world.bodies[sim.world.find(name)];
    velocities.insert(velocities.end(), {b.velocity, b.angular_velocity});
  }
  return velocities;
}

/// A level rod on a ball joint; an arm on a ball ends in a cable that is taut at first. The rod
/// falls.
constexpr const char* kRodAndBall = R"({"version": 1, "bodies": [
  {"name": "rod", "position": [0.5, 0, 0], "rotation_deg": [0, 0, 90], "mass": 1,
   "shape": {"type": "capsule", "radius": 0.02, "length": 0.9}},
  {"name": "ball", "position": [1.5, 0, 0], "mass": 1, "shape": {"type": "sphere", "radius": 0.1}}],
  "joints": [{"a": "world", "b": "rod", "anchor": [0, 0, 0]}],
  "cables": [{"a": "rod", "b": "ball", "anchor_a": [1, 0, 0], "anchor_b": [1.5, 0, 0]}]})";

}  // namespace

TEST_CASE("handles that pull at taut cables move rods with the least kinetic energy") {
  const json cases = json::parse(std::ifstream(test_data("cable_blows.json")))["cases"];
  REQUIRE(cases.size() == 6);
  const char* solver = GENERATE("auto", "lagrangian");
  const Real h = GENERATE(1e-5, 1e-4, 1e-3, 1.0 / 240);
  for (const json& c : cases) {
    const std::vector<Vec3> whole = velocities_after(c["scene"], c["after"], h, solver),
                            half = velocities_after(c["scene"], c["after"], h / 2, solver);
    std::size_t i = 0;
    Real fastest = 0, off = 0, at_blow = 0;
    for (const auto& [name, of] : c["after"].items())
      for (const char* kind : {"velocity", "angular_velocity"}) {
        const Vec3 exact = vector(of[kind]);
        fastest = std::max(fastest, glm::length(exact));
        off = std::max(off, glm::length(whole[i] - exact));
        at_blow = std::max(at_blow, glm::length(2.0 * half[i] - whole[i] - exact));
        ++i;
      }
    INFO(solver << ", step " << h << " s");
    // The bodies go on for the step: velocities differ by h times their accelerations.
    CHECK(off < 60 * h * fastest);
    CHECK(at_blow < std::max(1e-6, 1000 * h * h) * fastest);
  }
}

TEST_CASE("a cable that pulls a ball tight takes what the blow takes, whatever the step") {
  // lagrangian by radau at 2e-4 s, tolerance 1e-10, agrees with its run at 1e-8: -1.0104 J.
  const Real rate = GENERATE(60, 120, 240, 960);
  const auto read = parse_scene(kRodAndBall, "rod_and_ball");
  REQUIRE(read);
  Simulation sim = Simulation::copy_of(read->world, {1 / rate});
  const Real before = measure(sim.world).energy();
  Real most = before;
  for (int i = 0; i < rate; ++i) {
    REQUIRE(sim.step().status == Status::ok);
    most = std::max(most, measure(sim.world).energy());
  }
  INFO(rate << " Hz");
  CHECK(measure(sim.world).energy() - before == Approx(-1.0104).margin(0.05));
  CHECK(most < before + 1e-9);
}
