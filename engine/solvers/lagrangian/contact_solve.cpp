// Contact impulses by projected Gauss-Seidel: one point at a time, with its 3x3 response.
#include <algorithm>
#include <limits>

#include "engine/solvers/lagrangian/contacts.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// m/s: slower impacts are inelastic.
constexpr Real kSlowestImpact = 0.05;
/// Bounds on sweeps over impacts, on sweeps before Newton's method is tried, on such attempts, on
/// sweeps over overlaps, and on rounds in which further points close.
constexpr int kImpactSweeps = 64, kSweeps = 30, kAttempts = 12, kOverlapSweeps = 200, kRounds = 8;
/// Iterations end when no impulse changes by more than this fraction of the largest.
constexpr Real kTolerance = 1e-10;
/// For a sliding point: iterations, and the relative change that ends them.
constexpr int kSlideIterations = 60;
constexpr Real kSlideTolerance = 1e-15;
/// Fraction of the largest response: a direction with less carries no impulse.
constexpr Real kLeastPivot = 1e-9;
/// m: a smaller gap is closed.
constexpr Real kShut = 1e-12;

/// Which of a point's sums an impulse changes.
enum class Follows : std::uint8_t { speed, gap };

void follow(const Couplings& c, const ContactPoint& p, Vec3 impulse, Follows what) {
  ContactScratch& r = c.scratch;
  for (const std::uint32_t at : p.end) {
    if (at == kNoIndex) continue;
    PANTIN_ASSERT(at < r.ends.size() && r.ends[at].member < r.members.size());
    const ContactEnd& e = r.ends[at];
    const GroupMember& m = r.members[e.member];
    PANTIN_ASSERT(at - m.first_end < m.ends);
    const std::size_t n = std::size_t(3) * m.ends;
    const Real* column = &r.responses[m.first_response + 3 * (at - m.first_end)];
    for (std::uint32_t f = 0; f < m.ends; ++f, column += 3 * n) {
      ContactPoint& q = r.points[r.ends[m.first_end + f].point];
      const auto row = [&](std::size_t l) {
        const Real* w = column + l * n;
        return w[0] * impulse.x + w[1] * impulse.y + w[2] * impulse.z;
      };
      if (what == Follows::gap)
        q.gap += row(0);
      else
        q.speed += Vec3(row(0), row(1), row(2));
    }
  }
}

/// A tangential impulse that changes the tangential speed by `change`. Directions whose response is
/// negligible against `scale` carry none.
void stick(const Mat3& w, const Real change[2], Real scale, Real found[2]) {
  const int one = w[2][2] > w[1][1] ? 1 : 0, two = 1 - one;
  const Real d1 = w[one + 1][one + 1], off = w[one + 1][two + 1];
  found[0] = found[1] = 0;
  if (!(d1 > kLeastPivot * scale)) return;
  const Real d2 = w[two + 1][two + 1] - off * off / d1;
  if (d2 > kLeastPivot * scale) found[two] = (change[two] - off / d1 * change[one]) / d2;
  found[one] = (change[one] - off * found[two]) / d1;
}

/// Bounds the tangential part of an impulse by Coulomb's cone.
Vec3 within_cone(Vec3 r, Real friction) {
  const Real held = std::sqrt(r.y * r.y + r.z * r.z), most = friction * std::max(Real(0), r.x);
  if (held > most) r.y *= most / held, r.z *= most / held;
  return r;
}

/// The impulse of a sliding point: on the friction cone, opposite to the remaining slip.
Vec3 slide(const ContactPoint& p, Vec3 free, Vec3 r) {
  const Mat3& w = p.response;
  PANTIN_ASSERT(p.friction > 0);
  const Real soft = softest_of(w);
  for (int n = 0; n < kSlideIterations; ++n) {
    const Vec3 before = r;
    r.x = std::max(Real(0), -(free.x + w[1][0] * r.y + w[2][0] * r.z) / w[0][0]);
    const Vec3 speed = free + w * r;
    r = within_cone({r.x, r.y - speed.y / soft, r.z - speed.z / soft}, p.friction);
    const Vec3 change = r - before;
    if (glm::dot(change, change) <= kSlideTolerance * kSlideTolerance * glm::dot(r, r)) break;
  }
  return r;
}

/// The impulse of a point, starting from `r` with all others fixed, at which it neither closes nor
/// pulls, and sticks or slides.
Vec3 solve_point(const Couplings& with, const ContactPoint& p, Vec3 r) {
  if (p.is_rolling()) return solve_rolling(with.scratch, p, r);
  const Mat3& w = p.response;
  PANTIN_ASSERT(p.works && w[0][0] > 0);
  const Vec3 free = p.speed - w * r;
  if (!(p.friction > 0)) return {std::max(p.least, -free.x / w[0][0]), 0, 0};
  if (free.x >= 0) return Vec3(0);
  const Vec3 stopped = stop(w, free);
  if (stopped.x > 0 && within_cone(stopped, p.friction) == stopped) return stopped;
  return slide(p, free, within_cone(stopped.x > 0 ? stopped : r, p.friction));
}

/// An impact: restitution along the normal, with friction, at a point whose bodies collided `since`
/// seconds before the end of the step.
void meet(const Couplings& with, ContactPoint& p, Real since) {
  const Mat3& w = p.response;
  PANTIN_ASSERT(p.works && p.restitution > 0 && since >= 0 && since <= with.group.h);
  const Real wanted = -(1 + p.restitution) * (p.speed.x - p.pull * since);
  Vec3 r(wanted / w[0][0], 0, 0);
  for (int n = 0; n < 8 && p.friction > 0; ++n) {
    const Real change[2] = {-p.speed.y - w[0][1] * r.x, -p.speed.z - w[0][2] * r.x};
    Real t[2];
    stick(w, change, std::max({w[0][0], w[1][1], w[2][2]}), t);
    r = within_cone({r.x, t[0], t[1]}, p.friction);
    r.x = std::max(Real(0), (wanted - w[1][0] * r.y - w[2][0] * r.z) / w[0][0]);
  }
  p.impulse += r, p.shift += since * r;
  with.push(p, r), with.displace(p, since * r);
}

/// m: the gap that a closed point is to reach.
Real goal_of(const Couplings& with, const ContactPoint& p) {
  return std::min(Real(0), p.gap_before + kPushSpeed * with.group.h);
}

/// Displaces closed points along their normals until no overlap exceeds its goal; displacements may
/// shrink again.
void open_closed(const Couplings& with) {
  const std::span<ContactPoint> points = with.group.points;
  for (int n = 0; n < kOverlapSweeps; ++n) {
    Real worst = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      ContactPoint& p = points[n % 2 == 0 ? i : points.size() - 1 - i];
      if (!p.closed || !p.works || p.is_rolling()) continue;
      PANTIN_ASSERT(p.response[0][0] > 0);
      const Real missing = goal_of(with, p) - p.gap;
      const Real least = p.share * with.group.h * p.least;
      const Real more = std::max(least - p.held.x, missing / p.response[0][0]);
      if (more == 0) continue;
      worst = std::max(worst, std::abs(more) * p.response[0][0]);
      p.held.x += more, p.shift.x += more;
      with.displace(p, {more, 0, 0});
    }
    if (worst <= kShut) return;
  }
}

/// Adds to the lasting impulse of a point.
void add(const Couplings& with, ContactPoint& p, Vec3 change) {
  p.lasting += change, p.impulse += change;
  with.push(p, change);
}

enum class Order : std::uint8_t { forwards, backwards };

/// One sweep over closed points. Returns the largest change of an impulse.
Real sweep(const Couplings& with, Order order) {
  Real most = 0;
  for (std::size_t i = 0; i < with.group.points.size(); ++i) {
    ContactPoint& p =
        with.group.points[order == Order::forwards ? i : with.group.points.size() - 1 - i];
    if (!p.closed || !p.works) continue;
    const Vec3 change = solve_point(with, p, p.lasting) - p.lasting;
    if (change == Vec3(0)) continue;
    add(with, p, change);
    most = std::max(most, glm::length(change));
  }
  return most;
}

/// N s: scale of a group's impulses, including those that would stop its points one by one.
Real scale_of(const Couplings& with) {
  Real most = 0;
  for (const ContactPoint& p : with.group.points)
    if (p.closed && p.works)
      most = std::max({most, glm::length(p.lasting),
                       p.is_rolling() ? 0 : std::abs(p.pull) * with.group.h / p.response[0][0]});
  return most;
}

/// Solves for the closed points by sweeps and Newton's method in turn. False: the best iterate.
bool solve_closed(const Couplings& with) {
  Real least = std::numeric_limits<Real>::infinity();
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Real enough = kTolerance * scale_of(with);
    for (int n = 0; n < kSweeps; ++n)
      if (sweep(with, n % 2 == 0 ? Order::forwards : Order::backwards) <= enough) return true;
    if (polish(with, enough, attempt)) return true;
    const Real error = error_of(with);
    if (!(error < least)) continue;
    least = error;
    for (ContactPoint& p : with.group.points) p.kept = p.lasting;
  }
  for (ContactPoint& p : with.group.points)
    if (p.closed && p.works) add(with, p, p.kept - p.lasting);
  return false;
}

/// Whether a point is closed at the current poses; for rolling friction, whether the bodies touch.
bool is_shut(const Couplings& with, const ContactPoint& p) {
  if (p.is_rolling()) return is_any_closed(with.scratch, with.scratch.rollings[p.rolling]);
  // A contact that was closed at the start and approaches was opened by impacts within this solve.
  const bool comes_back = p.gap_before <= kNearlyShut && p.speed.x < 0;
  if (p.gap > kNearlyShut && !comes_back) return false;
  return !(p.gap > 0 && p.restitution > 0 && p.speed.x < -kSlowestImpact);
}

/// Closes the points that are shut. Whether any did.
bool close_more(const Couplings& with) {
  bool any = false;
  for (ContactPoint& p : with.group.points) {
    if (p.closed || !is_shut(with, p)) continue;
    p.closed = any = true;
    if (!p.works) continue;
    // Warm start from the last step.
    p.impulse += p.lasting;
    with.push(p, p.lasting);
  }
  return any;
}

}  // namespace

bool can_spin(const Mat3& w) { return w[0][0] > kLeastPivot * std::max(w[1][1], w[2][2]); }

Vec3 stop(const Mat3& w, Vec3 free) {
  // The tangential response with the normal impulse eliminated.
  Mat3 rest = w;
  for (int k = 1; k < 3; ++k)
    for (int l = 1; l < 3; ++l) rest[k][l] -= w[k][0] * w[0][l] / w[0][0];
  const Real change[2] = {-free.y + w[0][1] * free.x / w[0][0],
                          -free.z + w[0][2] * free.x / w[0][0]};
  Real t[2];
  stick(rest, change, std::max({w[0][0], w[1][1], w[2][2]}), t);
  return {(-free.x - w[1][0] * t[0] - w[2][0] * t[1]) / w[0][0], t[0], t[1]};
}

Real error_of(const Couplings& with) {
  Real most = 0;
  for (const ContactPoint& p : with.group.points)
    if (p.closed && p.works)
      most = std::max(most, glm::length(solve_point(with, p, p.lasting) - p.lasting));
  return most;
}

void Couplings::push(const ContactPoint& p, Vec3 impulse) const {
  follow(*this, p, impulse, Follows::speed);
}
void Couplings::displace(const ContactPoint& p, Vec3 shift) const {
  follow(*this, p, shift, Follows::gap);
}

void collide(const Couplings& with) {
  const Real h = with.group.h;
  for (int n = 0; n < kImpactSweeps; ++n) {
    bool any = false;
    for (ContactPoint& p : with.group.points) {
      if (!(p.restitution > 0) || !p.works || p.closed) continue;
      if (!(p.gap <= 0) || !(p.speed.x < 0)) continue;
      // The time since they met is the smaller root of gap - speed t + pull t^2 / 2.
      const Real root = std::sqrt(std::max(Real(0), p.speed.x * p.speed.x - 2 * p.pull * p.gap));
      const Real since = std::clamp(2 * p.gap / (p.speed.x - root), Real(0), h);
      if (p.speed.x - p.pull * since > -kSlowestImpact) continue;
      meet(with, p, since);
      any = true;
    }
    if (!any) return;
  }
}

bool hold(const Couplings& with) {
  bool solved = true;
  const Real h = with.group.h;
  for (int round = 0; round < kRounds && close_more(with); ++round) {
    solved = solve_closed(with);
    for (ContactPoint& p : with.group.points) {
      if (!p.closed || !p.works) continue;
      // Displacement by a constant force over the step.
      const Vec3 shift = p.share * h * p.lasting;
      with.displace(p, shift - p.held);
      p.shift += shift - p.held, p.held = shift;
    }
    open_closed(with);
    collide(with);  // bodies that were pushed against others
  }
  return solved;
}

bool hold_on(const Couplings& with) { return solve_closed(with); }

Real open_overlaps(const Couplings& with) {
  Real deepest = 0;
  for (ContactPoint& p : with.group.points) {
    p.shift = p.held = Vec3(0);
    const Real missing = goal_of(with, p) - p.gap;
    p.closed = missing > 0 && !p.is_rolling();
    if (p.closed && p.works) deepest = std::max(deepest, missing);
  }
  open_closed(with);
  return deepest;
}

}  // namespace pantin::detail::lagrangian
