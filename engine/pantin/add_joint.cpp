#include <pantin/joints.hpp>

#include "engine/joints/kinds.hpp"
#include "engine/pantin/detail/joint_frames.hpp"

namespace pantin {

using namespace detail;

namespace {

Dof freedom_of(Findings& findings, const JointMotor& motor, const SpringDamper& spring,
               const JointFriction& friction) {
  check(findings, motor), check(findings, spring), check(findings, friction);
  return {spring, friction, motor};
}

/// Optional properties that few joints have.
struct Extras {
  Dof rotation = {}, translation = {};
  AngleLimit travel = {};
  Real restitution = 0;
};

/// Sets only values that differ from the default, since most joints have no parameters.
void equip(Joint& joint, const Extras& extras) {
  if (extras.rotation.any()) joint.parameters.edit().rotation = extras.rotation;
  if (extras.translation.any()) joint.parameters.edit().translation = extras.translation;
  if (extras.travel.on) joint.parameters.edit().travel = extras.travel;
  if (extras.restitution != 0) joint.parameters.edit().restitution = extras.restitution;
}

/// Frames of a joint with one axis.
template <class T>
WorldFrames frames_of(Findings& findings, const T& joint, const char* member, Vec3 axis) {
  findings.bodies(joint.a, joint.b);
  if (joint.frames) return from_local(findings, {joint.a, joint.b}, *joint.frames);
  return at_place(findings, joint.anchor, axes_along(findings, member, axis, Vec3(0)));
}

}  // namespace

Result<Entity> add_to(World& world, const BallJoint& described) {
  Findings findings(world, "BallJoint", described.name);
  findings.bodies(described.a, described.b);
  WorldFrames at;
  if (described.frames) {
    at = from_local(findings, {described.a, described.b}, *described.frames);
  } else {
    const Quat axes = axes_along(findings, "axis", described.axis, described.across);
    at = at_place(findings, described.anchor, axes);
    if (described.cone_axis)
      at.a.rotation = axes_along(findings, "cone_axis", *described.cone_axis, described.across);
  }
  JointLimits limits;
  limits.angle = limit_of(findings, "twist", described.twist);
  if (described.cone) limits.swing = swing_of(findings, *described.cone);
  soften(findings, described.soft_stop, limits);
  check(findings, described.drive);
  if (!findings.ok()) return findings.take();
  Joint joint = make_joint(world, JointKind::ball, {described.a, described.b}, at);
  joint.limits = limits;
  return link(world, findings, described, joint);
}

Result<Entity> add_to(World& world, const HingeJoint& described) {
  Findings findings(world, "HingeJoint", described.name);
  const WorldFrames at = frames_of(findings, described, "axis", described.axis);
  JointLimits limits;
  limits.angle = limit_of(findings, "limits", described.limits);
  soften(findings, described.soft_stop, limits);
  const Dof rotation = freedom_of(findings, described.motor, described.spring, described.friction);
  findings.within("restitution", described.restitution, 0, 1);
  check(findings, described.drive);
  if (!findings.ok()) return findings.take();
  Joint joint = make_joint(world, JointKind::hinge, {described.a, described.b}, at);
  joint.limits = limits;
  equip(joint, {.rotation = rotation, .restitution = described.restitution});
  return link(world, findings, described, joint);
}

Result<Entity> add_to(World& world, const FixedJoint& described) {
  Findings findings(world, "FixedJoint", described.name);
  findings.bodies(described.a, described.b);
  const WorldFrames at = described.frames
                             ? from_local(findings, {described.a, described.b}, *described.frames)
                             : at_place(findings, described.anchor, kIdentity);
  if (!findings.ok()) return findings.take();
  return link(world, findings, described,
              make_joint(world, JointKind::fixed, {described.a, described.b}, at));
}

Result<Entity> add_to(World& world, const UniversalJoint& described) {
  Findings findings(world, "UniversalJoint", described.name);
  findings.bodies(described.a, described.b);
  WorldFrames at;
  if (described.frames) {
    at = from_local(findings, {described.a, described.b}, *described.frames);
  } else {
    const Vec3 y = findings.direction("axis_a", described.axis_a);
    const Vec3 z = findings.direction("axis_b", described.axis_b);
    if (std::abs(glm::dot(y, z)) > 1e-6)
      findings.add("axis_b", shown(described.axis_b), "a direction perpendicular to axis_a");
    const Vec3 x = findings.ok() ? glm::normalize(glm::cross(y, z)) : Vec3(1, 0, 0);
    at = at_place(findings, described.anchor, findings.ok() ? axes_of(x, y) : kIdentity);
  }
  JointLimits limits;
  limits.angle = limit_of(findings, "limits", described.limits);
  limits.second = limit_of(findings, "second_limits", described.second_limits);
  soften(findings, described.soft_stop, limits);
  check(findings, described.drive);
  if (!findings.ok()) return findings.take();
  Joint joint = make_joint(world, JointKind::universal, {described.a, described.b}, at);
  joint.limits = limits;
  return link(world, findings, described, joint);
}

Result<Entity> add_to(World& world, const PrismaticJoint& described) {
  Findings findings(world, "PrismaticJoint", described.name);
  const WorldFrames at = frames_of(findings, described, "axis", described.axis);
  const AngleLimit travel = limit_of(findings, "travel", described.travel);
  const Dof translation =
      freedom_of(findings, described.motor, described.spring, described.friction);
  findings.within("restitution", described.restitution, 0, 1);
  check(findings, described.drive);
  if (!findings.ok()) return findings.take();
  Joint joint = make_joint(world, JointKind::prismatic, {described.a, described.b}, at);
  equip(joint,
        {.translation = translation, .travel = travel, .restitution = described.restitution});
  return link(world, findings, described, joint);
}

Result<Entity> add_to(World& world, const CylindricalJoint& described) {
  Findings findings(world, "CylindricalJoint", described.name);
  const WorldFrames at = frames_of(findings, described, "axis", described.axis);
  JointLimits limits;
  limits.angle = limit_of(findings, "limits", described.limits);
  const AngleLimit travel = limit_of(findings, "travel", described.travel);
  const Dof rotation = freedom_of(findings, described.motor, described.spring, described.friction);
  const Dof translation = freedom_of(findings, described.travel_motor, described.travel_spring,
                                     described.travel_friction);
  findings.within("restitution", described.restitution, 0, 1);
  check(findings, described.drive);
  if (!findings.ok()) return findings.take();
  Joint joint = make_joint(world, JointKind::cylindrical, {described.a, described.b}, at);
  joint.limits = limits;
  equip(joint, {rotation, translation, travel, described.restitution});
  return link(world, findings, described, joint);
}

Result<Entity> add_to(World& world, const ScrewJoint& described) {
  Findings findings(world, "ScrewJoint", described.name);
  const WorldFrames at = frames_of(findings, described, "axis", described.axis);
  if (described.pitch == 0 || !std::isfinite(described.pitch))
    findings.add("pitch", shown(described.pitch), "metres per radian, not 0");
  JointLimits limits;
  limits.angle = limit_of(findings, "limits", described.limits);
  const AngleLimit travel = limit_of(findings, "travel", described.travel);
  const Dof rotation = freedom_of(findings, described.motor, described.spring, described.friction);
  findings.within("restitution", described.restitution, 0, 1);
  check(findings, described.drive);
  if (!findings.ok()) return findings.take();
  Joint joint = make_joint(world, JointKind::screw, {described.a, described.b}, at);
  joint.limits = limits;
  equip(joint, {.rotation = rotation, .travel = travel, .restitution = described.restitution});
  joint.parameters.edit().pitch = described.pitch;
  return link(world, findings, described, joint);
}

Result<Entity> add_to(World& world, const PlanarJoint& described) {
  Findings findings(world, "PlanarJoint", described.name);
  const WorldFrames at = frames_of(findings, described, "normal", described.normal);
  if (!findings.ok()) return findings.take();
  return link(world, findings, described,
              make_joint(world, JointKind::planar, {described.a, described.b}, at));
}

namespace {

/// Checks grip and friction of a blade or a wheel.
void check_slip(Findings& findings, Real grip, Real friction) {
  findings.not_negative("grip", grip), findings.not_negative("friction", friction);
  if (grip > 0 && friction > 0)
    findings.add("friction", shown(friction), "either a grip or a coefficient of friction");
}

}  // namespace

Result<Entity> add_to(World& world, const SkateJoint& described) {
  Findings findings(world, "SkateJoint", described.name);
  const WorldFrames at = frames_of(findings, described, "across", described.across);
  check_slip(findings, described.grip, described.friction);
  if (!findings.ok()) return findings.take();
  Joint joint = make_joint(world, JointKind::skate, {described.a, described.b}, at);
  if (described.grip > 0) joint.parameters.edit().grip = described.grip;
  if (described.friction > 0) joint.parameters.edit().friction = described.friction;
  return link(world, findings, described, joint);
}

Result<Entity> add_to(World& world, const WheelJoint& described) {
  Findings findings(world, "WheelJoint", described.name);
  WorldFrames at = frames_of(findings, described, "axle", described.axle);
  if (!described.frames) {
    const Vec3 normal = findings.direction("normal", described.normal);
    const Vec3 along = glm::cross(normal, findings.direction("axle", described.axle));
    if (findings.ok() && !(glm::length(along) > 1e-6))
      findings.add("axle", shown(described.axle), "a direction other than that of normal");
    if (findings.ok()) at.a.rotation = axes_of(glm::normalize(glm::cross(along, normal)), normal);
  }
  findings.above_zero("radius", described.radius);
  check_slip(findings, described.grip, described.friction);
  if (!findings.ok()) return findings.take();
  Joint joint = make_joint(world, JointKind::wheel, {described.a, described.b}, at);
  joint.parameters.edit().length = described.radius;
  joint.parameters.edit().grip = described.grip;
  joint.parameters.edit().friction = described.friction;
  return link(world, findings, described, joint);
}

}  // namespace pantin
