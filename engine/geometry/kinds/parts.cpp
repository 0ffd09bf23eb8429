#include "engine/geometry/kinds/parts.hpp"

#include "engine/geometry/surface.hpp"

namespace pantin::detail::shape_kinds {

Aabb bounds_of_surface(const Shape& shape, const Pose& at) {
  const Mat3 rotation = glm::mat3_cast(at.rotation);
  const Vec3 half = spread(rotation, (shape.surface->high - shape.surface->low) / 2.0);
  Vec3 middle = at.position;
  middle += rotation * ((shape.surface->high + shape.surface->low) / 2.0);
  return {middle - half, middle + half};
}

MassProperties enclosed_by_faces(const Shape& shape) {
  const Surface& surface = *shape.surface;
  const Vec3 apex = (surface.low + surface.high) / 2.0;
  Real volume = 0;
  Vec3 first(0);   // integral of x
  Mat3 second(0);  // integral of x x^T
  for (const Face& face : surface.faces)
    for (std::uint32_t i = 1; i + 1 < face.count; ++i) {
      const Vec3 a = surface.points[surface.corners[face.first]] - apex,
                 b = surface.points[surface.corners[face.first + i]] - apex,
                 c = surface.points[surface.corners[face.first + i + 1]] - apex, sum = a + b + c;
      const Real v = glm::dot(a, glm::cross(b, c)) / 6;
      volume += v, first += v / 4 * sum;
      second += v / 20 *
                (glm::outerProduct(a, a) + glm::outerProduct(b, b) + glm::outerProduct(c, c) +
                 glm::outerProduct(sum, sum));
    }
  const Vec3 centre = first / volume;
  second -= volume * glm::outerProduct(centre, centre);
  const Real trace = second[0][0] + second[1][1] + second[2][2];
  return {volume, apex + centre, trace * Mat3(1) - second};
}

std::optional<RayEntry> cast_ball(Vec3 from, Vec3 way, Vec3 centre, Real radius) {
  const Vec3 to = centre - from;
  const Real along = glm::dot(to, way), c = glm::dot(to, to) - radius * radius;
  const Vec3 beside = to - along * way;  // more exact than the discriminant for far small balls
  const Real half2 = radius * radius - glm::dot(beside, beside);
  if (c < 0 || along < 0 || half2 < 0 || !(radius > 0)) return std::nullopt;
  const Real distance = glm::max(along - std::sqrt(half2), Real(0));
  return RayEntry{distance, glm::normalize(distance * way - to)};
}

SurfacePoint closest_of_rounded(const RoundedBox& rounded, Vec3 p) {
  const Vec3 q = glm::clamp(p, -rounded.core, rounded.core), out = p - q;
  if (const Real apart = glm::length(out); apart > 0) {
    const Vec3 n = out / apart;
    return {q + rounded.radius * n, n, apart - rounded.radius};
  }
  const Vec3 left = rounded.core - glm::abs(p);
  const int axis = left.x <= left.y && left.x <= left.z ? 0 : left.y <= left.z ? 1 : 2;
  Vec3 n(0), point = p;
  n[axis] = p[axis] < 0 ? -1 : 1;
  point[axis] = n[axis] * (rounded.core[axis] + rounded.radius);
  return {point, n, -left[axis] - rounded.radius};
}

std::optional<RayEntry> cast_triangle(const std::array<Vec3, 3>& t, Vec3 from, Vec3 way,
                                      Real limit) {
  const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], p = glm::cross(way, ac);
  const Real facing = glm::dot(ab, p);
  if (!(facing > 0)) return std::nullopt;
  const Vec3 s = from - t[0], q = glm::cross(s, ab);
  const Real u = glm::dot(s, p) / facing, v = glm::dot(way, q) / facing;
  const Real distance = glm::dot(ac, q) / facing;
  constexpr Real kSeam = 1e-12;  // no ray slips through between two triangles
  const bool meets = u >= -kSeam && v >= -kSeam && u + v <= 1 + kSeam;
  if (!meets || distance < 0 || distance > limit) return std::nullopt;
  return RayEntry{distance, glm::normalize(glm::cross(ab, ac))};
}

}  // namespace pantin::detail::shape_kinds
