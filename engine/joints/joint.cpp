#include "engine/joints/joint.hpp"

#include <cstring>

#include "engine/base/rotation.hpp"

namespace pantin {
namespace {

constexpr const char* kNames[kJointKinds] = {
    "ball",  "hinge",  "universal", "fixed",  "cylindrical", "prismatic",
    "screw", "planar", "distance",  "spring", "custom"};

Real twist_of(Quat q) { return swing_twist(q).twist; }
Quat hinged(Real angle) { return Quat(std::cos(angle / 2), std::sin(angle / 2), 0, 0); }

}  // namespace

const char* name_of(JointKind kind) { return kNames[static_cast<int>(kind)]; }

bool joint_kind_from_name(const char* name, JointKind& kind) {
  if (std::strcmp(name, "spherical") == 0) name = "ball";
  if (std::strcmp(name, "revolute") == 0) name = "hinge";
  for (int i = 0; i < kJointKinds; ++i) {
    if (std::strcmp(name, kNames[i]) != 0) continue;
    kind = static_cast<JointKind>(i);
    return true;
  }
  return false;
}

Quat allowed_by_kind(JointKind kind, Quat q) {
  switch (kind) {
    case JointKind::hinge:
    case JointKind::cylindrical:
    case JointKind::screw:
    case JointKind::planar:
      return hinged(twist_of(q));
    case JointKind::universal:
      return turn_of(universal_angles(q));
    case JointKind::fixed:
    case JointKind::prismatic:
      return Quat(1, 0, 0, 0);
    default:
      break;
  }
  return q;
}

Quat allowed_turn(const Joint& joint, Quat q) {
  const JointLimits& limits = joint.limits;
  switch (joint.kind) {
    case JointKind::hinge:
    case JointKind::cylindrical:
    case JointKind::screw:
    case JointKind::planar:
      return hinged(clamped(limits.turn, twist_of(q)));
    case JointKind::universal: {
      const UniversalAngles at = universal_angles(q);
      return turn_of(UniversalAngles{clamped(limits.turn, at.first),
                                     clamped(limits.second, at.second)});
    }
    case JointKind::fixed:
    case JointKind::prismatic:
      return Quat(1, 0, 0, 0);
    default:
      break;
  }
  if (!limits.turn.on && !limits.swing.on) return q;
  const SwingTwist at = swing_twist(q);
  const SwingTwist to{clamped(limits.turn, at.twist), clamped(limits.swing, at.swing)};
  // A twist equal but for whole turns is the same turn.
  const Real off = std::remainder(to.twist - at.twist, 2 * kPi);
  if (std::abs(off) < 1e-15 && to.swing == at.swing) return q;
  return turn_of(to);
}

Real violation(const Joint& joint, Quat q) {
  return glm::length(rotation_vector(allowed_turn(joint, q) * glm::conjugate(q)));
}

}  // namespace pantin
