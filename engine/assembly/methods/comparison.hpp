#pragma once
/// Methods for comparison with the one that is used. [Nelson & Cohen, sections 7 and 9]
#include "engine/assembly/descent.hpp"

namespace pantin::detail::assembly {

/// -k C_q^T C in quaternion coordinates, k = 0.1. [Nelson & Cohen, Eqn 15]
Ending descend_gradient(Descent& d);
/// The same with k from Gershgorin's bound of the largest eigenvalue of C_q C_q^T.
Ending descend_gradient_safely(Descent& d);
/// The gradient with momentum, k = 0.1 and 0.85 of the last step. [Polyak 1964]
Ending descend_momentum(Descent& d);
/// One law after the other, each closed by the least step of its bodies.
Ending descend_gauss_seidel(Descent& d);
/// The gradient in Euler angles (z, then y, then x), k = 0.1: what the paper argues against.
Ending descend_euler_angles(Descent& d);

/// C_q^T C of every body: force and torque, world axes, into scratch.force. Each row is summed by
/// itself in the order of its laws, so that the bits do not depend on the number of threads.
/// [Nelson & Cohen, section 7.1]
void find_gradient(Descent& d);
/// Evaluates the rows at the current poses, the laws in parallel.
void look_in_parallel(Descent& d);

/// Iterates `step` until the residual is within the tolerance. Stops where it is not finite.
template <class Step>
Ending iterate(Descent& d, const Step& step) {
  for (;; ++d.iterations) {
    if (d.note(0)) return Ending::closed;
    if (d.iterations >= d.effort.iterations || !(merit_of(d.part) < 1e100))
      return Ending::unfinished;
    step();
  }
}

}  // namespace pantin::detail::assembly
