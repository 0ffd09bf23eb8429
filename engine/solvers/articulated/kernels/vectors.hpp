#pragma once
/// Vectors, quaternions and symmetric matrices, scalar or SIMD, and the maps between rotations and
/// rotation vectors.
///
/// Like all files of this folder part of kernels.cpp, which is compiled once per instruction set:
/// nothing in them has external linkage.
#include <math.h>

#include "engine/base/lanes.hpp"

namespace pantin::detail::articulated {
namespace {

#define INLINE PANTIN_INLINE  // until the end of kernels.cpp

INLINE Four load(const double* p) { return load_four(p); }
INLINE void store(double* p, Four v) { store_four(p, v); }
INLINE Four root(Four x) { return Four{::sqrt(x[0]), ::sqrt(x[1]), ::sqrt(x[2]), ::sqrt(x[3])}; }
/// Numbers in a scalar or SIMD vector.
template <class T>
inline constexpr std::size_t kNumbersIn = 1;
template <>
inline constexpr std::size_t kNumbersIn<Four> = 4;
#ifdef PANTIN_HAS_EIGHT
template <>
inline constexpr std::size_t kNumbersIn<Eight> = 8;
INLINE void store(double* p, Eight v) { store_eight(p, v); }
INLINE Eight root(Eight x) {
  return Eight{::sqrt(x[0]), ::sqrt(x[1]), ::sqrt(x[2]), ::sqrt(x[3]),
               ::sqrt(x[4]), ::sqrt(x[5]), ::sqrt(x[6]), ::sqrt(x[7])};
}
using Lane = Eight;
#else
using Lane = Four;
#endif
/// Islands per SIMD vector.
inline constexpr std::size_t kWide = kNumbersIn<Lane>;
/// The same number in all lanes.
template <class F = Four>
INLINE F all(double x) {
  return x - F{};
}
INLINE double sum(Four x) { return (x[0] + x[1]) + (x[2] + x[3]); }
INLINE double largest(Four x) {
  const double a = x[0] > x[1] ? x[0] : x[1], b = x[2] > x[3] ? x[2] : x[3];
  return a > b ? a : b;
}
template <class F>
INLINE bool any_not_below(F x, double bound) {
  const auto below = x < all<F>(bound);
  auto every = below[0];
  for (std::size_t l = 1; l < kNumbersIn<F>; ++l) every &= below[l];
  return every == 0;
}

/// Vectors and quaternions of T: a scalar or a SIMD vector.
template <class T>
struct Vec {
  T x, y, z;
};
template <class T>
struct Qua {
  T x, y, z, w;
};
/// Symmetric 3x3.
template <class T>
struct Sym {
  T xx, xy, xz, yy, yz, zz;
};

template <class T>
INLINE Vec<T> operator+(Vec<T> a, Vec<T> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
INLINE Vec<T> operator-(Vec<T> a, Vec<T> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
INLINE Vec<T> operator*(T s, Vec<T> a) {
  return {s * a.x, s * a.y, s * a.z};
}
INLINE Vec<Four> operator*(double s, Vec<Four> a) { return {s * a.x, s * a.y, s * a.z}; }
#ifdef PANTIN_HAS_EIGHT
INLINE Vec<Eight> operator*(double s, Vec<Eight> a) { return {s * a.x, s * a.y, s * a.z}; }
#endif
template <class T>
INLINE T dot(Vec<T> a, Vec<T> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
INLINE Vec<T> cross(Vec<T> a, Vec<T> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
INLINE Vec<T> mul(Sym<T> m, Vec<T> v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
template <class T>
INLINE Qua<T> mul(Qua<T> p, Qua<T> q) {
  return {
      p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y, p.w * q.y - p.x * q.z + p.y * q.w + p.z * q.x,
      p.w * q.z + p.x * q.y - p.y * q.x + p.z * q.w, p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z};
}
template <class T>
INLINE Vec<T> rotated(Qua<T> q, Vec<T> v) {
  const Vec<T> u{q.x, q.y, q.z};
  Vec<T> t = cross(u, v);
  t = t + t;
  return v + q.w * t + cross(u, t);
}
template <class T>
INLINE Qua<T> back(Qua<T> q) {
  return {-q.x, -q.y, -q.z, q.w};
}
template <class F>
INLINE F norm2(Qua<F> q) {
  return q.x * q.x + q.y * q.y + (q.z * q.z + q.w * q.w);
}
template <class F>
INLINE Qua<F> scaled(F s, Qua<F> q) {
  return {s * q.x, s * q.y, s * q.z, s * q.w};
}
template <class F>
INLINE Qua<F> unit(Qua<F> q) {
  return scaled(1.0 / root(norm2(q)), q);
}
/// The same for a quaternion that is normalised up to rounding, without root and division.
template <class F>
INLINE Qua<F> unit_again(Qua<F> q) {
  const F off = norm2(q) - 1.0, nearly = (0.375 * off - 0.5) * off + 1.0;
  if (!any_not_below(off * off, 1e-12)) return scaled(nearly, q);
  return scaled(choose(off * off < 1e-12, nearly, 1.0 / root(norm2(q))), q);
}

template <class Mask, class F>
INLINE Vec<F> chosen(Mask mask, Vec<F> yes, Vec<F> no) {
  return {choose(mask, yes.x, no.x), choose(mask, yes.y, no.y), choose(mask, yes.z, no.z)};
}
template <class Mask, class F>
INLINE Qua<F> chosen(Mask mask, Qua<F> yes, Qua<F> no) {
  return {choose(mask, yes.x, no.x), choose(mask, yes.y, no.y), choose(mask, yes.z, no.z),
          choose(mask, yes.w, no.w)};
}

// Below, each lane depends on that lane only, whichever branch the others take.

/// cos(a/2) and sin(a/2)/(a/2) of angles up to 1 rad, from t = (a/2)^2. Taylor series, summed in
/// pairs to shorten the chain of dependent additions.
template <class F>
INLINE F cosine_of(F t) {
  const F t2 = t * t, t4 = t2 * t2;
  return ((1.0 - t * (1.0 / 2)) + t2 * (1.0 / 24 - t * (1.0 / 720))) +
         t4 * ((1.0 / 40320 - t * (1.0 / 3628800)) +
               t2 * (1.0 / 479001600 - t * (1.0 / 87178291200)));
}
template <class F>
INLINE F sine_part_of(F t) {
  const F t2 = t * t, t4 = t2 * t2;
  return ((1.0 - t * (1.0 / 6)) + t2 * (1.0 / 120 - t * (1.0 / 5040))) +
         t4 * ((1.0 / 362880 - t * (1.0 / 39916800)) +
               t2 * (1.0 / 6227020800 - t * (1.0 / 1307674368000)));
}

/// The quaternion of a rotation vector: by series up to 1 rad, by doubling an eighth of the angle
/// up to 8 rad, by the library beyond.
template <class F>
INLINE Qua<F> exponential(Vec<F> r) {
  const F t = 0.25 * dot(r, r);
  const F s = 0.5 * sine_part_of(t);
  const Qua<F> by_series{s * r.x, s * r.y, s * r.z, cosine_of(t)};
  if (!any_not_below(t, 0.25)) return by_series;
  const F part = (1.0 / 64) * t;
  const F eighth = (1.0 / 16) * sine_part_of(part);
  Qua<F> q{eighth * r.x, eighth * r.y, eighth * r.z, cosine_of(part)};
  for (int doubling = 0; doubling < 3; ++doubling) {
    const F w = q.w + q.w;
    q = {w * q.x, w * q.y, w * q.z, w * q.w - 1.0};
  }
  if (any_not_below(t, 16.0)) {
    for (std::size_t l = 0; l < kNumbersIn<F>; ++l) {
      if (t[l] < 16.0) continue;
      const double half = ::sqrt(t[l]), by = 0.5 * ::sin(half) / half;
      q.x[l] = by * r.x[l], q.y[l] = by * r.y[l], q.z[l] = by * r.z[l], q.w[l] = ::cos(half);
    }
  }
  return chosen(t < 0.25, by_series, q);
}

/// atan of a tangent in [0, 1], by the rational approximation of the Cephes library; above 0.66 by
/// the reduction from a quarter of pi.
template <class F>
INLINE F arc_tangent(F t) {
  const auto large = t > all<F>(0.66);
  const F x = choose(large, (t - 1.0) / (t + 1.0), t);
  const F z = x * x;
  const F p = ((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z -
               7.500855792314704667340e1) *
                  z -
              1.228866684490136173410e2;
  const F d = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z +
                4.328810604912902668951e2) *
                   z +
               4.853903996359136964868e2) *
                  z +
              1.945506571482613964425e2;
  const F a = x + x * z * (p * z - 6.485021904942025371773e1) / d;
  return choose(large, a + 0.78539816339744830962, a);
}

/// The shortest rotation vector of a unit quaternion: 2 asin(n)/n times its vector part, by the
/// series up to 0.4 rad, above that by the tangent of a quarter of the angle.
template <class F>
INLINE Vec<F> logarithm(Qua<F> q) {
  const F sign = choose(q.w < 0.0, all<F>(-1.0), all<F>(1.0));
  const F z = q.x * q.x + q.y * q.y + q.z * q.z;
  const F z2 = z * z, z4 = z2 * z2, z8 = z4 * z4;
  const F series =
      ((1.0 + z * (1.0 / 6)) + z2 * (3.0 / 40 + z * (5.0 / 112))) +
      z4 * ((35.0 / 1152 + z * (63.0 / 2816)) + z2 * (231.0 / 13312 + z * (143.0 / 10240))) +
      z8 * ((6435.0 / 557056 + z * (12155.0 / 1245184)) + z2 * (46189.0 / 5505024));
  F s = 2.0 * sign * series;
  if (any_not_below(z, 0.04)) {
    const F n = root(z);
    const auto turned = n > all<F>(1e-150);
    const F some = choose(turned, n, all<F>(1.0));
    const F by_tangent =
        choose(turned, 4.0 * arc_tangent(some / (1.0 + sign * q.w)) / some, all<F>(2.0));
    s = choose(z < 0.04, s, sign * by_tangent);
  }
  return {s * q.x, s * q.y, s * q.z};
}

}  // namespace
}  // namespace pantin::detail::articulated
