#pragma once
/// Block LDL^T of a matrix in the layout of a KktPattern: of real numbers, or of complex ones,
/// whose matrices are symmetric too.
#include "engine/base/dense_blocks.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {

/// See PivotRule.
inline Real pivot_size(Complex pivot, Real) { return magnitude_of(pivot); }

/// Eliminates the node at a position of the order. Returns the number of dropped pivots.
template <int R, class T>
int eliminate(const KktPattern& p, T* v, std::uint32_t at, const PivotRule& rule) {
  T* d = v + p.diagonal[at];
  const std::size_t n = p.size[at];
  PANTIN_ASSERT(n <= 6 && (R == 0 || n == R));
  const int cut = decompose<R>(d, n, rule);
  const std::uint32_t from = p.first[at], to = p.first[at + 1];
  const std::uint32_t* target = p.targets.data() + p.first_target[at];
  T y[36];
  for (std::uint32_t i = from; i < to; ++i) {
    const std::size_t ni = p.size[p.below[i]];
    if (R && ni == R)
      solve_lower<R>(d, v + p.offset[i], y, {n, ni});
    else
      solve_lower<0>(d, v + p.offset[i], y, {n, ni});
    for (std::uint32_t j = from; j <= i; ++j, ++target) {
      const std::size_t nj = p.size[p.below[j]];
      if (R && ni == R && nj == R)
        subtract_product<R>(v + p.offset[j], y, v + *target, {n, nj, ni});
      else
        subtract_product<0>(v + p.offset[j], y, v + *target, {n, nj, ni});
    }
  }
  return cut;
}

/// The same for a node of rows, by their number.
template <class T>
int eliminate_rows(const KktPattern& p, T* v, std::uint32_t at, const PivotRule& rule) {
  const std::size_t n = p.size[at];
  return n == 1   ? eliminate<1>(p, v, at, rule)
         : n == 3 ? eliminate<3>(p, v, at, rule)
         : n == 5 ? eliminate<5>(p, v, at, rule)
                  : eliminate<0>(p, v, at, rule);
}

template <int R, class T>
void forward_substitute(const KktPattern& p, const T* v, T* y, std::uint32_t at) {
  const std::size_t n = R ? R : p.size[at];
  const T* d = v + p.diagonal[at];
  T* own = y + p.unknown[at];
  for (std::size_t r = 1; r < n; ++r)
    for (std::size_t k = 0; k < r; ++k) own[r] -= d[r * n + k] * own[k];
  for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i) {
    const std::uint32_t to = p.below[i];
    if (R && p.size[to] == R)
      update_forward<R>(v + p.offset[i], own, y + p.unknown[to], {n, R});
    else
      update_forward<0>(v + p.offset[i], own, y + p.unknown[to], {n, p.size[to]});
  }
  for (std::size_t r = 0; r < n; ++r) own[r] *= d[r * n + r];
}
template <int R, class T>
void back_substitute(const KktPattern& p, const T* v, T* y, std::uint32_t at) {
  const std::size_t n = R ? R : p.size[at];
  const T* d = v + p.diagonal[at];
  T* own = y + p.unknown[at];
  for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i) {
    const std::uint32_t to = p.below[i];
    if (R && p.size[to] == R)
      update_back<R>(v + p.offset[i], own, y + p.unknown[to], {n, R});
    else
      update_back<0>(v + p.offset[i], own, y + p.unknown[to], {n, p.size[to]});
  }
  for (std::size_t r = n; r-- > 1;)
    for (std::size_t k = 0; k < r; ++k) own[k] -= d[r * n + k] * own[r];
}

/// Solves with the factor `v`, in place.
template <class T>
void back_solve(const KktPattern& p, const T* v, T* y) {
  const auto count = static_cast<std::uint32_t>(p.order.size());
  for (std::uint32_t at = 0; at < count; ++at) {
    if (p.size[at] == 3)
      forward_substitute<3>(p, v, y, at);
    else if (p.size[at] == 5)
      forward_substitute<5>(p, v, y, at);
    else
      forward_substitute<0>(p, v, y, at);
  }
  for (std::uint32_t at = count; at-- > 0;) {
    if (p.size[at] == 3)
      back_substitute<3>(p, v, y, at);
    else if (p.size[at] == 5)
      back_substitute<5>(p, v, y, at);
    else
      back_substitute<0>(p, v, y, at);
  }
}

}  // namespace pantin::detail::lagrangian
