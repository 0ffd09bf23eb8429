// An ellipsoid: size is its radii.
#include "engine/geometry/kinds.hpp"
#include "engine/geometry/patch.hpp"

namespace pantin::detail::shape_kinds {
namespace {

constexpr SizeKey kSizes[] = {
    {"radii", "Along x, y and z.", 0, 3, 1, 0, "the three radii of the ellipsoid"}};
constexpr int kMostRounds = 200;

Real volume(const Shape& shape) {
  return 4.0 / 3 * kPi * shape.size.x * shape.size.y * shape.size.z;
}

Vec3 unit_moments(const Shape& shape) {
  const Vec3 s = shape.size * shape.size / 5.0;
  return {s.y + s.z, s.x + s.z, s.x + s.y};
}

Vec3 support(const Shape& shape, Vec3 d) {
  const Vec3 scaled = shape.size * d;
  const Real length = glm::length(scaled);
  return length > 0 ? shape.size * scaled / length : Vec3(shape.size.x, 0, 0);
}

Real inner_radius(const Shape& shape) {
  return glm::min(shape.size.x, glm::min(shape.size.y, shape.size.z));
}

Aabb bounds(const Shape& shape, const Pose& at) {
  const Mat3 rotation = glm::mat3_cast(at.rotation);
  Vec3 half;
  for (int k = 0; k < 3; ++k)
    half[k] = glm::length(shape.size * Vec3(rotation[0][k], rotation[1][k], rotation[2][k]));
  return {at.position - half, at.position + half};
}

void patch(const Shape& shape, const Towards& towards, Patch& to) {
  to.add(support(shape, towards.direction), 0);
}

/// Second derivative of the support function |D n|, D = diag(radii), in the rolling direction; half
/// its trace if the shape does not roll.
Real rounding(const Shape& shape, const Rolling& at) {
  const Vec3 squares = shape.size * shape.size, n = at.outward, by = squares * n;
  const Real height = std::sqrt(glm::dot(n, by)), cube = height * height * height;
  const Vec3 way = glm::cross(at.spin, n);
  const Real speed = glm::dot(way, way);
  if (!(speed > 0))
    return ((squares.x + squares.y + squares.z) / height - glm::dot(by, by) / cube) / 2;
  const Real along = glm::dot(way, by);
  return (glm::dot(way, squares * way) / height - along * along / cube) / speed;
}

/// Ray cast as for a ball, with all lengths divided by the radii.
std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  const Vec3 start = from / shape.size, step = way / shape.size;
  const Real a = glm::dot(step, step), b = glm::dot(start, step), c = glm::dot(start, start) - 1;
  const Vec3 beside = start - b / a * step;
  const Real under = a * (1 - glm::dot(beside, beside));
  if (c < 0 || b > 0 || !(under >= 0)) return std::nullopt;
  const Real distance = glm::max((-b - std::sqrt(under)) / a, Real(0));
  if (distance > limit) return std::nullopt;
  return RayEntry{distance, glm::normalize((start + distance * step) / shape.size)};
}

/// The nearest point q of the surface to p, p in the first octant: q_i = e_i^2 p_i / (e_i^2 + t),
/// with the largest t that puts q on the surface. Newton's method approaches it from below without
/// overshoot. [Eberly 2013, "Distance from a point to an ellipse, an ellipsoid, or a
/// hyperellipsoid"]
Vec3 nearest_to(Vec3 p, Vec3 e) {
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (e[i] < e[least] || (e[i] == e[least] && p[i] > p[least])) least = i;
  const Vec3 beyond = e * e - e[least] * e[least];  // e_i^2 + t = beyond_i + s
  const Vec3 weight = e * p;
  const auto term = [&](int i, Real s) { return p[i] > 0 ? weight[i] / (beyond[i] + s) : 0; };
  Real s = weight[least];
  if (s == 0) {
    // p is in the plane across the shortest axis, and so near the centre that q is outside this
    // plane.
    Real sum = 0;
    for (int i = 0; i < 3; ++i) sum += i == least ? 0 : term(i, 0) * term(i, 0);
    if (sum < 1) {
      Vec3 q;
      for (int i = 0; i < 3; ++i) q[i] = i == least ? e[i] * std::sqrt(1 - sum) : e[i] * term(i, 0);
      return q;
    }
  }
  for (int round = 0; round < kMostRounds; ++round) {
    Real value = -1, slope = 0;
    for (int i = 0; i < 3; ++i) {
      const Real part = term(i, s);
      value += part * part;
      if (part > 0) slope -= 2 * part * part / (beyond[i] + s);
    }
    const Real next = s - value / slope;
    if (!(value > 0) || !(next > s)) break;
    s = next;
  }
  return e * Vec3(term(0, s), term(1, s), term(2, s));
}

std::optional<SurfacePoint> closest(const Shape& shape, Vec3 p, Real limit) {
  const Vec3 e = shape.size, scaled = p / e;
  const bool inside = glm::dot(scaled, scaled) < 1;
  Vec3 q = nearest_to(glm::abs(p), e);
  for (int k = 0; k < 3; ++k) q[k] = std::copysign(q[k], p[k]);
  const Real apart = glm::distance(p, q);
  const SurfacePoint near{q, glm::normalize(q / (e * e)), inside ? -apart : apart};
  return near.distance <= limit ? std::optional(near) : std::nullopt;
}

}  // namespace

constinit const ShapeTraits ellipsoid{
    .about = "An ellipsoid.",
    .sizes = kSizes,
    .support = support,
    .volume = volume,
    .unit_moments = unit_moments,
    .inner_radius = inner_radius,
    .bounds = bounds,
    .cast = cast,
    .closest = closest,
    .patch = patch,
    .rounding = rounding,
};

}  // namespace pantin::detail::shape_kinds
