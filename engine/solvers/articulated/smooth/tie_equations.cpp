// The dense system that couples the ties of an island in the energy-momentum method.
#include <algorithm>
#include <limits>

#include "engine/solvers/articulated/internal.hpp"
#include "engine/solvers/articulated/kernels.hpp"

namespace pantin::detail::articulated {
namespace {

/// Pivots below this fraction of their row mean linearly dependent rows, which have no impulse.
constexpr Real kDependent = 1e-12;

/// Pivots below this fraction of their row end the fast elimination.
constexpr Real kClear = 1e-6;

/// Scales rows to a largest number of 1. False if one is not finite.
bool scale_rows(Real* m, Real* x, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    Real* const own = m + i * n;
    Real most = 0, probe = 0;
    for (std::size_t j = 0; j < n; ++j) {
      const Real size = std::abs(own[j]);
      most = size > most ? size : most, probe += size;
    }
    if (!(probe <= std::numeric_limits<Real>::max())) return false;
    const Real by = most > 0 ? 1 / most : 1;
    for (std::size_t j = 0; j < n; ++j) own[j] *= by;
    x[i] *= by;
  }
  return true;
}

/// The pivot of a column: on the diagonal, as in the vectorised kernel (kernels/lane_response.hpp),
/// or the largest. The matrix is nearly definite, so the diagonal mostly suffices.
enum class Pivot : std::uint8_t { diagonal, largest };

/// Gaussian elimination in place. False if a pivot is too small; with the largest pivots that means
/// dependent rows. The matrix is destroyed either way.
bool eliminate(Real* m, Real* x, std::size_t n, Pivot pivots) {
  const Real least = pivots == Pivot::diagonal ? kSafePivot : kClear;
  const auto subtract_row = kernels().subtract_row;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t row = k;
    for (std::size_t i = k + 1; pivots == Pivot::largest && i < n; ++i)
      if (std::abs(m[i * n + k]) > std::abs(m[row * n + k])) row = i;
    if (!(std::abs(m[row * n + k]) > least)) return false;
    if (row != k) {
      std::swap_ranges(m + row * n + k, m + row * n + n, m + k * n + k);
      std::swap(x[row], x[k]);
    }
    const Real* const pivot = m + k * n;
    const Real per = 1 / pivot[k];
    for (std::size_t i = k + 1; i < n; ++i) {
      Real* const own = m + i * n;
      const Real f = own[k] * per;
      if (f == 0) continue;
      subtract_row(own + k + 1, pivot + k + 1, f, n - k - 1);
      x[i] -= f * x[k];
    }
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t j = i + 1; j < n; ++j) x[i] -= m[i * n + j] * x[j];
    x[i] /= m[i * n + i];
  }
  return true;
}

}  // namespace

bool solve_tie_equations(StepScratch& r, std::size_t n) {
  PANTIN_ASSERT(r.tie_matrix.size() >= n * n && r.tie_solution.size() >= n);
  PANTIN_ASSERT(r.tie_order.size() >= n && r.tie_largest.size() >= n);
  Real* m = r.tie_matrix.data();
  Real* x = r.tie_solution.data();
  std::vector<std::uint32_t>& order = r.tie_order;
  if (!scale_rows(m, x, n)) return false;
  PANTIN_ASSERT(r.tie_kept.size() >= n * n + n);
  Real* const kept = r.tie_kept.data();
  std::copy_n(m, n * n, kept), std::copy_n(x, n, kept + n * n);
  for (const Pivot pivots : {Pivot::diagonal, Pivot::largest}) {
    if (eliminate(m, x, n, pivots)) return true;
    std::copy_n(kept, n * n, m), std::copy_n(kept + n * n, n, x);
  }
  for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<std::uint32_t>(i);
  std::size_t rank = 0;
  // Complete pivoting: the largest number of each remaining row, updated as rows are reduced.
  std::vector<Real>& largest = r.tie_largest;
  const auto largest_of = [&](std::size_t i, std::size_t first) {
    Real most = 0;
    for (std::size_t j = first; j < n; ++j) most = std::max(most, std::abs(m[i * n + j]));
    return most;
  };
  for (std::size_t i = 0; i < n; ++i) largest[i] = largest_of(i, 0);
  for (; rank < n; ++rank) {
    std::size_t row = rank, at = rank;
    for (std::size_t i = rank + 1; i < n; ++i)
      if (largest[i] > largest[row]) row = i;
    if (!(largest[row] > kDependent)) break;
    while (at + 1 < n && std::abs(m[row * n + at]) != largest[row]) ++at;
    if (row != rank) {
      std::swap_ranges(m + row * n, m + row * n + n, m + rank * n);
      std::swap(x[row], x[rank]), std::swap(largest[row], largest[rank]);
    }
    for (std::size_t i = 0; at != rank && i < n; ++i) std::swap(m[i * n + at], m[i * n + rank]);
    std::swap(order[at], order[rank]);
    const Real* const pivot = m + rank * n;
    for (std::size_t i = rank + 1; i < n; ++i) {
      Real* const own = m + i * n;
      const Real f = own[rank] / pivot[rank];
      if (f != 0) {
        for (std::size_t j = rank + 1; j < n; ++j) own[j] -= f * pivot[j];
        x[i] -= f * x[rank];
      }
      if (f != 0 || largest[i] == std::abs(own[rank])) largest[i] = largest_of(i, rank + 1);
    }
  }
  for (std::size_t i = rank; i < n; ++i) x[i] = 0;
  for (std::size_t i = rank; i-- > 0;) {
    for (std::size_t j = i + 1; j < rank; ++j) x[i] -= m[i * n + j] * x[j];
    x[i] /= m[i * n + i];
  }
  // Back to the order of the ties; the matrix is no longer needed.
  for (std::size_t i = 0; i < n; ++i) m[order[i]] = x[i];
  std::copy(m, m + n, x);
  return true;
}

}  // namespace pantin::detail::articulated
