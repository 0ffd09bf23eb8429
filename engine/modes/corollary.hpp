#pragma once
/// Feasibility by plane geometry: the sense of moments about where lines of action meet. It shares
/// no formula with the regions, which tests compare it with. [Trinkle & Zeng 1995, Corollary 1]
#include "engine/modes/prepare.hpp"

namespace pantin::detail::modes {

enum class Geometric : std::uint8_t {
  feasible,
  infeasible,
  concurrent  // the lines of action meet in one point or are parallel: forces without bound
};

/// Whether forces of the region's mode balance the load at its own coefficients. Two lines that
/// meet at infinity are compared by components across them.
Geometric by_moments(const Lamina& lamina, const Region& r, const OwnFriction& mu);

}  // namespace pantin::detail::modes
