#pragma once
/// A scene: a World ready to run, with settings of the run and of pictures. Reads scene files,
/// version 1.
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/sensor.hpp"
#include "engine/world/world.hpp"

namespace pantin {

namespace detail {
struct LaminaPlan;  // see lamina_plan.hpp
}

/// Picture settings of a scene file; the command line overrides them.
struct OutputDefaults {
  int width = 1280, height = 720;  // pixels
  Real fps = 60;
};

struct Scene {
  std::string title;  // file's "title", or its stem
  World world;
  View view;
  std::shared_ptr<const std::vector<detail::LaminaPlan>> laminas;  // null: none
  Real step = 1.0 / 60;                                            // s
  int substeps = 1;
  Real budget_ms = 0;        // of StepSettings::budget, in ms; 0: none
  Real duration = 5;         // s
  Real drift_bound = 1e-12;  // allowed joint gap, as a fraction of the island's size
  OutputDefaults output;
  std::vector<Sensor> sensors;
  std::vector<std::string> warnings;  // whole lines, with the position
  std::vector<std::string> files;     // besides its own, each once: prefabs, surfaces
};

/// Counts beyond which a file is rejected before anything is built.
struct SceneLimits {
  std::size_t bytes = 64u << 20;
  std::size_t bodies = 1'000'000;
  std::size_t links = 1'000'000;
  std::size_t parts = 4'000'000;        // shapes and keyframes
  std::size_t values = 8'000'000;       // JSON values in the file
  std::size_t depth = 64;               // nesting of JSON values and of prefabs
  std::size_t copies = 1'000'000;       // of prefabs, by grids
  std::size_t name_bytes = 128u << 20;  // of all names together; copies have longer names at
                                        // greater depth
  /// Called from time to time while a scene is read; true cancels the reading with one error.
  std::function<bool()> is_cancelled{};
};

/// Overrides a scene's solver settings in all its islands.
struct SolverChoices {
  std::optional<Solver> solver;
  // Of the Lagrangian solver:
  std::optional<Integrator> integrator;
  std::optional<Stabilisation> stabilisation;
  std::optional<Jacobians> jacobians;
  std::optional<Real> step_tolerance;
  void apply(SolverSettings& settings) const;
};

/// Reads a scene file. A faulty file yields all errors at once, each one line:
///   puppet.json:12:7: /joints/3/a: found "shim", expected the name of a body; nearest is "shin"
Result<Scene> load_scene(const std::string& path, const SceneLimits& limits = {},
                         const SolverChoices& choices = {});

/// The same from text; `name` stands for the file in errors.
Result<Scene> parse_scene(std::string_view text, std::string_view name,
                          const SceneLimits& limits = {}, const SolverChoices& choices = {});

}  // namespace pantin
