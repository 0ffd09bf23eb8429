// A ball: size (radius, -, -).
#include "engine/geometry/kinds/parts.hpp"

namespace pantin::detail::shape_kinds {
namespace {

constexpr SizeKey kSizes[] = {{"radius", "Of the sphere."}};

Real volume(const Shape& shape) {
  const Real r = shape.size.x;
  return 4.0 / 3 * kPi * r * r * r;
}

Vec3 unit_moments(const Shape& shape) {
  const Real r = shape.size.x;
  return Vec3(0.4 * r * r);
}

Vec3 support(const Shape& shape, Vec3 direction) {
  const Real length = glm::length(direction);
  return length > 0 ? shape.size.x / length * direction : Vec3(shape.size.x, 0, 0);
}

std::optional<RoundedBox> rounded(const Shape& shape) { return RoundedBox{Vec3(0), shape.size.x}; }

Real inner_radius(const Shape& shape) { return shape.size.x; }

Aabb bounds(const Shape& shape, const Pose& at) {
  const Vec3 half(shape.size.x);
  return {at.position - half, at.position + half};
}

Convex convex_piece(const Shape& shape, const Pose& at, ConvexScratch& scratch) {
  scratch.points.assign(1, at.position);
  return {scratch.points, {}, {}, {}, {}, shape.size.x, at.position, shape.size.x};
}

std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  const auto entry = cast_ball(from, way, Vec3(0), shape.size.x);
  return entry && entry->distance <= limit ? entry : std::nullopt;
}

}  // namespace

constinit const ShapeTraits sphere{
    .about = "A sphere.",
    .is_round = true,
    .sizes = kSizes,
    .support = support,
    .volume = volume,
    .unit_moments = unit_moments,
    .rounded = rounded,
    .inner_radius = inner_radius,
    .bounds = bounds,
    .convex_piece = convex_piece,
    .cast = cast,
};

}  // namespace pantin::detail::shape_kinds
