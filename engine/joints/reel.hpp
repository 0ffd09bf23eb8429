#pragma once
/// How the length of a cable passes through a step in which it changes.
#include "engine/joints/cable.hpp"

namespace pantin::detail {

/// A length that changes in time, m, with its rate, m/s.
struct CableReel {
  Real length = 0, rate = 0;
};
/// Whether the length of a cable changes from what it was before; an unknown one is below 0.
inline bool is_reeled(const CableReel& before, const CableParameters& now) {
  return before.length >= 0 && (before.length != now.length || before.rate != 0 || now.rate != 0);
}
/// The length at a fraction of a step of h seconds between two known ones: Hermite's cubic. With
/// its acceleration, m/s^2.
struct ReeledLength : CableReel {
  Real acceleration = 0;
};
inline ReeledLength reeled_at(const CableReel& from, const CableReel& to, Real part, Real h) {
  const Real x = part, way = to.length - from.length;
  const Real square = 3 * way - h * (2 * from.rate + to.rate),
             cube = h * (from.rate + to.rate) - 2 * way;
  return {{from.length + x * (h * from.rate + x * (square + x * cube)),
           from.rate + x * (2 * square + 3 * x * cube) / h},
          (2 * square + 6 * x * cube) / (h * h)};
}

/// The length at a fraction of a step of h seconds: by the rates of a winch or, where the length is
/// changed without one, evenly. `before` is unknown below 0.
inline ReeledLength reeled_in_step(const CableReel& before, const CableParameters& now, Real part,
                                   Real h) {
  if (!is_reeled(before, now)) return {{now.length, 0}, 0};
  const Real way = now.length - before.length;
  if (before.rate == 0 && now.rate == 0) return {{before.length + part * way, way / h}, 0};
  return reeled_at(before, {now.length, now.rate}, part, h);
}

}  // namespace pantin::detail
