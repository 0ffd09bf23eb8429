// A cone along y, its tip up, its origin in the middle of its height: size (radius of its base,
// half of its height, -).
#include "engine/geometry/kinds/turned.hpp"

namespace pantin::detail::shape_kinds {
namespace {

constexpr SizeKey kSizes[] = {
    {"radius", "Of the base."},
    {"height", "From the base to the apex; the origin is halfway up.", 1, 1, 0.5}};

/// The outward normal of the side: along the radius, and upwards.
struct Side {
  explicit Side(const Shape& shape) {
    const Real slant = std::hypot(shape.size.x, 2 * shape.size.y);
    out = 2 * shape.size.y / slant, up = shape.size.x / slant;
  }
  /// m, from the side's line to a place at `radius` from the axis, outwards.
  Real distance(const Shape& shape, Real radius, Real y) const {
    return (radius - shape.size.x) * out + (y + shape.size.y) * up;
  }
  Real out, up;
};

MassProperties enclosed(const Shape& shape) {
  const Real r = shape.size.x, height = 2 * shape.size.y;
  const Real volume = kPi * r * r * height / 3;
  const Real across = volume * (3.0 / 20 * r * r + 3.0 / 80 * height * height);
  Mat3 inertia(0);
  inertia[0][0] = inertia[2][2] = across, inertia[1][1] = 0.3 * volume * r * r;
  return {volume, {0, -height / 4, 0}, inertia};
}

/// For a direction straight down, the centre of the base represents the whole base.
Vec3 support(const Shape& shape, Vec3 d) {
  const Real r = shape.size.x, half = shape.size.y;
  const Polar at = polar_of(d);
  if (2 * half * d.y > r * at.radius) return {0, half, 0};
  return from_polar(at, at.radius > 0 ? r : 0, -half);
}

Real inner_radius(const Shape& shape) {
  return glm::min(shape.size.y, -Side(shape).distance(shape, 0, 0));
}

std::size_t flat_faces(const Shape& shape, std::span<Face, 2> to) {
  to[0] = {0, 0, {0, -1, 0}, shape.size.y};
  return 1;
}

void patch(const Shape& shape, const Towards& towards, Patch& to) {
  const Real r = shape.size.x, half = shape.size.y, slack = std::sin(towards.tilt);
  const Polar at = polar_of(towards.direction);
  const Side side(shape);
  const Real y = towards.direction.y;
  if (at.radius <= slack && y < 0) return add_rim(r, -half, kBottomRim, to);
  // The sine of the angle from the side's normal up to the direction.
  const Real above = y * side.out - at.radius * side.up;
  if (above <= slack) to.add(from_polar(at, r, -half), kBottomPoint);
  if (above >= -slack) to.add({0, half, 0}, kTopPoint);
}

std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  const Real r = shape.size.x, half = shape.size.y;
  const Side side(shape);
  if (from.y >= -half && side.distance(shape, std::hypot(from.x, from.z), from.y) <= 0)
    return std::nullopt;
  std::optional<RayEntry> best;
  const auto take = [&](Real t, Vec3 normal) {
    const bool meets = t >= 0 && t <= limit && glm::dot(normal, way) <= 0;
    if (meets && (!best || t < best->distance)) best = RayEntry{t, normal};
  };
  if (from.y < -half && way.y > 0) {
    const Real t = (-half - from.y) / way.y;
    const Vec3 at = from + t * way;
    if (std::hypot(at.x, at.z) <= r) take(t, {0, -1, 0});
  }
  // x^2 + z^2 = k^2 (half - y)^2 below the tip.
  const Real k = r / (2 * half), down = half - from.y;
  const Real a = way.x * way.x + way.z * way.z - k * k * way.y * way.y;
  const Real b = from.x * way.x + from.z * way.z + k * k * down * way.y;
  const Real c = from.x * from.x + from.z * from.z - k * k * down * down;
  const Real under = b * b - a * c;
  if (!(under >= 0)) return best;
  const Real sum = -(b + std::copysign(std::sqrt(under), b));
  for (const Real t : {a != 0 ? sum / a : -1, sum != 0 ? c / sum : -1}) {
    const Vec3 at = from + t * way;
    if (!(at.y >= -half && at.y <= half)) continue;
    const Polar out = polar_of(at);
    take(t, from_polar(out, side.out, side.up));
  }
  return best;
}

/// A point beside the axis: its distance from it, and its height.
struct Spot {
  Real radius, y;
};

/// The point of the segment from p to q nearest to x.
Spot nearest_on(Spot p, Spot q, Spot x) {
  const Real dr = q.radius - p.radius, dy = q.y - p.y, whole = dr * dr + dy * dy;
  const Real t = whole > 0 ? ((x.radius - p.radius) * dr + (x.y - p.y) * dy) / whole : 0;
  const Real s = glm::clamp(t, Real(0), Real(1));
  return {p.radius + s * dr, p.y + s * dy};
}

std::optional<SurfacePoint> closest(const Shape& shape, Vec3 p, Real limit) {
  const Real r = shape.size.x, half = shape.size.y;
  const Side side(shape);
  const Polar at = polar_of(p);
  const Real beside = side.distance(shape, at.radius, p.y), below = -half - p.y;
  SurfacePoint near;
  near.distance = glm::max(beside, below);
  near.normal = beside > below ? from_polar(at, side.out, side.up) : Vec3(0, -1, 0);
  if (near.distance > 0) {
    const Spot x{at.radius, p.y};
    const Spot base = nearest_on({0, -half}, {r, -half}, x),
               slant = nearest_on({r, -half}, {0, half}, x);
    const auto apart = [&](Spot s) { return std::hypot(x.radius - s.radius, x.y - s.y); };
    const Spot to = apart(slant) < apart(base) ? slant : base;
    if (const Real d = apart(to); d > 0)
      near.distance = d, near.normal = from_polar(at, x.radius - to.radius, x.y - to.y) / d;
  }
  near.point = p - near.distance * near.normal;
  return near.distance <= limit ? std::optional(near) : std::nullopt;
}

}  // namespace

constinit const ShapeTraits cone{
    .about = "A cone along y, its apex up; its origin is halfway up, its mass centre lower.",
    .is_turned = true,
    .sizes = kSizes,
    .support = support,
    .enclosed = enclosed,
    .inner_radius = inner_radius,
    .cast = cast,
    .closest = closest,
    .patch = patch,
    .flat_faces = flat_faces,
    .rounding = rounding_of_turned,
};

}  // namespace pantin::detail::shape_kinds
