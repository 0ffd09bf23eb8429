#pragma once
// A run in the window, written as a record and as a model with animated nodes.
#include <string>
#include <vector>

#include "engine/scene/scene.hpp"
#include "tools/pantin/gltf.hpp"
#include "tools/pantin/record.hpp"
#include "tools/pantin/view_pane.hpp"

namespace pantin::program {

using namespace detail;

/// Collects the run of a pane from now on, into PATH.csv and PATH.glb.
class RunExport final : public StepListener {
 public:
  /// `path` has no ending; steps after the time `until` (s, of the World) are left out.
  RunExport(std::string path, double until) : path_(std::move(path)), until_(until) {}

  /// Opens the record, whose first row is the present state, and listens to the pane.
  Result<Done> open(const Scene& scene, Pane& pane);
  void after_step(const World& world, const Measures& measures) override;
  /// Writes both files; `written` gets their paths.
  Result<Done> close(std::vector<std::string>& written);
  /// Whether nothing more is kept: the end is reached, or there is no more room.
  bool is_over() const { return is_over_; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  Record record_;
  GltfFilm film_;
  double until_;
  bool is_over_ = false;
};

}  // namespace pantin::program
