// A round block along y with flat ends: size (radius, half of its length, -).
#include "engine/geometry/kinds/turned.hpp"

namespace pantin::detail::shape_kinds {
namespace {

constexpr SizeKey kSizes[] = {{"radius", "Of the cylinder."},
                              {"length", "From end to end.", 1, 1, 0.5}};

Real volume(const Shape& shape) { return 2 * kPi * shape.size.x * shape.size.x * shape.size.y; }

Vec3 unit_moments(const Shape& shape) {
  const Real r = shape.size.x, c = shape.size.y;
  const Real across = r * r / 4 + c * c / 3;
  return {across, r * r / 2, across};
}

/// For a direction along the axis, the centre of an end represents the whole end.
Vec3 support(const Shape& shape, Vec3 d) {
  const Polar at = polar_of(d);
  return from_polar(at, at.radius > 0 ? shape.size.x : 0, d.y < 0 ? -shape.size.y : shape.size.y);
}

Real inner_radius(const Shape& shape) { return glm::min(shape.size.x, shape.size.y); }

std::size_t flat_faces(const Shape& shape, std::span<Face, 2> to) {
  to[0] = {0, 0, {0, -1, 0}, shape.size.y};
  to[1] = {0, 0, {0, 1, 0}, shape.size.y};
  return 2;
}

void patch(const Shape& shape, const Towards& towards, Patch& to) {
  const Real r = shape.size.x, c = shape.size.y, slack = std::sin(towards.tilt);
  const Polar at = polar_of(towards.direction);
  const bool up = towards.direction.y > 0;
  if (at.radius <= slack) return add_rim(r, up ? c : -c, up ? kTopRim : kBottomRim, to);
  const bool side = std::abs(towards.direction.y) <= slack;
  if (side || !up) to.add(from_polar(at, r, -c), kBottomPoint);
  if (side || up) to.add(from_polar(at, r, c), kTopPoint);
}

std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  const Real r = shape.size.x, c = shape.size.y;
  if (std::abs(from.y) <= c && std::hypot(from.x, from.z) <= r) return std::nullopt;
  std::optional<RayEntry> best;
  // An end, else the side.
  if (way.y != 0 && from.y * way.y < 0) {
    const Real t = ((from.y < 0 ? -c : c) - from.y) / way.y;
    const Vec3 at = from + t * way;
    if (t >= 0 && std::hypot(at.x, at.z) <= r) best = RayEntry{t, {0, way.y < 0 ? 1 : -1, 0}};
  }
  const Real a = way.x * way.x + way.z * way.z;
  if (!best && a > 0) {
    const Real b = from.x * way.x + from.z * way.z;
    const Real beside = from.x * way.z - from.z * way.x, under = a * r * r - beside * beside;
    if (under >= 0) {
      const Real t = (-b - std::sqrt(under)) / a;
      const Vec3 at = from + t * way;
      if (t >= 0 && std::abs(at.y) <= c) best = RayEntry{t, glm::normalize(Vec3(at.x, 0, at.z))};
    }
  }
  return best && best->distance <= limit ? best : std::nullopt;
}

std::optional<SurfacePoint> closest(const Shape& shape, Vec3 p, Real limit) {
  const Real r = shape.size.x, c = shape.size.y;
  const Polar at = polar_of(p);
  const Real out = at.radius - r, over = std::abs(p.y) - c, end = p.y < 0 ? -1 : 1;
  SurfacePoint near;
  if (out > 0 && over > 0) {
    near.distance = std::hypot(out, over);
    near.normal = from_polar(at, out, end * over) / near.distance;
  } else if (out > over) {
    near.distance = out, near.normal = from_polar(at, 1, 0);
  } else {
    near.distance = over, near.normal = {0, end, 0};
  }
  near.point = p - near.distance * near.normal;
  return near.distance <= limit ? std::optional(near) : std::nullopt;
}

}  // namespace

constinit const ShapeTraits cylinder{
    .about = "A cylinder along y with flat ends.",
    .is_turned = true,
    .sizes = kSizes,
    .support = support,
    .volume = volume,
    .unit_moments = unit_moments,
    .inner_radius = inner_radius,
    .cast = cast,
    .closest = closest,
    .patch = patch,
    .flat_faces = flat_faces,
    .rounding = rounding_of_turned,
};

}  // namespace pantin::detail::shape_kinds
