#include "engine/render/bounds.hpp"

#include <limits>

#include "engine/geometry/surface.hpp"
#include "engine/render/surface_mesh.hpp"
#include "engine/world/cable_route.hpp"

namespace pantin::detail {
namespace {

void add_corners(const Pose& at, Vec3 low, Vec3 high, std::vector<Ball>& to) {
  for (int c = 0; c < 8; ++c) {
    const Vec3 corner{c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z};
    to.push_back({to_world(at, corner), 0});
  }
}

void add_surface(const Shape& shape, const Pose& at, std::vector<Ball>& to) {
  if (!shape.surface) return;
  const Surface& s = *shape.surface;
  if (traits_of(shape.kind).shape_class == ShapeClass::heights)
    return add_corners(at, s.low - Vec3{0, rim_of(s), 0}, s.high, to);
  if (s.skin || s.points.size() > kMostBalls) return add_corners(at, s.low, s.high, to);
  for (Vec3 point : s.points) to.push_back({to_world(at, point), 0});
}

/// A ball at each corner of the core; one without extent along an axis has a single corner there.
void add_rounded(const RoundedBox& box, const Pose& at, std::vector<Ball>& to) {
  if (box.radius == 0) return add_corners(at, -box.core, box.core, to);
  for (int c = 0; c < 8; ++c) {
    Vec3 corner(0);
    bool again = false;
    for (int k = 0; k < 3; ++k) {
      again |= box.core[k] == 0 && (c & 1 << k);
      corner[k] = box.core[k] == 0 ? 0 : c & 1 << k ? box.core[k] : -box.core[k];
    }
    if (!again) to.push_back({to_world(at, corner), box.radius});
  }
}

/// Distance of a shape's farthest point from its body's origin; infinite for grounds.
Real shape_reach(const Shape& shape) {
  const Real off = glm::length(shape.local.position);
  if (is_ground(shape.kind)) return std::numeric_limits<Real>::infinity();
  if (shape.surface) return off + 0.5 * glm::length(shape.surface->high - shape.surface->low);
  return off + reach_of(shape);
}

}  // namespace

Real drawn_reach(const World& world, Entity body) {
  const Shapes* shapes = world.shapes.find(body);
  Real reach = 0;
  if (shapes)
    for (const Shape& shape : shapes->list) reach = std::max(reach, shape_reach(shape));
  return reach > 0 ? reach : std::numeric_limits<Real>::infinity();
}

void add_balls(const Shape& shape, const Pose& pose, std::vector<Ball>& to) {
  const Pose at = compose(pose, shape.local);
  const ShapeTraits& kind = traits_of(shape.kind);
  if (kind.shape_class == ShapeClass::half_space) {
    const Shape slab = slab_of(shape);
    if (shape.size.x > 0) add_corners(compose(pose, slab.local), -slab.size, slab.size, to);
    return;
  }
  const auto box = kind.rounded ? kind.rounded(shape) : std::nullopt;
  if (box) return add_rounded(*box, at, to);
  if (has_surface(shape.kind)) return add_surface(shape, at, to);
  const Aabb bounds = bounds_of(shape, Pose{});
  add_corners(at, bounds.low, bounds.high, to);
}

Shape slab_of(const Shape& plane) {
  const Real half = 0.01 * plane.size.x;
  Shape slab = plane;
  slab.kind = ShapeKind::box;
  slab.size = {plane.size.x, half, plane.size.x};
  slab.local.position = to_world(plane.local, {0, -half, 0});
  return slab;
}

std::optional<Vec3> PosedWorld::position_of(Entity body, Vec3 anchor) const {
  const std::uint32_t slot = world.bodies.slot(body);
  if (slot == kNoSlot) return std::nullopt;
  const Vec3 position = to_world(pose_of(slot), anchor);
  if (!is_finite(position)) return std::nullopt;
  return position;
}

namespace {

/// Between sample points of a cable on a pulley, rad.
constexpr Real kArcStep = 0.15;

Vec3 on_parabola(Vec3 a, Vec3 b, Vec3 drop, Real t) {
  return a + t * (b - a) + 4 * t * (1 - t) * drop;
}

Real polyline_length(Vec3 a, Vec3 b, Vec3 drop, int segments) {
  Real sum = 0;
  for (int i = 0; i < segments; ++i)
    sum += glm::length(on_parabola(a, b, drop, Real(i + 1) / segments) -
                       on_parabola(a, b, drop, Real(i) / segments));
  return sum;
}

}  // namespace

void add_curve(const HangingCable& cable, int segments, std::vector<Vec3>& to) {
  const auto& [a, b, length, down] = cable;
  if (!(length > glm::length(b - a) * (1 + 1e-4))) {
    to.push_back(a), to.push_back(b);
    return;
  }
  // The length grows with the sag, and is at least twice the sag minus the chord.
  Real low = 0, high = 0.5 * (length + glm::length(b - a)) + 1e-12;
  for (int i = 0; i < 24; ++i) {
    const Real middle = (low + high) / 2;
    (polyline_length(a, b, middle * down, segments) < length ? low : high) = middle;
  }
  for (int i = 0; i <= segments; ++i)
    to.push_back(on_parabola(a, b, low * down, Real(i) / segments));
}

void add_cable(const PosedWorld& scene, const Cable& cable, int segments, std::vector<Vec3>& to) {
  if (!cable.guides.empty()) {
    const auto pose_of = [&](Entity body) -> const Pose* {
      const std::uint32_t slot = scene.world.bodies.slot(body);
      return slot == kNoSlot ? nullptr : &scene.pose_of(slot);
    };
    if (const auto route = route_of(cable, pose_of); !route.empty())
      trace_path(route, kArcStep, to);
    return;
  }
  const auto a = scene.position_of(cable.a, cable.joint.anchor_a);
  const auto b = scene.position_of(cable.b, cable.joint.anchor_b);
  if (a && b) add_curve({*a, *b, cable.joint.length, down_of(scene.world)}, segments, to);
}

Vec3 down_of(const World& world) {
  const Real g = glm::length(world.gravity);
  return g > 0 ? world.gravity / g : Vec3{0, -1, 0};
}

}  // namespace pantin::detail
