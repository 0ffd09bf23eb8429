// Rotations of joints, and clearances of their limits.
#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"
#include "engine/joints/stops.hpp"
#include "engine/solvers/articulated/internal.hpp"

namespace pantin::detail::articulated {
namespace {

/// A joint at given rotations of its bodies.
struct At {
  const PackedJoint& packed;
  Quat a, b;      // joint axes of both bodies, world
  Quat rotation;  // of b relative to a

  At(const PackedJoint& j, Quat own, Quat parent)
      : packed(j),
        a((j.own_is_a ? own : parent) * j.joint.frames.a()),
        b((j.own_is_a ? parent : own) * j.joint.frames.b()),
        rotation(glm::conjugate(a) * b) {}

  /// Rotation of the own body for the relative rotation `q`, with the parent fixed.
  Quat own_at(Quat q) const {
    return packed.own_is_a ? b * glm::conjugate(q) * glm::conjugate(packed.joint.frames.a())
                           : a * q * glm::conjugate(packed.joint.frames.b());
  }
};

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

bool is_far_from_limits(const PackedJoint& joint, Quat own, Quat parent, Real margin) {
  return detail::is_far_from_limits(joint.joint, joint_rotation(joint, own, parent), margin);
}

/// The limits of a joint, with gradients for the rotation of the own body relative to the parent. A
/// lock is one limit that acts in both directions.
void find_limits(const PackedJoint& joint, Quat own, Quat parent, JointLimit (&out)[4]) {
  const BodyState on_own{.rotation = own, .rotation_matrix = glm::mat3_cast(own)},
      on_parent{.rotation = parent, .rotation_matrix = glm::mat3_cast(parent)};
  const Real sign = joint.own_is_a ? -1 : 1;
  JointStop excess[4];
  find_stops(
      {joint.joint, joint.own_is_a ? on_own : on_parent, joint.own_is_a ? on_parent : on_own},
      excess);
  for (int s = 0; s < 4; ++s) {
    out[s] = {};
    if (!excess[s].is_watched) continue;
    const bool with_next = s % 2 == 0 && excess[s + 1].is_watched;
    if (with_next && excess[s].beyond + excess[s + 1].beyond > -1e-12) continue;
    const JointLimits& limits = joint.joint.limits;
    const bool both = s % 2 == 1 && (s == 1 ? limits.angle : limits.second).on &&
                      excess[s - 1].is_watched && excess[s - 1].beyond + excess[s].beyond > -1e-12;
    out[s] = {sign * excess[s].along, -excess[s].beyond, true, both};
  }
}

}  // namespace pantin::detail::articulated
