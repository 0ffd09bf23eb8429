// A skin of NURBS faces: the inside of a closed one, or the inner side of a patch.
#include "engine/geometry/kinds/parts.hpp"
#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/nurbs/closest.hpp"

namespace pantin::detail::shape_kinds {
namespace {

constexpr int kMostSteps = 20;

/// Charts of an ellipsoid are known in closed form.
std::optional<Shape> closed_form(const Shape& shape) {
  const nurbs::Skin& skin = *shape.surface->skin;
  if (!skin.is_solid_ellipsoid()) return std::nullopt;
  Shape same;
  same.kind = ShapeKind::ellipsoid, same.size = *skin.half_axes();
  return same;
}

Vec3 support(const Shape& shape, Vec3 direction) {
  if (const auto same = closed_form(shape)) return ellipsoid.support(*same, direction);
  return farthest_on(*shape.surface, direction).point;
}

MassProperties enclosed(const Shape& shape) { return shape.surface->model->enclosed; }

/// For a convex skin about its origin: the distance of the nearest tangent plane.
Real inner_radius(const Shape& shape) {
  const SkinModel& m = *shape.surface->model;
  if (!m.is_convex) return 0;
  Real least = 1e300;
  for (std::size_t i = 0; i < m.tiles.points.size(); ++i)
    least = glm::min(least, glm::dot(m.tiles.normals[i], m.tiles.points[i]));
  return glm::max(least - m.chord, Real(0));
}

/// `way` has unit length.
struct Ray {
  Vec3 from, way;
};

/// Where a ray crosses a face near a start, by Newton's method: moves along the face to where the
/// tangent plane meets the ray.
std::optional<RayEntry> crossing(const nurbs::Face& face, nurbs::Place at, const Ray& ray) {
  const auto run = [](const nurbs::Knots& k, Real t) {
    return k.is_periodic ? k.inside(t) : k.domain().clamped(t);
  };
  for (int round = 0; round < kMostSteps; ++round) {
    const nurbs::Jet j = face.at(at.u, at.v);
    const Vec3 miss = ray.from + glm::dot(j.s - ray.from, ray.way) * ray.way - j.s;
    const Vec3 normal = glm::cross(j.u, j.v);
    const Real sinks = glm::dot(normal, ray.way);
    if (sinks == 0) return std::nullopt;
    const Vec3 to = miss - glm::dot(normal, miss) / sinks * ray.way;
    const Real uu = glm::dot(j.u, j.u), uv = glm::dot(j.u, j.v), vv = glm::dot(j.v, j.v);
    const Real determinant = uu * vv - uv * uv;
    if (!(determinant > 0)) return std::nullopt;
    const Real tu = glm::dot(to, j.u), tv = glm::dot(to, j.v);
    const Real u = run(face.u(), at.u + (vv * tu - uv * tv) / determinant);
    const Real v = run(face.v(), at.v + (uu * tv - uv * tu) / determinant);
    const Real moved = std::abs(u - at.u) / face.u().domain().width() +
                       std::abs(v - at.v) / face.v().domain().width();
    at.u = u, at.v = v;
    if (!(moved < 1e-14) && round + 1 < kMostSteps) continue;
    if (!face.holds(u, v)) return std::nullopt;
    const Vec3 end = face.at(u, v).s - ray.from;
    const Real distance = glm::dot(end, ray.way);
    if (glm::distance(end, distance * ray.way) > 1e-10 * face.size()) return std::nullopt;
    return RayEntry{distance, glm::normalize(normal)};
  }
  return std::nullopt;
}

std::optional<RayEntry> cast(const Shape& shape, Vec3 from, Vec3 way, Real limit) {
  if (const auto same = closed_form(shape)) return ellipsoid.cast(*same, from, way, limit);
  const Surface& s = *shape.surface;
  const SkinModel& m = *s.model;
  std::optional<RayEntry> best;
  m.tree.cast(from, way, limit, [&](std::uint32_t index, Real so_far) {
    for (const std::uint32_t corner : m.tiles.triangles[index]) {
      const nurbs::Place& start = m.tiles.places[corner];
      const auto at = crossing(s.skin->face(start.face), start, {from, way});
      if (!at || at->distance < 0 || at->distance > so_far || !(glm::dot(at->normal, way) < 0))
        continue;
      so_far = at->distance, best = at;
    }
    return so_far;
  });
  return best;
}

/// Searches all faces, unless the local result is certain.
std::optional<SurfacePoint> closest(const Shape& shape, Vec3 p, Real limit) {
  if (const auto same = closed_form(shape)) return ellipsoid.closest(*same, p, limit);
  const Surface& s = *shape.surface;
  SkinPoint near = nearest_on(s, p);
  // Another point may be closer by less than the chord of the triangles.
  const bool is_sure = s.model->is_convex && near.distance > 0;
  for (const nurbs::Face& face : s.skin->faces()) {
    if (is_sure) break;
    const nurbs::Ball ball = nurbs::bounding_ball(face.surface().points);
    const Real best = std::abs(near.distance) * (1 - 1e-9);
    if (glm::distance(ball.centre, p) - ball.radius >= best) continue;
    const nurbs::NearestPoint other = nurbs::closest_point(face, p);
    if (other.distance < best)
      near = place_on(s, {static_cast<int>(&face - s.skin->faces().data()), other.u, other.v}, p);
  }
  const bool is_inside = s.model->is_closed && near.distance < 0;
  if (!s.model->is_closed && near.distance < 0)  // a patch has no inside: use its other side
    near.distance = -near.distance, near.normal = -near.normal;
  if (!is_inside && near.distance > limit) return std::nullopt;
  return SurfacePoint{near.point, near.normal, near.distance};
}

/// The smaller principal curvature, 1/m; below 0 where the surface is concave.
Real least_curvature(const nurbs::Jet& j, Vec3 n) {
  const Real uu = glm::dot(j.u, j.u), uv = glm::dot(j.u, j.v), vv = glm::dot(j.v, j.v);
  const Real l = -glm::dot(n, j.uu), m = -glm::dot(n, j.uv), o = -glm::dot(n, j.vv);
  const Real determinant = uu * vv - uv * uv;
  if (!(determinant > 1e-18 * (uu + vv) * (uu + vv))) return 0;
  const Real mean = (l * vv - 2 * m * uv + o * uu) / (2 * determinant);
  const Real gauss = (l * o - m * m) / determinant;
  return mean - std::sqrt(std::max(mean * mean - gauss, Real(0)));
}

/// One point on a curved place; on a flat place or at an edge, the support points of tilted
/// directions.
void patch(const Shape& shape, const Towards& towards, Patch& to) {
  constexpr std::uint32_t kTilts = 8;
  constexpr Real kFlat = 0.1, kSame = 0.01;  // of 1 / size, and of the size
  const Vec3 d = towards.direction;
  if (closed_form(shape)) return to.add(support(shape, d), 0);
  const Surface& s = *shape.surface;
  const SkinPoint at = farthest_on(s, d);
  const nurbs::Face& face = s.skin->face(at.at.face);
  const Vec3 n = nurbs::normal_at(face, at.at.u, at.at.v);
  const bool is_facing = glm::distance(n, d) < 1e-6;
  if (is_facing && least_curvature(face.at(at.at.u, at.at.v), n) * s.model->size > kFlat)
    return to.add(at.point, 0);
  const Vec3 side = std::abs(d.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 u = glm::normalize(glm::cross(d, side)), v = glm::cross(d, u);
  for (std::uint32_t k = 0; k < kTilts; ++k) {
    const Real angle = 2 * kPi * (k + 0.5) / kTilts;
    const Vec3 p = support(shape, d + towards.tilt * (std::cos(angle) * u + std::sin(angle) * v));
    const auto near = [&](std::size_t i) {
      return glm::distance(to.points[i], p) <= kSame * s.model->size;
    };
    if (to.count == 0 || !(near(to.count - 1) || near(0))) to.add(p, k);
  }
}

/// Radius of curvature in the rolling direction.
Real rounding(const Shape& shape, const Rolling& at) {
  if (const auto same = closed_form(shape)) return ellipsoid.rounding(*same, at);
  const Surface& s = *shape.surface;
  const SkinPoint on = nearest_on(s, at.point);
  const nurbs::Jet j = s.skin->face(on.at.face).at(on.at.u, on.at.v);
  const Vec3 n = at.outward;
  Vec3 way = glm::cross(at.spin, n);
  if (!(glm::length(way) > 0)) way = j.u;
  const Real uu = glm::dot(j.u, j.u), uv = glm::dot(j.u, j.v), vv = glm::dot(j.v, j.v);
  const Real determinant = uu * vv - uv * uv, u = glm::dot(way, j.u), v = glm::dot(way, j.v);
  if (!(determinant > 0)) return 0;
  const Real du = (vv * u - uv * v) / determinant, dv = (uu * v - uv * u) / determinant;
  const Real bend = -(glm::dot(n, j.uu) * du * du + 2 * glm::dot(n, j.uv) * du * dv +
                      glm::dot(n, j.vv) * dv * dv);
  const Real speed = uu * du * du + 2 * uv * du * dv + vv * dv * dv;
  // A place much flatter than the body's size counts as a flat face.
  constexpr Real kFlat = 0.1;
  return bend * s.model->size > kFlat * speed ? speed / bend : 0;
}

}  // namespace

constinit const ShapeTraits nurbs{
    .about =
        "A surface of NURBS faces: the interior of a closed one, or the inner side of an open "
        "patch or a cavity, which have no mass of their own.",
    .shape_class = ShapeClass::skin,
    .source = SurfaceSource::skin,
    .support = support,
    .enclosed = enclosed,
    .inner_radius = inner_radius,
    .bounds = bounds_of_surface,
    .cast = cast,
    .closest = closest,
    .patch = patch,
    .rounding = rounding,
};

}  // namespace pantin::detail::shape_kinds
