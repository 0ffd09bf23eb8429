// Contact points of a group, and impulses on them.
#include "engine/solvers/articulated/impulses/group_points.hpp"

#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/impulses/group_lanes.hpp"

namespace pantin::detail::articulated {
namespace {

/// Iterations of one impact at a point, and at several, and the relative change that ends them:
/// friction rotates bodies that are not round, which changes the separating speed of the point.
constexpr int kStrikeIterations = 32, kBlowIterations = 400;
constexpr Real kStruckEnough = 1e-9;
/// Least response of a contact of bodies in trees, as a fraction of that without joints.
constexpr Real kLeastResponse = 1e-4;

/// A group is jammed if a sweep still changes speeds by this fraction of the walls' closing speed.
constexpr Real kJammed = 0.125;

/// m/s: separating speed of a hard contact.
Real push_speed(const GroupContact& c, const Substep& s) {
  return c.gap < (s.alone ? -c.shallow : 0) ? std::min(-0.2 * c.gap / s.h, kPushSpeed) : 0;
}

/// Fraction of its arm by which a contact may move over a body in half a substep. One that jumps,
/// as across the face of a drum that tilts, is not followed: the responses, which are measured
/// there, would be far from symmetric, and sweeps would diverge.
constexpr Real kFarLed = 0.2;
constexpr std::size_t kMostRows = 3 * kMostPoints + 3, kMostStride = padded(kMostRows);

/// Active contacts of a pair as rows of its responses.
struct PairRows {
  GroupContact* contacts[kMostPoints];
  std::size_t points = 0, rows = 0;
  GroupRolling* rolling = nullptr;
  std::size_t stride() const { return padded(rows); }
};

PairRows rows_of(const Group& g, const GroupPair& p) {
  PairRows r;
  for (GroupContact& c : g.contacts.subspan(p.first, p.count))
    if (c.works) r.contacts[r.points++] = &c;
  PANTIN_ASSERT(r.points <= kMostPoints);
  const std::uint32_t rolling = g.contacts[p.first].rolling;
  if (rolling != kNoNode) r.rolling = &g.rollings[rolling];
  r.rows = 3 * r.points + (r.rolling ? 3 : 0);
  return r;
}

/// The same of one point.
void write_own_responses(const Pair& pair, const GroupContact& c, Real* to) {
  for (const Vec3& axis : c.axes) {
    const BothWrenches motion = pair.response_to(opposed(arms_of(c), axis));
    const Vec3 speed = motion.a.force - motion.b.force + glm::cross(motion.a.torque, c.lead_a) -
                       glm::cross(motion.b.torque, c.lead_b);
    for (const Vec3& measured : c.axes) *to++ = glm::dot(measured, speed);
    *to++ = 0;
  }
}

/// Responses of all rows to impulses along each, column by column.
void write_responses(const Pair& pair, const PairRows& r, Real* to) {
  if (r.rows == 3) return write_own_responses(pair, *r.contacts[0], to);
  Real seen[kMotionNumbers * kMostStride], caused[kMotionNumbers * kMostRows];
  const std::size_t stride = r.stride();
  std::fill(seen, seen + kMotionNumbers * stride, Real(0));
  std::size_t row = 0;
  const auto add = [&](const BothWrenches& measured, const BothWrenches& impulse) {
    const BothWrenches motion = pair.response_to(impulse);
    const Vec3 m[4] = {measured.a.force, measured.a.torque, measured.b.force, measured.b.torque};
    const Vec3 c[4] = {motion.a.force, motion.a.torque, motion.b.force, motion.b.torque};
    for (int k = 0; k < 12; ++k) {
      seen[static_cast<std::size_t>(k) * stride + row] = m[k / 3][k % 3];
      caused[row * kMotionNumbers + static_cast<std::size_t>(k)] = c[k / 3][k % 3];
    }
    ++row;
  };
  for (std::size_t i = 0; i < r.points; ++i) {
    const GroupContact& c = *r.contacts[i];
    for (const Vec3& axis : c.axes) add(opposed(leads_of(c), axis), opposed(arms_of(c), axis));
  }
  if (r.rolling)
    for (const Vec3& axis : r.rolling->axes) add(opposed(axis), opposed(axis));
  kernels().multiply_motions({r.rows, stride, seen, caused}, to);
}

/// The contact's own responses, from its block of those of its pair.
void set_responses(GroupContact& c, const Real* own, std::size_t stride) {
  c.along = own[0], c.cross_first = own[1], c.cross_second = own[2];
  c.aside = larger_response(own + stride + 1, stride);
}

PairPoint point_of(const GroupContact& c, const Goal& goal) {
  PANTIN_ASSERT(c.along > 0 && c.aside > 0);
  PairPoint p{};
  for (int k = 0; k < 3; ++k) p.impulse[k] = c.impulse[k];
  p.speed = goal.speed, p.parted = goal.parted;
  p.kept = 1 - goal.spring.by_impulse, p.gain = goal.spring.by_mass / c.along;
  p.along = c.along, p.per_aside = 1 / c.aside;
  p.cross[0] = c.cross_first, p.cross[1] = c.cross_second;
  p.friction = c.friction;
  return p;
}

Vec3 impulse_of(const PairPoint& p) { return {p.impulse[0], p.impulse[1], p.impulse[2]}; }

/// Relative velocity along the axes of a contact, surface velocity included.
void set_speeds(const Pair& pair, const GroupContact& c, Real* speeds) {
  const Vec3 u = pair.speed_of(leads_of(c));
  speeds[0] = glm::dot(c.axes[0], u);
  speeds[1] = glm::dot(c.axes[1], u) + c.surface_first;
  speeds[2] = glm::dot(c.axes[2], u) + c.surface_second;
}

/// Solves the torque of rolling friction. Returns the change of speed, m/s.
Real roll(const Group& g, const PairRows& r, const PairIteration& of) {
  for (std::size_t i = 0; i < r.points; ++i) r.contacts[i]->impulse.x = of.at[i].impulse[0];
  const std::size_t first = 3 * r.points;
  const Vec3 change = solve_rolling(g, *r.rolling, of.speeds + first);
  if (change == Vec3(0)) return 0;
  for (int k = 0; k < 3; ++k) {
    const Real* const by = of.responses + (first + static_cast<std::size_t>(k)) * of.stride;
    for (std::size_t row = 0; row < of.stride; ++row) of.speeds[row] += change[k] * by[row];
  }
  return speed_of(g, *r.rolling, change);
}

/// Iterates the impulses of a pair. Returns the largest change of speed, m/s.
Real solve_pair(const Group& g, const GroupPair& p, const Substep& s, Sweep sweep) {
  if (p.working == 0) return 0;
  const PairRows r = rows_of(g, p);
  const PairOf both = pair_of(*r.contacts[0]);
  Pair pair = begin_pair(g, both);
  PairPoint at[kMostPoints];
  Real speeds[kMostStride];
  std::fill(speeds, speeds + r.stride(), Real(0));
  Vec3 before[kMostPoints], rolled(0);
  for (std::size_t i = 0; i < r.points; ++i) {
    const GroupContact& c = *r.contacts[i];
    at[i] = point_of(c, goal_of(c, spring_of(g, c, s), s, sweep));
    set_speeds(pair, c, speeds + 3 * i), before[i] = c.impulse;
  }
  if (r.rolling) {
    rolled = r.rolling->impulse;
    for (std::size_t k = 0; k < 3; ++k)
      speeds[3 * r.points + k] = glm::dot(r.rolling->axes[k], pair.a.spin - pair.b.spin);
  }
  const bool converges = r.rolling || s.hard || g.trees.empty();
  const int iterations = r.points > 1 || r.rolling ? kPointIterations : 1;
  Real most = 0, first = 0;
  PairIteration of{r.points, r.stride(), false, at, g.numbers.data() + p.responses, speeds};
  for (int n = 0; n < iterations; ++n, of.backwards = !of.backwards) {
    Real now = kernels().iterate_pair(of);
    if (r.rolling) now = std::max(now, roll(g, r, of));
    most = std::max(most, now);
    if (n == 0) first = now;
    if ((s.hard ? now <= s.enough : now == 0) || (converges && now <= kPairTolerance * first))
      break;
  }
  if (most == 0) return 0;
  BothWrenches sum;
  for (std::size_t i = 0; i < r.points; ++i) {
    GroupContact& c = *r.contacts[i];
    c.impulse = impulse_of(at[i]);
    sum += opposed(arms_of(c), to_world(c, c.impulse - before[i]));
  }
  if (r.rolling) sum += opposed(to_world(*r.rolling, r.rolling->impulse - rolled));
  pair.push(sum);
  end_pair(g, both, pair);
  return most;
}

/// m/s: approach of the fixed body of an active contact, plus the separating speed of an overlap.
Real asked_speed(const Group& g, const GroupContact& c, const Substep& s) {
  const GroupBody& b = g.b(c);
  const Real comes = glm::dot(c.axes[0], speed_at(b, c.arm_b));
  return comes + (c.gap < -c.shallow ? push_speed(c, s) : 0);
}

}  // namespace

Goal goal_of(const GroupContact& c, const Softness& spring, const Substep& s, Sweep sweep) {
  const Real meets = -c.gap / s.reach;
  if (sweep == Sweep::relaxes) return {0, s.hard || c.gap <= c.rest ? 0 : meets, {}};
  if (c.gap > c.rest) return {meets, meets, {}};
  const Real speed =
      s.hard ? push_speed(c, s) : std::min(spring.rate * (c.rest - c.gap), kPushSpeed);
  return {speed, speed, s.hard ? Softness{} : spring};
}

Real closing_speed_of_walls(const Group& g, const Substep& s) {
  const auto bears = [&](const GroupContact& c) { return c.impulse.x > 0 && g.is_fixed(c); };
  Real closing = 0;
  for (const GroupContact& c : g.contacts)
    for (const GroupContact& d : g.contacts)
      if (bears(c) && bears(d) && glm::dot(c.axes[0], d.axes[0]) < 0)
        closing = std::max(closing, asked_speed(g, c, s) + asked_speed(g, d, s));
  return closing;
}

bool is_jammed(const Group& g, const Substep& s, Real change) {
  const Real closing = closing_speed_of_walls(g, s);
  return closing > 0 && change > kJammed * closing;
}

void centre_bodies(const Group& g) {
  for (GroupBody& b : g.bodies)
    if (b.node == kNoNode) b.centre = b.pose.position;
}

void push(const Group& g, const GroupContact& c) {
  Pair pair = begin_pair(g, pair_of(c));
  pair.push(opposed(arms_of(c), to_world(c, c.impulse)));
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
  bool jumps = false;
  const auto led = [&](const GroupBody& body, const contact::TouchedPlace& on, Vec3 arm,
                       Vec3 outward) {
    const Quat turn = from_rotation_vector(0.5 * h * body.spin);
    const Vec3 at = on.at(turn * body.pose.rotation, outward);
    const Vec3 round = at - arm, fixed = at - turn * arm;  // on a round shape; of a corner
    const Real way2 = std::min(glm::dot(round, round), glm::dot(fixed, fixed));
    jumps = jumps || way2 > kFarLed * kFarLed * glm::dot(arm, arm);
    return at;
  };
  const Vec3 on_a = led(g.a(c), c.on_a, c.arm_a, -c.axes[0]),
             on_b = led(g.b(c), c.on_b, c.arm_b, c.axes[0]);
  if (!jumps) c.lead_a = on_a, c.lead_b = on_b;
}

void prepare_pair(const Group& g, GroupPair& p) {
  const PairOf both = pair_of(g.contacts[p.first]);
  const Pair pair{
      {g, both.a}, {g, both.b}, both.cross == kNoNode ? nullptr : &g.crosses[both.cross]};
  // Joints may leave a pair of bodies hardly any response: the contact is then inactive.
  const Real loose = kLeastResponse * (pair.a.body.per_mass + pair.b.body.per_mass);
  Real* const responses = g.numbers.data() + p.responses;
  for (bool again = true; again;) {
    again = false;
    const PairRows r = rows_of(g, p);
    p.working = static_cast<std::uint32_t>(r.points);
    if (r.points == 0) return;
    const std::size_t stride = r.stride();
    write_responses(pair, r, responses);
    for (std::size_t i = 0; i < r.points; ++i) {
      GroupContact& c = *r.contacts[i];
      set_responses(c, responses + 3 * i * (stride + 1), stride);
      if (c.along > loose && c.aside > loose) continue;
      c.works = false, c.impulse = Vec3(0), again = true;
    }
    const std::size_t last = 3 * r.points * (stride + 1);
    if (r.rolling) prepare_rolling(*r.rolling, {responses + last, stride});
  }
}

void Blow::add(GroupContact& c, Real speed) {
  PANTIN_ASSERT(count_ < kMostPoints);
  points_[count_++] = {&c, speed, Vec3(0)};
}

namespace {

/// The share of an impact's impulses that adds no energy. Friction may turn the slip around, and
/// would then do work until Newton's law of restitution is met. [Stronge 1990]
Real dissipative_share(const PairIteration& after, const Real* before) {
  Real work = 0, by_friction = 0, at_first = 0;  // twice the works
  for (std::size_t row = 0; row < 3 * after.points; ++row) {
    const Real impulse = after.at[row / 3].impulse[row % 3];
    const Real twice = impulse * (before[row] + after.speeds[row]);
    work += twice, at_first += 2 * impulse * before[row];
    if (row % 3 > 0) by_friction += twice;
  }
  if (!(by_friction > 0) || !(work > 0) || !(at_first < 0)) return 1;
  return at_first / (at_first - work);
}

}  // namespace

void Blow::solve(const Pair& pair, int& left) {
  GroupContact at_once[kMostPoints];
  PairRows r;
  for (const BlowPoint& p : points()) {
    GroupContact& c = at_once[r.points] = *p.contact;
    c.impulse = Vec3(0), c.lead_a = c.arm_a, c.lead_b = c.arm_b;
    r.contacts[r.points++] = &c;
  }
  r.rows = 3 * r.points;
  Real responses[most_responses(kMostRows)], speeds[kMostStride] = {};
  PairPoint at[kMostPoints];
  write_responses(pair, r, responses);
  for (std::size_t i = 0; i < r.points; ++i) {
    set_responses(at_once[i], responses + 3 * i * (r.stride() + 1), r.stride());
    set_speeds(pair, at_once[i], speeds + 3 * i);
    at[i] = point_of(at_once[i], {points_[i].speed, points_[i].speed, {}});
  }
  Real before[kMostStride];
  std::copy(speeds, speeds + r.stride(), before);
  PairIteration of{r.points, r.stride(), false, at, responses, speeds};
  Real first = 0;
  const int most =
      r.points > 1 ? std::clamp(left, kStrikeIterations, kBlowIterations) : kStrikeIterations;
  for (int n = 0; n < most; ++n, --left) {
    const Real now = kernels().iterate_pair(of);
    if (n == 0) first = now;
    if (now <= kStruckEnough * first) break;
    of.backwards = r.points > 1 && !of.backwards;
  }
  const Real share = dissipative_share(of, before);
  for (std::size_t i = 0; i < r.points; ++i) points_[i].impulse = share * impulse_of(at[i]);
}

Real sweep_contacts(const Group& g, const Substep& s, Sweep sweep, Order order) {
  const bool lanes = !s.hard && !g.laned.empty();
  Real most = lanes && order == Order::forwards ? sweep_lanes(g, s, sweep, order) : 0;
  const std::size_t n = g.pairs.size();
  for (std::size_t i = 0; i < n; ++i) {
    const GroupPair& p = g.pairs[order == Order::forwards ? i : n - 1 - i];
    if (!lanes || !p.in_lanes) most = std::max(most, solve_pair(g, p, s, sweep));
  }
  if (lanes && order == Order::backwards) most = std::max(most, sweep_lanes(g, s, sweep, order));
  return most;
}

}  // namespace pantin::detail::articulated
