#pragma once
/// Fixed joint: a shared point and shared axes.
#include "engine/joints/hinge.hpp"

namespace pantin::detail::joint_kinds {

struct fixed : SharesPoint, TurnsNowhere {
  static constexpr std::string_view name = "fixed";
  static constexpr int rows = 6, degrees_of_freedom = 0;
  static constexpr Mark marks[] = {Mark::lock};

  static void write(const Joint& joint, const BodyState& a, const BodyState& b, RowsOut out) {
    hinge::write(joint, a, b, out);
    write_row(5, dot_row(axes_on_a(joint, a).y(), axes_on_b(joint, b).z(), a, b), out);
  }
};

}  // namespace pantin::detail::joint_kinds
