// Contacts of NURBS shapes: while bodies slide and roll within a step, each moves over both faces
// to where they are closest.
#include <algorithm>

#include "engine/geometry/skin_model.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/solvers/articulated/impulses/group_points.hpp"

namespace pantin::detail::articulated {
namespace {

/// Cosine between the normals before and after, below which the faces are closest at another place.
constexpr Real kSamePlace = 0.7;
/// Of the smaller skin: overlap beyond which that place is on the far side.
constexpr Real kNewPlace = 0.02;

}  // namespace

void follow(const Group& g, GroupContact& c) {
  if (c.skins == kNoNode) return;
  TouchingSkins& s = g.skins[c.skins];
  const Pose &on_a = g.a(c).pose, &on_b = g.b(c).pose;
  const Pose b = compose(on_b, s.b->local), a_in_b = compose(inverse(b), compose(on_a, s.a->local));
  const auto touch = follow_touch({*s.a->surface, *s.b->surface, a_in_b}, s.on_a, s.on_b);
  if (!touch) return;
  const Vec3 normal = b.rotation * touch->normal;
  const bool same = glm::dot(normal, c.axes[0]) > kSamePlace;
  const Real gap = glm::dot(touch->normal, touch->at_a - touch->at_b);
  if (!same && gap < -kNewPlace * std::min(s.a->surface->model->size, s.b->surface->model->size))
    return;
  s.on_a = touch->on_a, s.on_b = touch->on_b;
  const Vec3 impulse = same ? to_world(c, c.impulse) : Vec3(0), passed = to_world(c, c.passed);
  const Vec3 surface = to_world(c, {0, c.surface_first, c.surface_second});
  const Real pressed = same ? c.impulse.x : 0;
  contact::set_axes(c.axes, normal);
  c.impulse = contact::along_axes(c.axes, impulse), c.passed = contact::along_axes(c.axes, passed);
  c.impulse.x = pressed;
  c.surface_first = glm::dot(surface, c.axes[1]), c.surface_second = glm::dot(surface, c.axes[2]);
  c.on_a.core = to_local(on_a, to_world(b, touch->at_a) + c.on_a.radius * normal);
  c.on_b.core = to_local(on_b, to_world(b, touch->at_b) - c.on_b.radius * normal);
}

}  // namespace pantin::detail::articulated
