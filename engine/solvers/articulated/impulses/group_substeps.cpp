// Number of substeps of a group, and where impacts divide them.
#include <algorithm>

#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/solvers/articulated/impulses/group_points.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// s: the longest substeps. Trees keep their joints at any length; towers of bodies need shorter
/// substeps.
constexpr Real kLongestSubstep = 1.0 / 470, kLongestTreeSubstep = 1.0 / 235,
               kLongestHardSubstep = 1.0 / 235;
/// m/s: towers beside trees need the shorter ones while they are slower. A body in a tower bears
/// this many times its weight.
constexpr Real kPileSpeed = 0.2, kPile = 4;
/// Bounds on substeps of a step. Trees at few points, whose motion converges with the step, take at
/// least three: so substeps shrink in proportion to steps below 1/60 s.
constexpr int kLeastTreeSubsteps = 2, kLeastAtFewPoints = 3, kMostSubsteps = 32,
              kMostRimSubsteps = 128;
/// rad in a substep, unless that takes too many: rotation of bodies of trees; rotation of a free
/// body that rolls on a rim, and of its contact around the rim.
constexpr Real kLargestTurn = 0.5, kLargestRoll = 0.1;
/// Likewise, of the size: displacement of NURBS shapes past each other.
constexpr Real kLargestSlide = 0.1;
/// rad: a rim rolling further in a step touches at one point, unless it leans less than the second.
constexpr Real kFarAround = 0.5, kFlat = 0.01;
/// Cosine of the angle between normal and axis from which a rim leans.
/// Cosine below which a body lies on its side and rolls as a drum.
constexpr Real kLeaning = 0.7, kLying = 0.02;
/// Relative difference of two moments of inertia below which a body is axially symmetric.
constexpr Real kRound = 1e-6;
/// Hz: contact springs between free bodies; twice that against fixed ones. Damping is far above
/// critical.
constexpr Real kContactFrequency = 60, kDampingRatio = 10;
/// Points that count as few in a step of this length, s; more in shorter steps, in proportion.
constexpr Real kFewPointsOfTrees = 12, kStepOfFewPoints = 1.0 / 240;
/// rad: spring zone before a limit; it shrinks with the substep.
constexpr Real kBuffer = 0.01;
/// An impact within this fraction of either end of a substep does not divide it.
constexpr Real kAtOnce = 1e-3;

Softness softness_of(Real frequency, Real h) {
  const Real omega = 2 * kPi * frequency, a = 2 * kDampingRatio + h * omega, b = h * omega * a;
  return {omega / a, b / (1 + b), 1 / (1 + b)};
}

/// The spin of a body in a net, for slender round bodies without that about the axis: a rod on
/// which bodies slide may rotate far about its axis.
Vec3 turning_of(const GroupBody& b) {
  for (int k = 0; k < 3; ++k) {
    const Real x = b.per_inertia[(k + 1) % 3], y = b.per_inertia[(k + 2) % 3];
    if (std::abs(x - y) > kRound * x || b.per_inertia[k] < x) continue;
    const Vec3 axis = glm::mat3_cast(b.pose.rotation)[k];
    return b.spin - glm::dot(b.spin, axis) * axis;
  }
  return b.spin;
}

/// Whether a leaning rim touches: its contact moves around the rim faster than the body rotates.
bool touches_with_rim(const Group& g, const GroupContact& c) {
  const auto leans = [&](const GroupBody& b, const contact::TouchedPlace& on) {
    return on.circle > 0 && std::abs(glm::dot(b.pose.rotation * on.axis, c.axes[0])) > kLeaning;
  };
  return leans(g.a(c), c.on_a) || leans(g.b(c), c.on_b);
}

/// Rate of a rim's contact around the rim, in the world and on the body, rad/s.
Real rolling_rate(const GroupBody& b, const contact::TouchedPlace& on, Vec3 normal) {
  if (on.circle == 0) return 0;
  const Vec3 axis = b.pose.rotation * on.axis;
  if (std::abs(glm::dot(axis, normal)) < kLying) return 0;
  const Real around = on.rate_around(b.pose.rotation, b.spin, normal);
  return std::max({std::abs(around), glm::length(b.spin),
                   std::abs(around * glm::dot(axis, normal) - glm::dot(b.spin, axis))});
}

/// 1/s: displacements of NURBS shapes by a part of the smaller one, past each other or turning, so
/// that their contact can be followed.
Real sliding_rate(const Group& g) {
  Real rate = 0;
  for (const GroupContact& c : g.contacts) {
    if (c.skins == kNoNode) continue;
    const GroupBody &a = g.a(c), &b = g.b(c);
    const Real of_a = g.skins[c.skins].a->surface->model->size,
               of_b = g.skins[c.skins].b->surface->model->size;
    const Real speed = glm::length(a.velocity - b.velocity) + of_a * glm::length(a.spin) +
                       of_b * glm::length(b.spin);
    rate = std::max(rate, speed / (kLargestSlide * std::min(of_a, of_b)));
  }
  return std::min(rate, Real(1e9));
}

int substeps_of_free(const Group& g, Real h) {
  bool rims = false;
  Real rate = 0;
  for (const GroupContact& c : g.contacts) {
    rims = rims || touches_with_rim(g, c);
    if (!(c.impulse.x > 0) || !g.has_at_most(kFewBodies)) continue;
    rate = std::max(
        {rate, rolling_rate(g.a(c), c.on_a, c.axes[0]), rolling_rate(g.b(c), c.on_b, c.axes[0])});
  }
  const Real longest = g.is_single() && !rims ? kLongestHardSubstep : kLongestSubstep;
  const Real least =
      h * std::max({1 / longest, std::min(rate, Real(1e9)) / kLargestRoll, sliding_rate(g)});
  return std::clamp(static_cast<int>(std::ceil(least)), 1, kMostRimSubsteps);
}

/// Whether a slow body without joints bears a pile of such bodies: a tower beside trees. Between
/// steps impulses are forces.
bool has_towers(const Group& g) {
  const auto is_stacked = [&](const GroupBody& b) {
    return b.per_mass > 0 && !has_joints(g, b) &&
           glm::dot(b.velocity, b.velocity) < kPileSpeed * kPileSpeed;
  };
  const auto weight_of = [](const GroupBody& b) {
    return glm::length(b.acceleration) / b.per_mass;
  };
  for (std::size_t from = 0, to = 0; from < g.contacts.size(); from = to) {
    const GroupBody &a = g.a(g.contacts[from]), &b = g.b(g.contacts[from]);
    Real load = 0;
    for (to = from; to < g.contacts.size() && have_same_bodies(g.contacts[to], g.contacts[from]);
         ++to)
      load += g.contacts[to].impulse.x;
    if (!is_stacked(a) || !is_stacked(b)) continue;
    if (load > kPile * std::max(weight_of(a), weight_of(b))) return true;
  }
  return false;
}

}  // namespace

int substeps_of(const Group& g, Real h) {
  if (g.trees.empty() && g.ties.empty()) return substeps_of_free(g, h);
  Real fastest = 0;
  for (const GroupBody& b : g.bodies)
    if (b.node != kNoNode)
      fastest = std::max(fastest, glm::length(b.looped == kNoNode ? b.spin : turning_of(b)));
  const Real least =
      std::max({Real(has_few_points(g, kStepOfFewPoints) ? kLeastAtFewPoints : kLeastTreeSubsteps),
                h / (has_towers(g) ? kLongestSubstep : kLongestTreeSubstep),
                h * std::min(fastest, Real(1e9)) / kLargestTurn, h * sliding_rate(g)});
  return static_cast<int>(std::ceil(std::min(least, Real(kMostSubsteps))));
}

void join_rims(const Group& g, Real h) {
  if (!g.has_at_most(kFewBodies)) return;
  const auto goes_around = [&](const GroupBody& b, const contact::TouchedPlace& on, Vec3 normal) {
    const Vec3 lean = glm::cross(b.pose.rotation * on.axis, normal);
    return on.circle > 0 && glm::dot(lean, lean) > kFlat * kFlat &&
           h * rolling_rate(b, on, normal) > kFarAround;
  };
  for (const GroupContact& low : g.contacts) {
    const bool on_a = goes_around(g.a(low), low.on_a, low.axes[0]),
               on_b = goes_around(g.b(low), low.on_b, low.axes[0]);
    if (!on_a && !on_b) continue;
    for (GroupContact& c : g.contacts) {
      if (!have_same_bodies(c, low)) continue;
      if (on_a && c.on_a.lies_on(low.on_a)) c.on_a = low.on_a;
      if (on_b && c.on_b.lies_on(low.on_b)) c.on_b = low.on_b;
    }
  }
}

namespace {

Real frequency_in(Real h) { return kContactFrequency * std::max(Real(1), kLongestSubstep / h); }

}  // namespace

Real spring_stiffness(Real h) {
  const Real omega = 2 * kPi * frequency_in(h);
  return omega * omega;
}

void set_springs(Substep& s, Real h) {
  const Real frequency = frequency_in(h);
  s.between = softness_of(frequency, s.h), s.against_fixed = softness_of(2 * frequency, s.h);
  s.before_limits = kBuffer * std::min(Real(1), h / kLongestTreeSubstep);
}

bool has_few_points(const Group& g, Real h) {
  const Real most = kFewPointsOfTrees * std::max(Real(1), kStepOfFewPoints / h);
  return !g.trees.empty() && static_cast<Real>(g.contacts.size()) <= most &&
         std::none_of(g.nodes.begin(), g.nodes.end(), [](auto& n) { return n.actuator.dof; });
}

Real first_strike(const Group& g, Real h) {
  Real first = h;
  for (const GroupContact& c : g.contacts) {
    const GroupBody &a = g.a(c), &b = g.b(c);
    const Vec3 n = c.axes[0];
    const Vec3 arm_a = c.on_a.at(a.pose.rotation, -n), arm_b = c.on_b.at(b.pose.rotation, n);
    const Real gap = glm::dot(n, a.pose.position + arm_a - b.pose.position - arm_b);
    const Real speed = glm::dot(
        n, a.velocity + glm::cross(a.spin, arm_a) - b.velocity - glm::cross(b.spin, arm_b));
    // Contacts with restitution are handled at their time by collide_elastically().
    if (!(gap > 0) || !(speed < -kLeastTimed) || c.restitution > 0) continue;
    const Real pull = glm::dot(n, a.acceleration - b.acceleration);
    const Real root = std::sqrt(std::max(Real(0), speed * speed - 2 * pull * gap));
    const Real when = 2 * gap / (root - speed);
    if (when > kAtOnce * h && when < first) first = when;
  }
  return first < (1 - kAtOnce) * h ? first : h;
}

}  // namespace pantin::detail::articulated
