// A substep of few bodies without joints: contacts without springs, iterated to convergence.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/impulses/extrapolation.hpp"
#include "engine/solvers/articulated/impulses/group_sweeps.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Spin from the angular momentum, with the inertia of the body rotated on by a time h: a substep
/// uses the inertia at its middle.
void turn_inertia(GroupBody& b, Real h) {
  b.response = inverse_inertia(b, from_rotation_vector(h * b.spin) * b.pose.rotation);
  b.spin = b.response * b.angular_momentum;
}

/// Contacts without springs add at most the energy of what they push apart. Where sweeps over few
/// bodies did not converge, as between masses of 1 and 1,000, and added more, they begin again from
/// zero, with responses that are symmetric: then each of them removes energy. So may extrapolated
/// sweeps between walls that close, where impulses have no limit.
void keep_energy_of_few(const Group& g, const Substep& s, Sweep sweep, Real before) {
  Real allowed = (1 + kSlightGain) * before + work_of_surfaces(g, before);
  for (const GroupBody& b : g.bodies)
    if (sweep == Sweep::solves && b.per_mass > 0) allowed += kPushSpeed * kPushSpeed / b.per_mass;
  if (kinetic_energy(g) <= allowed) return;
  forget_impulses(g);
  for (GroupContact& c : g.contacts) c.lead_a = c.arm_a, c.lead_b = c.arm_b;
  for (GroupPair& p : g.pairs) prepare_pair(g, p);
  for (int n = 0; n < std::min(s.most_sweeps, kHardSweeps); ++n)
    if (sweep_group(g, s, sweep, turned(Order::forwards, n)) <= s.enough) break;
}

}  // namespace

// Few bodies without joints: velocity Verlet, second order. Half of the forces and impulses act
// before the bodies move, so that gaps are right after it. The other half acts after it, so that
// contacts do not separate or approach. [Andersen 1983, RATTLE]
void take_hard_substep(const Group& g, const Substep& s, Order order) {
  for (GroupBody& b : g.bodies)
    if (b.per_mass > 0) turn_inertia(b, 0.5 * s.h);
  prepare_group(g, s);
  collide_elastically(g, s);
  bool jammed = false;
  const auto act = [&](Sweep sweep) {
    for (GroupBody& b : g.bodies)
      if (b.per_mass > 0) slow_down(b, s.h), accelerate(b, 0.5 * s.h);
    if (!s.alone) remember_free(g);
    const Real energy = s.alone ? 0 : kinetic_energy(g);
    for (GroupContact& c : g.contacts)
      if (c.impulse != Vec3(0)) push(g, c);
    for (GroupRolling& r : g.rollings) push(g, r);
    if (sweep == Sweep::relaxes) scale_impulses(g, 2);  // add those before the move
    Ending ending(g, s);
    Extrapolation extrapolation(g, s, sweep);
    const int looks_at = s.alone ? s.most_sweeps : std::min(s.most_sweeps, kHardSweeps);
    bool ends = false;
    for (int n = 0; n < s.most_sweeps && !ends; ++n) {
      const Real most = sweep_group(g, s, sweep, turned(order, n));
      const bool jams = n + 1 == looks_at && is_jammed(g, s, most);
      jammed = jammed || jams;
      ends = jams || ending.is_reached(most);
      if (!ends) extrapolation.follow(most);
    }
    const bool may_gain = !ends || closing_speed_of_walls(g, s) > 0;
    if (!s.alone && may_gain) keep_energy_of_few(g, s, sweep, energy);
  };
  scale_impulses(g, 0.5);
  act(Sweep::solves);
  for (GroupBody& b : g.bodies) move(b, b.velocity, s.h);
  prepare_touching(g);
  act(Sweep::relaxes);
  add_passed(g);
  if (!jammed) return;
  // Opposing impulses would grow from substep to substep until friction slips.
  scale_impulses(g, 0);
  for (GroupBody& b : g.bodies) b.jammed = b.jammed || b.per_mass > 0;
}

}  // namespace pantin::detail::articulated
