#include "engine/modes/touch.hpp"

#include <algorithm>
#include <limits>

namespace pantin::detail::modes {
namespace {

/// A point of the scene in the lamina's initial pose.
Vec2 to_start(const Moment& now, Vec2 p) {
  return turned(p - now.placed.shift, now.facing.x, -now.facing.y);
}
Vec2 to_scene(const Moment& now, Vec2 p) {
  return now.placed.shift + turned(p, now.facing.x, now.facing.y);
}

}  // namespace

Contact contact_of(const Moment& now, Touch touch) {
  const Finger& f = now.fingers[touch.finger];
  if (f.flat) return {to_scene(now, now.part.outline[touch.feature]), f.normal, f.velocity};
  const Edge e = edge_of(now.part.outline, touch.feature);
  return {now.finger_at(touch.finger), turned(e.normal, now.facing.x, now.facing.y), f.velocity};
}

Real gap_of(const Moment& now, Touch touch) {
  const Finger& f = now.fingers[touch.finger];
  const Vec2 at = now.finger_at(touch.finger);
  if (f.flat) return dot(f.normal, to_scene(now, now.part.outline[touch.feature]) - at);
  const Edge e = edge_of(now.part.outline, touch.feature);
  return -dot(e.normal, to_start(now, at) - e.from);
}

Real left_on_edge(const Moment& now, Touch touch) {
  if (now.fingers[touch.finger].flat) return std::numeric_limits<Real>::infinity();
  const Edge e = edge_of(now.part.outline, touch.feature);
  const Real along = dot(e.along, to_start(now, now.finger_at(touch.finger)) - e.from);
  return std::min(along, e.length - along);
}

Vec3 load_of(const Moment& now) {
  const Part& p = now.part;
  return {p.force.x, p.force.y, p.torque + cross(to_scene(now, p.centre), p.force)};
}

Touches touches_of(const Moment& now, Real tolerance) {
  Touches all;
  const std::size_t n = now.part.outline.size();
  for (std::size_t i = 0; i < now.fingers.size(); ++i) {
    std::size_t of_this = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const Touch touch{static_cast<std::uint8_t>(i), static_cast<std::uint32_t>(k)};
      if (std::abs(gap_of(now, touch)) > tolerance || left_on_edge(now, touch) < -tolerance)
        continue;
      if (all.count == kMostContacts) {
        all.too_many = true;
        return all;
      }
      all.list[all.count++] = touch;
      ++of_this;
      if (now.fingers[i].flat || of_this != 2) continue;
      // Two edges at once: a convex corner has no normal; at a reflex one both are contacts.
      const Touch before = all.list[all.count - 2];
      const Edge a = edge_of(now.part.outline, before.feature), b = edge_of(now.part.outline, k);
      const bool in_order = k == before.feature + 1;
      const Real turn = in_order ? cross(a.along, b.along) : cross(b.along, a.along);
      all.at_corner |= turn > 0;
    }
  }
  return all;
}

Real least_gap(const Moment& now, std::size_t finger) {
  const Finger& f = now.fingers[finger];
  const auto number = static_cast<std::uint8_t>(finger);
  if (f.flat) {
    Real least = std::numeric_limits<Real>::infinity();
    for (std::uint32_t k = 0; k < now.part.outline.size(); ++k)
      least = std::min(least, gap_of(now, {number, k}));
    return least;
  }
  const Vec2 at = to_start(now, now.finger_at(finger));
  const Real away = nearest_edge(now.part.outline, at, 0).distance;
  return is_inside(now.part.outline, at) ? -away : away;
}

}  // namespace pantin::detail::modes
