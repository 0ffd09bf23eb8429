#pragma once
/// Four right-hand sides of one articulated solve in the lanes of a vector.
#include "engine/base/math.hpp"

namespace pantin::detail::articulated {

/// Four vectors: forces, torques, translations or rotations.
struct Vec3x4 {
  static constexpr std::size_t kSides = 4;
  Real v[3][kSides] = {};

  bool none() const {
    for (const auto& axis : v)
      for (Real x : axis)
        if (x != 0) return false;
    return true;
  }
  void add(const Vec3x4& o) {
    for (int i = 0; i < 3; ++i)
      for (std::size_t n = 0; n < kSides; ++n) v[i][n] += o.v[i][n];
  }
  void subtract(const Vec3x4& o) {
    for (int i = 0; i < 3; ++i)
      for (std::size_t n = 0; n < kSides; ++n) v[i][n] -= o.v[i][n];
  }
  static Vec3x4 times(const Mat3& m, const Vec3x4& o) {
    Vec3x4 out;
    for (int i = 0; i < 3; ++i)
      for (std::size_t n = 0; n < kSides; ++n)
        out.v[i][n] = m[0][i] * o.v[0][n] + m[1][i] * o.v[1][n] + m[2][i] * o.v[2][n];
    return out;
  }
  static Vec3x4 transposed_times(const Mat3& m, const Vec3x4& o) {
    Vec3x4 out;
    for (int i = 0; i < 3; ++i)
      for (std::size_t n = 0; n < kSides; ++n)
        out.v[i][n] = m[i][0] * o.v[0][n] + m[i][1] * o.v[1][n] + m[i][2] * o.v[2][n];
    return out;
  }
  static Vec3x4 cross(Vec3 a, const Vec3x4& o) {
    Vec3x4 out;
    for (std::size_t n = 0; n < kSides; ++n) {
      out.v[0][n] = a.y * o.v[2][n] - a.z * o.v[1][n];
      out.v[1][n] = a.z * o.v[0][n] - a.x * o.v[2][n];
      out.v[2][n] = a.x * o.v[1][n] - a.y * o.v[0][n];
    }
    return out;
  }
  Vec3 side(std::size_t n) const { return {v[0][n], v[1][n], v[2][n]}; }
  /// this += a x o, this -= a x o.
  void add_cross(Vec3 a, const Vec3x4& o) { add(cross(a, o)); }
  void subtract_cross(Vec3 a, const Vec3x4& o) { subtract(cross(a, o)); }
  void add_to_side(std::size_t n, Vec3 x) { v[0][n] += x.x, v[1][n] += x.y, v[2][n] += x.z; }
};

}  // namespace pantin::detail::articulated
