#include <algorithm>

#include "engine/render/frame.hpp"

namespace pantin::detail {
namespace {

struct Grid {
  float x, z, step_x, step_z;  // centre of the first texel, distance to the next
};

/// A ball above the map's first corner, m.
struct Occluder {
  float x, z, height, radius;
};

/// Sky visibility of the ground at each texel, 0..1.
struct Openness {
  Grid grid;
  float spread;  // m; smaller occluders are blurred and do not flicker
  std::vector<float> open = std::vector<float>(kShadeSize * kShadeSize, 1.f);

  void darken_around(const Occluder& ball);
};

void Openness::darken_around(const Occluder& ball) {
  const auto& [x, z, height, radius] = ball;
  const float reach = static_cast<float>(kShadeReach) * radius + spread;
  const auto first = [](float from, float step) {
    return std::max(0, static_cast<int>(std::ceil(from / step)));
  };
  const auto last = [](float to, float step) {
    return std::min(kShadeSize - 1, static_cast<int>(std::floor(to / step)));
  };
  const int x0 = first(x - reach - grid.x, grid.step_x), x1 = last(x + reach - grid.x, grid.step_x);
  const int z0 = first(z - reach - grid.z, grid.step_z), z1 = last(z + reach - grid.z, grid.step_z);
  const float h = std::max(height, radius), taken = radius * radius * h;
  const float base = h * h + spread * spread, end = reach * reach;
  for (int j = z0; j <= z1; ++j) {
    const float dz = grid.z + static_cast<float>(j) * grid.step_z - z;
    float* row = open.data() + j * kShadeSize;
    for (int i = x0; i <= x1; ++i) {
      const float dx = grid.x + static_cast<float>(i) * grid.step_x - x;
      const float aside = dx * dx + dz * dz;
      if (aside >= end) continue;
      const float d2 = aside + base;
      const float fade = 1 - aside / end;
      row[i] *= 1 - 0.8f * fade * taken / (d2 * std::sqrt(d2));
    }
  }
}

}  // namespace

void shade_ground(std::span<const Ball> balls, const GroundPatch& ground,
                  std::vector<std::uint8_t>& to) {
  const Vec3 low = ground.low, size = ground.high - low;
  Grid grid;
  grid.step_x = static_cast<float>(size.x) / kShadeSize;
  grid.step_z = static_cast<float>(size.z) / kShadeSize;
  grid.x = grid.step_x / 2, grid.z = grid.step_z / 2;
  Openness map{grid, std::max(grid.step_x, grid.step_z) / 2};
  for (const Ball& b : balls) {
    const Real height = b.centre.y - ground.height;
    if (!shades_ground(b, height)) continue;
    map.darken_around({static_cast<float>(b.centre.x - low.x),
                       static_cast<float>(b.centre.z - low.z), static_cast<float>(height),
                       static_cast<float>(b.radius)});
  }
  to.resize(map.open.size());
  for (std::size_t i = 0; i < map.open.size(); ++i)
    to[i] = static_cast<std::uint8_t>(map.open[i] * 255.f + 0.5f);
}

}  // namespace pantin::detail
