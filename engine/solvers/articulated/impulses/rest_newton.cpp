// Newton's method for groups that are solved as a whole: residuals, factor, line search.
#include "engine/solvers/articulated/impulses/rest_newton.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

constexpr int kSearchSteps = 40;
/// Continuation: multiples of the compliance.
constexpr Real kSofter[] = {1e4, 1e3, 1e2, 1e1, 1};
/// Tolerance of the residual with softer points, as a fraction of the fastest speed. A larger one
/// than kHopeless means that the search would not converge.
constexpr Real kRoughly = 1e-2, kHopeless = 1e-2;
/// The same where bodies move, and the largest with which a solution is accepted.
constexpr Real kYielding[] = {1e3, 1e2, 1e1, 1}, kYields = 1e2;
constexpr int kYieldingIterations = 10, kYieldingOfTrees = 20;
/// Tolerance of a line search, as a fraction of its initial slope.
constexpr Real kSearched = 1e-3;

/// Momentum and angular momentum of a motion.
Wrench momentum_of(const GroupBody& b, const RestBody& r, const Wrench& motion) {
  return {motion.force / b.per_mass, r.inertia * motion.torque};
}

/// block += [X Y; Z W] by rows, each of three.
void add_block(Real* block, const Mat3 (&parts)[2][2]) {
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      block[i * kFactorWide + j] +=
          parts[i / 3][j / 3][static_cast<int>(j % 3)][static_cast<int>(i % 3)];
}

/// One side of a contact: the row of its body, and its arm.
struct End {
  std::size_t row;
  Mat3 arm;  // as a cross product
};

/// Adds J^T K J of two sides.
void add_contact(const BlockFactor& e, const Mat3& k, const End& a, const End& b) {
  if (a.row < b.row) return add_contact(e, k, b, a);
  const Mat3 moment = b.arm * k;
  add_block(e.block(a.row, b.row), {{k, -k * a.arm}, {moment, -moment * a.arm}});
}

BlockFactor factor_of(const Group& g) {
  const std::size_t blocks = g.rest_pattern.blocks();
  return {g.rest_pattern, g.numbers.subspan(kFactorWide * g.resting.size(), kFactorBlock * blocks)};
}

void assemble(const Group& g, const BlockFactor& e) {
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

}  // namespace

Vec3 speed_of(const Group& g, const GroupContact& c, Wrench RestBody::*motion) {
  const Wrench a = motion_of(g, c.a, motion), b = motion_of(g, c.b, motion);
  return contact::along_axes(
      c.axes, a.force + glm::cross(a.torque, c.arm_a) - b.force - glm::cross(b.torque, c.arm_b));
}

namespace {

/// Starts the residuals of momentum with those without contacts.
void begin_residuals(const Group& g) {
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    RestBody& r = g.resting[i];
    const Wrench now = momentum_of(g.bodies[i], r, r.motion),
                 free = momentum_of(g.bodies[i], r, r.free);
    r.residual = {now.force - free.force, now.torque - free.torque};
  }
}
/// Whether Coulomb's law allows the impulse: friction may have been changed.
bool is_in_cone(const GroupContact& c) {
  const Real most = (2 - kOnCone) * c.friction * c.impulse.x;
  return c.impulse.y * c.impulse.y + c.impulse.z * c.impulse.z <= most * most;
}

void add_impulse(const Group& g, const GroupContact& c, Vec3 impulse) {
  const Vec3 p = to_world(c, impulse);
  g.resting[c.a].residual += {-p, -glm::cross(c.arm_a, p)};
  if (c.b < g.resting.size()) g.resting[c.b].residual += {p, glm::cross(c.arm_b, p)};
}
/// m/s: the largest residual as a speed of a body.
Real largest_residual(const Group& g) {
  Real most = 0;
  for (std::size_t i = 0; i < g.resting.size(); ++i) {
    const GroupBody& b = g.bodies[i];
    const Wrench& left = g.resting[i].residual;
    most = std::max({most, b.per_mass * glm::length(left.force),
                     size_of(b) * glm::length(b.response * left.torque)});
  }
  return most;
}

}  // namespace

Real find_residuals(const Group& g, Acting acting) {
  begin_residuals(g);
  for (std::size_t i = 0; i < g.contacts.size(); ++i) {
    const GroupContact& c = g.contacts[i];
    RestContact& r = g.rest_contacts[i];
    if (!r.near) continue;
    r.speed = speed_of(g, c, &RestBody::motion);
    r.cone =
        acting == Acting::now
            ? cone_of(r, c.friction, r.speed)
            : cone_as_with(r, c.friction, acting == Acting::as_before ? c.impulse : r.cone.impulse);
    add_impulse(g, c, r.cone.impulse);
  }
  add_link_impulses(g, acting);
  return largest_residual(g);
}

bool rests_as_before(const Group& g, const Search& s) {
  if (!g.nodes.empty() || !g.ties.empty() || !g.rollings.empty()) return false;
  const Real enough = s.exactness.nearly * s.fastest;
  start_search(g);
  begin_residuals(g);
  for (std::size_t i = 0; i < g.contacts.size(); ++i) {
    const GroupContact& c = g.contacts[i];
    RestContact& r = g.rest_contacts[i];
    if (!r.near) continue;
    if (r.goal.x > 0 || r.goal.y != 0 || r.goal.z != 0) return false;
    const bool acts = c.impulse.x > 0;
    r.speed = speed_of(g, c, &RestBody::motion);
    if (acts ? !is_in_cone(c) : r.speed.x < r.goal.x - enough) return false;
    r.cone = {acts ? c.impulse : Vec3(0), acts ? At::inside : At::apex};
    add_impulse(g, c, r.cone.impulse);
  }
  return largest_residual(g) <= enough;
}

bool find_direction(const Group& g) {
  const BlockFactor e = factor_of(g);
  assemble(g, e);
  if (!e.factor()) return false;
  const std::span<Real> x = g.numbers.first(kFactorWide * g.resting.size());
  for (const RestBody& r : g.resting)
    for (int k = 0; k < 3; ++k) {
      x[kFactorWide * r.row + static_cast<std::size_t>(k)] = -r.residual.force[k];
      x[kFactorWide * r.row + 3 + static_cast<std::size_t>(k)] = -r.residual.torque[k];
    }
  e.solve(x);
  for (RestBody& r : g.resting)
    for (int k = 0; k < 3; ++k) {
      r.direction.force[k] = x[kFactorWide * r.row + static_cast<std::size_t>(k)];
      r.direction.torque[k] = x[kFactorWide * r.row + 3 + static_cast<std::size_t>(k)];
    }
  return true;
}

void start_search(const Group& g) {
  for (std::size_t i = 0; i < g.resting.size(); ++i)
    g.resting[i].motion = {g.bodies[i].velocity, g.bodies[i].spin};
  for (RestContact& r : g.rest_contacts) r.presses = r.may_press;
  for (RestLink& l : g.rest_links) l.presses = l.may_press;
}

void advance_search(const Group& g, Real part) {
  for (RestBody& r : g.resting)
    r.motion.force += part * r.direction.force, r.motion.torque += part * r.direction.torque;
}

bool resume_search(const Group& g) {
  for (RestContact& r : g.rest_contacts) r.presses = false;
  for (RestLink& l : g.rest_links) l.presses = false;
  find_residuals(g, Acting::as_before);
  const bool any =
      std::any_of(g.rest_contacts.begin(), g.rest_contacts.end(),
                  [](const RestContact& r) { return r.near && r.cone.at != At::apex; });
  if (!any || !find_direction(g)) return false;
  advance_search(g, 1);
  return true;
}

namespace {

/// Tolerances of the residual, as fractions of the fastest speed: as in Exactness.
struct Tolerance {
  Real balanced, nearly;
};

/// Newton's method until the residual is within the tolerance, at most so many iterations.
bool iterate_to(const Group& g, const Tolerance& t, int most, Search& s) {
  const Real enough = t.balanced * s.fastest, nearly_enough = t.nearly * s.fastest;
  Real before = std::numeric_limits<Real>::infinity();
  for (int n = 0;; ++n, --s.left) {
    const Real left = find_residuals(g);
    const bool nearly = left <= nearly_enough;
    if (left <= enough || (nearly && left > 0.5 * before)) return true;
    if (n == most || s.left <= 0 || !find_direction(g)) return nearly;
    const Real part = search(g);
    advance_search(g, part);
    before = left;
  }
}

}  // namespace

bool iterate(const Group& g, int most, Search& s) {
  return iterate_to(g, {s.exactness.balanced, s.exactness.nearly}, most, s);
}

void keep_found(const Group& g) {
  for (RestBody& r : g.resting) r.kept = r.motion;
  for (RestContact& r : g.rest_contacts) r.kept_lift = r.lift, r.kept_compliance = r.compliance;
  for (RestLink& l : g.rest_links) l.kept_compliance = l.compliance;
}

void return_to_kept(const Group& g) {
  for (RestBody& r : g.resting) r.motion = r.kept;
  for (RestContact& r : g.rest_contacts) {
    r.goal.x += r.lift - r.kept_lift, r.lift = r.kept_lift;
    r.compliance = r.kept_compliance;
  }
  for (RestLink& l : g.rest_links) l.compliance = l.kept_compliance;
  find_residuals(g);
}

namespace {

void scale_compliances(const Group& g, Real by) {
  for (RestContact& r : g.rest_contacts) r.compliance *= by;
  for (RestLink& l : g.rest_links) l.compliance *= by;
}

}  // namespace

bool iterate_softer(const Group& g, Search& s) {
  start_search(g);
  for (const Real softer : kSofter) {
    scale_compliances(g, softer);
    const bool done =
        softer == 1 ? iterate(g, 2 * kIterations, s) : iterate_to(g, {kRoughly, 1}, kIterations, s);
    const bool hopeless = !done && find_residuals(g) > kHopeless * s.fastest;
    scale_compliances(g, 1 / softer);
    if (softer == 1) return done;
    if (hopeless) return false;
  }
  return false;
}

bool iterate_yielding(const Group& g, Search& s) {
  start_search(g);
  const Real enough = s.exactness.nearly;
  const int most = g.nodes.empty() ? kYieldingIterations : kYieldingOfTrees;
  bool found = false, done = true;
  for (std::size_t n = 0; done && n < std::size(kYielding); ++n) {
    const Real softer = kYielding[n];
    scale_compliances(g, softer);
    done = iterate_to(g, {enough, enough}, most, s);
    if (done && softer <= kYields) keep_found(g), found = true;
    scale_compliances(g, 1 / softer);
    s.is_exact = done && softer == 1;
  }
  if (found && !s.is_exact) return_to_kept(g);
  return found;
}

}  // namespace pantin::detail::articulated
