#include "engine/render/supports.hpp"

#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::detail {
namespace {

constexpr Real kHeight = 0.45;   // of a cone, relative to the reach of its body
constexpr Real kRotor = 0.2;     // of the reach: nearer to the mass centre the body hides a symbol
constexpr Real kHanging = -0.4;  // sine of the elevation below which a body hangs
constexpr Real kRail = 0.12;     // half the width of a rail, relative to that of the slider

bool has_shapes(const World& world, Entity body) {
  const Shapes* shapes = world.shapes.find(body);
  return shapes && !shapes->list.empty();
}

/// A joint to the world: the frame of the world's side, and the body on the other.
struct Mounting {
  const Joint& joint;
  Vec3 at;    // the anchor in the world
  Quat axes;  // of the joint, world, on the world's side
  Entity body;
  Pose pose;       // of the body
  Quat body_axes;  // of the joint, in the body
  Vec3 anchor;     // in the body

  /// From the anchor to the body's mass centre where all coordinates are zero.
  Vec3 arm_at_start() const { return axes * glm::conjugate(body_axes) * -anchor; }
};

/// Extent of a body's shapes along a direction, from `middle`: least and most, m.
std::pair<Real, Real> extent(const PosedWorld& scene, const Mounting& m, Vec3 way, Vec3 middle) {
  std::vector<Ball> balls;
  if (const Shapes* shapes = scene.world.shapes.find(m.body))
    for (const Shape& shape : shapes->list) add_balls(shape, m.pose, balls);
  Real low = 0, high = 0;
  for (const Ball& b : balls) {
    const Real along = glm::dot(b.centre - middle, way);
    low = std::min(low, along - b.radius), high = std::max(high, along + b.radius);
  }
  return {low, high};
}

void add_pivot(const PosedWorld& scene, const Mounting& m, std::vector<SupportPart>& to) {
  const Vec3 arm = m.arm_at_start(), up = -down_of(scene.world);
  const Real length = glm::length(arm);
  Real reach = drawn_reach(scene.world, m.body);
  if (!std::isfinite(reach)) reach = length;
  if (!(reach > 0) || !std::isfinite(reach)) return;
  const bool hangs = length > 0 && glm::dot(arm, up) < kHanging * length;
  if (length < kRotor * reach) return;
  const Real half = 0.5 * kHeight * reach;
  const Vec3 tip = hangs ? -up : up;  // from the plate to the anchor
  const Quat turn = upright(tip);
  SupportPart cone, plate;
  cone.shape.kind = ShapeKind::cone, cone.shape.size = {0.6 * half, half, 0};
  cone.pose = {m.at - half * tip, turn};
  plate.shape.kind = ShapeKind::box;
  plate.shape.size = {1.3 * half, 0.12 * half, 1.3 * half};
  plate.pose = {m.at - 2.12 * half * tip, turn};
  to.push_back(cone), to.push_back(plate);
}

/// Two rails beside the slider, as long as its travel or three times its length.
void add_rails(const PosedWorld& scene, const Mounting& m, std::vector<SupportPart>& to) {
  const Vec3 along = m.axes * Vec3(1, 0, 0), up = -down_of(scene.world);
  Vec3 side = up - glm::dot(up, along) * along;
  if (glm::length(side) < 0.3) side = m.axes * Vec3(0, 1, 0);
  side = glm::normalize(side);
  const Vec3 now = to_world(m.pose, m.anchor);
  const auto [back, front] = extent(scene, m, along, now);
  const auto [under, over] = extent(scene, m, side, m.at);
  const Real size = front - back, travel = glm::dot(now - m.at, along);
  if (!(size > 0) || !is_finite(m.at)) return;
  Real low = std::min(-1.5 * size, travel + 1.2 * back),
       high = std::max(1.5 * size, travel + 1.2 * front);
  if (const AngleLimit& limit = m.joint.parameters->travel; limit.on)
    low = limit.low + back, high = limit.high + front;
  if (!std::isfinite(low) || !std::isfinite(high)) return;
  const Real half = kRail * 0.5 * std::min(size, over - under);
  const Quat turn = glm::quat_cast(Mat3(along, side, glm::cross(along, side)));
  for (const Real offset : {under - half, over + half}) {
    SupportPart rail;
    rail.shape.kind = ShapeKind::box;
    rail.shape.size = {0.5 * (high - low), half, 2 * half};
    rail.pose = {m.at + 0.5 * (low + high) * along + offset * side, turn};
    to.push_back(rail);
  }
}

void add_disc(const Mounting& m, std::vector<SupportPart>& to) {
  const Real radius = m.joint.parameters->length;
  SupportPart disc;
  disc.shape.kind = ShapeKind::cylinder, disc.shape.size = {radius, 0.06 * radius, 0};
  disc.pose = {to_world(m.pose, m.anchor),
               upright(m.pose.rotation * (m.body_axes * Vec3(1, 0, 0)))};
  to.push_back(disc);
}

/// Whether a shape of a fixed body is where the symbol would be.
bool is_drawn_already(const World& world, Vec3 at) {
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    const std::uint32_t slot = world.bodies.slot(world.shapes.owners()[i]);
    if (slot == kNoSlot || world.bodies.values()[slot].motion != Motion::fixed) continue;
    for (const Shape& shape : world.shapes.values()[i].list) {
      if (is_ground(shape.kind) || !is_complete(shape)) continue;
      const Aabb bounds = bounds_of(shape, world.bodies.values()[slot].pose);
      const Vec3 margin = 0.1 * (bounds.high - bounds.low);
      if (glm::all(glm::greaterThan(at, bounds.low - margin)) &&
          glm::all(glm::lessThan(at, bounds.high + margin)))
        return true;
    }
  }
  return false;
}

/// The joint of a link to the world, if one of its bodies is part of the world.
std::optional<Mounting> mounting_of(const PosedWorld& scene, const Link& link) {
  const World& world = scene.world;
  const std::uint32_t a = world.bodies.slot(link.a), b = world.bodies.slot(link.b);
  if (a == kNoSlot || b == kNoSlot) return std::nullopt;
  const auto is_frame = [&](std::uint32_t slot, Entity body) {
    return world.bodies.values()[slot].motion == Motion::fixed && !has_shapes(world, body);
  };
  const bool from_a = is_frame(a, link.a);
  if (from_a == is_frame(b, link.b)) return std::nullopt;
  const Joint& j = link.joint;
  const Pose &frame = scene.pose_of(from_a ? a : b), &body = scene.pose_of(from_a ? b : a);
  if (!is_finite(frame) || !is_finite(body)) return std::nullopt;
  const Quat frame_axes = from_a ? j.frames.a() : j.frames.b();
  return Mounting{j,
                  to_world(frame, from_a ? j.anchor_a : j.anchor_b),
                  frame.rotation * frame_axes,
                  from_a ? link.b : link.a,
                  body,
                  from_a ? j.frames.b() : j.frames.a(),
                  from_a ? j.anchor_b : j.anchor_a};
}

}  // namespace

Quat upright(Vec3 y) {
  const Vec3 aside = std::abs(y.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 0, 1);
  const Vec3 z = glm::normalize(glm::cross(aside, y));
  return glm::quat_cast(Mat3(glm::cross(y, z), y, z));
}

void add_supports(const PosedWorld& scene, std::vector<SupportPart>& to) {
  for (const Link& link : scene.world.links.values()) {
    const JointKindInfo& kind = info_of(link.joint.kind);
    const bool slides = std::ranges::find(kind.marks, Mark::translation) != kind.marks.end();
    const bool is_wheel = link.joint.kind == JointKind::wheel;
    if (!kind.holds_point && !slides && !is_wheel) continue;
    const auto mounting = mounting_of(scene, link);
    if (!mounting) continue;
    if (is_drawn_already(scene.world, mounting->at)) continue;
    if (is_wheel) {
      if (!has_shapes(scene.world, mounting->body)) add_disc(*mounting, to);
    } else if (slides) {
      add_rails(scene, *mounting, to);
    } else {
      add_pivot(scene, *mounting, to);
    }
  }
}

}  // namespace pantin::detail
