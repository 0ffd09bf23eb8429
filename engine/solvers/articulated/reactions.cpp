// Reactions of islands on bodies of other solvers, at interfaces and by contact.
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

/// Whether a pin or a cable ties the island to one of another solver.
bool ties_solvers(const World& world, contact::TieKind kind, std::uint32_t source) {
  const auto foreign = [&](Entity body) {
    const Owner owner = owner_of(partition_of(world), world.bodies.slot(body));
    return owner && owner.solver != kArticulated;
  };
  if (kind == contact::TieKind::pin) {
    const Pin& pin = world.pins.values()[source];
    return foreign(pin.body) || (pin.to && foreign(pin.to));
  }
  const Cable& cable = world.cables.values()[source];
  return foreign(cable.a) || foreign(cable.b);
}

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

/// Largest number of interfaces of one island.
constexpr std::size_t kMost = 16;

struct Reactions {
  Vec3 sum{0};     // N on the island, all anchors
  Real sizes = 0;  // of the reported ones
  contact::Reaction known[kMost];
  std::size_t count = 0;
  bool others = false;  // anchors that no other solver moves
};

/// The remainder of the momentum balance is distributed in proportion to the multipliers.
void share_rest(const World& world, const Island& a, Real h, Reactions& r) {
  Vec3 momentum(0);
  for (std::size_t c = 0; c < a.count(); ++c)
    momentum += a.constants.at(kMass, c) * world.bodies.values()[a.slots[c]].velocity;
  const Vec3 rest = (momentum - a.momentum_before) / h - other_forces(world, a, h) - r.sum;
  for (std::size_t i = 0; i < r.count; ++i) {
    const Real part = r.sizes > 0 ? glm::length(r.known[i].force) / r.sizes
                                  : Real(1) / static_cast<Real>(r.count);
    r.known[i].force -= part * rest;
  }
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

void react(World& world, std::size_t island, Real h, std::vector<contact::Reaction>& out) {
  const Island& a = islands_of(world)[island];
  const Real to_force = 1 / (a.force_share * h * h);
  Reactions r;
  const auto constraint = [&](contact::TieKind kind, std::uint32_t source, Vec3 force) {
    r.sum += force;
    if (source == UINT32_MAX || r.count == kMost || !ties_solvers(world, kind, source)) {
      r.others = r.others || force != Vec3(0);
      return;
    }
    r.known[r.count++] = {kind, source, -force, a.mass}, r.sizes += glm::length(force);
  };
  for (const Tree& t : a.trees)
    if (a.parents[t.first] == kHeld)
      constraint(contact::TieKind::pin, t.held_pin, to_force * a.memory.vec(kLambda, t.first));
  for (const PackedPin& g : a.pins)
    if (g.partner == UINT32_MAX) constraint(contact::TieKind::pin, g.held_pin, to_force * g.lambda);
  for (const PackedCable& cord : a.cables) {
    if (cord.column_a != UINT32_MAX && cord.column_b != UINT32_MAX) continue;
    const Cable& s = world.cables.values()[cord.cable];
    const Vec3 to_b = to_world(world.bodies[s.b].pose, s.joint.anchor_b) -
                      to_world(world.bodies[s.a].pose, s.joint.anchor_a);
    const Real span = glm::length(to_b);
    const Vec3 on_a = span > 0 ? to_force * cord.lambda / span * to_b : Vec3(0);
    constraint(contact::TieKind::cable, cord.cable, cord.column_a != UINT32_MAX ? on_a : -on_a);
  }
  for (const ContactRow& t : a.scratch.contact_rows)
    r.others = r.others || (t.side > 0 && contacts_of(world)[t.contact].active);
  if (r.count > 0 && !r.others) share_rest(world, a, h, r);
  out.insert(out.end(), r.known, r.known + r.count);
}

void press(const World& world, std::vector<contact::Pressure>& out) {
  for (const Island& a : islands_of(world))
    for (const ContactRow& t : a.scratch.contact_rows) {
      const Contact& c = contacts_of(world)[t.contact];
      if (t.side < 0 || !c.active || !owner_of(partition_of(world), c.slot_b)) continue;
      if (is_own(world, c.slot_b)) continue;
      const Vec3 arm = world.bodies.values()[c.slot_b].pose.rotation * c.point_b;
      out.push_back(
          {world.bodies.owners()[c.slot_b], -c.force, -glm::cross(arm, c.force) - c.torque});
    }
}

}  // namespace pantin::detail::articulated
