// Sweeps over a group, and when they end.
#include "engine/solvers/articulated/impulses/group_sweeps.hpp"

#include <algorithm>

#include "engine/solvers/articulated/impulses/group_ties.hpp"

namespace pantin::detail::articulated {
namespace {

/// m/s: tolerance with rolling friction. Its distribution among points is not unique, and
/// iterations may go on exchanging it without changing the motion.
constexpr Real kEnoughOfRolling = 1e-7;
/// Tolerance relative to the change of the first sweep, of a body alone.
constexpr Real kOfFirst = 1e-6;
/// Friction at two points of a line, as of a cone on its side, may require two speeds along it that
/// differ by the error of the step: sweeps then exchange friction for ever. Sweeps end once changes
/// are below the first (relative to 1 m/s plus the speed) and fall by less than the second.
constexpr Real kExchange = 1e-6, kStalled = 0.02;
/// Fraction of a tie's gap that is closed in a substep.
constexpr Real kTieReturn = 0.5;

}  // namespace

Real sweep_group(const Group& g, const Substep& s, Sweep sweep, Order order) {
  solve_actuators(g, s.h);
  const LimitSpring before{s.before_limits, sweep == Sweep::solves ? &s.against_fixed : nullptr};
  const Real limited = solve_limits(g, s.reach, before);
  const Real part = sweep == Sweep::solves ? kTieReturn : 0;
  begin_loops(g, s.h, part);
  Real most = s.few_points ? limited : 0;
  for (std::size_t i = 0; i < g.ties.size(); ++i) {
    GroupTie& t = g.ties[order == Order::forwards ? i : g.ties.size() - 1 - i];
    if (t.kind != GroupTie::Kind::rigid) most = std::max(most, solve_tie(g, t, s.h, part));
  }
  most = std::max(most, sweep_contacts(g, s, sweep, order));
  end_loops(g);
  return most;
}

bool has_friction(const Group& g) {
  return std::any_of(g.contacts.begin(), g.contacts.end(),
                     [](const GroupContact& c) { return c.works && c.friction > 0; });
}

bool is_tied(const Group& g) { return g.trees.empty() && has_cables(g); }

Ending::Ending(const Group& g, const Substep& s) : is_alone_(s.alone) {
  may_exchange_ = s.hard && has_friction(g);
  const Real speed = 1 + glm::length(g.bodies.front().velocity);
  enough_ = s.strikes || (is_tied(g) && !s.in_haste) ? kEnoughOfFew * speed
            : s.few_points                           ? s.enough
            : !s.hard                                ? kEnoughAtImpact
            : g.rollings.empty()                     ? s.enough
                                                     : kEnoughOfRolling * speed;
  exchange_ = kExchange * speed;
}

bool Ending::is_reached(Real most) {
  const bool stalls = may_exchange_ && most <= exchange_ && most >= (1 - kStalled) * before_;
  if (is_alone_ && before_ == kNothingYet) enough_ = std::max(enough_, kOfFirst * most);
  before_ = most;
  return most <= enough_ || stalls;
}

void add_passed(const Group& g) {
  for (GroupContact& c : g.contacts) c.passed += c.impulse;
  for (GroupRolling& r : g.rollings) r.passed += r.impulse;
  for (GroupTie& t : g.ties) t.passed += t.impulse;
}

void scale_impulses(const Group& g, Real by) {
  for (GroupContact& c : g.contacts) c.impulse *= by;
  for (GroupRolling& r : g.rollings) r.impulse *= by;
}

}  // namespace pantin::detail::articulated
