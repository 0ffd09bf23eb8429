// Rolling and spinning friction of two bodies: the law is in engine/contact/rolling_friction.hpp.
#include <algorithm>

#include "engine/solvers/articulated/impulses/group_points.hpp"

namespace pantin::detail::articulated {
namespace {

/// Response of the relative spin to a torque on a and its opposite on b.
Vec3 spin_response(const Pair& pair, Vec3 torque) {
  const auto own = [&](const Side& s) {
    return s.response ? s.response->wt * torque : s.body.response * torque;
  };
  const Vec3 both = own(pair.a) + own(pair.b);
  if (!pair.cross) return both;
  return both - pair.cross->wt * torque - torque * pair.cross->wt;
}

/// Bounds of the torque impulse, N m s.
contact::RollingBounds bounds_of(const Group& g, const GroupRolling& r) {
  PANTIN_ASSERT(is_part(r.first, r.count, g.contacts.size()));
  contact::RollingBounds b;
  for (const GroupContact& c : g.contacts.subspan(r.first, r.count)) b.add(c.lengths, c.impulse.x);
  return b;
}

}  // namespace

void prepare_rolling(const Pair& pair, GroupRolling& r) {
  r.about = glm::dot(r.axes[0], spin_response(pair, r.axes[0]));
  const Vec3 first = spin_response(pair, r.axes[1]), second = spin_response(pair, r.axes[2]);
  const Real k1 = glm::dot(r.axes[1], first), k2 = glm::dot(r.axes[2], second),
             k12 = glm::dot(r.axes[1], second);
  // The larger response, as in prepare_contact().
  r.across = 0.5 * (k1 + k2) + std::sqrt(0.25 * (k1 - k2) * (k1 - k2) + k12 * k12);
}

Real solve_rolling(const Group& g, Pair& pair, GroupRolling& r) {
  const Vec3 spin = pair.a.spin - pair.b.spin;
  Vec3 now(0);
  if (r.about > 0) now.x = r.impulse.x - glm::dot(r.axes[0], spin) / r.about;
  if (r.across > 0) {
    now.y = r.impulse.y - glm::dot(r.axes[1], spin) / r.across;
    now.z = r.impulse.z - glm::dot(r.axes[2], spin) / r.across;
  }
  const Vec3 change = bounds_of(g, r).bounded(now) - r.impulse;
  if (change == Vec3(0)) return 0;
  r.impulse += change;
  pair.twist(to_world(r, change));
  const GroupContact& c = g.contacts[r.first];
  const Real arm = std::sqrt(std::max(glm::dot(c.arm_a, c.arm_a), glm::dot(c.arm_b, c.arm_b)));
  return arm * std::max(r.about, r.across) * glm::length(change);
}

void push(const Group& g, GroupRolling& r) {
  r.impulse = bounds_of(g, r).bounded(r.impulse);
  PANTIN_ASSERT(r.count > 0);
  if (r.impulse == Vec3(0)) return;
  const PairOf both = pair_of(g.contacts[r.first]);
  Pair pair = begin_pair(g, both);
  pair.twist(to_world(r, r.impulse));
  end_pair(g, both, pair);
}

}  // namespace pantin::detail::articulated
