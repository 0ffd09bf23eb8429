#include <catch2/catch.hpp>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/runtime/simulation.hpp"
#include "engine/solvers/articulated/island.hpp"
#include "tests/runtime/puppets.hpp"

using namespace pantin;
using namespace pantin::detail;
using namespace pantin::test;

namespace {

void nudge(Real& number) { number = std::nextafter(number, 10.0); }

using Change = std::pair<std::string, std::function<void(Puppet&)>>;

std::vector<Change> body_changes() {
  std::vector<Change> all;
  for (int i = 0; i < 3; ++i) {
    const std::string axis(1, "xyz"[i]);
    const auto on_left = [&](const char* name, auto member) {
      all.emplace_back(name + axis, [=](Puppet& p) { nudge(member(p.world.bodies[p.left])[i]); });
    };
    on_left("position ", [](Body& b) -> Vec3& { return b.pose.position; });
    on_left("velocity ", [](Body& b) -> Vec3& { return b.velocity; });
    on_left("spin ", [](Body& b) -> Vec3& { return b.angular_velocity; });
    on_left("inertia ", [](Body& b) -> Vec3& { return b.inertia; });
  }
  for (int i = 0; i < 4; ++i)
    all.emplace_back("rotation " + std::to_string(i),
                     [=](Puppet& p) { nudge(p.world.bodies[p.left].pose.rotation[i]); });
  const auto add = [&](const char* name, auto change) {
    all.emplace_back(name, [=](Puppet& p) { change(p.world.bodies[p.left]); });
  };
  add("mass", [](Body& b) { nudge(b.mass); });
  add("drag", [](Body& b) { nudge(b.drag); });
  add("gravity scale", [](Body& b) { nudge(b.gravity_scale); });
  add("motion", [](Body& b) { b.motion = Motion::fixed; });
  add("restart", [](Body& b) { b.restart = !b.restart; });
  return all;
}

std::vector<Change> joint_changes() {
  return {
      {"link anchor a", [](Puppet& p) { nudge(p.world.links[p.link].joint.anchor_a.y); }},
      {"link anchor b", [](Puppet& p) { nudge(p.world.links[p.link].joint.anchor_b.z); }},
      {"link body", [](Puppet& p) { p.world.links[p.link].b = p.right; }},
      {"string anchor", [](Puppet& p) { nudge(p.world.cables[p.string].joint.anchor_a.x); }},
      {"string length", [](Puppet& p) { nudge(p.world.cables[p.string].joint.length); }},
      {"string compliance", [](Puppet& p) { nudge(p.world.cables[p.string].joint.compliance); }},
      {"pin anchor", [](Puppet& p) { nudge(p.world.pins[p.pin].anchor.x); }},
      {"pin target", [](Puppet& p) { nudge(p.world.pins[p.pin].target.y); }},
      {"pin priority", [](Puppet& p) { ++p.world.pins[p.pin].priority; }},
      {"pin stiffness", [](Puppet& p) { nudge(p.world.pins[p.pin].stiffness); }},
      {"pin grip", [](Puppet& p) { p.world.pins[p.pin].kind = PinKind::spring; }},
  };
}

std::vector<Change> world_changes() {
  const auto sway = [](Puppet& p) -> Lissajous& {
    return std::get<Lissajous>(p.world.paths[p.bar].curve);
  };
  return {
      {"gravity", [](Puppet& p) { nudge(p.world.gravity.y); }},
      {"time", [](Puppet& p) { nudge(p.world.time); }},
      {"tick", [](Puppet& p) { ++p.world.tick; }},
      {"force",
       [](Puppet& p) {
         p.world.forces.add(p.left, {{0, 1, 0}, Vec3(0)});
       }},
      {"force on another",
       [](Puppet& p) {
         p.world.forces.add(p.right, {{0, 1, 0}, Vec3(0)});
       }},
      {"torque",
       [](Puppet& p) {
         p.world.forces.add(p.left, {Vec3(0), {0, 1, 0}});
       }},
      {"drive amplitude", [=](Puppet& p) { nudge(sway(p).amplitude.x); }},
      {"drive phase", [=](Puppet& p) { nudge(sway(p).turn_phase.z); }},
      {"drive kind",
       [](Puppet& p) {
         p.world.paths.add(p.bar, {Keyframes{{{0, {}}}}});
       }},
      {"drive key",
       [](Puppet& p) {
         p.world.paths.add(p.bar, {Keyframes{{{1, {}}}}});
       }},
      {"default solver", [](Puppet& p) { p.world.default_settings.solver = Solver::sweep; }},
      {"default rounds", [](Puppet& p) { ++p.world.default_settings.sweeps; }},
      {"default tolerance", [](Puppet& p) { nudge(p.world.default_settings.tolerance); }},
      {"own settings", [](Puppet& p) { p.world.settings.add(p.left, {}); }},
      {"own limiter", [](Puppet& p) { p.world.settings.add(p.left, {}).limiter = false; }},
      {"new body", [](Puppet& p) { p.world.add_body({}); }},
  };
}

}  // namespace

TEST_CASE("the state hash changes with every number that decides the next step") {
  Simulation simulation(swaying_puppet().world);
  for (int i = 0; i < 5; ++i) simulation.step();
  Puppet start = swaying_puppet();
  start.world = simulation.world;

  std::set<std::uint64_t> seen{state_hash(start.world)};
  for (const auto& changes : {body_changes(), joint_changes(), world_changes()}) {
    for (const auto& [name, change] : changes) {
      Puppet changed = start;
      change(changed);
      INFO(name);
      CHECK(seen.insert(state_hash(changed.world)).second);
    }
  }
}

TEST_CASE("the state hash changes with every number the integrators remember") {
  Simulation simulation(hung_chain(3).world);
  for (int i = 0; i < 5; ++i) simulation.step();
  const World& world = simulation.world;
  REQUIRE(articulated::islands_of(world).size() == 1);
  std::set<std::uint64_t> seen{state_hash(world)};
  const std::size_t count = articulated::islands_of(world)[0].memory.numbers().size();
  REQUIRE(count > 0);
  for (std::size_t i = 0; i < count; ++i) {
    World changed = world;
    nudge(articulated::islands_of(changed)[0].memory.data()[i]);
    CHECK(seen.insert(state_hash(changed)).second);
  }
}

TEST_CASE("the state hash does not depend on names, looks or what was measured") {
  Puppet p = swaying_puppet();
  const std::uint64_t before = state_hash(p.world);
  p.world.names.add(p.left, "port");
  p.world.materials.push_back({});
  p.world.shapes.add(p.left, {});
  p.world.pins[p.pin].residual = 1;
  p.world.cables[p.string].tension = 3;
  CHECK(state_hash(p.world) == before);
}

TEST_CASE("equal Worlds have equal hashes, whatever way they came to be") {
  CHECK(state_hash(swaying_puppet().world) == state_hash(swaying_puppet().world));
  World a, b;
  a.add_body({});
  const Entity extra = b.create();
  b.destroy(extra);
  b.add_body({});
  CHECK(state_hash(a) == state_hash(b));
}
