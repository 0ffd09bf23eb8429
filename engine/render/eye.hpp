#pragma once
/// A camera with derived axes.
#include "engine/base/math.hpp"
#include "engine/world/look.hpp"

namespace pantin::detail {

struct Eye {
  Vec3 position{0};
  Vec3 right{1, 0, 0}, up{0, 1, 0}, forward{0, 0, -1};  // unit, world axes
  Real tan_x = 1, tan_y = 1;                            // tangents of half the angles of view
  Real distance = 1;                                    // m, to the target
  int width = 1, height = 1;                            // pixels

  /// Size of a pixel at unit depth, m.
  Real pixel() const { return 2 * tan_y / height; }
  Real depth(Vec3 world) const { return glm::dot(forward, world - position); }
  /// Pixels from the left and from the top; only for points in front of the eye.
  Vec3 project(Vec3 world) const {
    const Vec3 d = world - position;
    const Real z = glm::dot(forward, d);
    return {(1 + glm::dot(right, d) / (z * tan_x)) / 2 * width,
            (1 - glm::dot(up, d) / (z * tan_y)) / 2 * height, z};
  }
};

/// Keeps the horizon level; a camera whose eye and target coincide looks along -z.
Eye make_eye(const Camera& camera, int width, int height);

}  // namespace pantin::detail
