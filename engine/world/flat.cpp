#include "engine/world/flat.hpp"

#include "engine/base/rotation.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::detail {
namespace {

// Accepts the rounding of files with six digits and of a few successive rotations.
constexpr Real kAlong = 1e-6;

bool is_along_z(Vec3 axis) { return std::hypot(axis.x, axis.y) < kAlong; }
bool is_level(Vec3 axis) { return std::abs(axis.z) < kAlong; }

Vec3 axis_of(const Joint& joint, const Pose& a) {
  return a.rotation * (joint.frames.a() * Vec3(1, 0, 0));
}

/// Whether some rotation about z carries the joint's axes on a to those on b.
bool keeps_z(const Joint& joint, const Pose& a, const Pose& b) {
  const Quat turn = b.rotation * joint.frames.b() * glm::conjugate(a.rotation * joint.frames.a());
  return std::hypot(turn.x, turn.y) < kAlong;
}

/// Sample times of a path, s: its keys and between them, or many.
std::vector<Real> times_of(const KinematicPath& path) {
  constexpr int kBetween = 4, kMany = 256;
  constexpr Real kApart = 0.0371;  // s: no simple ratio to common frequencies
  std::vector<Real> times;
  if (const Keyframes* k = std::get_if<Keyframes>(&path.curve)) {
    for (std::size_t i = 0; i + 1 < k->keys.size(); ++i)
      for (int part = 0; part < kBetween; ++part)
        times.push_back(glm::mix(k->keys[i].time, k->keys[i + 1].time, Real(part) / kBetween));
    if (!k->keys.empty()) times.push_back(k->keys.back().time);
    return times;
  }
  for (int i = 0; i < kMany; ++i) times.push_back(kApart * i);
  return times;
}

/// How far the anchors of a joint may leave the plane, m.
Real height_tolerance(const Joint& joint) {
  return 1e-4 * (1e-3 + glm::length(joint.anchor_a) + glm::length(joint.anchor_b));
}

}  // namespace

bool has_planar_solver() {
#ifdef PANTIN_HAS_BOX2D
  return true;
#else
  return false;
#endif
}

std::string flat_fault(const Body& body) {
  if (std::abs(body.velocity.z) > kAlong * (1 + glm::length(body.velocity)))
    return "moves along z, out of the xy plane";
  const Vec3 spin = body.angular_velocity;
  if (std::hypot(spin.x, spin.y) > kAlong * (1 + glm::length(spin)))
    return "rotates about an axis other than z, out of the xy plane";
  const Mat3 inertia = world_inertia(body.pose.rotation, body.inertia);
  const Real largest = glm::max(body.inertia.x, glm::max(body.inertia.y, body.inertia.z));
  if (std::hypot(inertia[2].x, inertia[2].y) > 1e-4 * largest)
    return "has no principal axis along z: rotating, it would tilt out of the xy plane";
  return {};
}

std::string flat_fault(Vec3 gravity) {
  return std::abs(gravity.z) > kAlong * glm::length(gravity) ? "falls along z, out of the xy plane"
                                                             : "";
}

FlatJoint flat_kind(const Joint& joint, const Pose& a) {
  switch (joint.kind) {
    case JointKind::ball:
    case JointKind::hinge:
      return FlatJoint::hinge;
    case JointKind::cylindrical:
      return is_along_z(axis_of(joint, a)) ? FlatJoint::hinge : FlatJoint::slider;
    case JointKind::fixed:
      return FlatJoint::weld;
    case JointKind::prismatic:
      return FlatJoint::slider;
    case JointKind::distance:
      return FlatJoint::rod;
    case JointKind::spring:
      return FlatJoint::spring;
    default:  // planar has no constraint for it; flat_fault refuses other kinds
      return FlatJoint::none;
  }
}

std::string flat_fault(const Joint& joint, const Pose& a, const Pose& b) {
  const Vec3 axis = axis_of(joint, a);
  const std::string kind = name_of(joint.kind);
  switch (joint.kind) {
    case JointKind::hinge:
    case JointKind::planar:
      if (!is_along_z(axis))
        return "has an axis other than z, unlike a " + kind + " in the xy plane";
      break;
    case JointKind::prismatic:
      if (!is_level(axis)) return "has an axis that leaves the xy plane";
      break;
    case JointKind::cylindrical:
      if (!is_level(axis) && !is_along_z(axis))
        return "has an axis that is neither z nor in the xy plane";
      break;
    case JointKind::ball:
      if (joint.limits.any())
        return "is a ball joint with limits: \"planar\" needs a hinge along z for them";
      break;
    case JointKind::fixed:
    case JointKind::distance:
    case JointKind::spring:
      break;
    default:  // also a new kind, until flat_kind says what it is in a plane
      return "is of a kind that has no planar form";
  }
  const bool is_line = joint.kind == JointKind::distance || joint.kind == JointKind::spring;
  if (!is_line && joint.kind != JointKind::ball && !keeps_z(joint, a, b))
    return "has axes on its two bodies that no rotation about z aligns";
  const Vec3 gap = residual(joint, a, b);
  if (joint.kind != JointKind::planar && std::abs(gap.z) > height_tolerance(joint))
    return "has anchors at two heights z, which no motion in the plane closes";
  return {};
}

std::string flat_fault(const Joint& joint, const KinematicPath& path, Vec3 anchor) {
  const bool turns_freely = joint.kind == JointKind::ball || joint.kind == JointKind::distance ||
                            joint.kind == JointKind::spring;
  const Pose first = pose_at(path, 0);
  for (const Real time : times_of(path)) {
    const Pose at = pose_at(path, time);
    const Quat turn = at.rotation * glm::conjugate(first.rotation);
    const bool tilts = !turns_freely && std::hypot(turn.x, turn.y) > kAlong;
    const Real rise = std::abs((to_world(at, anchor) - to_world(first, anchor)).z);
    if (tilts || rise > height_tolerance(joint))
      return "is moved out of the xy plane by the path of one of its bodies";
  }
  return {};
}

std::string flat_drive_fault(const Joint& joint, const DriveMotion& motion, const Pose& a) {
  const bool travels = motion.travels;
  const FlatJoint moves = travels ? FlatJoint::slider : FlatJoint::hinge;
  if (flat_kind(joint, a) == moves) return {};
  return travels ? "is driven along its travel, which lies out of the xy plane"
                 : "is driven about its axis, which lies in the xy plane";
}

std::string flat_fault(const SurfaceContact& c, const Pose& a, const Pose& b) {
  for (const auto& [pose, side] :
       {std::pair{compose(a, c.on_a.pose), "a"}, {compose(b, c.on_b.pose), "b"}}) {
    const Quat q = pose.rotation;
    if (std::hypot(q.x, q.y) > kAlong)
      return std::string("has a curve of \"") + side +
             "\" that does not lie in the xy plane, facing +z";
  }
  return {};
}

bool has_section(const Shape& shape, Quat rotation) {
  const Quat at = rotation * shape.local.rotation;
  const Vec3 axis = at * Vec3(0, 1, 0);
  switch (shape.kind) {
    case ShapeKind::sphere:
    case ShapeKind::box:
    case ShapeKind::hull:
      return true;
    case ShapeKind::plane:
      return is_level(axis);
    case ShapeKind::capsule:
    case ShapeKind::cylinder:
    case ShapeKind::cone:
      return is_level(axis) || is_along_z(axis);
    default:  // also a new kind: a body with it is refused
      return false;
  }
}

}  // namespace pantin::detail
