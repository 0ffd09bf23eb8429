#pragma once
/// Seeded random numbers for tests: one seed gives one sequence with every compiler and library.
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>

#include "engine/base/rotation.hpp"

namespace pantin::test {

/// The standard fixes the numbers of the engine, a Mersenne twister, but not those of its
/// distributions and of std::shuffle, which this class does without. Several numbers for one value
/// are drawn in statements of their own, since the order of arguments is the compiler's affair.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// Evenly from `low` to below `high`.
  Real between(Real low, Real high) {
    return low + (high - low) * static_cast<Real>(engine_() >> 11) * 0x1p-53;
  }
  /// A whole number from 0 to below `count`.
  template <class Whole>
  Whole below(Whole count) {
    return static_cast<Whole>(between(0, static_cast<Real>(count)));
  }
  std::uint8_t byte() { return static_cast<std::uint8_t>(engine_() >> 56); }

  /// Each component evenly from `low` to below `high`.
  Vec3 in_box(Real low, Real high) {
    const Real x = between(low, high), y = between(low, high), z = between(low, high);
    return {x, y, z};
  }
  Vec3 in_cube(Real half) { return in_box(-half, half); }

  /// A unit vector, evenly over the sphere.
  Vec3 direction() {
    for (;;) {
      const Vec3 v = in_cube(1);
      const Real l2 = glm::dot(v, v);
      if (l2 > 0.01 && l2 < 1) return v / std::sqrt(l2);
    }
  }

  /// By an angle evenly from 0 to pi about any axis: small ones are more frequent than in an even
  /// choice of orientations.
  Quat rotation() {
    const Vec3 axis = direction();
    return from_rotation_vector(between(0, kPi) * axis);
  }
  /// By four numbers from -1 to 1, normalised: any orientation, nearly evenly.
  Quat orientation() {
    const Real z = between(-1, 1), y = between(-1, 1), x = between(-1, 1), w = between(-1, 1);
    return glm::normalize(Quat(w, x, y, z));
  }

  /// Puts a list in any order.
  void shuffle(auto& list) {
    for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[below(i)]);
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace pantin::test
