#pragma once
/// The support feature of a convex shape: a face, an edge or a point.
#include <array>
#include <cstdint>

#include "engine/base/math.hpp"

namespace pantin::detail {

/// A direction, and the tilt of the shape within which features count.
struct Towards {
  Vec3 direction{0, -1, 0};  // unit
  Real tilt = 0;             // rad
};

/// Corners of a face in order around it, the two ends of an edge, or a point, with numbers below
/// 255 that identify them on the shape.
struct Patch {
  static constexpr std::size_t kMost = 64;
  std::array<Vec3, kMost> points;
  std::array<std::uint32_t, kMost> numbers;
  std::size_t count = 0;
  Real rim = 0;  // m: the corners represent a circle of this radius about their mean

  void add(Vec3 point, std::uint32_t number) {
    if (count < kMost) points[count] = point, numbers[count++] = number;
  }
};

}  // namespace pantin::detail
