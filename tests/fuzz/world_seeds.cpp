// Saved Worlds to start world_fuzz from: world_seeds FOLDER SCENE...
#include <cstdio>
#include <filesystem>

#include "engine/runtime/save.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/scene/scene.hpp"

int main(int count, char** arguments) {
  using namespace pantin;
  for (int i = 2; i < count; ++i) {
    const std::filesystem::path file = arguments[i];
    Result<Scene> scene = load_scene(file.string());
    if (!scene || scene->world.bodies.size() > 20) continue;
    Simulation simulation(std::move(scene->world), {scene->step, scene->substeps});
    for (int step = 0; step < 10; ++step) simulation.step();
    const auto to = std::filesystem::path(arguments[1]) / file.stem().concat(".world");
    if (const auto saved = save_world(simulation.world, to.string()); !saved)
      return std::fprintf(stderr, "%s\n", saved.errors().front().message.c_str()), 1;
  }
}
