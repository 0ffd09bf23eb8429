#include "engine/joints/joint.hpp"

#include <vector>

#include "engine/base/invariants.hpp"
#include "engine/base/rotation.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::detail {
namespace {

/// Above it, halves of angles are found by roots without loss of digits: the cosines of a universal
/// joint's angles, and the square of the cosine of half the swing of a hinge.
constexpr Real kLeastCosine = 0.1;

Quat hinged(Real angle) { return Quat(std::cos(angle / 2), std::sin(angle / 2), 0, 0); }

/// Tangents x / w of half the angles of a universal joint; see universal_angles().
struct UniversalHalves {
  Real x, w, second_x, second_w;
  bool are_small;  // the cosines of both exceed kLeastCosine

  explicit UniversalHalves(Quat q) {
    const Vec3 z = q * Vec3(0, 0, 1), y = glm::conjugate(q) * Vec3(0, 1, 0);
    x = z.x, w = z.z + std::sqrt(z.x * z.x + z.z * z.z);
    second_x = y.x, second_w = y.y + std::sqrt(y.x * y.x + y.y * y.y);
    are_small = z.z > kLeastCosine && y.y > kLeastCosine;
  }
  bool are_within(const JointLimits& limits) const {
    return are_small && is_within(limits.angle, x, w) &&
           is_within(limits.second, second_x, second_w);
  }
};

}  // namespace

namespace joint_kinds {

Quat TurnsFreely::allowed(const JointLimits& limits, Quat q) {
  if (!limits.angle.on && !limits.swing.on) return q;
  if (is_unit(q) && is_within(limits, q)) return q;
  const SwingTwist at = swing_twist(q);
  const SwingTwist to{clamped(limits.angle, at.twist), clamped(limits.swing, at.swing)};
  // Twists that differ by whole revolutions are the same rotation.
  const Real off = std::remainder(to.twist - at.twist, 2 * kPi);
  if (std::abs(off) < 1e-15 && to.swing == at.swing) return q;
  return rotation_of(to);
}

Quat TurnsAboutX::allowed(const JointLimits& limits, Quat q) {
  if (q.w < 0) q = -q;
  const auto by_kind = [&] {
    const Real n2 = q.w * q.w + q.x * q.x;
    if (!(n2 > kLeastCosine)) return hinged(swing_twist(q).twist);
    return Quat(q.w, q.x, 0, 0) / std::sqrt(n2);
  };
  if (is_within(limits.angle, q.x, q.w)) return by_kind();
  const Real at = swing_twist(q).twist, to = clamped(limits.angle, at);
  return to == at ? by_kind() : hinged(to);
}

Quat TurnsAboutTwo::allowed(const JointLimits& limits, Quat q) {
  if (!is_unit(q)) q = glm::normalize(q);
  const UniversalHalves halves(q);
  const auto by_kind = [&] {
    if (!halves.are_small) return rotation_of(universal_angles(q));
    return glm::normalize(Quat(halves.w, 0, halves.x, 0) *
                          Quat(halves.second_w, 0, 0, halves.second_x));
  };
  if (halves.are_within(limits)) return by_kind();
  const UniversalAngles at = universal_angles(q);
  const UniversalAngles to{clamped(limits.angle, at.first), clamped(limits.second, at.second)};
  return to.first == at.first && to.second == at.second ? by_kind() : rotation_of(to);
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

bool is_far_from_limits(const Joint& joint, Quat q, Real margin) {
  JointLimits inner = joint.limits;
  for (AngleLimit* angle : {&inner.angle, &inner.second})
    angle->low += margin, angle->high -= margin;
  inner.swing.y -= margin, inner.swing.z -= margin;
  if (q.w < 0) q = -q;
  if (!is_unit(q)) return false;
  switch (info_of(joint.kind).rotations) {
    case Turns::freely:
      return is_within(inner, q);
    case Turns::about_x:
      return is_within(inner.angle, q.x, q.w);
    case Turns::about_two:
      return UniversalHalves(q).are_within(inner);
    case Turns::nowhere:
    case Turns::own:
      break;
  }
  return false;
}

Real violation(const Joint& joint, Quat q) {
  return glm::length(rotation_vector(allowed_rotation(joint, q) * glm::conjugate(q)));
}

}  // namespace pantin::detail
