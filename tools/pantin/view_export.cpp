#include "tools/pantin/view_export.hpp"

#ifdef PANTIN_HAS_VIEW
#include "engine/solvers/solver.hpp"

namespace pantin::program {

using namespace detail;

Result<Done> RunExport::open(const Scene& scene, Pane& pane) {
  World built = pane.world();
  compile_if_changed(built);  // the first row needs all columns
  RecordChoices choices;
  choices.columns = {"*"}, choices.step = pane.sim.settings.h, choices.sensors = scene.sensors;
  if (auto fits = record_.check(built, choices); !fits) return fits;
  if (auto opened = record_.open(path_ + ".csv"); !opened) return opened;
  film_.start(built, scene.title);
  pane.listener = this;
  return record_.add(built, measure(built));
}

void RunExport::after_step(const World& world, const Measures& measures) {
  is_over_ = is_over_ || world.time > until_;
  if (!is_over_) is_over_ = !record_.add(world, measures) || !film_.add(world);
}

Result<Done> RunExport::close(std::vector<std::string>& written) {
  if (auto done = record_.close(); !done) return done;
  written.push_back(path_ + ".csv");
  if (auto done = film_.write(path_ + ".glb"); !done) return done;
  written.push_back(path_ + ".glb");
  return Done{};
}

}  // namespace pantin::program
#endif
