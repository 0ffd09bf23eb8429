#pragma once
/// The only list of joint kinds. A new kind is a file, included here, and a word in the list:
/// names, rows, limits, keys of scene files and marks come from the file.
///
/// Every solver supports kinds that hold a point, the Lagrangian solver the others too.
#include <functional>
#include <string>

#include "engine/joints/ball.hpp"
#include "engine/joints/custom.hpp"
#include "engine/joints/cylindrical.hpp"
#include "engine/joints/distance.hpp"
#include "engine/joints/fixed.hpp"
#include "engine/joints/hinge.hpp"
#include "engine/joints/planar.hpp"
#include "engine/joints/prismatic.hpp"
#include "engine/joints/screw.hpp"
#include "engine/joints/skate.hpp"
#include "engine/joints/spring.hpp"
#include "engine/joints/universal.hpp"
#include "engine/joints/wheel.hpp"

#define PANTIN_JOINT_KINDS(KIND) \
  KIND(ball)                     \
  KIND(hinge)                    \
  KIND(universal)                \
  KIND(fixed)                    \
  KIND(cylindrical)              \
  KIND(prismatic)                \
  KIND(screw)                    \
  KIND(planar)                   \
  KIND(distance)                 \
  KIND(spring)                   \
  KIND(skate)                    \
  KIND(wheel)                    \
  KIND(custom)

namespace pantin::detail {

#define PANTIN_WORD(kind) kind,
enum class JointKind : std::uint8_t { PANTIN_JOINT_KINDS(PANTIN_WORD) };
#undef PANTIN_WORD

static_assert(JointKind::ball == JointKind{}, "the default kind of joint is a ball");

namespace joint_kinds {

template <class K>
void write(const JointState& at, RowsOut out) {
  if constexpr (K::counts_turns)
    K::write(at, out);
  else
    K::write(at.joint, at.a, at.b, out);
}

template <class K>
Real gap_of_rows(const Joint& joint, const Pose& a, const Pose& b) {
  const auto placed = [](const Pose& at) {
    return BodyState{at.position, at.rotation, glm::mat3_cast(at.rotation), {}, {}};
  };
  Real c[6] = {}, sum = 0;
  write<K>({joint, placed(a), placed(b)}, {c, nullptr, nullptr});
  for (const Real x : c) sum += x * x;
  return std::sqrt(sum);
}

/// The kind's own measure of its position error, or the norm of its residual.
template <class K>
constexpr auto gap_of() {
  if constexpr (requires { &K::gap; })
    return &K::gap;
  else
    return &gap_of_rows<K>;
}

/// The contact point of a kind that constrains velocities only, or null.
template <class K>
constexpr auto slip_of() -> SlipPoint (*)(const Joint&, const BodyState&, const BodyState&) {
  if constexpr (requires { &K::slip_point; })
    return &K::slip_point;
  else
    return nullptr;
}

template <class K>
constexpr JointKindInfo info_of() {
  static_assert(K::rows == kOwnRows || (K::rows >= 0 && K::rows <= 6));
  static_assert(!K::holds_point || K::rows >= 3);
  return {K::name,      K::alias,        K::rows,        K::degrees_of_freedom,
          K::rotations, K::holds_point,  K::is_line,     K::uses_axes,
          K::in_files,  K::counts_turns, K::coordinates, K::parameters,
          K::marks,     &K::own_rows,    &K::fault,      &K::slide_per_turn,
          gap_of<K>(),  &K::complete,    &K::allowed,    &K::on_right_branch,
          slip_of<K>()};
}

}  // namespace joint_kinds

#define PANTIN_INFO(kind) joint_kinds::info_of<joint_kinds::kind>(),
inline constexpr JointKindInfo kJointKindInfos[] = {PANTIN_JOINT_KINDS(PANTIN_INFO)};
#undef PANTIN_INFO
inline constexpr int kJointKinds = static_cast<int>(std::size(kJointKindInfos));
constexpr JointKind last_of(JointKind) { return static_cast<JointKind>(kJointKinds - 1); }

constexpr const JointKindInfo& info_of(JointKind kind) {
  return kJointKindInfos[static_cast<int>(kind)];
}

/// "ball", "hinge", "universal", "fixed", "cylindrical" ...
constexpr const char* name_of(JointKind kind) { return info_of(kind).name.data(); }
/// Also by the aliases "spherical" and "revolute". False, and `kind` untouched, for any other word.
bool joint_kind_from_name(std::string_view name, JointKind& kind);

/// Names of the kinds for which `holds` is true: "hinge, cylindrical or screw".
std::string kinds_where(const std::function<bool(const JointKindInfo&)>& holds);

/// Degrees of freedom of the kind, 0 to 6; 6 for a custom kind.
constexpr int degrees_of_freedom(JointKind kind) { return info_of(kind).degrees_of_freedom; }
/// Whether its bodies share a point.
constexpr bool holds_point(JointKind kind) { return info_of(kind).holds_point; }
constexpr Turns turns_of(JointKind kind) { return info_of(kind).rotations; }
/// Whether the articulated solver supports it: it holds a point, and its rotations are not its own.
constexpr bool is_articulated(JointKind kind) {
  return holds_point(kind) && turns_of(kind) != Turns::own;
}

}  // namespace pantin::detail
