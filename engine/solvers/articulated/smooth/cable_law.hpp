#pragma once
/// The law of a cable in a step by the energy-momentum method: its impulse, and its row of the
/// equations that couple ties. Scalar, or vectorised over several cables. See conserving_ties.cpp.
///
/// `V` is a vector, `S` a scalar or a SIMD vector of scalars; dot(), root() and choose() for these
/// are declared before this file is included. All is inlined: the kernels include it.
#include "engine/base/compiler.hpp"

namespace pantin::detail::articulated {
namespace {

/// Least response of a cable by which its compliance is chosen, as a fraction of that of the whole
/// island: two points of a rigid part have none but rounding.
inline constexpr double kRigidPart = 1e-6;
/// Tolerance of a cable's length, as a fraction of the island's size.
inline constexpr double kAtLength = 1e-10;
/// Likewise: largest gap of a tie in an accepted solution.
inline constexpr double kAccepted = 3e-6;
/// Likewise: convergence tolerance of an elastic cable's length. The change of rotations alone does
/// not show convergence of a stiff cable that has just become taut or slack.
inline constexpr double kFollowed = 1e-9;
/// Relative effect of a cable's change of direction on d, below which one row suffices: the change
/// of the impulse with the direction is left to the next iteration.
inline constexpr double kSlight = 0.1;
/// After so many iterations one cable changes state at a time: else the active set could cycle.
inline constexpr int kChangeAtOnce = 6;

/// Impulse over half the step that pulls b to a, kg m/s; its derivative by d at the end, by
/// columns; its ratio to the mean of d, kg/s.
template <class V, class S>
struct CableLoad {
  V mu, derivative[3];
  S across;
};
/// The equation by . d = right + own * impulse for an impulse along `direction`.
template <class V, class S>
struct CableEquation {
  V direction, by;
  S right, own;
};
/// d at the start and at the iterate, from a's point to b's, m.
template <class V>
struct CableSpan {
  V before, now;
};

template <class V>
PANTIN_INLINE auto length_of(const V& v) {
  return root(dot(v, v));
}
template <class V>
PANTIN_INLINE V unit_of(const V& v) {
  return (1.0 / length_of(v)) * v;
}
template <class V, class S>
PANTIN_INLINE V divided(const V& v, S by) {
  return V{v.x / by, v.y / by, v.z / by};
}

/// The impulse of a taut cable, projected to the mean of d; `across` is its ratio to that, kg/s.
template <class V, class S>
struct TautLoad {
  V mu;
  S across;
};
template <class V>
PANTIN_INLINE auto load_of_taut(const CableSpan<V>& d, const V& mu) {
  const V mean = 0.5 * (d.before + d.now);
  const auto across = dot(mu, mean) / dot(mean, mean);
  return TautLoad<V, decltype(dot(mu, mean))>{across * mean, across};
}

/// Direction of a taut cable's impulse: along the mean of d.
template <class V>
PANTIN_INLINE V direction_of(const CableSpan<V>& d) {
  return unit_of(d.before + d.now);
}

/// An elastic cable: its force is s times the mean of d before and after, with the discrete
/// gradient s = 2 (V_1 - V_0) / (l_1^2 - l_0^2), so that its work is the change of the stored
/// energy. [Gonzalez 1996]
template <class V, class S>
PANTIN_INLINE CableLoad<V, S> load_of_cable(const CableSpan<V>& d, S length, S stiffness, S h) {
  const S l0 = length_of(d.before), l1 = length_of(d.now), none = S{};
  const S over0 = choose(l0 > length, l0 - length, none),
          over1 = choose(l1 > length, l1 - length, none);
  const V mean = 0.5 * (d.before + d.now);
  const S both = l0 + l1, squares = l1 * l1 - l0 * l0;
  const auto stretched0 = over0 > none, stretched1 = over1 > none;
  const S of_both = stiffness * (1.0 - 2.0 * length / both);
  const S by_both = 2.0 * stiffness * length / (both * both);
  const S of_one = stiffness * (over1 * over1 - over0 * over0) / squares;
  const S by_one = 2.0 * (stiffness * over1 - of_one * l1) / squares;
  const S s =
      choose(stretched0, choose(stretched1, of_both, of_one), choose(stretched1, of_one, none));
  const S by_length =
      choose(stretched0, choose(stretched1, by_both, by_one), choose(stretched1, by_one, none));
  const S diagonal = 0.5 * h * (0.5 * s), f = 0.5 * h * by_length;
  const V along = divided(d.now, l1);
  const auto has_length = l1 > none;
  const auto column_of = [&](S component) {
    return V{choose(has_length, f * (mean.x * component), none),
             choose(has_length, f * (mean.y * component), none),
             choose(has_length, f * (mean.z * component), none)};
  };
  CableLoad<V, S> load{0.5 * h * s * mean,
                       {column_of(along.x), column_of(along.y), column_of(along.z)},
                       0.5 * h * s};
  load.derivative[0].x += diagonal, load.derivative[1].y += diagonal;
  load.derivative[2].z += diagonal;
  return load;
}

/// A taut inextensible cable: keeps its length by an impulse along the mean of d; `softness`, s/kg.
template <class V, class S>
PANTIN_INLINE CableEquation<V, S> equation_of_taut(const CableSpan<V>& d, const V& mu, S length,
                                                   S softness) {
  const V n = direction_of(d);
  const S l = length_of(d.now), too_long = 0.5 * (l - length * length / l);
  return {n, divided(d.now, l), softness * dot(n, mu) - too_long, softness};
}
/// A row times a matrix of columns.
template <class V>
PANTIN_INLINE V times_columns(const V& v, const V (&columns)[3]) {
  return V{dot(v, columns[0]), dot(v, columns[1]), dot(v, columns[2])};
}
/// A matrix of columns times a vector.
template <class V>
PANTIN_INLINE V times_vector(const V (&columns)[3], const V& v) {
  return v.x * columns[0] + v.y * columns[1] + v.z * columns[2];
}
/// The derivative of a taut cable's impulse by d at a given tension, by columns: see
/// load_of_taut().
template <class V, class S>
PANTIN_INLINE void turn_taut(S across, V (&columns)[3]) {
  const S none = S{}, own = choose(across > none, 0.5 * across, none);
  columns[0] = V{own, none, none}, columns[1] = V{none, own, none}, columns[2] = V{none, none, own};
}
/// Contribution of a grounded tie to the block of its body, by rows: that of a massless child at
/// the tie's end with an articulated mass, the derivative of the tie's impulse by d.
template <class V>
struct GroundedBlock {
  V tt[3], ty[3], yt[3], yy[3];
};
template <class V>
PANTIN_INLINE GroundedBlock<V> grounded_block(const V (&d)[3], const V& mean, const V& end) {
  GroundedBlock<V> b{
      {}, {}, {}, {{d[0].x, d[1].x, d[2].x}, {d[0].y, d[1].y, d[2].y}, {d[0].z, d[1].z, d[2].z}}};
  const V columns[3] = {cross(mean, d[0]), cross(mean, d[1]), cross(mean, d[2])};
  b.ty[0] = V{columns[0].x, columns[1].x, columns[2].x};
  b.ty[1] = V{columns[0].y, columns[1].y, columns[2].y};
  b.ty[2] = V{columns[0].z, columns[1].z, columns[2].z};
  for (int i = 0; i < 3; ++i) b.yt[i] = cross(end, b.yy[i]), b.tt[i] = cross(end, b.ty[i]);
  return b;
}
/// A stretched elastic cable: its impulse linearised in d by `derivative`.
template <class V>
PANTIN_INLINE auto equation_of_elastic(const CableSpan<V>& d, const V (&derivative)[3]) {
  const V n = direction_of(d), by = times_columns(n, derivative);
  const auto stiffness = length_of(by);
  using S = decltype(length_of(by));
  return CableEquation<V, S>{n, divided(by, stiffness), S{}, 1.0 / stiffness};
}

}  // namespace
}  // namespace pantin::detail::articulated
