// Islands whose joints have limits only, while none is active: they move as on free ball joints,
// which costs a third, and several of equal structure are stepped side by side. A substep that
// comes to a limit is not taken, but repeated with the limits as rows (conserving_limits.cpp).
#include <algorithm>

#include "engine/joints/kinds.hpp"
#include "engine/solvers/articulated/smooth/conserving_joints.hpp"

namespace pantin::detail::articulated {
namespace {

/// rad: a joint keeps clear of limits that are farther away.
constexpr Real kClear = 1e-6;

bool is_clear(const StiffStep& s, std::size_t c) {
  const PackedJoint& j = s.a.joints[c];
  const JointEnds ends = ends_of(s, c);
  if (is_far_from_limits(j, ends.own1, ends.parent1, kFarFromLimits)) return true;
  JointLimit found[4];
  find_limits(j, ends.own1, ends.parent1, found);
  return std::none_of(std::begin(found), std::end(found), [](const JointLimit& l) {
    return l.watched && (l.both_ways || !(l.clearance > kClear));
  });
}

bool are_clear(void* context) {
  OpenPart& open = *static_cast<OpenPart*>(context);
  const StiffStep s{open.world, open.a, 0, open.part};
  for (std::size_t c = 0; open.are_clear && c < open.a.joints.size(); ++c)
    open.are_clear = !has_limits(open.a, c) || is_clear(s, c);
  return open.are_clear;
}

}  // namespace

bool has_only_limits(const Island& a) {
  return !a.joints.empty() &&
         std::all_of(a.joints.begin(), a.joints.end(), [](const PackedJoint& j) {
           return !j.stiff || (turns_of(j.joint.kind) == Turns::freely && !exerts_torque(j));
         });
}

bool opens_limits(const Island& a) {
  if (!has_only_limits(a)) return false;
  for (std::size_t c = 0; c < a.joints.size(); ++c)
    for (const ConservingLimit& l : a.scratch.conserving_nodes[c].limits)
      if (has_limits(a, c) && l.at_start == LimitState::held) return false;
  return true;
}

OpenLimits open_limits(OpenPart& part) { return {&part, are_clear}; }

}  // namespace pantin::detail::articulated
