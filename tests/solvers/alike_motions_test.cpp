// Motions that are alike stay so: neither which of two blows falls into the earlier step decides
// them, nor sweeps that are cut short.
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

#include "engine/scene/scene.hpp"
#include "tests/paths.hpp"
#include "tests/solvers/solids.hpp"

using namespace pantin;
using namespace pantin::test;

namespace {

/// m: the largest distance between a body and the mirror image of its pair on the other side of the
/// plane z = 0.
Real largest_difference(const World& w) {
  Real most = 0;
  for (const Entity left : w.bodies.owners()) {
    const std::string name(w.name_of(left));
    if (!name.ends_with("_l")) continue;
    const Entity right = w.find(name.substr(0, name.size() - 1) + "r");
    const Vec3 p = w.bodies[right].pose.position;
    most = std::max(most, glm::distance(w.bodies[left].pose.position, Vec3(p.x, p.y, -p.z)));
  }
  return most;
}

/// The puppet on the stairs, with another part in the place of one of its file.
struct Change {
  std::string was = "[1200, 0, 0]", now = was;
};
Scene changed_stairs(const Change& change, const SolverChoices& choices) {
  std::ifstream file(asset("scenes/stairs.json"));
  std::string text{std::istreambuf_iterator<char>(file), {}};
  REQUIRE(text.find(change.was) != std::string::npos);
  text.replace(text.find(change.was), change.was.size(), change.now);
  auto read = parse_scene(text, asset("scenes/stairs.json"), {}, choices);
  REQUIRE(read);
  return std::move(*read);
}

SolverChoices lagrangian_by(Integrator integrator) {
  SolverChoices choices;
  choices.solver = Solver::lagrangian, choices.integrator = integrator;
  return choices;
}

std::vector<Vec3> places_after(const Scene& scene, Real time, int rate) {
  Simulation sim = Simulation::copy_of(scene.world, {1.0 / rate});
  for (int i = 0; i < std::lround(time * rate); ++i) REQUIRE(sim.step().status == Status::ok);
  std::vector<Vec3> places;
  for (const Body& b : sim.world.bodies.values()) places.push_back(b.pose.position);
  return places;
}

/// m: the largest distance between the same body here and there.
Real furthest_of(const std::vector<Vec3>& places, const std::vector<Vec3>& to) {
  Real most = 0;
  for (std::size_t i = 0; i < to.size(); ++i)
    most = std::max(most, glm::distance(places[i], to[i]));
  return most;
}

}  // namespace

TEST_CASE("a puppet that is pushed straight ahead falls alike on both sides") {
  for (const int rate : {60, 240, 960, 3840}) {
    const auto read = load_scene(asset("scenes/stairs.json"));
    REQUIRE(read);
    Simulation sim = Simulation::copy_of(read->world, {1.0 / rate});
    for (int i = 0; 2 * i < rate; ++i) sim.step();
    INFO(rate << " Hz");
    CHECK(largest_difference(sim.world) < 1e-4);
  }
}

TEST_CASE("a puppet whose stops are hit while it stands goes where the Lagrangian solver has it") {
  for (const char* force : {"[1000, 0, 0]", "[1100, 0, 0]", "[1200, 0, 0]"}) {
    const Change push{"[1200, 0, 0]", force};
    const std::vector<Vec3> to =
        places_after(changed_stairs(push, lagrangian_by(Integrator::rk4)), 0.5, 3840);
    const auto furthest = [&](int rate) {
      return furthest_of(places_after(changed_stairs(push, {}), 0.5, rate), to);
    };
    INFO(force << " N");
    CHECK(furthest(240) < 10e-3);
    CHECK(furthest(960) < 2e-3);
    CHECK(furthest(3840) < 0.5e-3);
  }
}

TEST_CASE("integrators agree where limits are reached again and again before one is hit") {
  for (const Change& change :
       {Change{"\"rotation_deg\": [0, 90, 0]", "\"rotation_deg\": [0, 85, 0]"},
        Change{"[1200, 0, 0]", "[1200, 0, 40]"}}) {
    const std::vector<Vec3> to =
        places_after(changed_stairs(change, lagrangian_by(Integrator::radau)), 0.5, 3840);
    for (const Integrator integrator :
         {Integrator::rk4, Integrator::rattle, Integrator::implicit}) {
      INFO(change.now);
      const Scene scene = changed_stairs(change, lagrangian_by(integrator));
      CHECK(furthest_of(places_after(scene, 0.5, 960), to) < 4e-3);
      CHECK(furthest_of(places_after(scene, 0.5, 3840), to) < 1e-3);
    }
  }
}

TEST_CASE("crates on a bridge of planks go where they go if weight is a millionth more") {
  const auto read = load_scene(asset("scenes/rope_bridge.json"));
  REQUIRE(read);
  Scene heavier = *read;
  heavier.world.gravity *= 1 + 1e-6;
  const std::vector<Vec3> places = places_after(*read, 0.8, 3840);
  CHECK(furthest_of(places_after(heavier, 0.8, 3840), places) < 3e-5);  // 3e-6 as they fall
}
