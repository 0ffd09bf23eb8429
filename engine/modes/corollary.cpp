#include "engine/modes/corollary.hpp"

namespace pantin::detail::modes {
namespace {

constexpr Real kParallel = 1e-9;

/// A force that acts along a line.
struct Action {
  Vec2 point, force;
};

Vec2 minus(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
Real size(Vec2 a) { return std::hypot(a.x, a.y); }
Real moment_about(Vec2 at, const Action& a) { return cross(minus(a.point, at), a.force); }

Action action(const Contact& c, Real along_tangent) {
  const Vec2 t = tangent_of(c.normal);
  return {c.point, {c.normal.x + along_tangent * t.x, c.normal.y + along_tangent * t.y}};
}

/// Moments, or components across, of the load and of the third force, which must differ in sign.
struct Senses {
  Real load, third;
  bool concurrent;
};

Senses senses(const Lamina& lamina, const Action& a, const Action& b, const Action& third) {
  const Vec2 load{lamina.load.x, lamina.load.y};
  const Real turn = cross(a.force, b.force);
  const Vec2 between = minus(b.point, a.point);
  if (std::abs(turn) < kParallel * size(a.force) * size(b.force)) {
    const Real across = cross(a.force, third.force);
    const bool same = std::abs(across) < kParallel * size(a.force) * size(third.force) ||
                      std::abs(cross(between, a.force)) < kParallel * size(a.force);
    return {cross(a.force, load), across, same};
  }
  const Real along = cross(between, b.force) / turn;
  const Vec2 meet{a.point.x + along * a.force.x, a.point.y + along * a.force.y};
  const Real moment = moment_about(meet, third);
  const Vec2 arm = minus(third.point, meet);
  return {lamina.load.z - cross(meet, load), moment,
          std::abs(moment) < kParallel * size(third.force) * (1 + size(arm))};
}

}  // namespace

Geometric by_moments(const Lamina& lamina, const Region& r, const OwnFriction& mu) {
  const auto slides = [&](std::size_t k) {
    return action(lamina.contacts[r.contacts[k]], -r.slip_sign[k] * mu[k]);
  };
  std::array<Action, 3> actions;
  if (r.kind == Kind::three_slide) {
    actions = {slides(0), slides(1), slides(2)};
  } else {
    // The rolling contact's force is a sum of the edges of its cone.
    const Contact& roll = lamina.contacts[r.contacts[0]];
    actions = {action(roll, mu[0]), action(roll, -mu[0]), slides(1)};
  }
  bool feasible = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const Senses s = senses(lamina, actions[(i + 1) % 3], actions[(i + 2) % 3], actions[i]);
    if (s.concurrent) return Geometric::concurrent;
    feasible &= s.load * s.third <= 0;
  }
  return feasible ? Geometric::feasible : Geometric::infeasible;
}

}  // namespace pantin::detail::modes
