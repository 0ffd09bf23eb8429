#pragma once
/// Complex numbers without the special cases of the standard library's, which cost more than the
/// arithmetic.
#include <cmath>

#include "engine/base/math.hpp"

namespace pantin::detail::lagrangian {

struct Complex {
  Real re = 0, im = 0;

  constexpr Complex() = default;
  constexpr Complex(Real real, Real imaginary = 0) : re(real), im(imaginary) {}

  constexpr Complex& operator+=(Complex b) { return re += b.re, im += b.im, *this; }
  constexpr Complex& operator-=(Complex b) { return re -= b.re, im -= b.im, *this; }
  constexpr Complex& operator*=(Complex b) { return *this = *this * b; }
  friend constexpr Complex operator+(Complex a, Complex b) { return a += b; }
  friend constexpr Complex operator-(Complex a, Complex b) { return a -= b; }
  friend constexpr Complex operator-(Complex a) { return {-a.re, -a.im}; }
  friend constexpr Complex operator*(Complex a, Complex b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  }
  friend constexpr Complex operator/(Complex a, Complex b) {
    const Real norm = b.re * b.re + b.im * b.im;
    return {(a.re * b.re + a.im * b.im) / norm, (a.im * b.re - a.re * b.im) / norm};
  }
};

inline Real magnitude_of(Complex a) { return std::hypot(a.re, a.im); }

}  // namespace pantin::detail::lagrangian
