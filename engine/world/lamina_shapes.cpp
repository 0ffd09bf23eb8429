#include "engine/world/lamina_shapes.hpp"

#include <cmath>

#include "engine/geometry/surface.hpp"

namespace pantin::detail {
namespace {

// Sizes relative to the outline's extent: finger radius, common thickness, length of a flat finger.
constexpr Real kFinger = 0.02, kThick = 0.04, kFlat = 3;

}  // namespace

Vec3 plate_inertia(std::span<const Vec3> outline, Real mass) {
  Real sum = 0, twice_area = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec3 p = outline[i], q = outline[(i + 1) % outline.size()];
    const Real across = p.x * q.y - p.y * q.x;
    const auto dot = [](Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y; };
    sum += across * (dot(p, p) + dot(p, q) + dot(q, q)) / 12;
    twice_area += across;
  }
  const Real inertia = mass * sum / (twice_area / 2);
  return {inertia / 2, inertia / 2, inertia};
}

std::vector<Shape> plate_shapes(const std::vector<std::vector<Vec3>>& pieces,
                                const LaminaLook& look) {
  const Real thick = kThick * look.extent;
  std::vector<Shape> shapes;
  for (const auto& piece : pieces) {
    std::vector<Vec3> points;
    for (const Vec3 c : piece)
      for (const Real z : {-thick / 2, thick / 2}) points.push_back(c + Vec3(0, 0, z));
    auto hull = make_hull(points);
    if (!hull) continue;  // too thin to be drawn
    Shape& shape = shapes.emplace_back();
    shape.kind = ShapeKind::hull, shape.material = look.material, shape.surface = *hull;
  }
  return shapes;
}

Shape finger_shape(const FingerTip& tip, const LaminaLook& look) {
  Shape shape;
  shape.material = look.material;
  if (tip.flat) {
    shape.kind = ShapeKind::box;
    shape.size = Vec3(kFinger, kFlat / 2, kThick / 2) * look.extent;
    const Real half = std::atan2(tip.normal.y, tip.normal.x) / 2;
    shape.local.rotation = Quat(std::cos(half), 0, 0, std::sin(half));
  } else {
    shape.size = Vec3(kFinger * look.extent, 0, 0);
  }
  return shape;
}

Vec3 finger_arm(const FingerTip& tip, const LaminaLook& look) {
  return kFinger * look.extent * tip.normal;
}

Collision lamina_collision() { return {.friction = 1, .others = false, .self = false}; }
Collision finger_collision(Real slide) {
  return {.friction = slide * slide, .others = false, .self = false};
}

}  // namespace pantin::detail
