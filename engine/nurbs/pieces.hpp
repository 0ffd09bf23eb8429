#pragma once
/// The polynomial pieces of a spline: which one a parameter is in, and its powers.
#include <span>

#include "engine/nurbs/knots.hpp"

namespace pantin::detail::nurbs {

/// The piece of a parameter, of those that begin at `starts`; the first or the last outside of the
/// domain. Without branches, which would be guessed wrong half of the time.
inline std::size_t piece_at(std::span<const Real> starts, Real t) {
  std::size_t first = 0, count = starts.size();
  while (count > 1) {
    const std::size_t half = count / 2;
    first += starts[first + half] <= t ? half : 0;
    count -= half;
  }
  return first;
}

/// The powers of a Bezier piece about its middle, in place: coefficient k is derivative k by k!,
/// the parameter from -1/2 to 1/2.
void to_powers(std::span<Weighted> piece);

}  // namespace pantin::detail::nurbs
