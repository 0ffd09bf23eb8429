// The linear system of one instant,
//
//   [ M  J^T ] [  a     ]   [ f     ]
//   [ J  -e  ] [ -lambda] = [ right ]
//
// by block LDL^T. Bodies with few blocks are eliminated analytically, which gives J M^-1 J^T. Hubs
// remain, with M of opposite sign: the matrix is quasi-definite, so every elimination order has
// nonzero pivots. [Vanderbei 1995; method of Baraff 1996 with loops by fill]
#include <algorithm>
#include <cmath>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/solvers/lagrangian/kkt_blocks.hpp"

namespace pantin::detail::lagrangian {
namespace {

/// Regularisation of dependent rows, relative to the mean diagonal; refinement removes its error.
constexpr Real kRegularisation = 1e-8;
/// Extra regularisation of rows bounded by friction: they carry less of a load that other rows
/// share.
constexpr Real kGive = 1e2;
/// A smaller pivot, relative to the mean diagonal, means a dependent row.
constexpr Real kPivotTolerance = 1e-12;
/// Pivots of dependent rows scale with the regularisation: factor between the two weights.
constexpr Real kProbeFactor = 4;
/// Pivots below this fraction of the scale are suspect.
constexpr Real kSuspectPivot = 1e-4;
/// Relative to the forces: smaller residuals of rows are rounding.
constexpr Real kForceRounding = 1e-9;
constexpr int kRefinements = 8;

/// Factors with this regularisation. False: a row of a tree is dependent.
bool factor_weighted(Island& m, Real weight) {
  StepScratch& scratch = m.scratch;
  const KktPattern& p = scratch.pattern;
  PANTIN_ASSERT(p.order.size() == m.blocks.size() + p.hubs.size());
  PANTIN_ASSERT(scratch.values.size() >= p.numbers && scratch.scales.size() == m.rows);
  assemble(m);
  for (std::uint32_t at = 0; at < p.order.size(); ++at) {
    const std::uint32_t node = p.order[at];
    const std::size_t n = p.size[at];
    Real* d = &scratch.values[p.diagonal[at]];
    if (node >= m.blocks.size()) {
      eliminate<6>(p, scratch.values.data(), at, {.sign = -1});
      continue;
    }
    const Block& b = m.blocks[node];
    const Real* scales = &scratch.scales[b.first_row];
    const Real own = weight * (may_slip(b) ? kGive : 1);
    for (std::size_t r = 0; r < n; ++r) {
      if (is_active(m, node))
        d[r * n + r] += own * scales[r];
      else
        d[r * n + r] = 1;
      d[r * n + r] += scratch.weights[b.first_row + r];
    }
    const PivotRule rule{.scales = scales, .least = weight > 0 ? 0.5 * own : kPivotTolerance};
    const int cut = eliminate_rows(p, scratch.values.data(), at, rule);
    if (weight == 0 && cut > 0 && is_active(m, node)) return false;
  }
  ++m.solves;
  return true;
}

/// 1 / pivot of a row of the factor; 0: the row was dropped.
Real inverse_pivot(const Island& m, std::size_t block, std::size_t row) {
  const KktPattern& p = m.scratch.pattern;
  PANTIN_ASSERT(block < m.blocks.size() && row < m.blocks[block].rows);
  return m.scratch.values[p.diagonal[p.place[block]] + row * m.blocks[block].rows + row];
}

/// Rank and redundant blocks, from the pivots of the factor and of the one with kProbeFactor times
/// the weight.
void find_redundant(Island& m) {
  for (std::uint32_t i = 0; i < m.blocks.size(); ++i) {
    if (!is_active(m, i) || is_compliant(m.blocks[i].kind)) continue;
    int dependent = 0;
    for (std::size_t r = 0; r < m.blocks[i].rows; ++r) {
      const Real now = inverse_pivot(m, i, r),
                 probe = m.scratch.row_residual[m.blocks[i].first_row + r];
      if (now == 0 || now * 2 > kProbeFactor * probe) ++dependent;
    }
    if (dependent == 0) continue;
    PANTIN_ASSERT(m.rank >= static_cast<std::size_t>(dependent));
    m.rank -= static_cast<std::size_t>(dependent);
    Fault f;
    f.kind = Fault::redundant, f.block = i, f.rows = dependent;
    m.faults.push_back(f);
  }
}

/// Whether a pivot is small enough for a dependent row.
bool any_suspect(const Island& m) {
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    for (std::size_t r = 0; r < m.blocks[i].rows && is_active(m, i); ++r)
      if (const Real inverse = inverse_pivot(m, i, r);
          inverse == 0 || inverse * m.scratch.scales[m.blocks[i].first_row + r] * kSuspectPivot > 1)
        return true;
  return false;
}

/// Finds dependent rows from the factors of two regularisations.
void probe(Island& m) {
  StepScratch& scratch = m.scratch;
  factor_weighted(m, kProbeFactor * kRegularisation);
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    for (std::size_t r = 0; r < m.blocks[i].rows; ++r)
      scratch.row_residual[m.blocks[i].first_row + r] = inverse_pivot(m, i, r);
  factor_weighted(m, kRegularisation);
  find_redundant(m);
}

}  // namespace

void factor_soft(Island& m, Real weight) { factor_weighted(m, weight); }

void factor(Island& m) {
  if (!m.loops) {
    if (factor_weighted(m, 0)) return;
    m.loops = true;  // a tree in a singular configuration: treated as if it had loops from now on
  }
  factor_weighted(m, kRegularisation);
}

void factor_and_report(Island& m) {
  const bool hubs = !m.scratch.pattern.hubs.empty();
  if (!hubs) m.rank = m.equations(), m.faults.clear();
  factor(m);
  if (m.loops && !hubs && any_suspect(m)) probe(m);
}

void note_dependence(const Island& m, std::span<Real> by_row) {
  PANTIN_ASSERT(by_row.size() >= m.rows);
  for (std::size_t i = 0; i < m.blocks.size(); ++i)
    for (std::size_t r = 0; r < m.blocks[i].rows; ++r) {
      const std::size_t row = m.blocks[i].first_row + r;
      const Real inverse = inverse_pivot(m, i, r);
      const bool counts = is_active(m, i) && !is_compliant(m.blocks[i].kind);
      by_row[row] = !counts        ? 0
                    : inverse == 0 ? 1 / kRegularisation
                                   : inverse * m.scratch.scales[row];
    }
}

void find_rank(Island& m) {
  StepScratch& scratch = m.scratch;
  if (scratch.pattern.hubs.empty()) return;  // already found by factor()
  m.rank = m.equations(), m.faults.clear();
  if (!m.loops) return;
  KktPattern other = make_pattern(m, Hubs::none);
  std::swap(scratch.pattern, other);
  scratch.values.resize(std::max(scratch.values.size(), scratch.pattern.numbers));
  factor_weighted(m, kRegularisation);
  probe(m);
  std::swap(scratch.pattern, other);
  factor_weighted(m, kRegularisation);
}

namespace {

/// right - J a, into scratch.row_residual; an empty motion counts as zero.
void find_row_residuals(Island& m, std::span<const Real> right, std::span<const Vec3> a) {
  PANTIN_ASSERT(right.size() >= m.rows && (a.empty() || a.size() >= 2 * m.count()));
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    Real* row_residual = &m.scratch.row_residual[b.first_row];
    const bool on = is_active(m, i);
    for (std::size_t r = 0; r < b.rows; ++r) row_residual[r] = on ? right[b.first_row + r] : 0;
    for (std::size_t k = 0; k < b.count && on && !a.empty(); ++k)
      if (b.body[k] < m.count())
        add_rates({b, jacobian_of(m, b), k}, -a[2 * b.body[k]], -a[2 * b.body[k] + 1],
                  row_residual);
  }
}

/// right - J a - weights lambda, into scratch.row_residual. Returns its largest entry, and the size
/// of its terms in `requested`.
Real measure_row_residuals(Island& m, std::span<const Real> right, const Unknowns& found,
                           Real& requested) {
  const auto& [a, lambda] = found;
  PANTIN_ASSERT(right.size() >= m.rows && lambda.size() >= m.rows && a.size() >= 2 * m.count());
  StepScratch& scratch = m.scratch;
  Real worst = 0;
  for (std::size_t i = 0; i < m.blocks.size(); ++i) {
    const Block& b = m.blocks[i];
    Real* row_residual = &scratch.row_residual[b.first_row];
    if (!is_active(m, i)) {
      std::fill(row_residual, row_residual + b.rows, 0.0);
      continue;
    }
    for (std::size_t r = 0; r < b.rows; ++r) {
      const std::size_t row = b.first_row + r;
      row_residual[r] = right[row] - scratch.weights[row] * lambda[row];
      if (!is_compliant(b.kind)) requested = std::max(requested, std::abs(right[row]));
    }
    for (std::size_t k = 0; k < b.count; ++k) {
      if (b.body[k] >= m.count()) continue;
      Real part[6] = {};
      add_rates({b, jacobian_of(m, b), k}, a[2 * b.body[k]], a[2 * b.body[k] + 1], part);
      for (std::size_t r = 0; r < b.rows; ++r)
        row_residual[r] -= part[r], requested = std::max(requested, std::abs(part[r]));
    }
    for (std::size_t r = 0; r < b.rows; ++r) worst = std::max(worst, std::abs(row_residual[r]));
  }
  return worst;
}

/// a = M^-1 force.
void find_free_motion(const Island& m, std::span<const Vec3> force, std::span<Vec3> a) {
  for (std::size_t b = 0; b < m.count(); ++b) {
    PANTIN_ASSERT(is_positive(m.mass[b]) && is_positive(m.inertia[b]));
    a[2 * b] = 1 / m.mass[b] * force[2 * b];
    a[2 * b + 1] = m.scratch.inverse_inertia[b] * force[2 * b + 1];
  }
}

/// a += M^-1 J^T lambda, for hubs too.
void add_motion(const Island& m, std::span<const Real> lambda, std::span<Vec3> a) {
  const KktPattern& p = m.scratch.pattern;
  PANTIN_ASSERT(p.first_incident.size() == m.count() + 1 && lambda.size() >= m.rows);
  for (std::size_t body = 0; body < m.count(); ++body) {
    Vec3 pull[2] = {Vec3(0), Vec3(0)};
    for (std::uint32_t i = p.first_incident[body]; i < p.first_incident[body + 1]; ++i) {
      const Block& b = m.blocks[p.incidents[i].block];
      add_constraint_force({b, jacobian_of(m, b), p.incidents[i].at}, &lambda[b.first_row], pull);
    }
    a[2 * body] += 1 / m.mass[body] * pull[0];
    a[2 * body + 1] += m.scratch.inverse_inertia[body] * pull[1];
  }
}

/// Centripetal acceleration at the end of the longest arm, or on a path as curved as that is long,
/// m/s^2: at least that of a slow rotation, since what rests has none but rounding.
Real turning(const Island& m) {
  constexpr Real kSlow = 1e-2;  // rad/s
  Real fastest = kSlow * kSlow * m.reach * m.reach;
  for (const Vec3& w : m.scratch.state.w)
    fastest = std::max(fastest, glm::dot(w, w) * m.reach * m.reach);
  for (const Vec3& v : m.scratch.state.v) fastest = std::max(fastest, glm::dot(v, v));
  return m.reach > 0 ? fastest / m.reach : 0;
}

/// One solve with the factor and right-hand side scratch.row_residual, which is overwritten.
void solve_for_lambda(Island& m, std::span<Real> lambda) {
  std::vector<Real>& row_residual = m.scratch.row_residual;
  PANTIN_ASSERT(row_residual.size() == m.scratch.pattern.unknowns && row_residual.size() >= m.rows);
  std::fill(row_residual.begin() + static_cast<std::ptrdiff_t>(m.rows), row_residual.end(), 0.0);
  back_solve(m.scratch.pattern, m.scratch.values.data(), row_residual.data());
  std::copy_n(row_residual.begin(), m.rows, lambda.begin());
}

}  // namespace

void keep_moving_part(Island& m, std::span<Real> lambda) {
  if (!m.loops) return;
  std::span<Vec3> a = m.scratch.solution;
  std::fill(a.begin(), a.end(), Vec3(0));
  add_motion(m, lambda, a);
  std::fill(m.scratch.right.begin(), m.scratch.right.end(), 0.0);
  find_row_residuals(m, m.scratch.right, a);
  for (std::size_t r = 0; r < m.rows; ++r) m.scratch.row_residual[r] *= -1;
  solve_for_lambda(m, lambda);
}

void solve_lambda(Island& m, std::span<const Real> right, std::span<Real> lambda) {
  PANTIN_ASSERT(right.size() == m.rows);
  std::copy(right.begin(), right.end(), m.scratch.row_residual.begin());
  solve_for_lambda(m, lambda);
}

Real solve(Island& m, const Known& known, const Unknowns& found, Real tolerance) {
  const auto& [force, right] = known;
  const auto& [a, lambda] = found;
  PANTIN_ASSERT(force.empty() || force.size() >= 2 * m.count());
  StepScratch& scratch = m.scratch;
  if (force.empty())
    std::fill(a.begin(), a.end(), Vec3(0));
  else
    find_free_motion(m, force, a);
  find_row_residuals(m, right, force.empty() ? std::span<const Vec3>{} : std::span<const Vec3>(a));
  Real given = 0;
  for (std::size_t r = 0; m.loops && r < m.rows; ++r)
    given = std::max(given, std::abs(scratch.row_residual[r]));
  solve_for_lambda(m, lambda);
  add_motion(m, lambda, a);
  if (!m.loops) return 0;  // the factor is exact
  Real requested = 1e-300, row_residual = std::numeric_limits<Real>::infinity();
  for (int n = 0;; ++n) {
    const Real before = row_residual;
    row_residual = measure_row_residuals(m, right, found, requested);
    if (row_residual <= tolerance * requested || n == kRefinements ||
        !(row_residual < 0.5 * before))
      break;
    solve_for_lambda(m, scratch.step_lambda);
    for (std::size_t r = 0; r < m.rows; ++r) lambda[r] += scratch.step_lambda[r];
    add_motion(m, scratch.step_lambda, a);
  }
  // Rounding errors of forces, or of centripetal terms, are no inconsistency, however slow the
  // motion.
  const Real part =
      row_residual / std::max(requested, kForceRounding * std::max(given, turning(m)));
  if (part > scratch.worst_relative_residual) {
    scratch.worst_relative_residual = part;
    for (std::uint32_t i = 0; i < m.blocks.size(); ++i)
      for (std::size_t r = 0; r < m.blocks[i].rows; ++r)
        if (std::abs(scratch.row_residual[m.blocks[i].first_row + r]) == row_residual)
          scratch.worst_relative_block = i;
  }
  return part;
}

}  // namespace pantin::detail::lagrangian
