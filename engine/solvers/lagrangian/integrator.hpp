#pragma once
/// What the solver knows of an integrator: a row, defined in the integrator's own file. The list of
/// their names is in engine/world/integrators.hpp.
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {

struct IntegratorRow {
  /// One step from room.state to room.state; m.mean_lambda become the mean forces of constraint.
  /// False: it did not converge, or is too long.
  bool (*step)(const World&, Island&, const Span&);
  /// ... that tells the worst of what it errs by, so that steps keep a tolerance; or null.
  bool (*step_estimated)(const World&, Island&, const Span&, Real& error) = nullptr;
  /// How many rates of the state (room.rates) both need.
  int stages = 0, stages_estimated = 0;
  /// Needs no projection where its residual is within the tolerance.
  bool ends_on_joints = false;
  /// A step that opens joints far may have gone to another branch: it is given up.
  bool may_open_joints = false;
  /// Springs and dampers are forces to it: its steps must be shorter than what these do.
  bool efforts_are_forces = false;
  /// Steps in which bodies turn far are not halved.
  bool turns_far = false;
  /// Meets what other solvers hang on the island; Euler takes the place of one that does not.
  bool carries_interfaces = true;
  /// Goes on from accelerations, which are to be found anew after a jump or another's step.
  bool keeps_accelerations = false;
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
