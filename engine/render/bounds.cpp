#include "engine/render/bounds.hpp"

namespace pantin {

void add_balls(const Shape& shape, const Pose& pose, std::vector<Ball>& to) {
  const Pose at = compose(pose, shape.local);
  switch (shape.kind) {
    case ShapeKind::sphere:
      to.push_back({at.position, shape.size.x});
      break;
    case ShapeKind::capsule:
      for (Real end : {-1.0, 1.0})
        to.push_back({to_world(at, {0, end * shape.size.y, 0}), shape.size.x});
      break;
    case ShapeKind::box:
      for (int c = 0; c < 8; ++c) {
        const Vec3 corner{c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1};
        to.push_back({to_world(at, corner * shape.size), 0});
      }
      break;
  }
}

bool string_ends(const World& world, std::span<const Pose> poses, const String& string, Vec3& a,
                 Vec3& b) {
  const std::uint32_t slot_a = world.bodies.slot(string.a), slot_b = world.bodies.slot(string.b);
  if (slot_a == kNoSlot || slot_b == kNoSlot) return false;
  a = to_world(pose_of(world, poses, slot_a), string.joint.anchor_a);
  b = to_world(pose_of(world, poses, slot_b), string.joint.anchor_b);
  return is_finite(a) && is_finite(b);
}

namespace {

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

void add_string_curve(Vec3 a, Vec3 b, Real length, Vec3 down, int segments, std::vector<Vec3>& to) {
  if (!(length > glm::length(b - a) * (1 + 1e-4))) {
    to.push_back(a), to.push_back(b);
    return;
  }
  // The length grows with the sag and is at least twice the sag less the chord.
  Real low = 0, high = 0.5 * (length + glm::length(b - a)) + 1e-12;
  for (int i = 0; i < 24; ++i) {
    const Real middle = (low + high) / 2;
    (polyline_length(a, b, middle * down, segments) < length ? low : high) = middle;
  }
  for (int i = 0; i <= segments; ++i)
    to.push_back(on_parabola(a, b, low * down, Real(i) / segments));
}

Vec3 down_of(const World& world) {
  const Real g = glm::length(world.gravity);
  return g > 0 ? world.gravity / g : Vec3{0, -1, 0};
}

}  // namespace pantin
