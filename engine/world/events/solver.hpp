#pragma once
/// Changes the solver.
#include "engine/world/events/event.hpp"

namespace pantin {

/// Sets the solver of all islands; its settings stay.
struct SolverEvent {
  Solver solver = Solver::articulated;
  Real at = 0;  // s

  static constexpr std::string_view name = "solver";
  static constexpr std::string_view about = "Changes the solver.";

  static void fields(auto& self, auto&& field) {
    field("solver", self.solver);
    field("at", self.at);
  }
  static void scene_keys(auto& self, auto&& key) {
    key({"solver", "", "The solver of all bodies from then on; settings are kept.",
         detail::EventForm::solver, "a solver"},
        self.solver);
    key(detail::event_keys::kAt, self.at);
  }

  void begin(const detail::EventStep& step, detail::EventProgress&) const {
    World& world = step.world;
    world.default_settings.solver = solver;
    for (SolverSettings& s : world.settings.values()) s.solver = solver;
    world.mark_dirty();
  }
};

}  // namespace pantin
