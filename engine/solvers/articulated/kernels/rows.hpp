#pragma once
/// Three rows of a 3x3 matrix, each followed by the component of a vector: scalar, or vectorised
/// over islands.
#include "engine/solvers/articulated/kernels/table.hpp"

namespace pantin::detail::articulated {
namespace {

/// A scalar row is one SIMD vector; a vectorised row is four SIMD vectors.
template <class F>
struct LaneRow {
  F at[4];
  INLINE F& operator[](std::size_t i) { return at[i]; }
  INLINE F operator[](std::size_t i) const { return at[i]; }
};
template <class F>
INLINE LaneRow<F> operator+(const LaneRow<F>& a, const LaneRow<F>& b) {
  return {{a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]}};
}
template <class F>
INLINE LaneRow<F> operator-(const LaneRow<F>& a, const LaneRow<F>& b) {
  return {{a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]}};
}
template <class F>
INLINE LaneRow<F> operator*(F s, const LaneRow<F>& a) {
  return {{s * a[0], s * a[1], s * a[2], s * a[3]}};
}
template <class F>
INLINE void operator+=(LaneRow<F>& a, const LaneRow<F>& b) {
  a = a + b;
}
template <class F>
INLINE void operator-=(LaneRow<F>& a, const LaneRow<F>& b) {
  a = a - b;
}

template <class N>
struct RowType {
  using Type = LaneRow<N>;
};
template <>
struct RowType<double> {
  using Type = Four;
};
template <class N>
using Row = typename RowType<N>::Type;

INLINE Four row_of(double a, double b, double c, double d) { return Four{a, b, c, d}; }
template <class F>
INLINE LaneRow<F> row_of(F a, F b, F c, F d) {
  return {{a, b, c, d}};
}

/// Consecutive numbers from `p`: scalars, or SIMD vectors.
template <class N>
INLINE double* number_at(double* p, std::size_t i) {
  return p + i * kNumbersIn<N>;
}
template <class N>
INLINE const double* number_at(const double* p, std::size_t i) {
  return p + i * kNumbersIn<N>;
}
template <class N>
INLINE N get(const double* p, std::size_t i) {
  return read<N>(number_at<N>(p, i));
}
template <class N>
INLINE Vec<N> get_vec(const double* p, std::size_t i) {
  return {get<N>(p, i), get<N>(p, i + 1), get<N>(p, i + 2)};
}
template <class N>
INLINE void set_vec(double* p, std::size_t i, Vec<N> v) {
  write(number_at<N>(p, i), v.x), write(number_at<N>(p, i + 1), v.y),
      write(number_at<N>(p, i + 2), v.z);
}

template <class N>
struct Rows {
  Row<N> x, y, z;
  INLINE static Row<N> one_from(const double* p, std::size_t i) {
    if constexpr (kNumbersIn<N> == 1)
      return load(p + i);
    else
      return {{get<N>(p, i), get<N>(p, i + 1), get<N>(p, i + 2), get<N>(p, i + 3)}};
  }
  INLINE static Rows from(const double* p, std::size_t i) {
    return {one_from(p, i), one_from(p, i + 4), one_from(p, i + 8)};
  }
  INLINE void to(double* p, std::size_t i) const {
    put_row(p, i, x), put_row(p, i + 4, y), put_row(p, i + 8, z);
  }

 private:
  INLINE static void put_row(double* p, std::size_t i, const Row<N>& row) {
    if constexpr (kNumbersIn<N> == 1)
      store(p + i, row);
    else
      for (std::size_t n = 0; n < 4; ++n) store(number_at<N>(p, i + n), row[n]);
  }
};

/// A 3 x 3 matrix by rows, as in the factors of ties and in nodes.
template <class N>
struct MatrixRows {
  Vec<N> x, y, z;
  /// The first three numbers of three rows of four.
  INLINE static MatrixRows from(const double* p, std::size_t i) {
    return {get_vec<N>(p, i), get_vec<N>(p, i + 4), get_vec<N>(p, i + 8)};
  }
};
template <class N>
INLINE Vec<N> mul(const MatrixRows<N>& m, Vec<N> v) {
  return {dot(m.x, v), dot(m.y, v), dot(m.z, v)};
}
template <class N>
INLINE Vec<N> mul(Vec<N> v, const MatrixRows<N>& m) {
  return (v.x * m.x + v.y * m.y) + v.z * m.z;
}

/// The fourth numbers of three rows.
template <class N>
INLINE Vec<N> fourths(const double* p, std::size_t i) {
  return {get<N>(p, i + 3), get<N>(p, i + 7), get<N>(p, i + 11)};
}
template <class N>
INLINE void set_fourths(double* p, std::size_t i, Vec<N> v) {
  write(number_at<N>(p, i + 3), v.x), write(number_at<N>(p, i + 7), v.y);
  write(number_at<N>(p, i + 11), v.z);
}

}  // namespace
}  // namespace pantin::detail::articulated
