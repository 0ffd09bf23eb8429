// Accelerations of a state.
#include <algorithm>

#include "engine/solvers/lagrangian/momenta.hpp"

namespace pantin::lagrangian {

void accelerate(const World& world, Island& m, Real part, Real whole) {
  StepScratch& room = m.room;
  const bool draws = m.settings.stabilisation == Stabilisation::baumgarte;
  place(m), place_frames(world, m, part, whole);
  write_all_rows(world, m, {draws, true});
  add_forces(world, m, true);
  factor(m, false);
  std::copy(room.gamma.begin(), room.gamma.end(), room.right.begin());
  take_known(m, room.right, true);
  if (draws) {
    const Real rate = rate_or_default(m, 5);
    for (const Block& b : m.blocks)
      for (std::size_t r = 0; r < b.rows; ++r)
        room.right[b.first_row + r] -=
            2 * rate * rate_of(m, b, r) + rate * rate * room.c[b.first_row + r];
  }
  solve(m, room.force, room.right, std::span(room.motion).first(2 * m.count()), room.lambda);
}

}  // namespace pantin::lagrangian
