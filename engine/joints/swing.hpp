#pragma once
/// The swing of a ball joint as a scalar coordinate, bounded from below by zero:
///
///   C = 1 - (y/Y)^2 - (z/Z)^2,  (0, y, z) the swing's rotation vector
///
/// The swing rotates x of a to x of b by the angle phi. With p, q, r the components of b's x along
/// x, y, z of a and h = phi / sin phi, p = cos phi:  y = -r h,  z = q h.
#include <algorithm>
#include <array>

#include "engine/joints/primitives.hpp"

namespace pantin::detail {

/// h = phi / sin phi as a function of p = cos phi, and its first two derivatives.
struct SwingScale {
  Real h = 1, first = 0, second = 0;
};

/// `sine`: of phi, not negative. At half a revolution, where all three diverge, they are bounded.
inline SwingScale swing_scale(Real p, Real sine) {
  const Real e = 1 - p;
  SwingScale out;
  if (e < 0.1) {
    // h = sum of a_n e^n, a_n = a_(n-1) n / (2 n + 1); the truncation error is below 1e-20.
    constexpr int kTerms = 16;
    constexpr auto a = [] {
      std::array<Real, kTerms + 1> terms{1};
      for (int n = 1; n <= kTerms; ++n)
        terms[std::size_t(n)] = terms[std::size_t(n) - 1] * n / (2.0 * n + 1);
      return terms;
    }();
    Real sum = a[kTerms], slope = 0, half_curvature = 0;
    for (std::size_t n = kTerms; n-- > 0;) {
      half_curvature = half_curvature * e + slope;
      slope = slope * e + sum;
      sum = sum * e + a[n];
    }
    out.h = sum, out.first = -slope, out.second = 2 * half_curvature;
    return out;
  }
  // h' (1 - p p) = p h - 1, from which h'' follows
  const Real s2 = std::max(sine * sine, 1e-12);
  out.h = std::atan2(sine, p) / std::sqrt(s2);
  out.first = (p * out.h - 1) / s2;
  out.second = (out.h + 3 * p * out.first) / s2;
  return out;
}

inline AngularRow swing_row(const Joint& joint, const BodyState& a, const BodyState& b) {
  // A cone locked in one direction has no interior; a small opening is kept.
  constexpr Real kNarrowest = 1e-4;
  const SwingLimit cone = joint.limits->swing;
  const Real y = std::max(cone.y, kNarrowest), z = std::max(cone.z, kNarrowest);
  const Real by_q = 1 / (z * z), by_r = 1 / (y * y);

  const JointAxes on_a = axes_on_a(joint, a);
  const Vec3 x = axes_on_b(joint, b).x();
  const AngularRow p = dot_row(on_a.x(), x, a, b);
  const AngularRow q = dot_row(on_a.y(), x, a, b), r = dot_row(on_a.z(), x, a, b);

  // C = 1 - h h m with m = q q / Z Z + r r / Y Y; its gradient and Hessian in p, q, r
  const Real m = by_q * q.c * q.c + by_r * r.c * r.c;
  const auto [h, h1, h2] = swing_scale(p.c, std::sqrt(q.c * q.c + r.c * r.c));
  const Real to_p = -2 * h * h1 * m, to_q = -2 * h * h * by_q * q.c, to_r = -2 * h * h * by_r * r.c;
  const Vec3 w = relative_angular_velocity(a, b);
  const Real rate_p = p.rate(w), rate_q = q.rate(w), rate_r = r.rate(w);
  const Real bias_acceleration = -2 * (h1 * h1 + h * h2) * m * rate_p * rate_p -
                                 8 * h * h1 * rate_p * (by_q * q.c * rate_q + by_r * r.c * rate_r) -
                                 2 * h * h * (by_q * rate_q * rate_q + by_r * rate_r * rate_r);
  return {1 - h * h * m, to_p * p.k + to_q * q.k + to_r * r.k,
          to_p * p.gamma + to_q * q.gamma + to_r * r.gamma - bias_acceleration};
}

}  // namespace pantin::detail
