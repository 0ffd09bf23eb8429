// Accelerations of a state.
#include <algorithm>

#include "engine/solvers/lagrangian/momenta.hpp"

namespace pantin::detail::lagrangian {

void accelerate(const World& world, Island& m, Real part, Real whole) {
  StepScratch& scratch = m.scratch;
  const bool draws = m.settings.stabilisation == Stabilisation::baumgarte;
  update_kinematics(m), update_frames(world, m, part, whole);
  scratch.leaves_gaps = true;
  write_all_rows(world, m, {draws, true});
  scratch.leaves_gaps = false;
  add_forces(world, m, Torques::with_gyroscopic);
  factor(m);
  std::copy(scratch.gamma.begin(), scratch.gamma.end(), scratch.right.begin());
  subtract_frame_accelerations(m, scratch.right);
  if (draws) {
    const Real rate = rate_or_default(m, 5);
    for (const Block& b : m.blocks)
      for (std::size_t r = 0; r < b.rows; ++r)
        scratch.right[b.first_row + r] -=
            2 * rate * rate_of(m, b, r) + rate * rate * scratch.c[b.first_row + r];
  }
  const Unknowns found{std::span(scratch.motion).first(2 * m.count()), scratch.lambda};
  solve(m, {scratch.force, scratch.right}, found);
  settle_grips(m, 1, scratch.force, [&] { solve(m, {scratch.force, scratch.right}, found); });
}

}  // namespace pantin::detail::lagrangian
