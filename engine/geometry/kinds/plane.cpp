// The half-space y <= 0, for fixed and kinematic bodies: size (extent of its picture, -, -).
#include "engine/geometry/kinds/parts.hpp"

namespace pantin::detail::shape_kinds {
namespace {

constexpr SizeKey kSizes[] = {
    {"size", "Edge of the square that is drawn; collision is unbounded.", 0, 1, 0.5, 20}};

Aabb bounds(const Shape&, const Pose&) { return {Vec3(-1e300), Vec3(1e300)}; }

std::optional<RayEntry> cast(const Shape&, Vec3 from, Vec3 way, Real limit) {
  if (from.y < 0 || !(way.y < 0)) return std::nullopt;
  const Real distance = from.y / -way.y;
  return distance <= limit ? std::optional(RayEntry{distance, {0, 1, 0}}) : std::nullopt;
}

std::optional<SurfacePoint> closest(const Shape&, Vec3 p, Real limit) {
  if (p.y > limit) return std::nullopt;
  return SurfacePoint{{p.x, 0, p.z}, {0, 1, 0}, p.y};
}

}  // namespace

constinit const ShapeTraits plane{
    .about = "The half-space below y = 0 of its frame. Only for fixed or kinematic bodies.",
    .shape_class = ShapeClass::half_space,
    .is_ground = true,
    .sizes = kSizes,
    .bounds = bounds,
    .cast = cast,
    .closest = closest,
};

}  // namespace pantin::detail::shape_kinds
