// A rod along y with round ends: size (radius, half of the straight part, -).
#include "engine/geometry/kinds/parts.hpp"

namespace pantin::detail::shape_kinds {
namespace {

constexpr SizeKey kSizes[] = {
    {"radius", "Of the cylinder and its hemispherical ends."},
    {"length", "Of the cylinder: the capsule is longer by two radii.", 1, 1, 0.5}};

Real volume(const Shape& shape) {
  const Real r = shape.size.x;
  return kPi * r * r * (2 * shape.size.y + 4.0 / 3 * r);
}

/// A cylinder and two half balls, weighted by their volumes.
Vec3 unit_moments(const Shape& shape) {
  const Real r = shape.size.x, c = shape.size.y;
  const Real cylinder = 2 * c * r * r, balls = 4.0 / 3 * r * r * r;  // both over pi
  const Real whole = cylinder + balls;
  const Real along = (cylinder * r * r / 2 + balls * 0.4 * r * r) / whole;
  const Real across =
      (cylinder * (r * r / 4 + c * c / 3) + balls * (0.4 * r * r + c * c + 0.75 * c * r)) / whole;
  return {across, along, across};
}

std::optional<RoundedBox> rounded(const Shape& shape) {
  return RoundedBox{{0, shape.size.y, 0}, shape.size.x};
}

Vec3 support(const Shape& shape, Vec3 direction) {
  const Vec3 end(0, direction.y < 0 ? -shape.size.y : shape.size.y, 0);
  const Real length = glm::length(direction);
  return length > 0 ? end + shape.size.x / length * direction : end;
}

Real inner_radius(const Shape& shape) { return shape.size.x; }

Aabb bounds(const Shape& shape, const Pose& at) {
  Vec3 half(shape.size.x);
  half += glm::abs(glm::mat3_cast(at.rotation)[1]) * shape.size.y;
  return {at.position - half, at.position + half};
}

constexpr std::array<std::array<std::uint32_t, 2>, 1> kEdge{{{0, 1}}};

Convex convex_piece(const Shape& shape, const Pose& at, ConvexScratch& scratch) {
  const Vec3 half = at.rotation * Vec3(0, shape.size.y, 0);
  if (half == Vec3(0)) return sphere.convex_piece(shape, at, scratch);
  scratch.points.assign({at.position - half, at.position + half});
  return {
      scratch.points, {}, {}, kEdge, {}, shape.size.x, at.position, shape.size.x + shape.size.y};
}

/// The straight part, else the two ends.
std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  const Real radius = shape.size.x, half = shape.size.y;
  if (closest_of_rounded({{0, half, 0}, radius}, from).distance < 0) return std::nullopt;
  std::optional<RayEntry> best;
  const auto take = [&](const std::optional<RayEntry>& entry) {
    if (entry && entry->distance <= limit && (!best || entry->distance < best->distance))
      best = entry;
  };
  const Real a = way.x * way.x + way.z * way.z;
  if (a > 1e-18) {
    const Real b = from.x * way.x + from.z * way.z;
    const Real c = from.x * from.x + from.z * from.z - radius * radius;
    const Real under = b * b - a * c;
    if (under >= 0) {
      const Real t = (-b - std::sqrt(under)) / a;
      const Vec3 at = from + t * way;
      if (t >= 0 && std::abs(at.y) <= half) take(RayEntry{t, glm::normalize(Vec3(at.x, 0, at.z))});
    }
  }
  take(cast_ball(from, way, {0, half, 0}, radius));
  take(cast_ball(from, way, {0, -half, 0}, radius));
  return best;
}

}  // namespace

constinit const ShapeTraits capsule{
    .about = "A cylinder along y with hemispherical ends.",
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
