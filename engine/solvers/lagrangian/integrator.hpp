#pragma once
/// What the solver knows of an integrator: a row, defined in the integrator's own file. The list of
/// their names is in engine/world/integrators.hpp.
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {

struct IntegratorRow {
  /// Advances scratch.state by one step; m.mean_lambda becomes the mean forces of constraint. False
  /// if it did not converge, or if the step is too long.
  bool (*step)(const World&, Island&, const Span&);
  /// The same with an estimate of the largest error, so that steps keep a tolerance; or null.
  bool (*step_estimated)(const World&, Island&, const Span&, Real& error) = nullptr;
  /// Number of rates of the state (scratch.rates) that each needs.
  int stages = 0, stages_estimated = 0;
  /// The estimate grows by this power of the step; a step that fails goes on with this part of it.
  int estimate_order = 5;
  Real after_failure = 0.1;
  /// Needs no projection where its residual is within the tolerance.
  bool ends_on_joints = false;
  /// A step that opens joints far may have reached another branch, and is given up.
  bool may_open_joints = false;
  /// Springs and dampers are explicit forces: steps must be shorter than their time constants.
  bool efforts_are_forces = false;
  /// Its projection is part of the motion: angular velocities turn along, and what it lifts is
  /// taken from the kinetic energy. Together with a step that adds no energy, none is ever gained.
  bool projection_moves = false;
  /// Its multipliers of what binds poses lag by a part of the step, which its projection of twists
  /// makes up for: where surfaces rub, both press them together.
  bool projection_presses = false;
  /// Of the energy of an island that only weight does work on, what a step may make or lose before
  /// it is halved; 0: nothing is asked.
  Real keeps_energy_to = 0;
  /// Symplectic: between blows it gives back what it makes, and ten times as much may come and go.
  bool returns_energy = false;
  /// Steps in which bodies rotate far are not halved.
  bool turns_far = false;
  /// Continues from accelerations, which are found anew after a jump or a step by another one.
  bool keeps_accelerations = false;
  /// Its multipliers are means of a step. Where singular configurations of loops leave these
  /// undetermined, Runge-Kutta takes the step.
  bool takes_means = false;
  /// Solves for three stages at once: scratch.collocation, and m.stage_accelerations from step to
  /// step.
  bool collocates = false;
};

namespace integrators {
#define PANTIN_DECLARE(word, ...) extern const IntegratorRow word;
PANTIN_INTEGRATORS(PANTIN_DECLARE)
#undef PANTIN_DECLARE
}  // namespace integrators

inline const IntegratorRow& row_of(Integrator integrator) {
#define PANTIN_ADDRESS(word, ...) &integrators::word,
  static constexpr const IntegratorRow* kRows[] = {PANTIN_INTEGRATORS(PANTIN_ADDRESS)};
#undef PANTIN_ADDRESS
  return *kRows[static_cast<int>(integrator)];
}

}  // namespace pantin::detail::lagrangian
