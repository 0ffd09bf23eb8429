#pragma once
/// Small surfaces put together by hand: pictures need not wait for what makes large ones.
#include <cmath>
#include <memory>

#include "engine/geometry/surface.hpp"

namespace pantin::picture {

using namespace detail;

/// Two pyramids on one square: corners at `wide` along x and z, tips at `high` along y.
inline std::shared_ptr<const Surface> double_pyramid(Real wide, Real high) {
  auto made = std::make_shared<Surface>();
  made->points = {{wide, 0, 0},  {0, 0, wide}, {-wide, 0, 0},
                  {0, 0, -wide}, {0, high, 0}, {0, -high, 0}};
  made->low = {-wide, -high, -wide}, made->high = {wide, high, wide};
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t next = (i + 1) % 4;
    for (const auto& f : {std::array{i, 4u, next}, std::array{i, next, 5u}}) {
      Face face{static_cast<std::uint32_t>(made->corners.size()), 3, Vec3{0}, 0};
      const Vec3 a = made->points[f[0]], b = made->points[f[1]], c = made->points[f[2]];
      face.normal = glm::normalize(glm::cross(b - a, c - a));
      face.offset = glm::dot(face.normal, a);
      made->corners.insert(made->corners.end(), f.begin(), f.end());
      made->faces.push_back(face);
    }
  }
  return made;
}

/// Waves of `height` above and below zero.
inline std::shared_ptr<const Surface> wavy_field(std::uint32_t columns, std::uint32_t rows,
                                                 Real spacing, Real height) {
  auto made = std::make_shared<Surface>();
  made->columns = columns, made->rows = rows;
  made->spacing_x = made->spacing_z = spacing;
  const Vec3 half{spacing * (columns - 1) / 2, height, spacing * (rows - 1) / 2};
  made->low = -half, made->high = half;
  for (std::uint32_t r = 0; r < rows; ++r)
    for (std::uint32_t c = 0; c < columns; ++c) {
      const Real x = spacing * c - half.x, z = spacing * r - half.z;
      made->points.push_back({x, height * std::sin(3 * x) * std::cos(2 * z), z});
    }
  return made;
}

}  // namespace pantin::picture
