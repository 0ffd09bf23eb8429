#pragma once
/// Polynomials of two parameters by control points: products and derivatives. Their hulls bound the
/// derivatives and normals of a rational piece.
#include <algorithm>
#include <vector>

#include "engine/nurbs/spline.hpp"

namespace pantin::detail::nurbs {

/// Degree p along u and q along v. Coefficients are stored times their two binomials, so that a
/// product is a convolution. Derivatives are by parameters that run from -1 to 1.
template <class T>
struct Bernstein {
  int p = 0, q = 0;
  std::vector<T> scaled;  // [i * (q + 1) + j]

  Bernstein(int by_u, int by_v)
      : p(by_u), q(by_v), scaled(static_cast<std::size_t>((by_u + 1) * (by_v + 1)), T(0)) {}
  T& at(int i, int j) { return scaled[static_cast<std::size_t>(i * (q + 1) + j)]; }
  const T& at(int i, int j) const { return scaled[static_cast<std::size_t>(i * (q + 1) + j)]; }
};

/// The binomials of n.
inline std::vector<Real> binomials(int n) {
  std::vector<Real> row(static_cast<std::size_t>(n + 1), 1);
  for (int k = 1; k <= n; ++k)
    row[static_cast<std::size_t>(k)] = row[static_cast<std::size_t>(k - 1)] * (n - k + 1) / k;
  return row;
}

/// Calls `each(c)` for the control points.
template <class T, class Each>
void for_each_coefficient(const Bernstein<T>& of, Each&& each) {
  const std::vector<Real> by_u = binomials(of.p), by_v = binomials(of.q);
  for (std::size_t i = 0; i < by_u.size(); ++i)
    for (std::size_t j = 0; j < by_v.size(); ++j)
      each((1 / (by_u[i] * by_v[j])) * of.scaled[i * by_v.size() + j]);
}

template <class T>
Bernstein<T> derivative(const Bernstein<T>& of, Along way) {
  const bool is_u = way == Along::u;
  if ((is_u ? of.p : of.q) == 0) return Bernstein<T>(of.p, of.q);
  Bernstein<T> d(of.p - (is_u ? 1 : 0), of.q - (is_u ? 0 : 1));
  for (int i = 0; i <= d.p; ++i)
    for (int j = 0; j <= d.q; ++j)
      d.at(i, j) = is_u ? 0.5 * ((i + 1.0) * of.at(i + 1, j) - Real(of.p - i) * of.at(i, j))
                        : 0.5 * ((j + 1.0) * of.at(i, j + 1) - Real(of.q - j) * of.at(i, j));
  return d;
}

/// The product, given a product of coefficients.
template <class A, class B, class Times>
auto product(const Bernstein<A>& a, const Bernstein<B>& b, Times&& times) {
  Bernstein<decltype(times(a.scaled[0], b.scaled[0]))> c(a.p + b.p, a.q + b.q);
  for (int i = 0; i <= a.p; ++i)
    for (int j = 0; j <= a.q; ++j)
      for (int k = 0; k <= b.p; ++k)
        for (int l = 0; l <= b.q; ++l) c.at(i + k, j + l) += times(a.at(i, j), b.at(k, l));
  return c;
}

/// The numerator of a derivative of the quotient `top` / w^power, over w^(power + 1).
inline Bernstein<Vec3> differentiated(const Bernstein<Vec3>& top, const Bernstein<Real>& w,
                                      int power, Along way) {
  const auto times = [](Real x, Vec3 y) { return x * y; };
  Bernstein<Vec3> d = product(w, derivative(top, way), times);
  const Bernstein<Vec3> rest = product(derivative(w, way), top, times);
  for (std::size_t i = 0; i < d.scaled.size(); ++i) d.scaled[i] -= Real(power) * rest.scaled[i];
  return d;
}

}  // namespace pantin::detail::nurbs
