#pragma once
/// Sweeps over a group, and when they end.
#include <limits>

#include "engine/solvers/articulated/impulses/group_points.hpp"

namespace pantin::detail::articulated {

/// Sweeps over few bodies: after so many, they may turn out to be jammed.
inline constexpr int kHardSweeps = 100;
/// m/s: tolerances of sweeps over trees and lanes, for the change of a contact's speed. Colour by
/// colour an impact passes from pair to pair only, in the order of pairs along a whole row.
inline constexpr Real kEnoughAtImpact = 0.06, kEnoughAtFewPoints = 3e-3;
/// Tolerance of few bodies, relative to 1 m/s plus the speed.
inline constexpr Real kEnoughOfFew = 1e-6;
/// Energy gain of a substep, as a fraction, above which the impulses are solved again from zero.
inline constexpr Real kSlightGain = 0.01;

/// One sweep: actuators, limits, then springs and cables, then contacts, then loops.
Real sweep_group(const Group& g, const Substep& s, Sweep sweep, Order order);

/// Applies weight and forces over a time h.
inline void accelerate(GroupBody& b, Real h) {
  b.velocity += h * b.acceleration, b.angular_momentum += h * b.torque;
  b.spin = b.response * b.angular_momentum;
}

bool has_friction(const Group& g);
/// Whether the group consists of free bodies on inextensible cables.
bool is_tied(const Group& g);

/// Decides when sweeps over a group end.
class Ending {
 public:
  Ending(const Group& g, const Substep& s);
  /// After a sweep that changed speeds by `most`, m/s.
  bool is_reached(Real most);

 private:
  static constexpr Real kNothingYet = std::numeric_limits<Real>::infinity();
  bool may_exchange_ = false, is_alone_;
  Real enough_ = 0, exchange_ = 0, before_ = kNothingYet;
};

/// Adds the impulses of a substep to those of the step.
void add_passed(const Group& g);
void scale_impulses(const Group& g, Real by);

/// A substep of few bodies without joints (group_few.cpp).
void take_hard_substep(const Group& g, const Substep& s, Order order);

}  // namespace pantin::detail::articulated
