#include "engine/render/trails.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kMostPoints = 4000;
// Relative to a surface's size: closer points are merged; a larger step is a jump of the contact.
constexpr Real kStep = 2e-3, kLeap = 0.25;

Real size_of(const ContactSurface& s) {
  return s.skin ? s.skin->size() : (s.curve ? s.curve->size() : 1);
}

}  // namespace

void ContactTrails::add(std::size_t which, Vec3 point, Real size) {
  Overlay::Trail& trail = trails_[which];
  std::vector<Vec3>& points = trail.points;
  const Real way = points.empty() ? 0 : glm::distance(points.back(), point);
  if (!points.empty() && !apart_[which] && way < kStep * size) return;
  if (points.size() == kMostPoints) {
    constexpr std::size_t kGone = kMostPoints / 4;
    points.erase(points.begin(), points.begin() + kGone);
    std::erase_if(trail.starts, [](std::size_t n) { return n <= kGone; });
    for (std::size_t& n : trail.starts) n -= kGone;
  }
  if (!points.empty() && (apart_[which] || way > kLeap * size))
    trail.starts.push_back(points.size());
  points.push_back(point), apart_[which] = false;
}

void ContactTrails::record(const World& world) {
  const auto owners = world.surface_contacts.owners();
  for (std::size_t i = 0; i < owners.size(); ++i) {
    const SurfaceContact& c = world.surface_contacts.values()[i];
    const auto note = [&](std::size_t which, const SurfaceSpot& spot) {
      const auto [place, is_new] =
          places_.try_emplace(std::pair(owners[i].index, which), trails_.size());
      const std::size_t first = place->second;
      if (is_new) trails_.push_back({c.a, {}}), trails_.push_back({c.b, {}});
      apart_.resize(trails_.size(), true);
      if (!spot.touches || !is_finite(spot.point)) {
        apart_[first] = apart_[first + 1] = true;
        return;
      }
      const auto go = [&](std::size_t trail, Vec3 at, const ContactSurface& surface) {
        const std::uint32_t slot = world.bodies.slot(trails_[trail].body);
        const Pose pose = slot == kNoSlot ? Pose{} : world.bodies.values()[slot].pose;
        add(trail, to_local(pose, at), size_of(surface));
      };
      go(first, spot.point + spot.gap * spot.normal, c.on_a), go(first + 1, spot.point, c.on_b);
    };
    note(0, {c.touches, c.slips, c.point, c.normal, c.force, c.gap});
    for (std::size_t n = 0; n + 1 < c.spots; ++n) note(n + 1, c.more[n]);
  }
}

}  // namespace pantin::detail
