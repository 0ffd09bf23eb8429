#pragma once
// Solid bodies for the contact tests.
#include "engine/base/rotation.hpp"
#include "engine/runtime/simulation.hpp"

namespace pantin::test {

using namespace detail;

inline Shape box_shape(Vec3 half) {
  Shape s;
  s.kind = ShapeKind::box, s.size = half;
  return s;
}
inline Shape ball_shape(Real radius) {
  Shape s;
  s.size = {radius, 0, 0};
  return s;
}
inline Shape rod_shape(Real radius, Real half) {
  Shape s;
  s.kind = ShapeKind::capsule, s.size = {radius, half, 0};
  return s;
}
inline Shape ground_shape() {
  Shape s;
  s.kind = ShapeKind::plane, s.size = {5, 0, 0};
  return s;
}

/// A body of one solid shape with the mass of water.
inline Entity add_solid(World& w, const Shape& shape, const Pose& pose, Motion motion,
                        const Collision& collision = {}, Real density = 1000) {
  Body b;
  b.drag = 0, b.pose = pose, b.motion = motion;
  if (motion == Motion::dynamic) {
    const MassProperties m = mass_properties(shape, density);
    b.mass = m.mass, b.inertia = {m.inertia[0][0], m.inertia[1][1], m.inertia[2][2]};
  }
  const Entity e = w.add_body(b);
  Shapes shapes;
  shapes.list.push_back(shape);
  w.shapes.add(e, shapes);
  w.collisions.add(e, collision);
  return e;
}

inline Entity add_ground(World& w, const Collision& collision = {}, Quat rotation = kIdentity) {
  return add_solid(w, ground_shape(), {Vec3(0), rotation}, Motion::fixed, collision);
}

}  // namespace pantin::test
