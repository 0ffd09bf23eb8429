#include "engine/pantin/detail/joint_frames.hpp"

#include <string>

namespace pantin::detail {
namespace {

/// A direction perpendicular to a unit vector; a function of the vector alone.
Vec3 any_across(Vec3 x) {
  const Vec3 size = glm::abs(x);
  const Vec3 least = size.x <= size.y && size.x <= size.z ? Vec3(1, 0, 0)
                     : size.y <= size.z                   ? Vec3(0, 1, 0)
                                                          : Vec3(0, 0, 1);
  return glm::normalize(glm::cross(x, least));
}

}  // namespace

Quat axes_of(Vec3 x, Vec3 y) {
  return glm::normalize(glm::quat_cast(Mat3(x, y, glm::cross(x, y))));
}

Quat axes_along(Findings& findings, const char* member, Vec3 axis, Vec3 across) {
  const Vec3 x = findings.direction(member, axis);
  if (across == Vec3(0)) return axes_of(x, any_across(x));
  const Vec3 wish = findings.direction("across", across);
  const Vec3 y = wish - glm::dot(wish, x) * x;
  if (glm::length(y) > 1e-6) return axes_of(x, glm::normalize(y));
  findings.add("across", shown(across), std::string("a direction not parallel to ") + member);
  return kIdentity;
}

WorldFrames at_place(Findings& findings, Vec3 anchor, Quat axes) {
  findings.finite("anchor", anchor);
  return {{anchor, axes}, {anchor, axes}};
}

WorldFrames from_local(Findings& findings, const JointEnds& ends, const LocalFrames& local) {
  const auto side = [&](Entity body, const char* member, Pose frame) {
    findings.finite(member, frame.position);
    frame.rotation = findings.rotation(member, frame.rotation);
    return findings.ok() ? compose(findings.world().origin_pose(body), frame) : frame;
  };
  return {side(ends.a, "frames.in_a", local.in_a), side(ends.b, "frames.in_b", local.in_b)};
}

Joint make_joint(const World& world, JointKind kind, const JointEnds& ends, const WorldFrames& at) {
  const Pose &on_a = world.bodies[ends.a].pose, &on_b = world.bodies[ends.b].pose;
  Joint joint;
  joint.kind = kind;
  joint.anchor_a = to_local(on_a, at.a.position), joint.anchor_b = to_local(on_b, at.b.position);
  const Quat frame_a = glm::normalize(glm::conjugate(on_a.rotation) * at.a.rotation),
             frame_b = glm::normalize(glm::conjugate(on_b.rotation) * at.b.rotation);
  if (frame_a != kIdentity || frame_b != kIdentity) joint.frames.set(frame_a, frame_b);
  return joint;
}

}  // namespace pantin::detail
