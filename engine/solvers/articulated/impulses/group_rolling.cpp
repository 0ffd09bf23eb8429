// Rolling and spinning friction of two bodies: the law is in engine/contact/rolling_friction.hpp.
#include <algorithm>

#include "engine/solvers/articulated/impulses/group_points.hpp"

namespace pantin::detail::articulated {
namespace {

/// Bounds of the torque impulse, N m s.
contact::RollingBounds bounds_of(const Group& g, const GroupRolling& r) {
  PANTIN_ASSERT(is_part(r.first, r.count, g.contacts.size()));
  contact::RollingBounds b;
  for (const GroupContact& c : g.contacts.subspan(r.first, r.count)) b.add(c.lengths, c.impulse.x);
  return b;
}

}  // namespace

void prepare_rolling(GroupRolling& r, const RollingRows& rows) {
  r.about = rows.first[0];
  r.across = larger_response(rows.first + rows.stride + 1, rows.stride);
}

Vec3 solve_rolling(const Group& g, GroupRolling& r, const Real* spin) {
  Vec3 now(0);
  if (r.about > 0) now.x = r.impulse.x - spin[0] / r.about;
  if (r.across > 0) {
    now.y = r.impulse.y - spin[1] / r.across;
    now.z = r.impulse.z - spin[2] / r.across;
  }
  const Vec3 change = bounds_of(g, r).bounded(now) - r.impulse;
  r.impulse += change;
  return change;
}

Real speed_of(const Group& g, const GroupRolling& r, Vec3 change) {
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
  pair.push(opposed(to_world(r, r.impulse)));
  end_pair(g, both, pair);
}

}  // namespace pantin::detail::articulated
