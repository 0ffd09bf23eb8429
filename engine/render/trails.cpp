#include "engine/render/trails.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kMostPoints = 4000;
constexpr Real kStep = 2e-3;  // of a surface's size: points nearer than this are one

Real size_of(const ContactSurface& s) {
  return s.skin ? s.skin->size() : (s.curve ? s.curve->size() : 1);
}

}  // namespace

void ContactTrails::add(Overlay::Trail& trail, Vec3 point, Real near) {
  if (!trail.points.empty() && glm::distance(trail.points.back(), point) < near) return;
  if (trail.points.size() == kMostPoints)
    trail.points.erase(trail.points.begin(), trail.points.begin() + kMostPoints / 4);
  trail.points.push_back(point);
}

void ContactTrails::record(const World& world) {
  const auto owners = world.surface_contacts.owners();
  for (std::size_t i = 0; i < owners.size(); ++i) {
    const SurfaceContact& c = world.surface_contacts.values()[i];
    const auto [place, is_new] = places_.try_emplace(owners[i].index, trails_.size());
    if (is_new) trails_.push_back({c.a, {}}), trails_.push_back({c.b, {}});
    if (!c.touches || !is_finite(c.point)) continue;
    const Vec3 on_b = c.point, on_a = c.point + c.gap * c.normal;
    const auto note = [&](std::size_t which, Entity body, Vec3 at, const ContactSurface& surface) {
      const std::uint32_t slot = world.bodies.slot(body);
      const Pose pose = slot == kNoSlot ? Pose{} : world.bodies.values()[slot].pose;
      add(trails_[place->second + which], to_local(pose, at), kStep * size_of(surface));
    };
    note(0, c.a, on_a, c.on_a), note(1, c.b, on_b, c.on_b);
  }
}

}  // namespace pantin::detail
