// Marks of surface joints: contact points, the tangent plane, and the trail of the contact.
#include "engine/base/rotation.hpp"
#include "engine/render/marks.hpp"

namespace pantin::detail {
namespace {

constexpr Real kPlane = 0.3;  // half the side of the drawn plane, relative to the smaller surface

Real size_of(const ContactSurface& s) {
  return s.skin ? s.skin->size() : (s.curve ? s.curve->size() : 1);
}

}  // namespace

void add_surface_marks(const PosedWorld& scene, Pen& pen) {
  for (const SurfaceContact& c : scene.world.surface_contacts.values()) {
    if (!c.known || c.over || !pen.sees(c.point) || glm::length(c.normal) < 0.5) continue;
    const Vec3 n = c.normal, colour = c.touches ? ink::kContact : ink::kNear;
    const Real half = kPlane * std::min(size_of(c.on_a), size_of(c.on_b));
    const Vec3 side = std::abs(n.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    const Vec3 u = half * glm::normalize(glm::cross(n, side)), v = glm::cross(n, u);
    const Vec3 corners[4] = {c.point - u - v, c.point + u - v, c.point + u + v, c.point - u + v};
    for (int i = 0; i < 4; ++i) {
      pen.triangle(c.point, corners[i], corners[(i + 1) % 4], {colour, 0.25});
      pen.line(corners[i], corners[(i + 1) % 4], pen.fine(), {colour});
    }
    pen.line(c.point, c.point + half * n, 1.5 * pen.fine(), {colour});
    pen.dot(c.point, 3 * pen.fine(), colour);
  }
}

void add_trails(const PosedWorld& scene, std::span<const Overlay::Trail> trails, Pen& pen) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < trails.size(); ++i) {
    const std::uint32_t slot = scene.world.bodies.slot(trails[i].body);
    const Pose pose = slot == kNoSlot ? Pose{} : scene.pose_of(slot);
    const Paint paint{i % 2 == 0 ? ink::kTrailA : ink::kTrailB};
    const auto draw = [&] {
      if (points.size() > 1) pen.path(points, 1.8 * pen.fine(), paint);
      points.clear();
    };
    auto start = trails[i].starts.begin();
    for (std::size_t n = 0; n < trails[i].points.size(); ++n) {
      if (start != trails[i].starts.end() && *start == n) draw(), ++start;
      points.push_back(to_world(pose, trails[i].points[n]));
    }
    draw();
  }
}

}  // namespace pantin::detail
