// Groups at rest, solved as a whole in one step.
//
// The velocities v at the end of the step are those at which
//   1/2 (v - v*)^T M (v - v*) + 1/2 sum over points of R |p|^2
// is least, with v* those without contacts. The impulse p of a point is (goal - J v) / R, projected
// to Coulomb's cone. Joints, limits and cables are points of such a kind (group_rest_links.cpp).
// The compliance R is so small that loads leave no visible overlap. Newton's method uses a factor
// of M + J^T G J, whose blocks are pairs of bodies that touch or are joined: a tower's is banded.
// Groups at rest take at most one iteration, whatever their weight. [Castro, Permenter & Han 2022]
//
// The convex problem would lift sliding bodies: points separate at the sliding speed times the
// friction. The goals are corrected by that, until it agrees with the sliding found; then Coulomb's
// law holds. [Acary & Cadoux 2013] Where a body moves fast, or the search does not converge,
// nothing is done here, and sweeps follow (step_group.cpp).
#include <algorithm>
#include <limits>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/solvers/articulated/impulses/group_resting.hpp"
#include "engine/solvers/articulated/impulses/rest_cones.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Sizes of a body: contacts that slide farther in a step than this are left to substeps.
constexpr Real kSlides = 2e-3;
/// m/s: bodies that glide strike others if points close faster.
constexpr Real kStrikes = 0.1;
/// Corrections of lifts, at most, in short steps and in others; their tolerance, and that of the
/// last one, as fractions of the speed that weight gives in a step, or of the sliding.
constexpr int kLiftings = 12, kFewLiftings = 3;
constexpr Real kLifted = 1e-5, kNearlyLifted = 1e-3, kLiftedOfSliding = 1e-3;
/// Largest closing speed under load, as a fraction of the speed that weight gives in a step; points
/// that exceed it are made stiffer, so many times at most.
constexpr Real kSinks = 1e-5;
constexpr int kHardenings = 8;
/// Multiples of a shallow overlap: deeper ones are left to sweeps, which separate them faster.
constexpr Real kDeep = 2;
/// Largest speed that closes an overlap, sizes of a body per second; overlap that stays, in sizes
/// of a body, and the largest that stays between bodies with joints.
constexpr Real kCloses = 1e-2, kSunk = 1e-6, kSunkJoined = 0.05;
/// Margin of the predicted active set, as a fraction of the speed that weight gives in a step.
constexpr Real kMayPress = 0.1;
/// Newton iterations in a step, and in a short one.
constexpr int kMostOfStep = 120, kMostOfPart = 80;
constexpr int kFirstIterations = 2, kSwingIterations = 12, kSearchSteps = 40;
/// Continuation: multiples of the compliance, and iterations with each.
constexpr std::pair<Real, int> kSofter[] = {{1e4, 20}, {1e3, 20}, {1e2, 20}, {1e1, 20}, {1, 40}};
/// Tolerance of the residual, as a fraction of the fastest speed without contacts, which counts as
/// kLeastSpeed (m/s) at least; kNearly times that where rounding stops progress; kRoughly with soft
/// points. With soft points, a larger residual than kHopeless means that the search would not
/// converge.
constexpr Real kBalanced = 1e-9, kRoughly = 1e-2, kNearly = 100, kLeastSpeed = 1e-6,
               kHopeless = 1e-2;
/// Tolerance of a line search, as a fraction of its initial slope.
constexpr Real kSearched = 1e-3;

/// m/s^2: the largest acceleration of a body by weight and applied force.
Real weight_of(const Group& g) {
  Real most = 0;
  for (const GroupBody& b : g.bodies) most = std::max(most, glm::length(b.acceleration));
  return most;
}

/// m/s: velocity of a's point relative to b's, along the axes.
Vec3 speed_of(const Group& g, const GroupContact& c, Wrench RestBody::*motion) {
  const Wrench a = motion_of(g, c.a, motion), b = motion_of(g, c.b, motion);
  return contact::along_axes(
      c.axes, a.force + glm::cross(a.torque, c.arm_a) - b.force - glm::cross(b.torque, c.arm_b));
}

using At = ConeImpulse::At;

/// Inertia about the mass centre, world axes.
Mat3 inertia_of(const GroupBody& b) {
  const Mat3 r = glm::mat3_cast(b.pose.rotation);
  const Vec3 i = Real(1) / b.per_inertia;
  return Mat3(i.x * r[0], i.y * r[1], i.z * r[2]) * glm::transpose(r);
}

/// Momentum and angular momentum of a motion.
Wrench momentum_of(const GroupBody& b, const RestBody& r, const Wrench& motion) {
  return {motion.force / b.per_mass, r.inertia * motion.torque};
}

void begin_bodies(const Group& g, Real h) {
  for (GroupBody& b : g.bodies) b.centre = b.pose.position;
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    GroupBody& b = g.bodies[i];
    RestBody& r = g.resting[i];
    if (b.node != kNoNode) b.response = inverse_inertia(b, b.pose.rotation);
    r.touches = b.node == kNoNode;
    const Real kept = std::exp(-0.5 * h * b.drag);
    r.inertia = inertia_of(b);
    r.free.force = kept * b.velocity + h * b.acceleration;
    r.free.torque = b.response * (kept * b.angular_momentum + h * b.torque);
  }
}

/// m/s, without contacts and joints: an arm may swing, and bodies glide towards others.
Real closing_speed(const Group& g, const GroupContact& c) {
  return std::max(-speed_of(g, c, &RestBody::free).x, -speed_of(g, c, &RestBody::motion).x);
}

/// Whether one of the bodies has joints. Shallow overlaps of such bodies stay: joints could not
/// follow if each point were separated at its own speed.
bool is_joined(const Group& g, const GroupContact& c) {
  const auto has_joints = [&](const GroupBody& b) {
    return b.node != kNoNode && g.trees[g.nodes[b.node].tree].count > 1;
  };
  return has_joints(g.a(c)) || has_joints(g.b(c));
}

/// m/s: at which the convex problem separates a contact that does not hold, at this speed.
Real lift_of(const GroupContact& c, const RestContact& r, Vec3 speed) {
  return c.friction * std::hypot(speed.y - r.goal.y, speed.z - r.goal.z);
}

/// Whether a contact bore and did not slide in the last step.
bool holds(const GroupContact& c) {
  const Real most = kOnCone * c.friction * c.impulse.x;
  return c.impulse.y * c.impulse.y + c.impulse.z * c.impulse.z < most * most;
}

/// Contacts that may act in the step. False if an overlap is so deep that sweeps must separate it,
/// or bodies that glide strike others, or bounce.
bool begin_contacts(const Group& g, const GroupPart& part) {
  const Real h = part.h;
  const Real weight = weight_of(g);
  const bool glides = may_glide_for(g, h);
  for (std::size_t i = 0; i < g.contacts.size(); ++i) {
    GroupContact& c = g.contacts[i];
    RestContact& r = g.rest_contacts[i];
    place(g, c);
    const Real closes = closing_speed(g, c);
    r.near = c.gap < 2 * h * std::max(kRestSpeed, closes);
    if (!r.near) continue;
    const Real comes = -speed_of(g, c, &RestBody::motion).x;
    if ((glides && comes > kStrikes) || (c.restitution > 0 && comes > kLeastBlow)) return false;
    g.resting[c.a].touches = true;
    if (c.b < g.resting.size()) g.resting[c.b].touches = true;
    if (c.gap < -kDeep * c.shallow) return false;
    Pair pair{{g, c.a}, {g, c.b}, nullptr};
    pair.a.response = pair.b.response = nullptr;  // without joints
    Real response = 0;
    for (const Vec3& axis : c.axes)
      response += glm::dot(axis, response_of(pair, arms_of(c), axis)) / 3;
    r.compliance = kRestCompliance * response;
    const Real size = size_of(g.a(c));
    const Real stays = is_joined(g, c) ? std::min(c.shallow, kSunkJoined * size) : kSunk * size;
    const Real deep = std::max(Real(0), -c.gap - stays);
    r.goal.x = c.gap > 0 ? -c.gap / h : std::min(kRestClosed * deep / h, kCloses * size);
    r.may_press = speed_of(g, c, &RestBody::free).x < r.goal.x + kMayPress * h * weight;
    r.goal.y = -c.surface_first, r.goal.z = -c.surface_second;
    r.lift = holds(c) ? 0 : lift_of(c, r, speed_of(g, c, &RestBody::motion));
    r.goal.x -= r.lift;
  }
  begin_links(g, part, kRestSpeed);
  predict_links(g, kMayPress * h * weight);
  return true;
}

/// Computes the impulses, and the residuals of momentum with them. Returns the largest as a speed
/// of a body, m/s.
Real measure(const Group& g, Acting acting = Acting::now) {
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    RestBody& r = g.resting[i];
    const Wrench now = momentum_of(g.bodies[i], r, r.motion),
                 free = momentum_of(g.bodies[i], r, r.free);
    r.residual = {now.force - free.force, now.torque - free.torque};
  }
  for (std::size_t i = 0; i < g.contacts.size(); ++i) {
    const GroupContact& c = g.contacts[i];
    RestContact& r = g.rest_contacts[i];
    if (!r.near) continue;
    r.speed = speed_of(g, c, &RestBody::motion);
    r.cone =
        acting == Acting::now
            ? cone_of(r, c.friction, r.speed)
            : cone_as_with(r, c.friction, acting == Acting::as_before ? c.impulse : r.cone.impulse);
    const Vec3 p = to_world(c, r.cone.impulse);
    g.resting[c.a].residual += {-p, -glm::cross(c.arm_a, p)};
    if (c.b < g.resting.size()) g.resting[c.b].residual += {p, glm::cross(c.arm_b, p)};
  }
  add_link_impulses(g, acting);
  Real most = 0;
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    const GroupBody& b = g.bodies[i];
    const Wrench& left = g.resting[i].residual;
    most = std::max({most, b.per_mass * glm::length(left.force),
                     size_of(b) * glm::length(b.response * left.torque)});
  }
  return most;
}

/// block += [X Y; Z W] by rows, each of three.
void add_block(Real* block, const Mat3 (&parts)[2][2]) {
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      block[i * kEnvelopeWide + j] +=
          parts[i / 3][j / 3][static_cast<int>(j % 3)][static_cast<int>(i % 3)];
}

/// One side of a contact: the row of its body, and its arm.
struct End {
  std::size_t row;
  Mat3 arm;  // as a cross product
};

/// Adds J^T K J of two sides.
void add_contact(const BlockEnvelope& e, const Mat3& k, const End& a, const End& b) {
  if (a.row < b.row) return add_contact(e, k, b, a);
  const Mat3 moment = b.arm * k;
  add_block(e.block(a.row, b.row), {{k, -k * a.arm}, {moment, -moment * a.arm}});
}

BlockEnvelope envelope_of(const Group& g) {
  const std::size_t n = g.resting.size();
  return {g.rest_rows, g.numbers.subspan(kEnvelopeWide * n)};
}

void assemble(const Group& g, const BlockEnvelope& e) {
  std::fill(e.numbers.begin(), e.numbers.end(), Real(0));
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    const RestBody& r = g.resting[i];
    add_block(e.block(r.row, r.row),
              {{Mat3(1 / g.bodies[i].per_mass), Mat3(0)}, {Mat3(0), r.inertia}});
  }
  for (std::size_t i = 0; i < g.contacts.size(); ++i) {
    const GroupContact& c = g.contacts[i];
    RestContact& r = g.rest_contacts[i];
    if (!r.near) continue;
    const bool acts = r.cone.at != At::apex;
    if (!acts && !r.presses) continue;
    r.presses = false;
    const Mat3 axes(c.axes[0], c.axes[1], c.axes[2]);
    const Mat3 stiffness = acts ? stiffness_of(r, c.friction) : Mat3(1 / r.compliance);
    const Mat3 k = axes * stiffness * glm::transpose(axes);
    const End a{g.resting[c.a].row, cross_matrix(c.arm_a)};
    add_contact(e, k, a, a);
    if (c.b >= g.resting.size()) continue;
    const End b{g.resting[c.b].row, cross_matrix(c.arm_b)};
    add_contact(e, k, b, b);
    add_contact(e, -k, a, b);
  }
  add_link_blocks(g, e);
}

/// Newton's direction. False if the factorisation fails.
bool find_direction(const Group& g) {
  const BlockEnvelope e = envelope_of(g);
  assemble(g, e);
  if (!e.factor()) return false;
  const std::span<Real> x = g.numbers.first(kEnvelopeWide * g.resting.size());
  for (const RestBody& r : g.resting)
    for (int k = 0; k < 3; ++k) {
      x[kEnvelopeWide * r.row + static_cast<std::size_t>(k)] = -r.residual.force[k];
      x[kEnvelopeWide * r.row + 3 + static_cast<std::size_t>(k)] = -r.residual.torque[k];
    }
  e.solve(x);
  for (RestBody& r : g.resting)
    for (int k = 0; k < 3; ++k) {
      r.direction.force[k] = x[kEnvelopeWide * r.row + static_cast<std::size_t>(k)];
      r.direction.torque[k] = x[kEnvelopeWide * r.row + 3 + static_cast<std::size_t>(k)];
    }
  return true;
}

/// Derivative of the objective along the direction; it increases, since the objective is convex.
struct Slope {
  const Group& g;
  Real first = 0, second = 0;  // of the bodies: first + part * second

  explicit Slope(const Group& all) : g(all) {
    for (std::size_t i = 0; i < g.resting.size(); ++i) {
      const RestBody& r = g.resting[i];
      const Wrench way = momentum_of(g.bodies[i], r, r.direction);
      first += glm::dot(way.force, r.motion.force - r.free.force) +
               glm::dot(way.torque, r.motion.torque - r.free.torque);
      second += glm::dot(way.force, r.direction.force) + glm::dot(way.torque, r.direction.torque);
    }
    for (std::size_t i = 0; i < g.contacts.size(); ++i)
      if (g.rest_contacts[i].near)
        g.rest_contacts[i].change = speed_of(g, g.contacts[i], &RestBody::direction);
    aim_links(g);
  }
  Real at(Real part) const {
    Real sum = first + part * second;
    for (std::size_t i = 0; i < g.contacts.size(); ++i) {
      const RestContact& r = g.rest_contacts[i];
      if (!r.near) continue;
      const ConeImpulse cone = cone_of(r, g.contacts[i].friction, r.speed + part * r.change);
      sum -= glm::dot(cone.impulse, r.change);
    }
    return sum + slope_of_links(g, part);
  }
};

/// Line search: the fraction of the direction at which the objective is least, at most 1.
Real search(const Group& g) {
  const Slope slope(g);
  const Real start = slope.at(0), enough = kSearched * std::abs(start);
  Real low = 0, high = 1, at_low = start, at_high = slope.at(1);
  if (at_high <= enough) return 1;
  for (int n = 0; n < kSearchSteps; ++n) {
    // Regula falsi, with a bisection every third time.
    const Real guess = low - at_low * (high - low) / (at_high - at_low);
    const Real part = n % 3 == 2 ? 0.5 * (low + high) : guess;
    const Real now = slope.at(part);
    if (std::abs(now) <= enough) return part;
    if (now < 0)
      low = part, at_low = now;
    else
      high = part, at_high = now;
  }
  return low;
}

/// Starts from the velocities of the last step, with the predicted active set.
void start(const Group& g) {
  for (std::size_t i = 0; i < g.resting.size(); ++i)
    g.resting[i].motion = {g.bodies[i].velocity, g.bodies[i].spin};
  for (RestContact& r : g.rest_contacts) r.presses = r.may_press;
  for (RestLink& l : g.rest_links) l.presses = l.may_press;
}

void advance(const Group& g, Real part) {
  for (RestBody& r : g.resting)
    r.motion.force += part * r.direction.force, r.motion.torque += part * r.direction.torque;
}

/// Moves on to the velocities at which every contact acts as in the last step. Whether there is one
/// that acted.
bool resume(const Group& g) {
  for (RestContact& r : g.rest_contacts) r.presses = false;
  for (RestLink& l : g.rest_links) l.presses = false;
  measure(g, Acting::as_before);
  const bool any =
      std::any_of(g.rest_contacts.begin(), g.rest_contacts.end(),
                  [](const RestContact& r) { return r.near && r.cone.at != At::apex; });
  if (!any || !find_direction(g)) return false;
  advance(g, 1);
  return true;
}

/// A search: the fastest speed without contacts, m/s, and the iterations that are left.
struct Search {
  Real fastest;
  int left;
};

/// Newton's method until no residual exceeds `enough`, m/s, or kNearly times that where rounding
/// stops progress.
bool iterate(const Group& g, Real enough, int most, Search& s) {
  Real before = std::numeric_limits<Real>::infinity();
  for (int n = 0;; ++n, --s.left) {
    const Real left = measure(g);
    const bool nearly = left <= kNearly * enough;
    if (left <= enough || (nearly && left > 0.5 * before)) return true;
    if (n == most || s.left <= 0 || !find_direction(g)) return nearly;
    const Real part = search(g);
    advance(g, part);
    before = left;
  }
}

/// Calls `visit(contact, lift)` for the contacts of the problem, with the lifts of the sliding
/// found.
template <class Visit>
void each_lift(const Group& g, const Visit& visit) {
  for (std::size_t i = 0; i < g.contacts.size(); ++i)
    if (RestContact& r = g.rest_contacts[i]; r.near)
      visit(r, r.cone.at == At::inside ? 0 : lift_of(g.contacts[i], r, r.speed));
}

/// m/s: by how much goals are off the lifts of the sliding found, where contacts act.
Real error_of_lifts(const Group& g) {
  Real most = 0;
  each_lift(g, [&](const RestContact& r, Real lift) {
    if (r.cone.at != At::apex)
      most = std::max(most, std::abs(lift - r.lift) - kLiftedOfSliding * lift);
  });
  return most;
}

/// Moves on to the velocities with these goals at which every contact acts as found.
bool follow_lifts(const Group& g) {
  measure(g, Acting::as_found);
  if (!find_direction(g)) return false;
  advance(g, 1);
  return true;
}

/// Continuation from far larger compliances, where the distribution of loads is found first.
bool iterate_softer(const Group& g, Search& s) {
  start(g);
  const auto scale = [&](Real by) {
    for (RestContact& r : g.rest_contacts) r.compliance *= by;
    for (RestLink& l : g.rest_links) l.compliance *= by;
  };
  for (const auto& [softer, most] : kSofter) {
    scale(softer);
    const bool done = iterate(g, (softer > 1 ? kRoughly : kBalanced) * s.fastest, most, s);
    const bool hopeless = !done && measure(g) > kHopeless * s.fastest;
    scale(1 / softer);
    if (softer == 1) return done;
    if (hopeless) return false;
  }
  return false;
}

/// Solves again with corrected goals until they agree with the sliding found.
bool settle_lifts(const Group& g, Search& s, Real h) {
  const bool glides = may_glide_for(g, h);  // sweeps would be worse
  const Real gained = h * weight_of(g);
  for (int n = 0;; ++n) {
    const Real error = error_of_lifts(g);
    if (error <= kLifted * gained) return true;
    if (n == (glides ? kLiftings : kFewLiftings)) return error <= kNearlyLifted * gained;
    each_lift(g, [](RestContact& r, Real lift) { r.goal.x -= lift - r.lift, r.lift = lift; });
    const bool found = follow_lifts(g) && iterate(g, kBalanced * s.fastest, kSofter[0].second, s);
    if (!found && !(glides && iterate_softer(g, s))) return false;
  }
}

/// Reduces the compliance under heavy loads on light bodies. Whether there are any.
bool harden(const Group& g, Real h) {
  const Real most = kSinks * h * weight_of(g);
  bool any = false;
  for (RestContact& r : g.rest_contacts) {
    const Real sinks = r.compliance * r.cone.impulse.x;
    if (!r.near || !(sinks > most) || most == 0) continue;
    r.compliance *= 0.5 * most / sinks, any = true;
  }
  return harden_links(g, most) || any;
}

/// Whether no contact slides far at the velocities found, unless the step is short.
bool is_at_rest(const Group& g, Real h) {
  if (may_glide_for(g, h)) return true;
  for (std::size_t i = 0; i < g.contacts.size(); ++i) {
    const RestContact& r = g.rest_contacts[i];
    if (!r.near || r.cone.at != At::surface) continue;
    const Vec3 over = r.speed - r.goal;
    const Real most = kSlides / h * size_of(g.a(g.contacts[i]));
    if (over.y * over.y + over.z * over.z > most * most) return false;
  }
  return true;
}

}  // namespace

Rest rest_group(const Group& g, const GroupPart& part) {
  const Real h = part.h;
  if (g.resting.empty()) return Rest::fails;
  PANTIN_ASSERT(g.resting.size() == free_bodies(g.bodies));
  begin_bodies(g, h);
  start(g);
  if (!begin_contacts(g, part)) return Rest::fails;
  if (!are_calm(g, part)) return Rest::moves;
  Real fastest = kLeastSpeed;
  for (const RestBody& r : g.resting) fastest = std::max(fastest, glm::length(r.free.force));
  start(g);
  const Real enough = kBalanced * fastest;
  const int first = h < part.whole ? kSwingIterations : kFirstIterations;
  Search s{fastest, may_glide_for(g, h) ? kMostOfPart : kMostOfStep};
  if (!(resume(g) && iterate(g, enough, first, s))) {
    start(g);
    if (!iterate(g, enough, kFirstIterations, s) && !iterate_softer(g, s)) return Rest::missed;
  }
  for (int n = 0; harden(g, h); ++n)
    if (n == kHardenings || !iterate(g, enough, kSofter[0].second, s)) return Rest::missed;
  if (!settle_lifts(g, s, h)) return Rest::missed;
  if (!is_at_rest(g, h)) return Rest::moves;
  if (!are_calm(g, part)) return Rest::moves;
  set_rest_impulses(g);
  for (GroupContact& c : g.contacts) c.passed += c.impulse;
  for (GroupRolling& r : g.rollings) r.passed += r.impulse;
  move_resting_trees(g, part);
  for (GroupBody& b : g.bodies)
    if (b.per_mass == 0 && b.velocity != Vec3(0)) move(b, b.velocity, h);
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    GroupBody& b = g.bodies[i];
    const RestBody& r = g.resting[i];
    if (b.node != kNoNode) continue;
    b.velocity = r.motion.force, b.spin = r.motion.torque;
    b.angular_momentum = r.inertia * b.spin;
    move(b, b.velocity, h);
    slow_down(b, h);
  }
  if (g.nodes.empty() && part.end == 1)
    for (GroupPair& p : g.pairs) prepare_pair(g, p);  // responses, for take_up
  return Rest::taken;
}

}  // namespace pantin::detail::articulated
