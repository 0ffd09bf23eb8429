// Spring pins and cables of islands in contact: impulses iterated with the contacts.
#include "engine/solvers/articulated/impulses/group_ties.hpp"

#include <algorithm>

#include "engine/solvers/articulated/impulses/group_pair.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// m/s: the fastest closing velocity of a gap.
constexpr Real kFastestReturn = 4;

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

/// Fraction of its length by which a cable is slack at least.
constexpr Real kSlack = 1e-6;
/// m/s: bodies that approach faster are struck, cables whose ends separate faster.
constexpr Real kSudden = 0.02;
/// A part of the way over a substep may be across a cable, as a fraction of its length: above that
/// the substep does not resolve the cable's rotation.
constexpr Real kMostAcross = 0.5;

/// Whether a body moves by the mean of its velocities before and after a substep.
bool flies(const GroupBody& b) { return b.node == kNoNode && b.per_mass > 0 && !b.touched; }

/// The motion of a cable's end relative to the other one in a substep.
struct EndMotion {
  Vec3 velocity;  // m/s, by which it is displaced
  Vec3 bend;      // m: by how much the bodies' rotations bend its path
  Real along;     // 1/kg: response of that velocity
};
EndMotion motion_of(const Pair& pair, const GroupTie& t, Real h) {
  const auto bend = [](Vec3 spin, Vec3 arm) { return glm::cross(spin, glm::cross(spin, arm)); };
  EndMotion end{-pair.speed_of(arms_of(t)),
                0.5 * h * h * (bend(pair.b.spin, t.arm_b) - bend(pair.a.spin, t.arm_a)), t.along};
  if (flies(pair.a.body))
    end.velocity += 0.5 * (pair.a.velocity - pair.a.body.before),
        end.along -= 0.5 * pair.a.body.per_mass;
  if (flies(pair.b.body))
    end.velocity -= 0.5 * (pair.b.velocity - pair.b.body.before),
        end.along -= 0.5 * pair.b.body.per_mass;
  return end;
}

/// m/s: the fastest rate at which an inextensible cable may stretch, so that it is not longer than
/// `within` after the substep. A taut cable's end moves along the chord of its arc, not along the
/// tangent: so it neither gains nor loses energy as it swings (SHAKE).
/// [Ryckaert, Ciccotti & Berendsen 1977]
Real fastest_stretch(const GroupTie& t, const EndMotion& end, Real h, Real within) {
  const Vec3 n = direction_of(t);
  const Vec3 way = h * end.velocity + end.bend, across = way - glm::dot(n, way) * n;
  const Real most = kMostAcross * within;
  const Real aside = std::min(glm::dot(across, across), most * most);
  return (std::sqrt(within * within - aside) - glm::length(t.apart) - glm::dot(n, end.bend)) / h;
}

/// The tension impulse that an inextensible cable lacks. A slack cable may stretch by its slack in
/// the substep; one that is too long is shortened by the fraction `part` of that. After the motion
/// its end keeps its distance (RATTLE). [Andersen 1983]
Real lacking(const GroupTie& t, const Pair& pair, Real h, Real part) {
  const Real span = glm::length(t.apart), stretch = span - t.length;
  const Vec3 n = direction_of(t);
  if (t.has_moved) {
    const Real most = stretch < -kSlack * t.length ? -stretch / h : 0;
    return (-glm::dot(n, pair.speed_of(arms_of(t))) - most) / t.along;
  }
  const EndMotion end = motion_of(pair, t, h);
  const Real back = std::min(part * std::max(Real(0), stretch), h * kFastestReturn);
  const Real most = fastest_stretch(t, end, h, stretch < 0 ? t.length : span - back);
  // Along the chord the end returns no faster than it would part: else that adds energy.
  const bool swings = end.along < t.along;
  const Real least = swings ? most : std::max(most, -t.parting - back / h);
  return (glm::dot(n, end.velocity) - least) / end.along;
}

/// The change of a cable's tension impulse.
Real solve_cable(GroupTie& t, const Pair& pair, Real h, Real part) {
  PANTIN_ASSERT(t.kind == GroupTie::Kind::cable && t.along > 0);
  Real more = 0;
  if (t.stiffness > 0) {
    const Real speed = -glm::dot(direction_of(t), pair.speed_of(arms_of(t)));
    const Real stretch = glm::length(t.apart) - t.length;
    const Real soft = stiffness_of(t, h);
    more = (h * t.stiffness * stretch + soft * speed - t.impulse.x) / (1 + soft * t.along);
  } else {
    more = lacking(t, pair, h, part);
  }
  const Real before = t.impulse.x;
  t.impulse.x = std::max(Real(0), before + more);
  return t.impulse.x - before;
}

/// m/s: velocity of a body's point; of a free body, as it was before the substep.
Vec3 speed_before(const GroupBody& b, Vec3 arm) {
  const bool moves = b.node == kNoNode && b.per_mass > 0;
  return (moves ? b.before : b.velocity) + glm::cross(b.spin, arm);
}

/// Whether both ends of an inextensible cable are on free or fixed bodies.
bool connects_free(const Group& g, const GroupTie& t) {
  return is_inextensible(t) && g.bodies[t.a].node == kNoNode && g.bodies[t.b].node == kNoNode;
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
  t.has_moved = false;
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
  Vec3 change(0);
  if (t.kind == GroupTie::Kind::cable) {
    if (!(t.along > 0)) return 0;
    change = -solve_cable(t, pair, h, part) * direction_of(t);
  } else {
    const Vec3 speed = -pair.speed_of(arms_of(t));  // of b relative to a
    change = -t.inverse * (t.impulse + h * t.stiffness * t.apart + stiffness_of(t, h) * speed);
    t.impulse += change;
  }
  if (change == Vec3(0)) return 0;
  pair.push(opposed(arms_of(t), -change));
  end_pair(g, pair_of(t), pair);
  return glm::length(t.response * change);
}

void begin_cables(const Group& g, Real h) {
  for (GroupTie& t : g.ties) {
    if (!is_inextensible(t)) continue;
    const Pair pair = begin_pair(g, pair_of(t));
    t.parting = std::max(Real(0), -glm::dot(direction_of(t), pair.speed_of(arms_of(t))));
  }
  for (const GroupContact& c : g.contacts) {
    const Real closing =
        -glm::dot(c.axes[0], speed_before(g.a(c), c.arm_a) - speed_before(g.b(c), c.arm_b));
    if (c.works && closing > kSudden && c.gap < h * closing) g.a(c).touched = g.b(c).touched = true;
  }
  for (const GroupTie& t : g.ties) {
    if (!connects_free(g, t)) continue;
    GroupBody &a = g.bodies[t.a], &b = g.bodies[t.b];
    const Vec3 now = speed_at(b, t.arm_b) - speed_at(a, t.arm_a),
               before = speed_before(b, t.arm_b) - speed_before(a, t.arm_a);
    const bool is_slack = glm::length(t.apart) < (1 - kSlack) * t.length;
    const bool strikes = is_slack ? glm::length(t.apart + h * now) > t.length
                                  : glm::dot(direction_of(t), before) > kSudden;
    if (strikes) a.touched = b.touched = true;
  }
}

void touch_by_impulses(const Group& g) {
  for (const GroupContact& c : g.contacts) {
    if (!(c.impulse.x > 0)) continue;
    GroupBody &a = g.a(c), &b = g.b(c);
    const Vec3 change = speed_at(a, c.arm_a) - speed_before(a, c.arm_a) - speed_at(b, c.arm_b) +
                        speed_before(b, c.arm_b);
    const bool strikes = glm::dot(c.axes[0], change) > kSudden;
    for (GroupBody* body : {&a, &b})
      body->touched = body->touched || strikes || body->node != kNoNode;
  }
  for (const GroupTie& t : g.ties)
    if (is_taut(t) && !connects_free(g, t)) g.bodies[t.a].touched = g.bodies[t.b].touched = true;
}

void follow_cables(const Group& g) {
  for (GroupTie& t : g.ties) {
    if (!connects_free(g, t)) continue;
    const GroupBody &a = g.bodies[t.a], &b = g.bodies[t.b];
    const auto swings = [](const GroupBody& body) { return body.per_mass == 0 || flies(body); };
    if (is_taut(t) && swings(a) && swings(b)) {  // the other half acts at the end
      t.impulse.x *= -0.5;
      push_tie(g, t);
      t.impulse.x *= -1;
    }
    t.arm_a = a.pose.rotation * t.anchor_a, t.arm_b = b.pose.rotation * t.anchor_b;
    t.apart = b.pose.position + t.arm_b - a.pose.position - t.arm_a;
    const Vec3 n = direction_of(t);
    t.along = glm::dot(n, t.response * n), t.has_moved = true;
  }
}

}  // namespace pantin::detail::articulated
