#pragma once
// Worlds for the planar solver: bodies in the plane of x and y.
#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/runtime/simulation.hpp"
#include "engine/solvers/planar/island.hpp"
#include "engine/world/ties.hpp"

namespace pantin::test {

using namespace detail;

inline World planar_world(Vec3 gravity = {0, -9.81, 0}) {
  World w;
  w.default_settings.solver = Solver::planar;
  w.gravity = gravity;
  return w;
}

inline Entity add_fixed(World& w, Pose at = {}) {
  Body b;
  b.motion = Motion::fixed, b.pose = at;
  return w.add_body(b);
}

/// A half-space below a line through `at`, at an angle to the level.
inline Entity add_slope(World& w, Real angle, const Collision& how = {}) {
  const Entity ground = add_fixed(w, {Vec3(0), from_rotation_vector({0, 0, angle})});
  Shape plane;
  plane.kind = ShapeKind::plane, plane.size = {10, 0, 0};
  w.shapes.add(ground, {{plane}}), w.collisions.add(ground, how);
  return ground;
}

inline Entity add_solid(World& w, ShapeKind kind, Vec3 size, Pose at, const Collision& how = {}) {
  Shape shape;
  shape.kind = kind, shape.size = size;
  const MassProperties m = mass_properties(shape, 1000);
  Body b;
  b.mass = m.mass, b.inertia = {m.inertia[0][0], m.inertia[1][1], m.inertia[2][2]};
  b.pose = at, b.drag = 0;
  const Entity e = w.add_body(b);
  w.shapes.add(e, {{shape}}), w.collisions.add(e, how);
  return e;
}

/// A uniform rod of 1 kg whose ends are at `from` and `to`.
inline Entity add_rod(World& w, Vec3 from, Vec3 to) {
  const Vec3 along = to - from;
  const Real length = glm::length(along), across = length * length / 12;
  Body b;
  b.mass = 1, b.inertia = {0.01 * across, across, across}, b.drag = 0;
  b.pose = {0.5 * (from + to), from_rotation_vector({0, 0, std::atan2(along.y, along.x)})};
  return w.add_body(b);
}

/// A joint whose x is along `axis` at a place of the world as it stands.
inline Joint planar_joint(const World& w, Entity a, Entity b, JointKind kind, Vec3 place,
                          Vec3 axis = {0, 0, 1}) {
  const Pose &pa = w.bodies[a].pose, &pb = w.bodies[b].pose;
  const Vec3 x = glm::normalize(axis), turn = glm::cross(Vec3(1, 0, 0), x);
  const Quat axes =
      glm::length(turn) > 0
          ? from_rotation_vector(std::atan2(glm::length(turn), x.x) / glm::length(turn) * turn)
      : x.x > 0 ? kIdentity
                : from_rotation_vector({0, 0, kPi});
  Joint j;
  j.kind = kind, j.anchor_a = to_local(pa, place), j.anchor_b = to_local(pb, place);
  j.frames.set(glm::conjugate(pa.rotation) * axes, glm::conjugate(pb.rotation) * axes);
  return j;
}
inline Entity add_hinge(World& w, Entity a, Entity b, Vec3 place, Vec3 axis = {0, 0, 1}) {
  return add_link(w, {a, b, planar_joint(w, a, b, JointKind::hinge, place, axis)});
}

inline StepReport run(World& w, Real h, int steps) {
  StepSettings settings;
  settings.h = h;
  StepReport report;
  for (int i = 0; i < steps; ++i) report = step_world(w, settings, {}, {});
  return report;
}

/// A crank, a coupler and a rocker on a frame of 1 m.
inline World planar_four_bar() {
  World w = planar_world();
  const Vec3 a(0), b(0, 0.3, 0), d(1, 0, 0), c(0.9, 0.8, 0);
  const Entity frame = add_fixed(w);
  const Entity crank = add_rod(w, a, b), coupler = add_rod(w, b, c), rocker = add_rod(w, d, c);
  add_hinge(w, frame, crank, a), add_hinge(w, crank, coupler, b);
  add_hinge(w, coupler, rocker, c), add_hinge(w, frame, rocker, d);
  return w;
}

/// Boxes of 0.2 m on one another.
inline World planar_stack(int boxes) {
  World w = planar_world();
  add_slope(w, 0);
  for (int i = 0; i < boxes; ++i)
    add_solid(w, ShapeKind::box, Vec3(0.1), {{0, 0.1 + 0.2 * i, 0}, kIdentity});
  return w;
}

}  // namespace pantin::test
