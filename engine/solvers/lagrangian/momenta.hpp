#pragma once
/// Momenta of bodies and their changes: shared by the integrators that step in momenta.
#include <algorithm>

#include "engine/solvers/lagrangian/integrator.hpp"

namespace pantin::detail::lagrangian {

/// L = R I R^T w.
inline Vec3 angular_momentum(const BodyState& at, Vec3 inertia) {
  return at.rotation_matrix * (inertia * (at.angular_velocity * at.rotation_matrix));
}

/// Momenta of all bodies plus `h` times the forces.
inline void kick(Island& m, Real h) {
  for (std::size_t b = 0; b < m.count(); ++b) {
    const BodyState& at = m.scratch.body_states[b];
    m.scratch.momenta[2 * b] = m.mass[b] * at.velocity + h * m.scratch.force[2 * b];
    m.scratch.momenta[2 * b + 1] =
        angular_momentum(at, m.inertia[b]) + h * m.scratch.force[2 * b + 1];
  }
}

/// Adds J^T (scale lambda) of the given Jacobian to the momenta.
inline void push(Island& m, const std::vector<Vec3>& jacobian, std::span<const Real> lambda,
                 Real scale) {
  for (const Block& b : m.blocks) {
    PANTIN_ASSERT(b.rows <= 6 && b.first_row + b.rows <= lambda.size());
    Real block_lambda[6];
    for (std::size_t r = 0; r < b.rows; ++r) block_lambda[r] = scale * lambda[b.first_row + r];
    for (std::size_t k = 0; k < b.count; ++k)
      if (b.body[k] < m.count())
        add_constraint_force({b, &jacobian[b.first_vector], k}, block_lambda,
                             &m.scratch.momenta[2 * b.body[k]]);
  }
}

inline Real rate_or_default(const Island& m, Real standard) {
  return m.settings.baumgarte > 0 ? m.settings.baumgarte : standard;
}

/// J V of frames, into the right-hand side of rates.
inline void right_of_rates(Island& m) {
  std::fill(m.scratch.right.begin(), m.scratch.right.end(), 0.0);
  subtract_frame_twists(m, m.scratch.right);
}

}  // namespace pantin::detail::lagrangian
