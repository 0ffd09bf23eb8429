#pragma once
/// A scene: a World ready to run, and how it wants to be run and seen. Reads scene files,
/// version 1.
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/world/world.hpp"

namespace pantin {

namespace detail {
struct LaminaPlan;  // see lamina_plan.hpp
}

/// What a scene file says of pictures; the command line overrides it.
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
  Real duration = 5;         // s
  Real drift_bound = 1e-12;  // allowed joint gap, part of the island's size
  OutputDefaults output;
  std::vector<std::string> warnings;  // whole lines, the place included
  std::vector<std::string> files;     // read beside its own, each once: prefabs, surfaces
};

/// Counts beyond which a file is refused as absurd, before anything is made of it.
struct SceneLimits {
  std::size_t bytes = 64u << 20;
  std::size_t bodies = 1'000'000;
  std::size_t links = 1'000'000;
  std::size_t parts = 4'000'000;        // shapes and keyframes
  std::size_t values = 8'000'000;       // JSON values in the file
  std::size_t depth = 64;               // nesting of JSON values and of prefabs
  std::size_t copies = 1'000'000;       // of prefabs, by grids
  std::size_t name_bytes = 128u << 20;  // of all names together; those of copies grow with depth
  /// Asked now and then while a scene is read; true calls the reading off, with one complaint.
  std::function<bool()> is_cancelled{};
};

/// What takes the place of a scene's solver settings, in all its islands.
struct SolverChoices {
  std::optional<Solver> solver;
  // Of the Lagrangian solver:
  std::optional<Integrator> integrator;
  std::optional<Stabilisation> stabilisation;
  std::optional<Real> step_tolerance;
  void apply(SolverSettings& settings) const;
};

/// Reads a scene file. A bad file yields every complaint at once, each one line:
///   puppet.json:12:7: /joints/3/a: found "shim", expected the name of a body; nearest is "shin"
Result<Scene> load_scene(const std::string& path, const SceneLimits& limits = {},
                         const SolverChoices& choices = {});

/// The same from text; `name` stands for the file in complaints.
Result<Scene> parse_scene(std::string_view text, std::string_view name,
                          const SceneLimits& limits = {}, const SolverChoices& choices = {});

}  // namespace pantin
