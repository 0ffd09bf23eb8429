#pragma once
/// Momenta of bodies and what changes them: shared by the integrators that step in momenta.
#include <algorithm>

#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::lagrangian {

/// L = R I R^T w.
inline Vec3 spin_momentum(const Placed& at, Vec3 inertia) {
  return at.turn * (inertia * (at.spin * at.turn));
}

/// Momenta of all bodies as placed, plus `h` times the forces.
inline void kick(Island& m, Real h) {
  for (std::size_t b = 0; b < m.count(); ++b) {
    const Placed& at = m.room.placed[b];
    m.room.momenta[2 * b] = m.mass[b] * at.velocity + h * m.room.force[2 * b];
    m.room.momenta[2 * b + 1] =
        spin_momentum(at, m.inertia[b]) + h * m.room.force[2 * b + 1];
  }
}

/// Adds J^T (scale lambda) of the given Jacobian to the momenta.
inline void push(Island& m, const std::vector<Vec3>& jacobian, std::span<const Real> lambda,
          Real scale) {
  for (const Block& b : m.blocks) {
    Real load[6];
    for (std::size_t r = 0; r < b.rows; ++r) load[r] = scale * lambda[b.first_row + r];
    for (std::size_t k = 0; k < b.count; ++k)
      if (b.body[k] < m.count())
        add_pull(b, &jacobian[b.first_vector], k, load, &m.room.momenta[2 * b.body[k]]);
  }
}

inline Real rate_or_default(const Island& m, Real standard) {
  return m.settings.baumgarte > 0 ? m.settings.baumgarte : standard;
}

/// J V of what is known, to the right-hand side of rates.
inline void right_of_rates(Island& m) {
  std::fill(m.room.right.begin(), m.room.right.end(), 0.0);
  take_known(m, m.room.right, false);
}

}  // namespace pantin::lagrangian
