#include "engine/joints/joint.hpp"

#include <vector>

#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::detail {
namespace {

Quat hinged(Real angle) { return Quat(std::cos(angle / 2), std::sin(angle / 2), 0, 0); }

}  // namespace

namespace joint_kinds {

Quat TurnsFreely::allowed(const JointLimits& limits, Quat q) {
  if (!limits.angle.on && !limits.swing.on) return q;
  const SwingTwist at = swing_twist(q);
  const SwingTwist to{clamped(limits.angle, at.twist), clamped(limits.swing, at.swing)};
  // Twists that differ by whole revolutions are the same rotation.
  const Real off = std::remainder(to.twist - at.twist, 2 * kPi);
  if (std::abs(off) < 1e-15 && to.swing == at.swing) return q;
  return rotation_of(to);
}

Quat TurnsAboutX::allowed(const JointLimits& limits, Quat q) {
  return hinged(clamped(limits.angle, swing_twist(q).twist));
}

Quat TurnsAboutTwo::allowed(const JointLimits& limits, Quat q) {
  const UniversalAngles at = universal_angles(q);
  return rotation_of(
      UniversalAngles{clamped(limits.angle, at.first), clamped(limits.second, at.second)});
}

}  // namespace joint_kinds

bool joint_kind_from_name(std::string_view name, JointKind& kind) {
  for (int i = 0; i < kJointKinds; ++i) {
    const JointKindInfo& info = kJointKindInfos[i];
    if (name.empty() || (name != info.name && name != info.alias)) continue;
    kind = static_cast<JointKind>(i);
    return true;
  }
  return false;
}

std::string kinds_where(const std::function<bool(const JointKindInfo&)>& holds) {
  std::vector<std::string_view> names;
  for (const JointKindInfo& info : kJointKindInfos)
    if (holds(info)) names.push_back(info.name);
  std::string all;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) all += i + 1 == names.size() ? " or " : ", ";
    all += names[i];
  }
  return all;
}

Quat allowed_by_kind(JointKind kind, Quat q) { return info_of(kind).allowed({}, q); }

Quat allowed_rotation(const Joint& joint, Quat q) {
  return info_of(joint.kind).allowed(joint.limits, q);
}

Real violation(const Joint& joint, Quat q) {
  return glm::length(rotation_vector(allowed_rotation(joint, q) * glm::conjugate(q)));
}

}  // namespace pantin::detail
