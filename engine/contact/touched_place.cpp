// Contact points of rotating bodies.
#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/base/invariants.hpp"
#include "engine/contact/detect.hpp"
#include "engine/contact/on_the_way.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::contact {
namespace {

// A solid of revolution whose axis leans less, rad, stands on fixed points of its rim. With more
// lean the lowest point travels around the rim. Rim points within this cosine beside it count as
// that point, since it may reach them within the step. Tolerance of the lowest point, 1 - cos.
constexpr Real kUpright = 1e-3, kBeside = 0.5, kOffFarthest = 1e-9;
// Fractions: of the size; of the circle's radius, for contact points that were found separately.
constexpr Real kOnRim = 1e-6, kOnCircle = 1e-4;
// Least squared sine of a lean that is used as a divisor.
constexpr Real kLeastLean = 1e-12;

/// Whether a point, in the shape's frame, is on the circle about its axis through the support point
/// of a direction.
bool is_on_rim(const Shape& s, Vec3 point, Vec3 outward) {
  const Vec3 far = traits_of(s.kind).support(s, outward);
  const Real radius = std::hypot(far.x, far.z), near = kOnRim * (radius + std::abs(far.y));
  return std::abs(point.y - far.y) <= near &&
         std::abs(std::hypot(point.x, point.z) - radius) <= near;
}

}  // namespace

Real TouchedPlace::rate_around(Quat rotation, Vec3 spin, Vec3 normal) const {
  PANTIN_ASSERT(is_unit(axis) && is_unit(normal));
  const Vec3 about = rotation * axis, lean = about - glm::dot(about, normal) * normal;
  return glm::dot(normal, glm::cross(lean, glm::cross(spin, about))) /
         std::max(glm::dot(lean, lean), kLeastLean);
}

bool TouchedPlace::lies_on(const TouchedPlace& rim) const {
  PANTIN_ASSERT(rim.circle > 0 && is_unit(rim.axis));
  const Vec3 from = core - rim.core;
  const Real along = glm::dot(from, rim.axis);
  return circle == 0 &&
         std::abs(along) + std::abs(glm::length(from) - rim.circle) < kOnCircle * rim.circle;
}

Real rounding_of(const Shape& s, const Rolling& at) {
  const ShapeTraits& kind = traits_of(s.kind);
  if (kind.rounding) return kind.rounding(s, at);
  const std::optional<RoundedBox> core = kind.rounded ? kind.rounded(s) : std::nullopt;
  return core ? core->radius : 0;
}

TouchedPlace touched_place(const World& world, const Contact& c, const BodyOfContact& at) {
  const bool is_a = at.side == BodyOfContact::Side::a;
  const std::uint32_t slot = is_a ? c.slot_a : c.slot_b;
  const Vec3 point = is_a ? c.point_a : c.point_b, normal = is_a ? -c.normal : c.normal;
  PANTIN_ASSERT(slot < world.bodies.size() && is_unit(normal));
  const Vec3 outward = glm::conjugate(at.rotation) * normal;
  const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot]);
  const std::uint32_t index = is_a ? shape_of_a(c.key) : shape_of_b(c.key);
  if (!shapes || index >= shapes->list.size()) return {point};
  const Shape& s = shapes->list[index];
  const bool by_core = is_a && is_core(c.key);
  if (!by_core && traits_of(s.kind).is_turned) {
    const Vec3 axis = s.local.rotation * Vec3(0, 1, 0), from = point - s.local.position;
    const Vec3 middle = glm::dot(from, axis) * axis, out = from - middle;
    const Vec3 lean = outward - glm::dot(outward, axis) * axis;
    const Real circle = glm::length(out), length = glm::length(lean);
    // The farthest point along the normal travels around the rim; others are fixed to the body.
    const Quat back = glm::conjugate(s.local.rotation);
    const Real beside = glm::dot(out, lean), whole = circle * length;
    if (length > kUpright &&
        (beside > (1 - kOffFarthest) * whole ||
         (beside > kBeside * whole && is_on_rim(s, back * from, back * outward))))
      return {s.local.position + middle, axis, circle, 0};
    return {point};
  }
  const Quat turn = glm::conjugate(at.rotation * s.local.rotation);
  const Vec3 spin = world.bodies.values()[slot].angular_velocity;
  // Rounded: at that distance from a body point along the normal, while the body rotates.
  const Real radius = by_core
                          ? inner_radius(s)
                          : rounding_of(s, {to_local(s.local, point), turn * normal, turn * spin});
  return {point - radius * outward, Vec3(0), 0, radius};
}

}  // namespace pantin::detail::contact
