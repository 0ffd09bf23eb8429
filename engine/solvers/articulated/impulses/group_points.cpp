// Contact points of a group, and impulses on them.
#include "engine/solvers/articulated/impulses/group_points.hpp"

#include <algorithm>

#include "engine/base/rotation.hpp"

namespace pantin::detail::articulated {
namespace {

/// m/s: the fastest separation of overlaps.
constexpr Real kPushSpeed = 1;
constexpr int kPointIterations = 8;
/// Iterations over a pair end when changes fall below this fraction of the first one.
constexpr Real kPairTolerance = 0.02;
/// Least response of a contact of bodies in trees, as a fraction of that without joints.
constexpr Real kLeastResponse = 1e-4;

/// A group is jammed if a sweep still changes speeds by this fraction of the walls' closing speed.
constexpr Real kJammed = 0.125;

/// m/s: separating speed of a hard contact.
Real push_speed(const GroupContact& c, const Substep& s) {
  return c.gap < (s.alone ? -c.shallow : 0) ? std::min(-0.2 * c.gap / s.h, kPushSpeed) : 0;
}

Goal goal_of(const GroupContact& c, const Softness& spring, const Substep& s, Sweep sweep) {
  if (sweep == Sweep::relaxes && (s.hard || c.impulse.x > 0)) return {};
  if (c.gap > c.rest) return {-c.gap / s.reach, {}};
  if (sweep == Sweep::relaxes) return {};
  if (s.hard) return {push_speed(c, s), {}};
  return {std::min(spring.rate * (c.rest - c.gap), kPushSpeed), spring};
}

}  // namespace

Vec3 solve_point(const Pair& pair, GroupContact& c, const Goal& goal) {
  PANTIN_ASSERT(c.along > 0 && c.aside > 0);
  const Vec3 u = pair.speed_of(leads_of(c));
  const Real un = glm::dot(c.axes[0], u);
  const Real normal =
      std::max(Real(0), c.impulse.x + goal.spring.by_mass * (goal.speed - un) / c.along -
                            goal.spring.by_impulse * c.impulse.x);
  const Real more = normal - c.impulse.x;
  const Real u1 = glm::dot(c.axes[1], u) + c.surface_first,
             u2 = glm::dot(c.axes[2], u) + c.surface_second;
  Real f1 = c.impulse.y - (u1 + c.cross_first * more) / c.aside;
  Real f2 = c.impulse.z - (u2 + c.cross_second * more) / c.aside;
  const Real held = std::sqrt(f1 * f1 + f2 * f2), most = c.friction * normal;
  if (normal == 0)
    f1 = f2 = 0;  // squares of tiny values may underflow to zero
  else if (held > most)
    f1 *= most / held, f2 *= most / held;
  const Vec3 change = Vec3(normal, f1, f2) - c.impulse;
  c.impulse += change;
  return to_world(c, change);
}

namespace {

/// Contacts [from, to) between the same two bodies. Returns the largest change of speed, m/s.
Real solve_points(const Group& g, std::span<GroupContact> points, const Substep& s, Sweep sweep) {
  Real most = 0, first = 0;
  const auto working = std::count_if(points.begin(), points.end(), [](auto& c) { return c.works; });
  if (working == 0) return most;
  PANTIN_ASSERT(have_same_bodies(points.front(), points.back()));
  const bool rolls = points.front().rolling != kNoNode;
  // Trees: a residual of one pair would go on oscillating through the joints.
  const bool converges = rolls || s.hard || g.trees.empty();
  const int iterations = working > 1 || rolls ? kPointIterations : 1;
  Pair pair = begin_pair(g, pair_of(points.front()));
  for (int n = 0; n < iterations; ++n) {
    Real now = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      GroupContact& c = points[n % 2 == 0 ? i : points.size() - 1 - i];
      if (!c.works) continue;
      const Vec3 change = solve_point(pair, c, goal_of(c, spring_of(g, c, s), s, sweep));
      if (change != Vec3(0)) {
        pair.push(arms_of(c), change);
        now = std::max(now, c.along * glm::length(change));
      }
    }
    if (rolls) now = std::max(now, solve_rolling(g, pair, g.rollings[points.front().rolling]));
    most = std::max(most, now);
    if (n == 0) first = now;
    if ((s.hard ? now <= s.enough : now == 0) || (converges && now <= kPairTolerance * first))
      break;
  }
  if (most > 0) end_pair(g, pair_of(points.front()), pair);
  return most;
}

/// m/s: approach of the fixed body of an active contact, plus the separating speed of an overlap.
Real asked_speed(const Group& g, const GroupContact& c, const Substep& s) {
  const GroupBody& b = g.b(c);
  const Real comes = glm::dot(c.axes[0], speed_at(b, c.arm_b));
  return comes + (c.gap < -c.shallow ? push_speed(c, s) : 0);
}

}  // namespace

bool is_jammed(const Group& g, const Substep& s, Real change) {
  const auto bears = [&](const GroupContact& c) { return c.impulse.x > 0 && g.is_fixed(c); };
  Real closing = 0;
  for (const GroupContact& c : g.contacts)
    for (const GroupContact& d : g.contacts)
      if (bears(c) && bears(d) && glm::dot(c.axes[0], d.axes[0]) < 0)
        closing = std::max(closing, asked_speed(g, c, s) + asked_speed(g, d, s));
  return closing > 0 && change > kJammed * closing;
}

void centre_bodies(const Group& g) {
  for (GroupBody& b : g.bodies)
    if (b.node == kNoNode) b.centre = b.pose.position;
}

void push(const Group& g, const GroupContact& c) {
  Pair pair = begin_pair(g, pair_of(c));
  pair.push(arms_of(c), to_world(c, c.impulse));
  end_pair(g, pair_of(c), pair);
}

void place(const Group& g, GroupContact& c) {
  const GroupBody &a = g.a(c), &b = g.b(c);
  const Vec3 n = c.axes[0];
  c.arm_a = a.pose.position - a.centre + c.on_a.at(a.pose.rotation, -n);
  c.arm_b = b.pose.position - b.centre + c.on_b.at(b.pose.rotation, n);
  c.lead_a = c.arm_a, c.lead_b = c.arm_b;
  c.gap = glm::dot(n, a.centre + c.arm_a - b.centre - c.arm_b);
}

void lead(const Group& g, GroupContact& c, Real h) {
  const auto arm = [&](const GroupBody& body, const contact::TouchedPlace& on, Vec3 outward) {
    return on.at(from_rotation_vector(0.5 * h * body.spin) * body.pose.rotation, outward);
  };
  c.lead_a = arm(g.a(c), c.on_a, -c.axes[0]), c.lead_b = arm(g.b(c), c.on_b, c.axes[0]);
}

void prepare_contact(const Group& g, GroupContact& c) {
  const Vec3 n = c.axes[0];
  const Pair pair{{g, c.a}, {g, c.b}, c.cross == kNoNode ? nullptr : &g.crosses[c.cross]};
  Vec3 moved[3];
  for (int k = 0; k < 3; ++k) moved[k] = response_of(pair, arms_of(c), c.axes[k], leads_of(c));
  c.along = glm::dot(n, moved[0]);
  c.cross_first = glm::dot(c.axes[1], moved[0]), c.cross_second = glm::dot(c.axes[2], moved[0]);
  const Real k1 = glm::dot(c.axes[1], moved[1]), k2 = glm::dot(c.axes[2], moved[2]),
             k12 = glm::dot(c.axes[1], moved[2]);
  // The larger tangential response: a mean would overshoot in the softer direction.
  c.aside = 0.5 * (k1 + k2) + std::sqrt(0.25 * (k1 - k2) * (k1 - k2) + k12 * k12);
  // Joints may leave a pair of bodies hardly any response: the contact is then inactive.
  const Real loose = kLeastResponse * (pair.a.body.per_mass + pair.b.body.per_mass);
  c.works = c.along > loose && c.aside > loose;
  if (!c.works) c.impulse = Vec3(0);
  if (c.works && c.rolling != kNoNode) prepare_rolling(pair, g.rollings[c.rolling]);
}

Real sweep_contacts(const Group& g, const Substep& s, Sweep sweep, Order order) {
  Real most = 0;
  const std::size_t n = g.contacts.size();
  for (std::size_t from = 0; from < n;) {
    std::size_t count = 1;
    const auto at = [&](std::size_t i) { return order == Order::forwards ? i : n - 1 - i; };
    while (from + count < n && have_same_bodies(g.contacts[at(from)], g.contacts[at(from + count)]))
      ++count;
    const std::size_t first = order == Order::forwards ? from : n - from - count;
    most = std::max(most, solve_points(g, g.contacts.subspan(first, count), s, sweep));
    from += count;
  }
  return most;
}

}  // namespace pantin::detail::articulated
