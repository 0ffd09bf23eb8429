#pragma once
/// Methods that move the bodies of one part until its laws hold.
#include <functional>
#include <string_view>

#include "engine/assembly/problem.hpp"
#include "engine/assembly/random.hpp"

namespace pantin::detail::assembly {

/// The state of a descent before one iteration.
struct Iteration {
  const Part* part = nullptr;
  int number = 0;
  Real residual = 0;  // the largest, m or rad
  Real merit = 0;     // m^2
  Real damping = 0;   // of the last step
};

/// What a descent may take.
struct Effort {
  Real tolerance = 1e-12;  // of the largest residual, m or rad
  int iterations = 400;    // at most, for one start
  int threads = 1;         // of row-parallel methods; the result does not depend on it
};

enum class Ending : std::uint8_t {
  closed,      // the residual is within the tolerance
  stationary,  // a least-squares pose: no small displacement reduces the residual
  unfinished   // out of iterations
};

/// A descent of one part from its present poses.
struct Descent {
  World& world;
  Part& part;
  const Effort& effort;
  Random& random;  // of perturbations
  const std::function<void(const Iteration&)>& watch;
  bool settles = false;  // does not give up while the merit falls, however slowly
  int iterations = 0, perturbations = 0;

  /// Reports the present state. True: the residual is within the tolerance.
  bool note(Real damping);
  /// Rotates every body by 1e-3 rad about a random axis, and displaces it by as much of its arm.
  void perturb();
};

struct Method {
  std::string_view name, about;
  Ending (*descend)(Descent&);
  bool changes_design = false;  // whether it solves for design variables
};

/// Levenberg-Marquardt, and Gauss-Newton steps near the end. [Levenberg 1944; Marquardt 1963]
Ending descend_auto(Descent& d);
Ending descend_levenberg(Descent& d);
Ending descend_gauss_newton(Descent& d);

/// The methods, the first by default.
std::span<const Method> methods();

}  // namespace pantin::detail::assembly
