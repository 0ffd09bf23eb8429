// Newton's method for contacts near the solution of Gauss-Seidel: all closed points of a group at
// once. [Alart & Curnier 1991]
#include <algorithm>

#include "engine/solvers/lagrangian/contacts.hpp"

namespace pantin::detail::lagrangian {
namespace {

constexpr int kIterations = 16;
/// Groups with more unknowns are left to Gauss-Seidel.
constexpr std::size_t kMostUnknowns = 900;
/// Redundant points make the loads non-unique. These fractions of a point's own response are added
/// to make the step unique; they do not move the solution. One per attempt, in turn: larger ones
/// keep iterates close together, smaller ones converge in fewer.
constexpr Real kRegularisations[] = {1e-6, 1e-4, 1e-9};

/// The dense equations of a group.
struct Equations {
  std::span<Real> matrix, right;
  std::size_t n = 0;
  Real& at(std::size_t r, std::size_t c) const { return matrix[r * n + c]; }
};

/// Whether a point is among the unknowns.
bool counts(const ContactPoint& p) { return p.closed && p.works; }

/// Responses of all closed points.
void fill_responses(const Couplings& with, const Equations& to) {
  const ContactScratch& r = with.scratch;
  std::fill(to.matrix.begin(), to.matrix.end(), 0.0);
  for (const GroupMember& m : with.group.members) {
    const std::size_t n = std::size_t(3) * m.ends;
    for (std::size_t e = 0; e < m.ends; ++e) {
      const ContactPoint& p = r.points[r.ends[m.first_end + e].point];
      if (!counts(p)) continue;
      for (std::size_t f = 0; f < m.ends; ++f) {
        const ContactPoint& q = r.points[r.ends[m.first_end + f].point];
        if (!counts(q)) continue;
        for (std::size_t l = 0; l < 3; ++l)
          for (std::size_t k = 0; k < 3; ++k)
            to.at(p.unknown + l, q.unknown + k) +=
                r.responses[m.first_response + (3 * e + l) * n + 3 * f + k];
      }
    }
  }
}

/// Direction in which a point slides, and how its bound changes.
struct Sliding {
  Vec3 way{0};    // unit, tangential: of the impulse at its bound
  Real most = 0;  // N s: the bound
  Real turn = 0;  // derivative of the bounded impulse by a change across `way`
};

/// Rows of a sliding point: its impulse stays at its bound and opposes the slip. The dependence of
/// the bound on other impulses is added by follow().
void write_sliding(const Equations& to, const ContactPoint& p, const Sliding& s, Real step) {
  const std::size_t n = p.unknown;
  PANTIN_ASSERT(n + 3 <= to.n && s.way.x == 0);
  const Real y = s.way.y, z = s.way.z;
  const Real across[2][2] = {{1 - y * y, -y * z}, {-y * z, 1 - z * z}};
  for (std::size_t c = 0; c < to.n; ++c) {
    const Real w1 = to.at(n + 1, c), w2 = to.at(n + 2, c);
    for (std::size_t k = 0; k < 2; ++k)
      to.at(n + 1 + k, c) = s.turn * step * (across[k][0] * w1 + across[k][1] * w2);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    to.at(n + 1 + k, n + 1 + k) += 1;
    for (std::size_t l = 0; l < 2; ++l) to.at(n + 1 + k, n + 1 + l) -= s.turn * across[k][l];
  }
  to.right[n + 1] = s.most * y - p.lasting.y, to.right[n + 2] = s.most * z - p.lasting.z;
}

/// The rows of a point in a Newton step.
struct PointRows {
  const Equations& to;
  const ContactPoint& p;
  Real regularisation;

  /// Fixes a component to `impulse`.
  void set(std::size_t k, Real impulse) const {
    const std::size_t row = p.unknown + k;
    for (std::size_t c = 0; c < to.n; ++c) to.at(row, c) = 0;
    to.at(row, row) = 1;
    to.right[row] = impulse - p.lasting[static_cast<int>(k)];
  }
  /// Requires that the speed along a component vanishes.
  void stop(std::size_t k, Real response) const {
    const std::size_t row = p.unknown + k;
    to.at(row, row) += regularisation * response;
    to.right[row] = -p.speed[static_cast<int>(k)];
  }
  /// Bounds the two tangential components. Returns the direction in which the bound is reached, or
  /// 0.
  Vec3 bound_across(Real most) const {
    const Real soft = softest_of(p.response);
    if (!(soft > 0)) return set(1, 0), set(2, 0), Vec3(0);
    const Vec3 wanted(0, p.lasting.y - p.speed.y / soft, p.lasting.z - p.speed.z / soft);
    const Real size = glm::length(wanted);
    if (size <= most) return stop(1, soft), stop(2, soft), Vec3(0);
    write_sliding(to, p, {wanted / size, most, most / size}, 1 / soft);
    return wanted / size;
  }
  /// Couples the tangential bound to the normal impulse of `on`.
  void follow(Vec3 way, Real length, const ContactPoint& on) const {
    to.at(p.unknown + 1, on.unknown) -= length * way.y;
    to.at(p.unknown + 2, on.unknown) -= length * way.z;
  }
};

void write_contact_rows(const PointRows& rows) {
  const ContactPoint& p = rows.p;
  const bool open = p.lasting.x - p.least - p.speed.x / p.response[0][0] <= 0;
  if (open) return rows.set(0, p.least), rows.set(1, 0), rows.set(2, 0);
  rows.stop(0, p.response[0][0]);
  if (!(p.friction > 0)) return rows.set(1, 0), rows.set(2, 0);
  rows.follow(rows.bound_across(p.friction * std::max(Real(0), p.lasting.x)), p.friction, p);
}

/// Rolling and spinning friction.
void write_rolling_rows(const ContactScratch& r, const PointRows& rows) {
  const ContactPoint& p = rows.p;
  const RollingAt& all = r.rollings[p.rolling];
  const contact::RollingBounds most = rolling_bounds(r, all);
  Real spins = 0;  // at its bound: which way
  if (const Real w = p.response[0][0]; can_spin(p.response)) {
    const Real wanted = p.lasting.x - p.speed.x / w;
    if (std::abs(wanted) <= most.spinning)
      rows.stop(0, w);
    else
      spins = wanted > 0 ? 1 : -1, rows.set(0, spins * most.spinning);
  } else {
    rows.set(0, 0);
  }
  const Vec3 way = rows.bound_across(most.rolling);
  for (std::uint32_t i = 0; i < all.count; ++i) {
    const ContactPoint& on = r.points[all.first + i];
    if (!counts(on)) continue;
    const contact::RollingLengths& lengths = r.lengths[all.first_length + i];
    rows.to.at(p.unknown, on.unknown) -= spins * lengths.spinning;
    rows.follow(way, lengths.rolling, on);
  }
}

/// Gaussian elimination with partial pivoting; the solution is in `right`. False: singular.
bool eliminate(const Equations& e) {
  PANTIN_ASSERT(e.matrix.size() >= e.n * e.n && e.right.size() >= e.n);
  for (std::size_t k = 0; k < e.n; ++k) {
    std::size_t pivot = k;
    for (std::size_t r = k + 1; r < e.n; ++r)
      if (std::abs(e.at(r, k)) > std::abs(e.at(pivot, k))) pivot = r;
    if (!(std::abs(e.at(pivot, k)) > 0)) return false;
    if (pivot != k) {
      std::swap_ranges(&e.at(k, 0), &e.at(k, 0) + e.n, &e.at(pivot, 0));
      std::swap(e.right[k], e.right[pivot]);
    }
    PANTIN_ASSERT(pivot < e.n);
    const Real inverse = 1 / e.at(k, k);
    for (std::size_t r = k + 1; r < e.n; ++r) {
      const Real part = e.at(r, k) * inverse;
      if (part == 0) continue;
      for (std::size_t c = k + 1; c < e.n; ++c) e.at(r, c) -= part * e.at(k, c);
      e.right[r] -= part * e.right[k];
    }
  }
  for (std::size_t k = e.n; k-- > 0;) {
    for (std::size_t c = k + 1; c < e.n; ++c) e.right[k] -= e.at(k, c) * e.right[c];
    e.right[k] /= e.at(k, k);
  }
  return true;
}

/// Adds to the impulses of a point.
void add(const Couplings& with, ContactPoint& p, Vec3 change) {
  if (change == Vec3(0)) return;
  p.lasting += change, p.impulse += change;
  with.push(p, change);
}

}  // namespace

Real softest_of(const Mat3& w) {
  const Real k1 = w[1][1], k2 = w[2][2], k12 = w[1][2];
  return 0.5 * (k1 + k2) + std::sqrt(0.25 * (k1 - k2) * (k1 - k2) + k12 * k12);
}

bool polish(const Couplings& with, Real tolerance, int attempt) {
  const Real regularisation = kRegularisations[attempt % 3];
  PANTIN_ASSERT(attempt >= 0);
  ContactScratch& r = with.scratch;
  std::size_t n = 0;
  for (ContactPoint& p : with.group.points)
    if (counts(p)) p.unknown = n, n += 3, p.best = p.lasting;
  if (n == 0 || n > kMostUnknowns) return false;
  r.matrix.resize(std::max(r.matrix.size(), n * n)), r.right.resize(std::max(r.right.size(), n));
  const Equations e{std::span(r.matrix).first(n * n), std::span(r.right).first(n), n};
  Real best = error_of(with);
  for (int i = 0; i < kIterations && best > tolerance; ++i) {
    fill_responses(with, e);
    for (const ContactPoint& p : with.group.points)
      if (counts(p)) {
        const PointRows rows{e, p, regularisation};
        p.is_rolling() ? write_rolling_rows(r, rows) : write_contact_rows(rows);
      }
    if (!eliminate(e)) break;
    if (!std::all_of(e.right.begin(), e.right.end(), [](Real x) { return std::isfinite(x); }))
      break;
    for (ContactPoint& p : with.group.points)
      if (counts(p))
        add(with, p, {e.right[p.unknown], e.right[p.unknown + 1], e.right[p.unknown + 2]});
    const Real now = error_of(with);
    if (!(now < best)) continue;
    best = now;
    for (ContactPoint& p : with.group.points) p.best = p.lasting;
  }
  for (ContactPoint& p : with.group.points)
    if (counts(p)) add(with, p, p.best - p.lasting);
  return best <= tolerance;
}

}  // namespace pantin::detail::lagrangian
