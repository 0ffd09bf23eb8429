#pragma once
/// Random numbers whose sequence depends on the seed only, on every platform.
#include <cstdint>

#include "engine/base/math.hpp"

namespace pantin::detail::assembly {

/// SplitMix64. [Steele, Lea & Flood 2014]
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t word() {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15ull;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }
  /// Uniform in [-1, 1).
  Real signed_unit() { return static_cast<Real>(word() >> 11) * 0x1p-52 - 1; }
  /// Uniform in the unit ball.
  Vec3 in_ball() {
    for (;;) {
      const Real x = signed_unit(), y = signed_unit(), z = signed_unit();
      const Vec3 v(x, y, z);
      if (glm::dot(v, v) <= 1) return v;
    }
  }
  /// Uniform on the unit sphere.
  Vec3 direction() {
    for (;;) {
      const Vec3 v = in_ball();
      if (const Real length = glm::length(v); length > 1e-3) return v / length;
    }
  }

 private:
  std::uint64_t state_;
};

}  // namespace pantin::detail::assembly
