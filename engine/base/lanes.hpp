#pragma once
/// SIMD vectors of two and four doubles, and of eight where the machine has registers for them:
/// arithmetic, comparisons to a mask, `choose` by a mask, []. Either compiler vectors or plain
/// arrays, with the same bits; see compiler.hpp.
///
/// In an unnamed namespace: translation units that include this are built for several instruction
/// sets, and the linker must not merge their code.
#include "engine/base/compiler.hpp"

PANTIN_QUIET_VECTORS

namespace pantin::detail {
namespace {

#if defined(__GNUC__) && !defined(PANTIN_PLAIN_CPP)

typedef double Four __attribute__((vector_size(32)));
typedef double Two __attribute__((vector_size(16)));
typedef double UnalignedFour __attribute__((vector_size(32), aligned(8), may_alias));

#ifdef __AVX512F__
#define PANTIN_HAS_EIGHT
typedef double Eight __attribute__((vector_size(64)));
typedef double UnalignedEight __attribute__((vector_size(64), aligned(8), may_alias));

PANTIN_INLINE Eight load_eight(const double* p) {
  return *reinterpret_cast<const UnalignedEight*>(p);
}
PANTIN_INLINE void store_eight(double* p, Eight v) { *reinterpret_cast<UnalignedEight*>(p) = v; }
#endif

PANTIN_INLINE Four load_four(const double* p) { return *reinterpret_cast<const UnalignedFour*>(p); }
PANTIN_INLINE void store_four(double* p, Four v) { *reinterpret_cast<UnalignedFour*>(p) = v; }

template <class Mask, class T>
PANTIN_INLINE T choose(Mask mask, T yes, T no) {
  return mask ? yes : no;
}

#else

template <class T, int N>
struct LanesOf {
  T lane[N];
  PANTIN_INLINE T& operator[](unsigned long long i) { return lane[i]; }
  PANTIN_INLINE T operator[](unsigned long long i) const { return lane[i]; }
};
using Four = LanesOf<double, 4>;
using Two = LanesOf<double, 2>;

// Lane by lane; a scalar is broadcast to all lanes.
#define PANTIN_LANES(op, Result)                                                             \
  template <int N>                                                                           \
  PANTIN_INLINE LanesOf<Result, N> operator op(LanesOf<double, N> a, LanesOf<double, N> b) { \
    LanesOf<Result, N> r{};                                                                  \
    for (int i = 0; i < N; ++i) r.lane[i] = a.lane[i] op b.lane[i];                          \
    return r;                                                                                \
  }                                                                                          \
  template <int N>                                                                           \
  PANTIN_INLINE LanesOf<Result, N> operator op(double a, LanesOf<double, N> b) {             \
    LanesOf<Result, N> r{};                                                                  \
    for (int i = 0; i < N; ++i) r.lane[i] = a op b.lane[i];                                  \
    return r;                                                                                \
  }                                                                                          \
  template <int N>                                                                           \
  PANTIN_INLINE LanesOf<Result, N> operator op(LanesOf<double, N> a, double b) {             \
    LanesOf<Result, N> r{};                                                                  \
    for (int i = 0; i < N; ++i) r.lane[i] = a.lane[i] op b;                                  \
    return r;                                                                                \
  }
PANTIN_LANES(+, double)
PANTIN_LANES(-, double)
PANTIN_LANES(*, double)
PANTIN_LANES(/, double)
PANTIN_LANES(<, long long)
PANTIN_LANES(>, long long)
PANTIN_LANES(>=, long long)
PANTIN_LANES(==, long long)
#undef PANTIN_LANES

template <int N>
PANTIN_INLINE LanesOf<double, N> operator-(LanesOf<double, N> a) {
  for (double& x : a.lane) x = -x;
  return a;
}
template <class T, int N, class Other>
PANTIN_INLINE LanesOf<T, N>& operator+=(LanesOf<T, N>& a, Other b) {
  return a = a + b;
}
template <class T, int N, class Other>
PANTIN_INLINE LanesOf<T, N>& operator-=(LanesOf<T, N>& a, Other b) {
  return a = a - b;
}
template <class T, int N, class Other>
PANTIN_INLINE LanesOf<T, N>& operator*=(LanesOf<T, N>& a, Other b) {
  return a = a * b;
}
template <int N>
PANTIN_INLINE LanesOf<long long, N> operator|(LanesOf<long long, N> a, LanesOf<long long, N> b) {
  for (int i = 0; i < N; ++i) a.lane[i] |= b.lane[i];
  return a;
}
template <int N>
PANTIN_INLINE LanesOf<long long, N> operator&(LanesOf<long long, N> a, LanesOf<long long, N> b) {
  for (int i = 0; i < N; ++i) a.lane[i] &= b.lane[i];
  return a;
}

PANTIN_INLINE Four load_four(const double* p) { return {p[0], p[1], p[2], p[3]}; }
PANTIN_INLINE void store_four(double* p, Four v) {
  for (int i = 0; i < 4; ++i) p[i] = v.lane[i];
}

template <class T, int N>
PANTIN_INLINE LanesOf<T, N> choose(LanesOf<long long, N> mask, LanesOf<T, N> yes,
                                   LanesOf<T, N> no) {
  for (int i = 0; i < N; ++i) no.lane[i] = mask.lane[i] != 0 ? yes.lane[i] : no.lane[i];
  return no;
}

#endif

}  // namespace
}  // namespace pantin::detail
