#include "tools/pantin/view_pick.hpp"

#ifdef PANTIN_HAS_VIEW
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/geometry/surface.hpp"

namespace pantin::program {
namespace {

/// The first crossing with a sphere about the origin of the ray's own frame.
std::optional<Real> meet_sphere(Vec3 from, Vec3 way, Vec3 centre, Real radius) {
  const Vec3 to = centre - from;
  const Real along = glm::dot(to, way), c = glm::dot(to, to) - radius * radius;
  const Vec3 beside = to - along * way;  // more exact than the discriminant for far small spheres
  const Real half2 = radius * radius - glm::dot(beside, beside);
  if (c < 0 || along < 0 || half2 < 0) return std::nullopt;
  return along - std::sqrt(half2);
}

/// A capsule about the y axis: its straight part, else its two ends.
std::optional<Real> meet_capsule(Vec3 from, Vec3 way, Real radius, Real half) {
  std::optional<Real> best;
  const auto take = [&](std::optional<Real> t) {
    if (t && (!best || *t < *best)) best = t;
  };
  const Real a = way.x * way.x + way.z * way.z;
  if (a > 1e-18) {
    const Real b = from.x * way.x + from.z * way.z;
    const Real c = from.x * from.x + from.z * from.z - radius * radius;
    const Real under = b * b - a * c;
    if (under >= 0) {
      const Real t = (-b - std::sqrt(under)) / a;
      if (t >= 0 && std::abs(from.y + t * way.y) <= half) take(t);
    }
  }
  take(meet_sphere(from, way, {0, half, 0}, radius));
  take(meet_sphere(from, way, {0, -half, 0}, radius));
  return best;
}

/// A box by its three slabs.
std::optional<Real> meet_box(Vec3 from, Vec3 way, Vec3 half) {
  Real enter = 0, leave = INFINITY;
  for (int i = 0; i < 3; ++i) {
    if (way[i] == 0) {
      if (std::abs(from[i]) > half[i]) return std::nullopt;
      continue;
    }
    const Real one = (-half[i] - from[i]) / way[i], two = (half[i] - from[i]) / way[i];
    enter = std::max(enter, std::min(one, two)), leave = std::min(leave, std::max(one, two));
  }
  if (enter > leave || enter == 0) return std::nullopt;
  return enter;
}

/// The upper side of the slab that a plane is drawn as.
std::optional<Real> meet_plane(Vec3 from, Vec3 way, Real extent) {
  if (from.y <= 0 || way.y >= 0) return std::nullopt;
  const Real t = -from.y / way.y;
  const Vec3 at = from + t * way;
  if (std::abs(at.x) > extent || std::abs(at.z) > extent) return std::nullopt;
  return t;
}

/// A triangle seen from outside. [Moeller & Trumbore 1997]
std::optional<Real> meet_triangle(Vec3 from, Vec3 way, Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 ab = b - a, ac = c - a, p = glm::cross(way, ac);
  const Real facing = glm::dot(ab, p);
  if (facing <= 0) return std::nullopt;
  const Vec3 s = from - a, q = glm::cross(s, ab);
  const Real u = glm::dot(s, p) / facing, v = glm::dot(way, q) / facing;
  const Real t = glm::dot(ac, q) / facing;
  if (u < 0 || v < 0 || u + v > 1 || t < 0) return std::nullopt;
  return t;
}

std::optional<Real> meet_surface(Vec3 from, Vec3 way, const Surface& surface) {
  std::optional<Real> best;
  const Vec3 middle = 0.5 * (surface.low + surface.high), half = 0.5 * (surface.high - surface.low);
  const Vec3 inside = glm::abs(from - middle);
  const bool within = inside.x <= half.x && inside.y <= half.y && inside.z <= half.z;
  // A little wider: a flat field has no height.
  if (!within && !meet_box(from - middle, way, half + 1e-9)) return std::nullopt;
  const auto take = [&](Vec3 a, Vec3 b, Vec3 c) {
    const auto t = meet_triangle(from, way, a, b, c);
    if (t && (!best || *t < *best)) best = t;
  };
  if (surface.columns > 0) {
    const std::uint32_t count = 2 * (surface.columns - 1) * (surface.rows - 1);
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto corners = triangle_of(surface, i);
      take(corners[0], corners[1], corners[2]);
    }
    return best;
  }
  for (const Face& face : surface.faces) {
    const auto corner = [&](std::uint32_t i) {
      return surface.points[surface.corners[face.first + i]];
    };
    for (std::uint32_t i = 2; i < face.count; ++i) take(corner(0), corner(i - 1), corner(i));
  }
  return best;
}

std::optional<Picked> pick_exactly(const World& world, std::span<const Pose> poses,
                                   const Ray& ray) {
  std::optional<Picked> best;
  Real nearest = INFINITY;
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    const Entity body = world.shapes.owners()[i];
    const std::uint32_t slot = world.bodies.slot(body);
    if (slot >= poses.size()) continue;
    for (const Shape& shape : world.shapes.values()[i].parts) {
      const auto t = meet(ray, shape, poses[slot]);
      if (!t || !(*t < nearest)) continue;
      nearest = *t;
      const Vec3 point = ray.origin + *t * ray.way;
      best = {body, point, to_local(poses[slot], point)};
    }
  }
  return best;
}

}  // namespace

Ray ray_through(const Eye& eye, double x, double y) {
  const Real right = (2 * (x + 0.5) / eye.width - 1) * eye.tan_x;
  const Real up = (1 - 2 * (y + 0.5) / eye.height) * eye.tan_y;
  return {eye.position, glm::normalize(eye.forward + right * eye.right + up * eye.up)};
}

std::optional<Real> meet(const Ray& ray, const Shape& shape, const Pose& pose) {
  const Pose at = compose(pose, shape.local);
  const Vec3 from = to_local(at, ray.origin), way = glm::conjugate(at.rotation) * ray.way;
  switch (shape.kind) {
    case ShapeKind::sphere:
      return meet_sphere(from, way, Vec3(0), shape.size.x);
    case ShapeKind::capsule:
      return meet_capsule(from, way, shape.size.x, shape.size.y);
    case ShapeKind::plane:
      return meet_plane(from, way, shape.size.x);
    case ShapeKind::hull:
    case ShapeKind::mesh:
    case ShapeKind::height_field:
      return shape.surface ? meet_surface(from, way, *shape.surface) : std::nullopt;
    case ShapeKind::box:
      break;
  }
  return meet_box(from, way, shape.size);
}

std::optional<Picked> pick(const World& world, std::span<const Pose> poses, const Eye& eye,
                           double x, double y) {
  if (auto hit = pick_exactly(world, poses, ray_through(eye, x, y))) return hit;
  constexpr int kAround = 12;
  for (const double pixels : {2.0, 4.0, 6.0})
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2 * kPi * i / kAround;
      const Ray ray = ray_through(eye, x + pixels * std::cos(angle), y + pixels * std::sin(angle));
      if (auto hit = pick_exactly(world, poses, ray)) return hit;
    }
  return std::nullopt;
}

Vec3 on_plane(const Eye& eye, Vec3 point, double x, double y) {
  const Ray ray = ray_through(eye, x, y);
  // Every ray of the picture goes forward, so none is parallel to a plane that faces the eye.
  return ray.origin + eye.depth(point) / glm::dot(ray.way, eye.forward) * ray.way;
}

}  // namespace pantin::program
#endif
