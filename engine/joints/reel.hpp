#pragma once
/// How the length of a cable passes through a step in which it changes.
#include "engine/joints/cable.hpp"

namespace pantin::detail {

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
