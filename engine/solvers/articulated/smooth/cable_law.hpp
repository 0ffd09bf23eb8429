#pragma once
/// The law of a cable in a step by the energy-momentum method, of one cable or of several side by
/// side: its load, and its row of the equations that couple ties. See conserving_ties.cpp.
///
/// `V` is a vector, `S` a number, or numbers side by side; dot(), root() and choose() of these are
/// declared before this file. Makes no code of its own: the kernels include it.
#include "engine/base/compiler.hpp"

namespace pantin::detail::articulated {
namespace {

/// Of the island's size: a cable is at its length.
inline constexpr double kAtLength = 1e-10;
/// Likewise: a tie that is wider open is no solution.
inline constexpr double kAccepted = 3e-6;
/// Likewise: the next iteration would change the length of an elastic cable by less. Rotations
/// alone do not tell when a stiff one is solved that has just become taut or slack.
inline constexpr double kFollowed = 1e-9;
/// Of the change of d by a cable's impulse: what its direction changes of the impulse makes less of
/// it, and is left to the next iteration.
inline constexpr double kSlight = 0.1;
/// After so many iterations one cable at a time changes: changes of many may go round in circles.
inline constexpr int kChangeAtOnce = 6;

/// Impulse of half the step that pulls b to a, kg m/s; its derivative by d at the end, by columns;
/// its part along the mean of d, kg/s.
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

/// The impulse of a taut cable is along the mean of d: that part of `mu`, and its factor, kg/s.
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

/// Along the mean of d: where the impulse of a taut cable acts.
template <class V>
PANTIN_INLINE V direction_of(const CableSpan<V>& d) {
  return unit_of(d.before + d.now);
}

/// Of an elastic cable: minus its tension is s d, s = 2 (V_1 - V_0) / (l_1^2 - l_0^2), d being the
/// mean of d before and after, so that its work is the difference of what is stored. [Gonzalez
/// 1996]
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

/// Of an inextensible one that is taut: along the mean of d, its length; `softness`, s/kg.
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
/// The impulse of a stretched cable follows from d, by its `derivative`.
template <class V>
PANTIN_INLINE auto equation_of_elastic(const CableSpan<V>& d, const V (&derivative)[3]) {
  const V n = direction_of(d), by = times_columns(n, derivative);
  const auto stiffness = length_of(by);
  using S = decltype(length_of(by));
  return CableEquation<V, S>{n, divided(by, stiffness), S{}, 1.0 / stiffness};
}

}  // namespace
}  // namespace pantin::detail::articulated
