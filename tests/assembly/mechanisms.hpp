#pragma once
// Mechanisms for tests of assembly: assembled, and the same with their parts thrown about.
#include <cmath>
#include <string>
#include <vector>

#include "engine/assembly/assemble.hpp"
#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/world/ties.hpp"

namespace pantin::test {

using namespace detail;

inline Entity add_solid(World& w, Pose at, std::string name, Motion motion = Motion::dynamic) {
  Body b;
  b.motion = motion, b.pose = at, b.mass = 1, b.inertia = Vec3(0.1);
  return w.add_body(b, std::move(name));
}

/// Joint axes with x along `x` and y along the part of `y` across it, world.
inline Quat axes_along(Vec3 x, Vec3 y) {
  x = glm::normalize(x);
  y = glm::normalize(y - glm::dot(y, x) * x);
  return glm::normalize(glm::quat_cast(Mat3(x, y, glm::cross(x, y))));
}

struct JointAt {
  Entity a, b;
  JointKind kind = JointKind::ball;
  Vec3 point{0};
  Quat axes{1, 0, 0, 0};  // of both bodies
};

/// A joint whose point and axes are given in the world as it stands: it is closed there.
inline Entity join(World& w, const JointAt& at, std::string name) {
  const Pose a = w.bodies[at.a].pose, b = w.bodies[at.b].pose;
  Joint j;
  j.kind = at.kind;
  j.anchor_a = to_local(a, at.point), j.anchor_b = to_local(b, at.point);
  j.frames.set(glm::conjugate(a.rotation) * at.axes, glm::conjugate(b.rotation) * at.axes);
  return add_link(w, {at.a, at.b, j}, std::move(name));
}

/// A rod of that length between points of two bodies.
inline Entity add_rod(World& w, Entity a, Vec3 at_a, Entity b, Vec3 at_b, Real length,
                      std::string name) {
  Joint j;
  j.kind = JointKind::distance;
  j.anchor_a = at_a, j.anchor_b = at_b;
  j.parameters.edit().length = length;
  return add_link(w, {a, b, j}, std::move(name));
}

/// A chain of `n` links of 1 m on ball joints in an arc, both ends at points of the world.
inline World bendy(int n) {
  World w;
  w.gravity = Vec3(0);
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  Entity before = ground;
  Vec3 at(0);
  for (int i = 0; i < n; ++i) {
    const Real slope = n > 1 ? 2.4 * (0.5 - Real(i) / (n - 1)) : 0;
    const Vec3 along(std::cos(slope), std::sin(slope), 0);
    const Entity link =
        add_solid(w, {at + 0.5 * along, axes_along(along, {0, 0, 1})}, "link" + std::to_string(i));
    join(w, {before, link, JointKind::ball, at}, "joint" + std::to_string(i));
    at += along, before = link;
  }
  join(w, {before, ground, JointKind::ball, at}, "finger");
  return w;
}

/// Links bent by 90 degrees on hinges that are askew in turn, both ends on the ground.
inline World bent(int n) {
  World w;
  w.gravity = Vec3(0);
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  Entity before = ground;
  Vec3 at(0), along(1, 0, 0), across(0, 1, 0);
  for (int i = 0; i < n; ++i) {
    const Vec3 corner = at + 0.5 * along, end = corner + 0.5 * across;
    const Entity link =
        add_solid(w, {corner, axes_along(along, across)}, "link" + std::to_string(i));
    const bool is_ball = i == 0;
    join(w,
         {before, link, is_ball ? JointKind::ball : JointKind::hinge, at,
          axes_along(i % 2 ? along : across, glm::cross(along, across))},
         "joint" + std::to_string(i));
    const Vec3 up = glm::cross(along, across);
    at = end, before = link, along = across, across = i % 2 ? up : -up;
  }
  join(w, {before, ground, JointKind::ball, at}, "finger");
  return w;
}

/// A Stewart platform: six legs of two parts each, 13 bodies and 66 rows.
inline World stewart() {
  World w;
  w.gravity = Vec3(0);
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  const Entity top = add_solid(w, {{0, 1, 0}, kIdentity}, "platform");
  for (int i = 0; i < 6; ++i) {
    const Real low = (2 * kPi / 3) * (i / 2) + (i % 2 ? 0.2 : -0.2),
               high = (2 * kPi / 3) * (i / 2) + (i % 2 ? kPi / 3 - 0.2 : -kPi / 3 + 0.2);
    const Vec3 from(std::cos(low), 0, std::sin(low)),
        to(0.6 * std::cos(high), 1, 0.6 * std::sin(high));
    const Quat axes = axes_along(to - from, {0.3, 0.1, 1});
    const std::string n = std::to_string(i);
    const Entity lower = add_solid(w, {glm::mix(from, to, 0.25), axes}, "lower" + n),
                 upper = add_solid(w, {glm::mix(from, to, 0.75), axes}, "upper" + n);
    join(w, {ground, lower, JointKind::universal, from, axes}, "base" + n);
    join(w, {lower, upper, JointKind::cylindrical, glm::mix(from, to, 0.5), axes}, "ram" + n);
    join(w, {upper, top, JointKind::ball, to}, "head" + n);
  }
  return w;
}

/// Links on parallel hinges in a closed polygon with the ground: n moving links.
inline World polygon(int n) {
  World w;
  w.gravity = Vec3(0);
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  const Quat axes = axes_along({0, 0, 1}, {1, 0, 0});
  Entity before = ground;
  const auto corner = [&](int i) {
    const Real angle = 2 * kPi * i / (n + 1);
    return Vec3(std::cos(angle), std::sin(angle) * 0.9, 0);
  };
  for (int i = 0; i < n; ++i) {
    const Vec3 along = corner(i + 1) - corner(i);
    const Entity link =
        add_solid(w, {0.5 * (corner(i) + corner(i + 1)), axes_along(along, {0, 0, 1})},
                  "link" + std::to_string(i));
    join(w, {before, link, JointKind::hinge, corner(i), axes}, "hinge" + std::to_string(i));
    before = link;
  }
  join(w, {before, ground, JointKind::hinge, corner(n), axes}, "hinge" + std::to_string(n));
  return w;
}

/// Bricard's loop of six hinges along the edges of a cube.
inline World bricard() {
  World w;
  w.gravity = Vec3(0);
  const Vec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {1, 0, -1}, {1, 1, -1}, {0, 1, -1}, {0, 1, 0}};
  const Vec3 axes[] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  const Entity ground = add_solid(w, {}, "ground", Motion::fixed);
  Entity links[6] = {ground};
  for (int i = 1; i < 6; ++i)
    links[i] = add_solid(w, {0.5 * (corners[i] + corners[(i + 1) % 6]), kIdentity},
                         "link" + std::to_string(i));
  // Link i lies between corners i and i + 1; the hinge at a corner is across both of its links.
  for (int i = 0; i < 6; ++i) {
    const Vec3 axis = axes[(i + 1) % 6];
    const Vec3 in = corners[i] - corners[(i + 5) % 6], out = corners[(i + 1) % 6] - corners[i];
    const Vec3 across = glm::cross(in, out);
    join(w,
         {links[(i + 5) % 6], links[i], JointKind::hinge, corners[i],
          axes_along(glm::length(across) > 0.5 ? across : axis, in)},
         "hinge" + std::to_string(i));
  }
  return w;
}

}  // namespace pantin::test
