// Impacts with restitution, at their time within the substep.
#include <algorithm>

#include "engine/solvers/articulated/group_points.hpp"

namespace pantin::detail::articulated {
namespace {

/// m/s: slower impacts are inelastic.
constexpr Real kSlowestImpact = 0.05;
constexpr int kImpactSweeps = 64;

/// The impact of two bodies that meet within the substep, at the time when they do. They continue
/// as if they had come from where that leads back to. False if they do not meet.
bool meet(const Group& g, GroupContact& c, Real h) {
  GroupBody &a = g.a(c), &b = g.b(c);
  const Vec3 n = c.axes[0];
  Pair pair = begin_pair(g, pair_of(c));
  // The motions of trees have the acceleration of the substep already.
  Vec3 gained(0);
  if (a.node != kNoNode) gained += h * a.acceleration;
  if (b.node != kNoNode) gained -= h * b.acceleration;
  const Real speed = glm::dot(n, pair.speed_of(arms_of(c)) - gained);
  const Real pull = glm::dot(n, a.acceleration - b.acceleration);
  const Real gap = std::max(Real(0), c.gap);
  if (speed > -kSlowestImpact || gap + h * (speed + 0.5 * h * pull) > 0) return false;
  // The first zero of gap + speed t + pull t^2 / 2, in the form that does not cancel.
  const Real root = std::sqrt(std::max(Real(0), speed * speed - 2 * pull * gap));
  const Real when = std::min(h, 2 * gap / (root - speed));
  const Real after = -c.restitution * (speed + pull * when) - pull * when;
  const Real impulse = (after - speed) / c.along;
  pair.push(arms_of(c), impulse * n);
  end_pair(g, pair_of(c), pair);
  c.passed.x += impulse;
  if (a.node != kNoNode || b.node != kNoNode) return true;
  const Real back = -when * (after + 0.5 * pull * when) - gap;
  const Real whole = a.per_mass + b.per_mass;
  a.pose.position += back * a.per_mass / whole * n,
      b.pose.position -= back * b.per_mass / whole * n;
  c.gap += back;
  return true;
}

}  // namespace

bool collide_elastically(const Group& g, const Substep& s) {
  if (std::none_of(g.contacts.begin(), g.contacts.end(),
                   [](auto& c) { return c.restitution > 0 && c.works; }))
    return false;
  bool moved = false;
  begin_loops(g, s.h, 0);
  for (int sweep = 0; sweep < kImpactSweeps; ++sweep) {
    bool any = false;
    for (GroupContact& c : g.contacts)
      any = (c.restitution > 0 && c.works && meet(g, c, s.h)) || any;
    if (!any) break;
    moved = true;
  }
  end_loops(g);
  if (!moved) return false;
  centre_bodies(g);
  for (GroupContact& c : g.contacts) {
    place(g, c);
    if (c.works) prepare_contact(g, c);
  }
  return true;
}

}  // namespace pantin::detail::articulated
