// Rolling and spinning friction: what touches over a patch resists turning about the contact.
//
// A torque across the normal, bounded by a length times the normal impulse, opposes rolling; one
// along the normal opposes spinning. Both are implicit, like Coulomb's cone: what they can stop
// stands, and nothing turns back.
#include <algorithm>

#include "engine/solvers/articulated/group_points.hpp"

namespace pantin::detail::articulated {
namespace {

/// What a torque on a, and its opposite on b, changes of their relative spin.
Vec3 spin_response(const Pair& pair, Vec3 torque) {
  const auto own = [&](const Side& s) {
    return s.response ? s.response->wt * torque : s.body.response * torque;
  };
  const Vec3 both = own(pair.a) + own(pair.b);
  if (!pair.cross) return both;
  return both - pair.cross->wt * torque - torque * pair.cross->wt;
}

}  // namespace

void prepare_rolling(const Pair& pair, const GroupContact& c, GroupRolling& r) {
  r.about = glm::dot(c.axes[0], spin_response(pair, c.axes[0]));
  const Vec3 first = spin_response(pair, c.axes[1]), second = spin_response(pair, c.axes[2]);
  const Real k1 = glm::dot(c.axes[1], first), k2 = glm::dot(c.axes[2], second),
             k12 = glm::dot(c.axes[1], second);
  // The softer direction, as of friction.
  r.across = 0.5 * (k1 + k2) + std::sqrt(0.25 * (k1 - k2) * (k1 - k2) + k12 * k12);
}

Real solve_rolling(Pair& pair, const GroupContact& c, GroupRolling& r) {
  const Vec3 spin = pair.a.spin - pair.b.spin;
  Vec3 now(0);
  if (const Real most = r.spinning * c.impulse.x; r.about > 0 && most > 0)
    now.x = std::clamp(r.impulse.x - glm::dot(c.axes[0], spin) / r.about, -most, most);
  if (const Real most = r.rolling * c.impulse.x; r.across > 0 && most > 0) {
    now.y = r.impulse.y - glm::dot(c.axes[1], spin) / r.across;
    now.z = r.impulse.z - glm::dot(c.axes[2], spin) / r.across;
    const Real held = std::sqrt(now.y * now.y + now.z * now.z);
    if (held > most) now.y *= most / held, now.z *= most / held;
  }
  const Vec3 change = now - r.impulse;
  if (change == Vec3(0)) return 0;
  r.impulse = now;
  pair.twist(to_world(c, change));
  const Real arm = std::sqrt(std::max(glm::dot(c.arm_a, c.arm_a), glm::dot(c.arm_b, c.arm_b)));
  return arm * std::max(r.about, r.across) * glm::length(change);
}

}  // namespace pantin::detail::articulated
