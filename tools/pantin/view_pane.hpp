#pragma once
// A running copy of the scene in the viewer, and its display; two of them may be side by side.
#include <optional>
#include <string>
#include <vector>

#include "engine/render/trails.hpp"
#include "engine/runtime/simulation.hpp"
#include "tools/pantin/view_focus.hpp"
#include "tools/pantin/view_hand.hpp"
#include "tools/pantin/view_trace.hpp"

namespace pantin::program {

using namespace detail;

/// Sees a run step by step.
struct StepListener {
  virtual ~StepListener() = default;
  virtual void after_step(const World& world, const Measures& measures) = 0;
};

class Pane {
 public:
  Pane() = default;
  Pane(const Pane&) = delete;  // systems of the simulation refer to this object
  Pane& operator=(const Pane&) = delete;

  /// Starts with a World; nothing is held.
  void start(const World& from, const StepSettings& how);
  /// Takes as many whole steps as fit into the time, at most `most`.
  Advance advance(double seconds, int most);
  /// Takes one step; the picture shows its end.
  StepReport single_step();

  /// Bodies were added or removed: draws the poses at the end of the last step.
  void place();

  /// Begins pose mode; returns the reason if the World has none.
  std::optional<std::string> start_posing();
  /// Ends it: dynamics go on from the pose at rest, or, if nothing was moved, as before.
  void stop_posing();
  /// In pose mode, once a picture.
  void pose();
  /// Why a solver cannot move this scene, or nothing.
  std::optional<std::string> why_not(Solver solver) const;
  /// Sets the solver of all islands; returns the reason if that is impossible.
  std::optional<std::string> choose(Solver solver);
  /// If the run cannot continue after this step, what happened.
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
  Focus focus;
  StepListener* listener = nullptr;  // until the run starts anew
  ContactTrails trails;
  std::string alarm;     // why the run stopped, until a restart
  double gap = 0;        // m, after the last step
  double fraction = 0;   // of the next step
  double step_cost = 0;  // s, wall time
  bool is_behind = false;

  // Over the whole session, across restarts:
  double worst_gap = 0, worst_gap_rel = 0, simulated = 0;  // m, fraction of the size, s
  std::uint64_t steps = 0;

 private:
  void begin(const World& from, const StepSettings& how);
  void draw_poses();
  void after_step(const World& world, Real h);
};

}  // namespace pantin::program
