// What multipliers mean as forces after a step that changed its rule.
//
// The multipliers give the distribution of the reactions. Their sum follows from the momentum
// balance, so that momentum is conserved between both sides:
//   sum of forces on the island = (p_after - p_before) / h - weight + drag
#include <algorithm>

#include "engine/solvers/articulated/articulated.hpp"
#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/solver.hpp"

namespace pantin::detail::articulated {
namespace {

/// All forces on the island except at its anchors, N: weight, external forces, drag.
Vec3 other_forces(const World& world, const Island& a, Real h) {
  Vec3 sum(0);
  for (std::size_t c = 0; c < a.count(); ++c) {
    const Real mass = a.constants.at(kMass, c);
    sum += mass * a.constants.at(kGravityScale, c) * world.gravity;
    if (a.forced) sum += mass * a.scratch.forces.vec(0, c);
    sum -= a.constants.at(kDrag, c) * mass / h * a.memory.vec(kLastTranslation, c);
  }
  return sum;
}

/// The multipliers of the island's anchors, kg m. Cables to the world are left out: they are
/// negligible beside an impact.
Vec3 outer_lambdas(const World& world, const Island& a) {
  Vec3 sum(0);
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kHeld) sum += a.memory.vec(kLambda, t.first);
  for (const PackedPin& pin : a.pins)
    if (pin.partner == UINT32_MAX) sum += pin.lambda;
  for (const ContactRow& row : a.scratch.contact_rows) {
    const Contact& contact = contacts_of(world)[row.contact];
    if (contact.active) sum += row.side * contact.lambda;
  }
  return sum;
}

}  // namespace

void scale_to_momentum(World& world, Island& a, const EndSums& end, Real h) {
  const Vec3 after(end.momentum[0], end.momentum[1], end.momentum[2]);
  const Vec3 force = (after - a.momentum_before) / h - other_forces(world, a, h);
  const Vec3 lambda = outer_lambdas(world, a);
  const Real square = glm::dot(lambda, lambda);
  if (!(square > 0)) return;
  const Real share = glm::clamp(square / (h * h * glm::dot(force, lambda)), a.force_share, Real(1));
  if (!std::isfinite(share)) return;
  for (const ContactRow& row : a.scratch.contact_rows)
    if (row.side > 0) contacts_of(world)[row.contact].force *= a.force_share / share;
  a.force_share = share;
}

}  // namespace pantin::detail::articulated
