#pragma once
/// Small dense blocks of sparse symmetric factors, up to six rows and columns: L D L^T of diagonal
/// blocks, and the updates of the others. The scalar type is Real or one like it. R is the number
/// of rows and W that of columns if they are known at compile time, else 0. All forms of a function
/// take the same steps in the same order, so results do not depend on which one is called.
#include <cstddef>
#include <type_traits>

#include "engine/base/invariants.hpp"
#include "engine/base/math.hpp"

namespace pantin::detail {

/// Calls `act` with a size of 1 to 6 as a compile-time constant.
template <class F>
decltype(auto) with_size(std::size_t size, const F& act) {
  PANTIN_ASSERT(size >= 1 && size <= 6);
  switch (size) {
    case 1:
      return act(std::integral_constant<int, 1>{});
    case 2:
      return act(std::integral_constant<int, 2>{});
    case 3:
      return act(std::integral_constant<int, 3>{});
    case 4:
      return act(std::integral_constant<int, 4>{});
    case 5:
      return act(std::integral_constant<int, 5>{});
    default:  // 6
      return act(std::integral_constant<int, 6>{});
  }
}

/// The pivot with its expected sign; see PivotRule.
inline Real pivot_size(Real pivot, Real sign) { return sign * pivot; }

/// Accepts pivots of the given `sign` that exceed `least` times the row's scale. Mass blocks have
/// no scales, and all their pivots are accepted.
struct PivotRule {
  Real sign = 1;
  const Real* scales = nullptr;
  Real least = 0;
};

/// LDL^T of a square block, lower part; the diagonal becomes 1 / D. Pivots that the rule rejects
/// are dropped. Returns the number of dropped pivots.
template <int R, class T>
int decompose(T* d, std::size_t rows, const PivotRule& rule) {
  const std::size_t n = R ? R : rows;
  const Real least = rule.least;
  const Real* scales = rule.scales;
  int cut = 0;
  for (std::size_t c = 0; c < n; ++c) {
    const T pivot = d[c * n + c];
    const bool stands = pivot_size(pivot, rule.sign) > (scales ? least * scales[c] : 0);
    // Mass blocks stay positive definite under elimination. The first pivot is a sum without
    // cancellation; later ones may be lost to rounding where moments of inertia differ by many
    // orders of magnitude.
    PANTIN_ASSERT(scales || c > 0 || is_positive(pivot_size(pivot, rule.sign)));
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

/// Size of an off-diagonal block of the factor: a row for each unknown of the eliminated node, and
/// a column for each of the other node.
struct BlockSize {
  std::size_t rows, width;
};

/// Y = L^-1 B into `y`, and D^-1 Y in place of B.
template <int R, int W = R, class T>
void solve_lower(const T* d, T* b, T* y, const BlockSize& size) {
  const std::size_t n = R ? R : size.rows, width = W ? W : size.width;
  for (std::size_t c = 0; c < n; ++c) {
    PANTIN_ASSERT(width <= 6);
    T own[6];  // a local copy stays in registers, since nothing can alias it
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

/// T -= Z^T Y. Of a diagonal block only the lower part is read later.
template <int R, int Z = R, int W = R, class T>
void subtract_product(const T* z, const T* y, T* t, const PairSize& size) {
  const std::size_t n = R ? R : size.rows, wz = Z ? Z : size.width_z, wy = W ? W : size.width_y;
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

/// other -= B^T own, and own -= B other, for one off-diagonal block of the factor.
template <int R, int W = R, class T>
void update_forward(const T* b, const T* own, T* other, const BlockSize& size) {
  const std::size_t n = R ? R : size.rows, width = W ? W : size.width;
  PANTIN_ASSERT(width <= 6);
  T sum[6];
  for (std::size_t r = 0; r < width; ++r) sum[r] = other[r];
  for (std::size_t k = 0; k < n; ++k) {
    const T part = own[k];
    for (std::size_t r = 0; r < width; ++r) sum[r] -= b[k * width + r] * part;
  }
  for (std::size_t r = 0; r < width; ++r) other[r] = sum[r];
}
template <int R, int W = R, class T>
void update_back(const T* b, T* own, const T* other, const BlockSize& size) {
  const std::size_t n = R ? R : size.rows, width = W ? W : size.width;
  for (std::size_t k = 0; k < n; ++k) {
    T sum = own[k];
    for (std::size_t r = 0; r < width; ++r) sum -= b[k * width + r] * other[r];
    own[k] = sum;
  }
}

}  // namespace pantin::detail
