#pragma once
/// Several right-hand sides of one articulated solve, side by side for the vector lanes.
#include "engine/base/math.hpp"

namespace pantin::articulated {

/// Up to four of them: a force or a torque, a slide or a turn each.
struct Loads {
  static constexpr std::size_t kSides = 4;
  Real v[3][kSides] = {};

  bool none() const {
    for (const auto& axis : v)
      for (Real x : axis)
        if (x != 0) return false;
    return true;
  }
  void add(const Loads& o) {
    for (int i = 0; i < 3; ++i)
      for (std::size_t n = 0; n < kSides; ++n) v[i][n] += o.v[i][n];
  }
  void subtract(const Loads& o) {
    for (int i = 0; i < 3; ++i)
      for (std::size_t n = 0; n < kSides; ++n) v[i][n] -= o.v[i][n];
  }
  static Loads times(const Mat3& m, const Loads& o) {
    Loads out;
    for (int i = 0; i < 3; ++i)
      for (std::size_t n = 0; n < kSides; ++n)
        out.v[i][n] = m[0][i] * o.v[0][n] + m[1][i] * o.v[1][n] + m[2][i] * o.v[2][n];
    return out;
  }
  static Loads transposed_times(const Mat3& m, const Loads& o) {
    Loads out;
    for (int i = 0; i < 3; ++i)
      for (std::size_t n = 0; n < kSides; ++n)
        out.v[i][n] = m[i][0] * o.v[0][n] + m[i][1] * o.v[1][n] + m[i][2] * o.v[2][n];
    return out;
  }
  static Loads cross(Vec3 a, const Loads& o) {
    Loads out;
    for (std::size_t n = 0; n < kSides; ++n) {
      out.v[0][n] = a.y * o.v[2][n] - a.z * o.v[1][n];
      out.v[1][n] = a.z * o.v[0][n] - a.x * o.v[2][n];
      out.v[2][n] = a.x * o.v[1][n] - a.y * o.v[0][n];
    }
    return out;
  }
  Vec3 side(std::size_t n) const { return {v[0][n], v[1][n], v[2][n]}; }
  /// this += a x o, this -= a x o.
  void add_cross(Vec3 a, const Loads& o) { add(cross(a, o)); }
  void subtract_cross(Vec3 a, const Loads& o) { subtract(cross(a, o)); }
  void add_to_side(std::size_t n, Vec3 x) { v[0][n] += x.x, v[1][n] += x.y, v[2][n] += x.z; }
};

}  // namespace pantin::articulated
