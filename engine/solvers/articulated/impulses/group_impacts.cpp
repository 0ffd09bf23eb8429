// Impacts with restitution, at their times within the substep.
#include <algorithm>

#include "engine/solvers/articulated/impulses/group_lanes.hpp"

namespace pantin::detail::articulated {
namespace {

/// Points whose gap at the end is below this fraction of the substep's path meet within it. Else
/// rounding decides, and the contact may stop the bodies without restitution.
constexpr Real kMeets = 1e-9;
constexpr int kImpactSweeps = 64;
/// Iterations of all impacts of a substep, after which each is solved less exactly: heavy bodies on
/// light ones pass an impact on many times.
constexpr int kIterationsOfAll = 20000;
/// Points of two bodies that are closer than this fraction of their arm at the time of the first
/// impact meet at once, as the corners of a box that falls flat.
constexpr Real kTogether = 1e-3;

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

/// A contact before an impact.
struct Meeting {
  Real speed = 0, gained = 0, pull = 0, gap = 0;  // m/s; m/s of it by forces; m/s^2; m
  Real when = 0;                                  // s, of the impact
  bool comes = false, meets = false;              // fast enough to bounce; within the substep

  /// m/s: separating speed after an impact at a time.
  Real after(Real restitution, Real time) const {
    return -restitution * (speed + pull * time) - pull * time;
  }
  Real gap_at(Real time) const { return gap + time * (speed + 0.5 * time * pull); }
};

bool is_jointed(const Group& g, const GroupContact& c) {
  return g.a(c).node != kNoNode || g.b(c).node != kNoNode;
}

Meeting meeting_of(const Group& g, const Pair& pair, const GroupContact& c, Real h) {
  Meeting m;
  if (!c.works || !(c.restitution > 0)) return m;
  const GroupBody &a = g.a(c), &b = g.b(c);
  const Vec3 n = c.axes[0];
  const auto pull_on = [&](const GroupBody& body) {
    return body.node == kNoNode ? glm::dot(n, body.acceleration) : 0;
  };
  m.gained = glm::dot(n, gained_by(g, a, c.arm_a) - gained_by(g, b, c.arm_b));
  m.speed = glm::dot(n, pair.speed_of(arms_of(c))) - m.gained;
  m.pull = m.gained / h + pull_on(a) - pull_on(b);
  m.gap = std::max(Real(0), c.gap);
  m.comes = m.speed <= -slowest_blow(a, b, h);
  m.meets = m.comes && m.gap_at(h) <= -kMeets * h * m.speed;
  if (!m.meets || is_jointed(g, c)) return m;
  // The first zero of gap + speed t + pull t^2 / 2, in the form that does not cancel.
  const Real root = std::sqrt(std::max(Real(0), m.speed * m.speed - 2 * m.pull * m.gap));
  m.when = std::min(h, 2 * m.gap / (root - m.speed));
  return m;
}

/// The impact of two bodies that meet within the substep, at the time of the impact. Free bodies
/// are moved back so that the new velocity leads through the point of impact. Trees are not moved:
/// they meet at the start of the substep, at their speed there. False if there is no impact.
bool meet(const Group& g, const GroupPair& p, Real h, int& left) {
  const auto contacts = g.contacts.subspan(p.first, p.count);
  if (std::none_of(contacts.begin(), contacts.end(),
                   [](const GroupContact& c) { return c.works && c.restitution > 0; }))
    return false;
  const GroupContact& any = contacts.front();
  GroupBody &a = g.a(any), &b = g.b(any);
  Pair pair = begin_pair(g, pair_of(any));
  const bool jointed = is_jointed(g, any);
  const GroupContact* first = nullptr;
  Meeting at, all[kMostPoints];
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Meeting& m = all[i] = meeting_of(g, pair, contacts[i], h);
    if (m.meets && (!first || m.when < at.when)) first = &contacts[i], at = m;
  }
  if (!first) return false;
  Blow blow;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    GroupContact& c = contacts[i];
    const Meeting& m = all[i];
    const Real together = kTogether * glm::length(can_give_way(a) ? c.arm_a : c.arm_b);
    const bool at_once = jointed ? m.meets : m.comes && m.gap_at(at.when) <= together;
    if (&c == first || at_once)
      blow.add(c, m.after(c.restitution, jointed ? 0 : at.when) + m.gained);
  }
  blow.solve(pair, left);
  Vec3 aside(0);  // N s, across the normal: acts from the impact on
  BothWrenches sum;
  for (const BlowPoint& struck : blow.points()) {
    const Vec3 impulse = to_world(*struck.contact, struck.impulse);
    sum += opposed(arms_of(*struck.contact), impulse);
    aside += impulse - struck.impulse.x * struck.contact->axes[0];
    struck.contact->passed += struck.impulse;
  }
  pair.push(sum);
  end_pair(g, pair_of(any), pair);
  if (jointed) return true;
  const Vec3 n = first->axes[0];
  const Real after = at.after(first->restitution, at.when);
  const Real back = -at.when * (after + 0.5 * at.pull * at.when) - at.gap;
  const Real whole = a.per_mass + b.per_mass;
  a.pose.position += a.per_mass * (back / whole * n - at.when * aside);
  b.pose.position -= b.per_mass * (back / whole * n - at.when * aside);
  for (GroupContact& c : contacts) c.gap += back * glm::dot(n, c.axes[0]);
  return true;
}

}  // namespace

bool collide_elastically(const Group& g, const Substep& s) {
  if (std::none_of(g.contacts.begin(), g.contacts.end(),
                   [](auto& c) { return c.restitution > 0 && c.works; }))
    return false;
  bool moved = false;
  int left = kIterationsOfAll;
  find_gained(g, s.h);
  begin_loops(g, s.h, 0);
  for (int sweep = 0; sweep < kImpactSweeps; ++sweep) {
    bool any = false;
    for (const GroupPair& p : g.pairs) any = meet(g, p, s.h, left) || any;
    if (!any) break;
    moved = true;
  }
  end_loops(g);
  if (!moved) return false;
  centre_bodies(g);
  for (GroupContact& c : g.contacts) place(g, c);
  for (GroupPair& p : g.pairs)
    if (s.hard || !p.in_lanes) prepare_pair(g, p);
  if (!s.hard) prepare_lanes(g);
  return true;
}

}  // namespace pantin::detail::articulated
