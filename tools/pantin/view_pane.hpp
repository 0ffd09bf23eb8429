#pragma once
// One running copy of the scene in the viewer, and what is seen of it; two of them stand side by
// side.
#include <optional>
#include <string>
#include <vector>

#include "engine/render/trails.hpp"
#include "engine/runtime/simulation.hpp"
#include "tools/pantin/view_hand.hpp"
#include "tools/pantin/view_trace.hpp"

namespace pantin::program {

using namespace detail;

class Pane {
 public:
  Pane() = default;
  Pane(const Pane&) = delete;  // systems of the simulation point here
  Pane& operator=(const Pane&) = delete;

  /// Begins with a World as it is; nothing is held.
  void start(const World& from, const StepSettings& how);
  /// As many whole steps as fit into the time, at most `most`.
  Advance advance(double seconds, int most);
  /// One step; the picture is that of its end.
  StepReport single_step();

  /// Bodies came or went: what is drawn are the poses at the end of the last step.
  void place();
  /// Why a solver cannot move what this one does, if so.
  std::optional<std::string> why_not(Solver solver) const;
  /// Takes a solver for all islands; else says why that cannot be.
  std::optional<std::string> choose(Solver solver);
  /// Of a step that must not be gone on from, what happened.
  std::optional<std::string> trouble(const StepReport& step) const;
  std::string solver() const;
  World& world() { return sim.world; }
  const World& world() const { return sim.world; }
  PosedWorld scene() const { return {sim.world, poses}; }

  Simulation sim;
  Hand hand;
  std::vector<Pose> poses;  // as drawn, by slot
  std::optional<Solver> chosen;
  Trace trace;
  ContactTrails trails;
  std::string alarm;     // why the last step stopped the run, until it starts over
  double gap = 0;        // m, after the last step
  double fraction = 0;   // of the next step
  double step_cost = 0;  // s, wall time
  bool is_behind = false;

  // Over the whole session, whatever starts over:
  double worst_gap = 0, worst_gap_rel = 0, simulated = 0;  // m, part of the size, s
  std::uint64_t steps = 0;

 private:
  void after_step(const World& world, Real h);
};

}  // namespace pantin::program
