#include "engine/render/springs.hpp"

#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/render/supports.hpp"

namespace pantin::detail {
namespace {

constexpr int kTurns = 8;
constexpr Real kEnds = 0.1;       // of the length: straight at each end
constexpr Real kRadius = 0.07;    // of the coil, relative to the rest length
constexpr Real kLeastRest = 0.3;  // of the present length, for springs that rest at no length
constexpr Real kWire = 0.24;      // relative to the radius of the coil
constexpr Real kSeat = 1.5;       // length at rest, relative to the way from rest to the low limit
constexpr Real kBehind = 2;       // likewise, relative to the reach of the body, without limits
constexpr Real kPressed = 0.1;    // of the length at rest: a shorter coil is not drawn

std::optional<Coil> coil_between(Vec3 a, Vec3 b, Real rest) {
  const Real now = glm::distance(a, b);
  rest = std::max(rest, kLeastRest * now);
  if (!(now > 1e-9) || !std::isfinite(rest)) return std::nullopt;
  return Coil{a, b, kRadius * rest, kWire * kRadius * rest};
}

/// The length of a travel's spring at rest, from its seat to body b, m; 0: unknown.
Real length_at_rest(const PosedWorld& scene, const Link& link) {
  const AngleLimit& range = link.joint.parameters->travel;
  const Real rest = link.joint.parameters->translation.spring.rest;
  if (range.on && std::isfinite(range.low)) return kSeat * (rest - range.low);
  const Real reach = drawn_reach(scene.world, link.b);
  return std::isfinite(reach) ? kBehind * reach : 0;
}

std::optional<Coil> travel_coil(const PosedWorld& scene, const Link& link) {
  const SpringDamper& spring = link.joint.parameters->translation.spring;
  const JointKindInfo& kind = info_of(link.joint.kind);
  const std::uint32_t slot = scene.world.bodies.slot(link.a);
  if (!(spring.stiffness > 0) || kind.is_line || !kind.find(Coordinate::travel))
    return std::nullopt;
  const Real length = length_at_rest(scene, link);
  if (slot == kNoSlot || !(length > 0)) return std::nullopt;
  const Pose& a = scene.pose_of(slot);
  const auto seat_of = scene.position_of(link.a, link.joint.anchor_a),
             b = scene.position_of(link.b, link.joint.anchor_b);
  if (!seat_of || !b) return std::nullopt;
  const Vec3 along = a.rotation * (link.joint.frames.a() * Vec3(1, 0, 0));
  const Vec3 seat = *seat_of + (spring.rest - length) * along;
  if (!(glm::dot(*b - seat, along) > kPressed * length)) return std::nullopt;
  return coil_between(seat, *b, length);
}

}  // namespace

std::optional<Coil> coil_of(const PosedWorld& scene, const Link& link) {
  if (!link.joint.parameters.any()) return std::nullopt;
  if (link.joint.kind != JointKind::spring) return travel_coil(scene, link);
  const auto a = scene.position_of(link.a, link.joint.anchor_a);
  const auto b = scene.position_of(link.b, link.joint.anchor_b);
  if (!a || !b) return std::nullopt;
  return coil_between(*a, *b, link.joint.parameters->length);
}

std::optional<Coil> coil_of(const PosedWorld& scene, const Pin& pin) {
  if (pin.kind != PinKind::spring || !(pin.stiffness > 0)) return std::nullopt;
  const auto from = pin.to ? scene.position_of(pin.to, pin.target) : std::optional(pin.target);
  const auto to = scene.position_of(pin.body, pin.anchor);
  if (!from || !to || !is_finite(*from)) return std::nullopt;
  return coil_between(*from, *to, 0);
}

std::vector<Vec3> wire_of(const Coil& coil, int around) {
  const Vec3 way = coil.b - coil.a;
  const Quat turn = upright(glm::normalize(way));
  std::vector<Vec3> points{coil.a};
  const int count = kTurns * around;
  for (int i = 0; i <= count; ++i) {
    const Real part = static_cast<Real>(i) / count, angle = 2 * kPi * kTurns * part;
    const Vec3 out = turn * Vec3(std::cos(angle), 0, std::sin(angle));
    points.push_back(coil.a + (kEnds + (1 - 2 * kEnds) * part) * way + coil.radius * out);
  }
  points.push_back(coil.b);
  return points;
}

}  // namespace pantin::detail
