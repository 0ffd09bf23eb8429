#include "engine/modes/roots.hpp"

#include <algorithm>

namespace pantin::detail::modes {
namespace {

using Polynomial = std::array<Real, 4>;

Real at(const Polynomial& p, Real t) { return ((p[3] * t + p[2]) * t + p[1]) * t + p[0]; }

/// Sum of absolute terms: what at() rounds relative to.
Real magnitude(const Polynomial& p, Real t) {
  return ((std::abs(p[3]) * t + std::abs(p[2])) * t + std::abs(p[1])) * t + std::abs(p[0]);
}

/// The only root between two points of different sign.
Real between(const Polynomial& p, Real low, Real high) {
  const bool rises = at(p, low) < 0;
  Real t = (low + high) / 2;
  for (int i = 0; i < 200 && low < high; ++i) {
    const Real value = at(p, t);
    if (value == 0) return t;
    ((value < 0) == rises ? low : high) = t;
    const Real slope = (3 * p[3] * t + 2 * p[2]) * t + p[1];
    const Real newton = t - value / slope;
    // Newton's step where it stays between, else bisection.
    const Real next = newton > low && newton < high ? newton : low + (high - low) / 2;
    if (next == t || std::abs(next - t) <= 1e-16 * t) return next;
    t = next;
  }
  return t;
}

/// Where the derivative is 0, t > 0.
Roots turning_points(const Polynomial& p) {
  const Real a = 3 * p[3], b = p[2], c = p[1];  // a t^2 + 2 b t + c
  Roots out;
  const auto add = [&](Real t) {
    if (t > 0 && std::isfinite(t)) out.list[out.count++] = t;
  };
  if (a == 0) {
    if (b != 0) add(-c / (2 * b));
    return out;
  }
  const Real square = b * b - a * c;
  if (square < 0) return out;
  const Real q = -(b + std::copysign(std::sqrt(square), b));
  add(q / a);
  if (q != 0) add(c / q);
  if (out.count == 2 && out.list[1] < out.list[0]) std::swap(out.list[0], out.list[1]);
  return out;
}

void add_root(Roots& all, Real t) {
  if (all.count > 0 && t - all.list[all.count - 1] <= 1e-14 * t) return;
  if (all.count < 3) all.list[all.count++] = t;
}

}  // namespace

Roots real_roots(const std::array<Real, 4>& given) {
  Polynomial p = given;
  Real largest = 0;
  for (const Real x : p) largest = std::max(largest, std::abs(x));
  Roots all;
  if (!(largest > 0)) return all;
  int degree = 3;
  for (; degree > 0; --degree) {
    Real& lead = p[static_cast<std::size_t>(degree)];
    if (std::abs(lead) >= 1e-15 * largest) break;
    lead = 0;
  }
  if (degree == 0) return all;
  // Cauchy: no root is farther out.
  const Real far = 1 + largest / std::abs(p[static_cast<std::size_t>(degree)]);
  const Roots turns = turning_points(p);
  Real low = 0;
  const auto touches = [&](Real t) { return std::abs(at(p, t)) <= 4e-16 * magnitude(p, t); };
  for (std::size_t i = 0; i <= turns.count; ++i) {
    const Real high = i < turns.count ? turns.list[i] : std::max(far, 2 * low);
    if (touches(low))
      add_root(all, low);
    else if (!touches(high) && (at(p, low) < 0) != (at(p, high) < 0))
      add_root(all, between(p, low, high));
    low = high;
  }
  return all;
}

}  // namespace pantin::detail::modes
