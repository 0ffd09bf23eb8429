// Every shipped scene does what its title says: the runs, and the list of those that are shown.
#include "tests/scene/claims.hpp"

#include <filesystem>

#include "tests/paths.hpp"
#include "tests/scene/scenes.hpp"

namespace pantin::test {
namespace {

constexpr const char* kFolders[] = {"scenes", "laminas"};

std::string file_of(const std::string& name) {
  for (const std::string folder : kFolders)
    if (const std::string file = asset(folder + "/" + name + ".json");
        std::filesystem::exists(file))
      return file;
  return {};
}

/// Calls `see` with the file of each shipped scene.
void each_shipped(const std::function<void(const std::filesystem::path&)>& see) {
  for (const char* folder : kFolders)
    for (const auto& file : std::filesystem::directory_iterator(asset(folder)))
      if (file.is_regular_file()) see(file.path());
}

}  // namespace

Played play(const std::string& name, const Watch& watch, Real seconds) {
  Result<Scene> scene = load_scene(file_of(name));
  REQUIRE(bool(scene));
  Played p{std::move(*scene), {}};
  Simulation sim = Simulation::copy_of(p.scene.world, {p.scene.step, p.scene.substeps, 1, true});
  const Real until = seconds > 0 ? seconds : p.scene.duration;
  const auto steps = static_cast<int>(std::lround(until / p.scene.step));
  p.start_energy = measure(sim.world).energy();
  if (watch) watch(sim.world);
  for (int i = 0; i < steps; ++i) {
    const StepReport report = sim.step();
    REQUIRE(report.status == Status::ok);
    p.worst_gap = std::max(p.worst_gap, report.measures.worst_gap_rel);
    p.worst_violation = std::max(p.worst_violation, report.measures.worst_violation);
    p.worst_depth = std::max(p.worst_depth, report.worst_depth);
    p.worst_residual = std::max(p.worst_residual, report.worst_residual);
    p.most_energy = std::max(p.most_energy, report.measures.energy());
    p.least_energy = std::min(p.least_energy, report.measures.energy());
    p.last = report;
    if (watch) watch(sim.world);
  }
  CHECK(p.worst_gap <= p.scene.drift_bound);
  p.end = std::move(sim.world);
  return p;
}

void each_moving(const World& world, const std::function<void(const Body&)>& see) {
  for (const Body& b : world.bodies.values())
    if (b.motion == Motion::dynamic) see(b);
}

Real fastest(const World& world) {
  Real most = 0;
  each_moving(world, [&](const Body& b) { most = std::max(most, glm::length(b.velocity)); });
  return most;
}

}  // namespace pantin::test

using namespace pantin;
using namespace pantin::test;

TEST_CASE("Every shipped scene runs to the same bits twice, by any number of threads") {
  each_shipped([](const std::filesystem::path& file) {
    CAPTURE(file.stem().string());
    const Result<Scene> scene = load_scene(file.string());
    REQUIRE(bool(scene));
    std::set<std::uint64_t> hashes;
    for (const int threads : {1, 1, 3}) {
      Simulation sim = Simulation::copy_of(scene->world, {scene->step, scene->substeps, threads});
      for (int i = 0; i < 15; ++i) sim.step();
      hashes.insert(state_hash(sim.world));
    }
    CHECK(hashes.size() == 1);
  });
}

TEST_CASE("Every shipped scene has a claim that is shown by numbers") {
  std::set<std::string> shipped;
  each_shipped([&](const std::filesystem::path& file) { shipped.insert(file.stem().string()); });
  for (const std::string& name : shipped) {
    CAPTURE(name);
    CHECK(claimed().count(name) == 1);
  }
  for (const std::string& name : claimed()) {
    CAPTURE(name);
    CHECK(shipped.count(name) == 1);
  }
}
