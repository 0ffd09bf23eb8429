// Rotations of joints, and how far they are from their limits.
#include <algorithm>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/joints/stops.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

const Vec3 kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);

/// Smallest half angle of a cone that is locked in one direction.
constexpr Real kMinConeAngle = 1e-6;  // rad

/// A joint at given rotations of its bodies.
struct At {
  const PackedJoint& packed;
  Quat a, b;      // joint axes of both bodies, world
  Quat rotation;  // of b's in a's

  At(const PackedJoint& j, Quat own, Quat parent)
      : packed(j),
        a((j.own_is_a ? own : parent) * j.joint.frames.a()),
        b((j.own_is_a ? parent : own) * j.joint.frames.b()),
        rotation(glm::conjugate(a) * b) {}

  /// 1 if the own body is the joint's body b, else -1.
  Real sign() const { return packed.own_is_a ? -1 : 1; }

  /// Rotation of the own body for the relative rotation `q`, with the parent fixed.
  Quat own_at(Quat q) const {
    return packed.own_is_a ? b * glm::conjugate(q) * glm::conjugate(packed.joint.frames.a())
                           : a * q * glm::conjugate(packed.joint.frames.b());
  }
};

void watch(const AngleLimit& limit, Real angle, Vec3 along, JointStop* out) {
  if (limit.on) find_sides(limit, angle, along, out);
}

void find_cone_side(const SwingLimit& limit, const At& at, Vec3 swing, JointStop* out) {
  if (!limit.on) return;
  const Real y = std::max(limit.y, kMinConeAngle), z = std::max(limit.z, kMinConeAngle);
  const Real angle = glm::length(swing), m = std::hypot(swing.y / y, swing.z / z);
  if (!(m > 1e-9) || !(angle > 1e-12)) {  // at the centre of the cone
    *out = {-std::min(y, z), Vec3(0), false};
    return;
  }
  // d(swing) = (w.e) e + (angle / sin angle) (w.(x_b x e)) (x_a x e) for a relative angular
  // velocity w.
  const Vec3 local = swing / angle, e = at.a * local;
  const Vec3 slope = at.a * Vec3(0, swing.y / (y * y * m), swing.z / (z * z * m));
  const Vec3 xa = at.a * kX, xb = at.b * kX;
  const Real ratio = std::sin(angle) > 1e-6 ? angle / std::sin(angle) : 1e6;
  const Vec3 grow =
      glm::dot(slope, e) * e + ratio * glm::dot(slope, glm::cross(xa, e)) * glm::cross(xb, e);
  const Real size = glm::length(grow);
  *out = {(m - 1) / size, grow / size, true};
}

/// The limits of a joint: angle low and high, second angle low and high (or one for swing).
void measure_stops(const At& at, JointStop (&out)[4]) {
  const Joint& joint = at.packed.joint;
  const JointLimits& limits = joint.limits;
  switch (turns_of(joint.kind)) {
    case Turns::about_x:
      watch(limits.angle, swing_twist(at.rotation).twist, at.a * kX, &out[0]);
      return;
    case Turns::about_two: {
      const UniversalAngles angles = universal_angles(at.rotation);
      watch(limits.angle, angles.first, at.a * kY, &out[0]);
      watch(limits.second, angles.second, at.b * kZ, &out[2]);
      return;
    }
    case Turns::freely:
      break;
    case Turns::nowhere:
    case Turns::own:  // does not come here
      return;
  }
  if (!limits.any()) return;
  const SwingTwist parts = swing_twist(at.rotation);
  const Vec3 xa = at.a * kX, xb = at.b * kX;
  const Real c = 1 + glm::dot(xa, xb);
  if (c > 1e-6) watch(limits.angle, parts.twist, (xa + xb) / c, &out[0]);
  find_cone_side(limits.swing, at, parts.swing, &out[2]);
}

/// The limits of a joint, with gradients for the rotation of the own body relative to the parent. A
/// lock is one limit that acts in both directions.
void find_limits(const At& at, JointLimit (&out)[4]) {
  JointStop excess[4];
  measure_stops(at, excess);
  for (int s = 0; s < 4; ++s) {
    out[s] = {};
    if (!excess[s].is_watched) continue;
    const bool with_next = s % 2 == 0 && excess[s + 1].is_watched;
    if (with_next && excess[s].beyond + excess[s + 1].beyond > -1e-12) continue;
    const JointLimits& limits = at.packed.joint.limits;
    const bool both = s % 2 == 1 && (s == 1 ? limits.angle : limits.second).on &&
                      excess[s - 1].is_watched && excess[s - 1].beyond + excess[s].beyond > -1e-12;
    out[s] = {at.sign() * excess[s].along, -excess[s].beyond, true, both};
  }
}

}  // namespace

std::uint32_t held_body_of(const Island& a, std::size_t c) {
  for (const Tree& t : a.trees)
    if (t.first == c) return t.held_body;
  return UINT32_MAX;
}

Quat parent_rotation(const World& world, const Island& a, std::size_t c, Work rotation_row) {
  if (a.parents[c] >= 0)
    return a.scratch.work.quat(rotation_row, static_cast<std::size_t>(a.parents[c]));
  const std::uint32_t held = held_body_of(a, c);
  return held == UINT32_MAX ? kIdentity : world.bodies.values()[held].pose.rotation;
}

Quat own_rotation(const PackedJoint& joint, Quat parent, Quat rotation) {
  const At at(joint, kIdentity, parent);
  return glm::normalize(at.own_at(rotation));
}

Quat inboard_rotation(const PackedJoint& joint, Quat own, Quat rotation) {
  const At at(joint, own, kIdentity);
  return glm::normalize(joint.own_is_a ? at.a * rotation * glm::conjugate(joint.joint.frames.b())
                                       : at.b * glm::conjugate(rotation) *
                                             glm::conjugate(joint.joint.frames.a()));
}

Quat joint_rotation(const PackedJoint& joint, Quat own, Quat parent) {
  return At(joint, own, parent).rotation;
}

FreeAxes free_axes(const PackedJoint& joint, Quat own, Quat parent) {
  const At at(joint, own, parent);
  return detail::free_axes(joint.joint.kind, at.a, at.b);
}

void find_limits(const PackedJoint& joint, Quat own, Quat parent, JointLimit (&out)[4]) {
  find_limits(At(joint, own, parent), out);
}

}  // namespace pantin::detail::articulated
