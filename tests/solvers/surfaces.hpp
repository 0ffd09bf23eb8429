#pragma once
// Bodies that touch by smooth surfaces, for the exact solver.
#include <memory>

#include "engine/nurbs/makers.hpp"
#include "engine/world/surface_contact.hpp"
#include "engine/world/ties.hpp"
#include "tests/solvers/exact.hpp"

namespace pantin::test {

using SkinPtr = std::shared_ptr<const nurbs::Skin>;

inline SkinPtr skin_of(nurbs::Surface surface) {
  return std::make_shared<const nurbs::Skin>(std::vector{std::move(surface)}, 1e-9);
}
inline SkinPtr ball_skin(Vec3 half_axes) {
  return std::make_shared<const nurbs::Skin>(nurbs::Skin::ellipsoid(half_axes));
}
/// Outwards is `up`.
inline SkinPtr flat_skin(Real side, Vec3 up = {0, 1, 0}) {
  const Vec3 x = std::abs(up.x) < 0.9 ? glm::normalize(glm::cross(up, Vec3(1, 0, 0)))
                                      : glm::normalize(glm::cross(up, Vec3(0, 1, 0)));
  return skin_of(nurbs::plane({{}, x, glm::cross(up, x), up}, side, side));
}
/// Outwards becomes inwards.
inline nurbs::Surface turned_over(const nurbs::Surface& s) {
  nurbs::Surface t{s.v, s.u, {}};
  for (int j = 0; j < s.v.count(); ++j)
    for (int i = 0; i < s.u.count(); ++i) t.points.push_back(s.at(i, j));
  return t;
}

/// A joint of two surfaces, each in its body's frame; the solver finds where they touch.
struct SurfacePair {
  Entity a;
  SkinPtr on_a;
  Entity b;
  SkinPtr on_b;
};
inline Entity touch(World& w, const SurfacePair& pair, SurfaceMotion motion) {
  SurfaceContact c;
  c.a = pair.a, c.b = pair.b, c.on_a.skin = pair.on_a, c.on_b.skin = pair.on_b;
  c.motion = motion;
  return add_surface_contact(w, c);
}

inline Body solid_ball(Real mass, Real radius, Vec3 at) {
  return solid(mass, Vec3(0.4 * mass * radius * radius), {at, kIdentity});
}
inline Body solid_ellipsoid(Real mass, Vec3 h, const Pose& at) {
  const Real k = mass / 5;
  return solid(
      mass, {k * (h.y * h.y + h.z * h.z), k * (h.x * h.x + h.z * h.z), k * (h.x * h.x + h.y * h.y)},
      at);
}

/// How fast two surfaces slip on one another where they touch, m/s.
inline Real slip_of(const World& w, Entity contact) {
  const SurfaceContact& c = w.surface_contacts[contact];
  const auto velocity = [&](Entity e) {
    const Body& b = w.bodies[e];
    return b.velocity + glm::cross(b.angular_velocity, c.point - b.pose.position);
  };
  const Vec3 v = velocity(c.a) - velocity(c.b);
  return glm::length(v - glm::dot(v, c.normal) * c.normal);
}

}  // namespace pantin::test
