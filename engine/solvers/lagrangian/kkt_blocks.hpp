#pragma once
/// Block LDL^T of a matrix in the layout of a KktPattern: of real numbers, or of complex ones,
/// whose matrices are symmetric too.
#include "engine/base/dense_blocks.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {

/// See PivotRule.
inline Real pivot_size(Complex pivot, Real) { return magnitude_of(pivot); }

/// Eliminates a node of R unknowns from the nodes below it, of which that number `i` has W.
template <int R, int W, class T>
void eliminate_below(const KktPattern& p, T* v, std::uint32_t at, std::uint32_t i) {
  const std::uint32_t from = p.first[at], done = i - from;
  const std::uint32_t* target = p.targets.data() + p.first_target[at] + done * (done + 1) / 2;
  T y[R * W];
  solve_lower<R, W>(v + p.diagonal[at], v + p.offset[i], y, {R, W});
  for (std::uint32_t j = from; j <= i; ++j, ++target)
    subtract_product<R, 0, W>(v + p.offset[j], y, v + *target, {R, p.size[p.below[j]], W});
}

/// Eliminates the node at a position of the order. Returns the number of dropped pivots.
template <int R, class T>
int eliminate(const KktPattern& p, T* v, std::uint32_t at, const PivotRule& rule) {
  PANTIN_ASSERT(p.size[at] == R);
  const int cut = decompose<R>(v + p.diagonal[at], R, rule);
  for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i)
    with_size(p.size[p.below[i]],
              [&](auto width) { eliminate_below<R, decltype(width)::value>(p, v, at, i); });
  return cut;
}

/// The same for a node of rows, by their number.
template <class T>
int eliminate_rows(const KktPattern& p, T* v, std::uint32_t at, const PivotRule& rule) {
  return with_size(p.size[at],
                   [&](auto n) { return eliminate<decltype(n)::value>(p, v, at, rule); });
}

template <int R, class T>
void forward_substitute(const KktPattern& p, const T* v, T* y, std::uint32_t at) {
  const T* d = v + p.diagonal[at];
  T* own = y + p.unknown[at];
  for (std::size_t r = 1; r < R; ++r)
    for (std::size_t k = 0; k < r; ++k) own[r] -= d[r * R + k] * own[k];
  for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i) {
    const std::uint32_t to = p.below[i];
    with_size(p.size[to], [&](auto width) {
      constexpr int W = decltype(width)::value;
      update_forward<R, W>(v + p.offset[i], own, y + p.unknown[to], {R, W});
    });
  }
  for (std::size_t r = 0; r < R; ++r) own[r] *= d[r * R + r];
}
template <int R, class T>
void back_substitute(const KktPattern& p, const T* v, T* y, std::uint32_t at) {
  const T* d = v + p.diagonal[at];
  T* own = y + p.unknown[at];
  for (std::uint32_t i = p.first[at]; i < p.first[at + 1]; ++i) {
    const std::uint32_t to = p.below[i];
    with_size(p.size[to], [&](auto width) {
      constexpr int W = decltype(width)::value;
      update_back<R, W>(v + p.offset[i], own, y + p.unknown[to], {R, W});
    });
  }
  for (std::size_t r = R; r-- > 1;)
    for (std::size_t k = 0; k < r; ++k) own[k] -= d[r * R + k] * own[r];
}

/// Solves with the factor `v`, in place.
template <class T>
void back_solve(const KktPattern& p, const T* v, T* y) {
  const auto count = static_cast<std::uint32_t>(p.order.size());
  for (std::uint32_t at = 0; at < count; ++at)
    with_size(p.size[at], [&](auto n) { forward_substitute<decltype(n)::value>(p, v, y, at); });
  for (std::uint32_t at = count; at-- > 0;)
    with_size(p.size[at], [&](auto n) { back_substitute<decltype(n)::value>(p, v, y, at); });
}

}  // namespace pantin::detail::lagrangian
