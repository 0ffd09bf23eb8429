#pragma once
/// Block LDL^T of a matrix in the layout of a KktPattern: of real numbers, or of complex ones,
/// whose matrices are symmetric too.
#include "engine/base/invariants.hpp"
#include "engine/solvers/lagrangian/internal.hpp"

namespace pantin::detail::lagrangian {

/// Pivots of dependent rows are dropped; see PivotRule.
inline Real size_of(Real pivot, Real sign) { return sign * pivot; }
inline Real size_of(Complex pivot, Real) { return magnitude_of(pivot); }

/// Which pivots of a block stand: those of `sign` that exceed `least` times the row's scale. Masses
/// have no scales, and all of theirs stand.
struct PivotRule {
  Real sign = 1;
  const Real* scales = nullptr;
  Real least = 0;
};

/// LDL^T of a square block, lower part; the diagonal becomes 1 / D. Other pivots than those that
/// stand are dropped. Returns the number of dropped pivots.
template <int R, class T>
int decompose(T* d, std::size_t rows, const PivotRule& rule) {
  const std::size_t n = R ? R : rows;
  const Real least = rule.least;
  const Real* scales = rule.scales;
  int cut = 0;
  for (std::size_t c = 0; c < n; ++c) {
    const T pivot = d[c * n + c];
    const bool stands = size_of(pivot, rule.sign) > (scales ? least * scales[c] : 0);
    // Masses are positive definite, whatever was eliminated before them; the first pivot is a sum
    // without cancellation, later ones drown where moments differ by more than rounding.
    PANTIN_ASSERT(scales || c > 0 || is_positive(size_of(pivot, rule.sign)));
    const T inverse = stands ? T(1) / pivot : T(0);
    cut += stands ? 0 : 1;
    // The column below the pivot, and its update of the rest.
    for (std::size_t r = c + 1; r < n; ++r) {
      const T x = d[r * n + c];
      const T l = x * inverse;
      for (std::size_t k = c + 1; k < r; ++k) d[r * n + k] -= x * d[k * n + c];
      d[r * n + r] -= x * l;
      d[r * n + c] = l;
    }
    d[c * n + c] = inverse;
  }
  return cut;
}

/// Size of a block of the factor beside the diagonal: a row for each unknown of the eliminated
/// node, as wide as the other node has unknowns.
struct BlockSize {
  std::size_t rows, width;
};

/// Y = L^-1 B into `y`, and D^-1 Y in place of B.
template <int R, class T>
void solve_lower(const T* d, T* b, T* y, const BlockSize& size) {
  const std::size_t n = R ? R : size.rows, width = R ? R : size.width;
  for (std::size_t c = 0; c < n; ++c) {
    PANTIN_ASSERT(width <= 6);
    T own[6];  // stays in registers: nothing else can point to it
    for (std::size_t r = 0; r < width; ++r) own[r] = b[c * width + r];
    for (std::size_t k = 0; k < c; ++k) {
      const T l = d[c * n + k];
      for (std::size_t r = 0; r < width; ++r) own[r] -= l * y[k * width + r];
    }
    const T inverse = d[c * n + c];
    for (std::size_t r = 0; r < width; ++r)
      y[c * width + r] = own[r], b[c * width + r] = own[r] * inverse;
  }
}

/// Sizes of two blocks of the factor that belong to the same eliminated node.
struct PairSize {
  std::size_t rows, width_z, width_y;
};

/// T -= Z^T Y. Of a block on the diagonal only the lower part is read later.
template <int R, class T>
void subtract_product(const T* z, const T* y, T* t, const PairSize& size) {
  const std::size_t n = R ? R : size.rows, wz = R ? R : size.width_z, wy = R ? R : size.width_y;
  for (std::size_t r = 0; r < wz; ++r) {
    T row[6];
    for (std::size_t s = 0; s < wy; ++s) row[s] = t[r * wy + s];
    for (std::size_t k = 0; k < n; ++k) {
      const T part = z[k * wz + r];
      for (std::size_t s = 0; s < wy; ++s) row[s] -= part * y[k * wy + s];
    }
    for (std::size_t s = 0; s < wy; ++s) t[r * wy + s] = row[s];
  }
}

/// Eliminates the node at a place of the order. Returns the number of dropped pivots.
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

/// The same for a place of rows, by how many there are.
template <class T>
int eliminate_rows(const KktPattern& p, T* v, std::uint32_t at, const PivotRule& rule) {
  const std::size_t n = p.size[at];
  return n == 1   ? eliminate<1>(p, v, at, rule)
         : n == 3 ? eliminate<3>(p, v, at, rule)
         : n == 5 ? eliminate<5>(p, v, at, rule)
                  : eliminate<0>(p, v, at, rule);
}

/// other -= B^T own, and own -= B other, for one block of the factor beside the diagonal.
template <int R, class T>
void update_forward(const T* b, const T* own, T* other, const BlockSize& size) {
  const std::size_t n = R ? R : size.rows, width = R ? R : size.width;
  PANTIN_ASSERT(width <= 6);
  T sum[6];
  for (std::size_t r = 0; r < width; ++r) sum[r] = other[r];
  for (std::size_t k = 0; k < n; ++k) {
    const T part = own[k];
    for (std::size_t r = 0; r < width; ++r) sum[r] -= b[k * width + r] * part;
  }
  for (std::size_t r = 0; r < width; ++r) other[r] = sum[r];
}
template <int R, class T>
void update_back(const T* b, T* own, const T* other, const BlockSize& size) {
  const std::size_t n = R ? R : size.rows, width = R ? R : size.width;
  for (std::size_t k = 0; k < n; ++k) {
    T sum = own[k];
    for (std::size_t r = 0; r < width; ++r) sum -= b[k * width + r] * other[r];
    own[k] = sum;
  }
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
