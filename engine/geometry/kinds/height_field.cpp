// Heights along y over a grid of x and z, for fixed and kinematic bodies: all below is solid.
#include <algorithm>

#include "engine/geometry/kinds/parts.hpp"
#include "engine/geometry/surface.hpp"

namespace pantin::detail::shape_kinds {
namespace {

constexpr Real kEndless = 1e300;

/// The cells that a ray passes, in order: steps from line to line of the grid.
struct Walk {
  Walk(const Surface& s, Vec3 from, Vec3 way, Real start) {
    const Vec3 at = from + start * way;
    const Real spacing[2] = {s.spacing_x, s.spacing_z}, origin[2] = {s.low.x, s.low.z};
    const std::uint32_t lines[2] = {s.columns, s.rows};
    for (int k = 0; k < 2; ++k) {
      const int axis = 2 * k;
      cell[k] = cell_at(at[axis], spacing[k], lines[k]);
      step[k] = way[axis] > 0 ? 1 : -1;
      count[k] = static_cast<int>(lines[k]) - 1;
      const Real line = origin[k] + (cell[k] + (way[axis] > 0 ? 1 : 0)) * spacing[k];
      next[k] = way[axis] == 0 ? kEndless : (line - from[axis]) / way[axis];
      each[k] = way[axis] == 0 ? kEndless : spacing[k] / std::abs(way[axis]);
    }
  }

  /// Goes to the next cell; false beyond the rim or beyond `limit`.
  bool advance(Real limit) {
    const int k = next[0] <= next[1] ? 0 : 1;
    if (next[k] > limit) return false;
    const int to = static_cast<int>(cell[k]) + step[k];
    if (to < 0 || to >= count[k]) return false;
    cell[k] = static_cast<std::uint32_t>(to), next[k] += each[k];
    return true;
  }

  std::uint32_t cell[2];
  int step[2], count[2];
  Real next[2], each[2];
};

std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  const Surface& s = *shape.surface;
  // A flat field has no thickness; a little is added, so that rounding loses no ray.
  const Real slack = 1e-9 * glm::length(s.high - s.low);
  const Aabb bounds = Aabb{s.low, s.high}.grown(slack);
  const auto [enter, leave] = ray_range(bounds, from, way);
  const Real start = glm::max(enter, Real(0)), end = glm::min(leave, limit);
  if (start > end) return std::nullopt;
  Walk walk(s, from, way, start);
  do {
    const std::uint32_t cell = walk.cell[1] * (s.columns - 1) + walk.cell[0];
    std::optional<RayEntry> best;
    for (std::uint32_t i : {2 * cell, 2 * cell + 1})
      if (const auto entry = cast_triangle(triangle_of(s, i), from, way, limit))
        if (!best || entry->distance < best->distance) best = entry;
    if (best) return best;
  } while (walk.advance(end));
  return std::nullopt;
}

/// The nearest triangle, ring by ring of cells around the one below or above the point.
std::optional<SurfacePoint> closest(const Shape& shape, Vec3 p, Real limit) {
  const Surface& s = *shape.surface;
  const bool over = p.x >= s.low.x && p.x <= s.high.x && p.z >= s.low.z && p.z <= s.high.z;
  const std::uint32_t tile = tile_at(s, p);
  const Vec3 up = normal_of(s, tile);
  const bool inside = over && glm::dot(up, p - triangle_of(s, tile)[0]) < 0;
  const int cx = static_cast<int>(cell_at(p.x, s.spacing_x, s.columns)),
            cz = static_cast<int>(cell_at(p.z, s.spacing_z, s.rows));
  const int wide = static_cast<int>(s.columns) - 1, deep = static_cast<int>(s.rows) - 1;
  Real best = inside ? kEndless : limit * limit;
  std::optional<SurfacePoint> found;
  const auto look = [&](int x, int z) {
    if (x < 0 || z < 0 || x >= wide || z >= deep) return;
    const auto cell = static_cast<std::uint32_t>(z * wide + x);
    for (std::uint32_t i : {2 * cell, 2 * cell + 1}) {
      const Vec3 q = nearest_in(triangle_of(s, i), p), way = p - q;
      const Real d = glm::dot(way, way);
      if (!(d <= best) || (found && d == best)) continue;
      best = d;
      const Real apart = std::sqrt(d);
      found = {q, apart > 0 ? (inside ? -way : way) / apart : normal_of(s, i),
               inside ? -apart : apart};
    }
  };
  for (int ring = 0; ring <= std::max({cx, wide - 1 - cx, cz, deep - 1 - cz}); ++ring) {
    const Real away = (ring - 1) * std::min(s.spacing_x, s.spacing_z);
    if (ring > 1 && away * away > best) break;
    if (ring == 0) look(cx, cz);
    for (int i = -ring; i < ring; ++i) {
      look(cx + i, cz - ring), look(cx + ring, cz + i);
      look(cx - i, cz + ring), look(cx - ring, cz - i);
    }
  }
  return found;
}

}  // namespace

constinit const ShapeTraits height_field{
    .about =
        "A terrain of heights along y over a grid, its middle at the origin. Only for fixed or "
        "kinematic bodies.",
    .shape_class = ShapeClass::heights,
    .source = SurfaceSource::heights,
    .is_ground = true,
    .bounds = bounds_of_surface,
    .cast = cast,
    .closest = closest,
};

}  // namespace pantin::detail::shape_kinds
