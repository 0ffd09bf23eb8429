#pragma once
/// Interface of an integrator: a row, defined in the integrator's own file. The list of their names
/// is in engine/world/integrators.hpp.
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
  /// Power of the step in the error estimate; a step that fails is retried with this fraction.
  int estimate_order = 5;
  Real after_failure = 0.1;
  /// Needs no projection where its residual is within the tolerance.
  bool ends_on_joints = false;
  /// A step that opens joints far may have reached another branch, and is rejected.
  bool may_open_joints = false;
  /// Springs and dampers are explicit forces: steps must be shorter than their time constants.
  bool efforts_are_forces = false;
  /// Its projection is part of the motion: it rotates angular velocities, and the potential energy
  /// that it adds is taken from the kinetic energy. If the step adds no energy either, none is ever
  /// gained.
  bool projection_moves = false;
  /// Its multipliers of pose rows lag by a fraction of the step, which its projection of twists
  /// corrects. Normal forces of friction include both.
  bool projection_presses = false;
  /// Relative energy that a step may gain or lose before it is halved, in islands where only weight
  /// does work; 0: unchecked.
  Real keeps_energy_to = 0;
  /// Symplectic: energy errors oscillate between impacts, so they may be ten times as large.
  bool returns_energy = false;
  /// Steps in which bodies rotate far are not halved.
  bool turns_far = false;
  /// Continues from accelerations, which are recomputed after a jump or a step of another
  /// integrator.
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
