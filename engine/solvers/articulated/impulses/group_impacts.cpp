// Impacts with restitution, at their times within the substep.
#include <algorithm>

#include "engine/solvers/articulated/impulses/group_points.hpp"

namespace pantin::detail::articulated {
namespace {

/// Points whose gap at the end is below this fraction of the substep's path meet within it. Else
/// rounding decides, and the contact may stop the bodies without restitution.
constexpr Real kMeets = 1e-9;
constexpr int kImpactSweeps = 64;

/// Velocity that the forces of the substep have already added at a point of a tree.
Vec3 gained_by(const Group& g, const GroupBody& b, Vec3 arm) {
  if (b.node == kNoNode) return Vec3(0);
  const Wrench& motion = g.nodes[b.node].passing;
  return motion.force + glm::cross(motion.torque, arm);
}

/// Leaves in `passing` the change of motion by the forces of the substep in trees, whose joints
/// carry some of the weight.
void find_gained(const Group& g, Real h) {
  for (const GroupTree& t : g.trees) {
    for (std::uint32_t i = t.first; i < t.first + t.count; ++i) {
      GroupNode& n = g.nodes[i];
      const GroupBody& b = g.bodies[n.body];
      const Vec3 impulse = n.mass * h * b.acceleration;
      n.passing = {impulse, h * b.torque + glm::cross(n.arm, impulse)};
    }
    for (std::uint32_t i = t.first + t.count; i-- > t.first;) gather_impulse(g, i);
    for (std::uint32_t i = t.first; i < t.first + t.count; ++i) follow_impulse(g, i);
  }
}

/// m/s: slower impacts are inelastic. Below what their forces give to the bodies in two substeps
/// nothing bounces; where these are weak, slower bodies do.
Real slowest_blow(const GroupBody& a, const GroupBody& b, Real h) {
  constexpr Real kRounding = 1e-6;
  if (a.node != kNoNode || b.node != kNoNode) return kLeastBlow;
  const Real pulls = std::max(glm::length(a.acceleration), glm::length(b.acceleration));
  return std::clamp(2 * h * pulls, kRounding, kLeastBlow);
}

/// The impact of two bodies that meet within the substep, at the time of the impact. Free bodies
/// are moved back so that the new velocity leads through the point of impact. Trees are not moved:
/// they meet at the start of the substep, at their speed there. False if there is no impact.
bool meet(const Group& g, GroupContact& c, Real h) {
  PANTIN_ASSERT(c.works && c.restitution > 0);
  GroupBody &a = g.a(c), &b = g.b(c);
  const Vec3 n = c.axes[0];
  Pair pair = begin_pair(g, pair_of(c));
  const bool jointed = a.node != kNoNode || b.node != kNoNode;
  const Real gained = glm::dot(n, gained_by(g, a, c.arm_a) - gained_by(g, b, c.arm_b));
  const Real speed = glm::dot(n, pair.speed_of(arms_of(c))) - gained;
  const auto pull_on = [&](const GroupBody& body) {
    return body.node == kNoNode ? glm::dot(n, body.acceleration) : 0;
  };
  const Real pull = gained / h + pull_on(a) - pull_on(b);
  const Real gap = std::max(Real(0), c.gap);
  const Real left = gap + h * (speed + 0.5 * h * pull);
  if (speed > -slowest_blow(a, b, h) || left > -kMeets * h * speed) return false;
  // The first zero of gap + speed t + pull t^2 / 2, in the form that does not cancel.
  const Real root = std::sqrt(std::max(Real(0), speed * speed - 2 * pull * gap));
  const Real when = jointed ? 0 : std::min(h, 2 * gap / (root - speed));
  const Real after = -c.restitution * (speed + pull * when) - pull * when;
  const Vec3 impulse = strike(pair, c, after + gained);
  pair.push(opposed(arms_of(c), to_world(c, impulse)));
  end_pair(g, pair_of(c), pair);
  c.passed += impulse;
  if (jointed) return true;
  const Real back = -when * (after + 0.5 * pull * when) - gap;
  const Real whole = a.per_mass + b.per_mass;
  const Vec3 aside = to_world(c, {0, impulse.y, impulse.z});  // acts from the impact on
  a.pose.position += a.per_mass * (back / whole * n - when * aside),
      b.pose.position -= b.per_mass * (back / whole * n - when * aside);
  c.gap += back;
  return true;
}

}  // namespace

bool collide_elastically(const Group& g, const Substep& s) {
  if (std::none_of(g.contacts.begin(), g.contacts.end(),
                   [](auto& c) { return c.restitution > 0 && c.works; }))
    return false;
  bool moved = false;
  find_gained(g, s.h);
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
  for (GroupContact& c : g.contacts) place(g, c);
  for (GroupPair& p : g.pairs) prepare_pair(g, p);
  return true;
}

}  // namespace pantin::detail::articulated
