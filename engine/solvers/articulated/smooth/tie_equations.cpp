// The dense system that couples the ties of an island in the energy-momentum method.
#include <algorithm>

#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// Pivots below this part of their row count as dependent rows: these have no impulse.
constexpr Real kDependent = 1e-12;

}  // namespace

bool solve_tie_equations(StepScratch& r, std::size_t n) {
  PANTIN_ASSERT(r.tie_matrix.size() >= n * n && r.tie_solution.size() >= n);
  PANTIN_ASSERT(r.tie_order.size() >= n && r.tie_largest.size() >= n);
  Real* m = r.tie_matrix.data();
  Real* x = r.tie_solution.data();
  std::vector<std::uint32_t>& order = r.tie_order;
  for (std::size_t i = 0; i < n; ++i) {
    Real most = 0;
    for (std::size_t j = 0; j < n; ++j) most = std::max(most, std::abs(m[i * n + j]));
    order[i] = static_cast<std::uint32_t>(i);
    if (!std::isfinite(most)) return false;
    for (std::size_t j = 0; most > 0 && j < n; ++j) m[i * n + j] /= most;
    if (most > 0) x[i] /= most;
  }
  std::size_t rank = 0;
  // The largest number of each row that is left, kept up as rows are reduced.
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
