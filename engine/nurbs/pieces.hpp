#pragma once
/// The polynomial pieces of a spline: the piece of a parameter, and its powers.
#include <span>

#include "engine/nurbs/knots.hpp"

namespace pantin::detail::nurbs {

/// The piece of a parameter among those that begin at `starts`; the first or the last outside the
/// domain. Without branches, since half of them would be mispredicted.
inline std::size_t piece_at(std::span<const Real> starts, Real t) {
  std::size_t first = 0, count = starts.size();
  while (count > 1) {
    const std::size_t half = count / 2;
    first += starts[first + half] <= t ? half : 0;
    count -= half;
  }
  return first;
}

/// Converts a Bezier piece to powers about its middle, in place: coefficient k is derivative k /
/// k!, with the parameter from -1/2 to 1/2.
void to_powers(std::span<Weighted> piece);

}  // namespace pantin::detail::nurbs
