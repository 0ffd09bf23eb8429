#pragma once
/// Real roots of polynomials up to degree three.
#include <array>

#include "engine/base/math.hpp"

namespace pantin::detail::modes {

/// At most three, ascending.
struct Roots {
  std::array<Real, 3> list{};
  std::size_t count = 0;

  const Real* begin() const { return list.data(); }
  const Real* end() const { return list.data() + count; }
};

/// All roots t >= 0 of p[0] + p[1] t + p[2] t^2 + p[3] t^3 to the last digits; a double root, which
/// the polynomial touches without passing through 0, is one. None of the polynomial 0.
/// Leading coefficients below 1e-15 of the largest are rounding errors.
Roots real_roots(const std::array<Real, 4>& p);

}  // namespace pantin::detail::modes
