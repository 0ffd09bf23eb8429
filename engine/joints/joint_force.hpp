#pragma once
/// Springs, friction and motors along a coordinate of a joint: one law for all solvers.
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/joints/parameters.hpp"

namespace pantin::detail {

/// The force along the coordinate, N or N m, and minus its derivatives by the coordinate and by its
/// rate, at given values of both.
struct LinearisedForce {
  Real force = 0, stiffness = 0, damping = 0;
};
/// Secants converge for forces that saturate.
enum class Slope : std::uint8_t { tangent, secant };
LinearisedForce linearise(const Dof& dof, Real coordinate, Real rate, Slope slope);

/// J: energy of a spring along a coordinate.
inline Real energy_of(const SpringDamper& spring, Real coordinate) {
  const Real off = coordinate - spring.rest;
  return 0.5 * spring.stiffness * off * off;
}

/// Whether the force saturates: dry friction, or a motor with a cap.
bool saturates(const Dof& dof);

/// Whether all its numbers are valid, and dry friction is regularised near zero rate.
bool is_sound(const Dof& dof);

/// Solves x = freely + yield force(x) for a force that decreases with x; `force` returns it and
/// minus its derivative. Newton's method, safeguarded by a bracket.
template <class Force>
Real settled(Real freely, Real yield, const Force& force) {
  constexpr int kMostIterations = 30;
  constexpr Real kEnough = 1e-15;
  const Real first = freely + yield * force(freely)[0];
  Real low = std::min(first, freely), high = std::max(first, freely), x = freely;
  for (int n = 0; n < kMostIterations && high - low > kEnough * (1 + std::abs(x)); ++n) {
    const auto [value, slope] = force(x);
    const Real off = freely + yield * value - x;
    (off > 0 ? low : high) = x;
    if (std::abs(off) <= kEnough * (1 + std::abs(x))) break;
    const Real next = x + off / (1 + yield * slope);
    x = next > low && next < high ? next : 0.5 * (low + high);
  }
  return x;
}

/// A coordinate and its rate at the start of a step, and the length of that, s.
struct RateAt {
  Real coordinate = 0, rate = 0, h = 0;
};
/// The rate after a step in which only the force acts, which follows its law at the end.
/// `response`: change of the rate by an impulse.
Real rate_after(const Dof& dof, const RateAt& at, Real response);

}  // namespace pantin::detail
