// Spring pins and cables of islands in contact: impulses iterated with the contacts.
#include <algorithm>

#include "engine/solvers/articulated/impulses/group_pair.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// m/s: the fastest closing velocity of a gap.
constexpr Real kFastestReturn = 4;

const Vec3 kAxes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

PairOf pair_of(const GroupTie& t) { return {t.a, t.b, t.cross}; }
Arms arms_of(const GroupTie& t) { return {t.arm_a, t.arm_b}; }

Vec3 direction_of(const GroupTie& t) {
  const Real span = glm::length(t.apart);
  return span > 0 ? t.apart / span : Vec3(0);
}

/// The impulse on b.
Vec3 impulse_of(const GroupTie& t) {
  return t.kind == GroupTie::Kind::cable ? -t.impulse.x * direction_of(t) : t.impulse;
}

/// Implicit stiffness of a spring with a damper: impulse per relative velocity at the end.
Real stiffness_of(const GroupTie& t, Real h) { return h * (h * t.stiffness + t.damping); }

/// The change of a cable's tension impulse. A slack cable may stretch by its slack in the substep.
Real solve_cable(GroupTie& t, Real speed, Real h, Real part) {
  PANTIN_ASSERT(t.kind == GroupTie::Kind::cable && t.along > 0);
  const Real stretch = glm::length(t.apart) - t.length;
  Real more = 0;
  if (t.stiffness > 0) {
    const Real soft = stiffness_of(t, h);
    more = (h * t.stiffness * stretch + soft * speed - t.impulse.x) / (1 + soft * t.along);
  } else {
    const Real most = stretch < 0 ? -stretch / h : -std::min(part * stretch / h, kFastestReturn);
    more = (speed - most) / t.along;
  }
  const Real before = t.impulse.x;
  t.impulse.x = std::max(Real(0), before + more);
  return t.impulse.x - before;
}

}  // namespace

void place_tie(const Group& g, GroupTie& t) {
  const GroupBody &a = g.bodies[t.a], &b = g.bodies[t.b];
  t.arm_a = a.pose.position - a.centre + a.pose.rotation * t.anchor_a;
  t.arm_b = b.pose.position - b.centre + b.pose.rotation * t.anchor_b;
  t.apart = b.centre + t.arm_b - a.centre - t.arm_a;
}

void prepare_tie(const Group& g, GroupTie& t, Real h) {
  place_tie(g, t);
  PANTIN_ASSERT(t.kind != GroupTie::Kind::rigid && h > 0);
  prepare_looped(g, t.a), prepare_looped(g, t.b);
  if (t.cross != kNoNode) g.crosses[t.cross] = cross_response_of(g, t.a, t.b);
  const Pair pair{{g, t.a}, {g, t.b}, t.cross == kNoNode ? nullptr : &g.crosses[t.cross]};
  for (int k = 0; k < 3; ++k) t.response[k] = response_of(pair, arms_of(t), kAxes[k]);
  t.response = 0.5 * (t.response + glm::transpose(t.response));
  if (t.kind == GroupTie::Kind::cable) {
    const Vec3 n = direction_of(t);
    t.along = glm::dot(n, t.response * n);
    if (!(t.along > 0)) t.impulse = Vec3(0);
    return;
  }
  t.inverse = compliance_of(Mat3(1) + stiffness_of(t, h) * t.response, kAxes, 3);
}

void push_tie(const Group& g, const GroupTie& t) {
  const Vec3 impulse = impulse_of(t);
  if (impulse == Vec3(0)) return;
  Pair pair = begin_pair(g, pair_of(t));
  pair.push(opposed(arms_of(t), -impulse));
  end_pair(g, pair_of(t), pair);
}

Real solve_tie(const Group& g, GroupTie& t, Real h, Real part) {
  Pair pair = begin_pair(g, pair_of(t));
  const Vec3 speed = -pair.speed_of(arms_of(t));  // of b relative to a
  Vec3 change(0);
  if (t.kind == GroupTie::Kind::cable) {
    if (!(t.along > 0)) return 0;
    const Vec3 n = direction_of(t);
    change = -solve_cable(t, glm::dot(n, speed), h, part) * n;
  } else {
    change = -t.inverse * (t.impulse + h * t.stiffness * t.apart + stiffness_of(t, h) * speed);
    t.impulse += change;
  }
  if (change == Vec3(0)) return 0;
  pair.push(opposed(arms_of(t), -change));
  end_pair(g, pair_of(t), pair);
  return glm::length(t.response * change);
}

}  // namespace pantin::detail::articulated
