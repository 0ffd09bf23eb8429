// Whether the bodies of a group hardly move, so that it may be solved at rest (group_rest.cpp).
#include "engine/solvers/articulated/impulses/group_resting.hpp"

namespace pantin::detail::articulated {
namespace {

/// A body is calm below this speed, m/s, and this path in a step, in sizes of the body.
constexpr Real kCalmWay = 0.02;
/// m/s: the same for few bodies, whose other method is exact: they must be nearly still.
constexpr Real kStill = 1e-3;
/// Largest fraction of a group's mass that may swing from it.
constexpr Real kArms = 0.1;

bool is_calm(const GroupBody& b, const Wrench& motion, Real h, Real most) {
  const Real size = size_of(b);
  const Real speed = glm::length(motion.force) + size * glm::length(motion.torque);
  return speed < most && h * speed < kCalmWay * size;
}

Real most_of(std::size_t bodies) { return bodies > kFewBodies ? kRestSpeed : kStill; }

/// Adds up the bodies of a group that rest and those that swing from them.
struct Calmness {
  enum class May : std::uint8_t { rest, swing };
  Real most = 0, moving = 0, whole = 0;  // m/s; kg
  bool is_lost = false;                  // a body moves that must not

  void add(const GroupBody& b, const Wrench& motion, Real h, May may) {
    whole += 1 / b.per_mass;
    if (is_calm(b, motion, h, most)) return;
    moving += 1 / b.per_mass;
    is_lost = is_lost || may == May::rest;
  }
  bool holds() const { return !is_lost && moving <= kArms * whole; }
};

}  // namespace

bool are_calm(const Group& g, const GroupPart& part) {
  Calmness calm{most_of(g.resting.size())};
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    const RestBody& r = g.resting[i];
    const bool swings = part.h < part.whole && !r.touches;
    calm.add(g.bodies[i], r.motion, part.h, swings ? Calmness::May::swing : Calmness::May::rest);
  }
  return calm.holds();
}

bool is_calm(std::span<const GroupBody> bodies, std::size_t free, Real h) {
  Calmness calm{most_of(free)};
  for (const GroupBody& b : bodies)
    if (b.per_mass > 0)
      calm.add(b, {b.velocity, b.spin}, h,
               b.node != kNoNode && !b.touched ? Calmness::May::swing : Calmness::May::rest);
    else if (b.velocity != Vec3(0) || b.spin != Vec3(0))
      return false;
  return calm.holds();
}

}  // namespace pantin::detail::articulated
